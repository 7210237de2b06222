"""How long a phone's packet takes to the picture, and whether a long stream takes memory.

Run:  python benchmarks/live.py [--rig RIG] [--take take.csv] [--minutes 10] [--lost 0.02]
          [--shuffled 0.02] [--jitter 5] [--pace 2]

Runs ``elastomorph live`` as people do and sends it a recorded take as a phone would, again and
again, of which packets are lost and change their order: first with a client that does what the page
does but draws nothing, so that what is left of the delay are the sockets and our own work; then
with its page in a Chromium that draws in software. Prints both delays; a line a minute with the
memory of the command, the heap of the page after its garbage was collected, and what the page says
of the stream; and what was recorded beside what was sent. Delays run from the arrival of a packet
until the page has begun the frame after the one that shows it, so they are that much too long.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from playwright.sync_api import Page, sync_playwright
from websockets.sync.client import connect
from websockets.typing import Origin

from elastomorph.io.performance import read_performance
from elastomorph.live import Replay, Weather
from measuring import data_folder
from viewer import ARGUMENTS, chromium

sys.path.append(str(Path(__file__).parents[1] / "tests"))
from small_head import rig_file

WINDOW = {"width": 1010, "height": 640}
SECONDS = 20.0


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--rig", default=str(rig_file()), help="a small head by default")
    parser.add_argument("--take", type=Path, default=None)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--lost", type=float, default=0.02)
    parser.add_argument("--shuffled", type=float, default=0.02)
    parser.add_argument("--jitter", type=float, default=5.0, help="milliseconds")
    parser.add_argument("--pace", type=float, default=1.0, help="times as fast as recorded")
    own = parser.parse_args()
    take = read_performance(own.take or data_folder() / "livelink" / "rom_3.csv")
    weather = Weather(own.lost, own.shuffled, own.jitter / 1000)
    with command(own.rig) as (process, said):
        with Replay(take, said["port"], weather=weather, pace=own.pace):
            answer(said["address"], SECONDS)
        print(f"without drawing: {delay(ended(process))}", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "take.csv"
        with (
            command(own.rig, "--record", str(file)) as (process, said),
            opened(said["address"]) as page,
        ):
            replay = Replay(take, said["port"], weather=weather, pace=own.pace)
            with replay:
                watch(process.pid, page, own.minutes)
            time.sleep(0.5)
            outcome = ended(process)
        print(f"in the browser: {delay(outcome)}, the last ten seconds")
        print(json.dumps(outcome["status"]["phones"][0]))
        back = read_performance(file)
        print(
            f"sent {replay.sent:,} packets, {replay.lost:,} lost on purpose, {replay.shuffled:,} "
            f"out of order; recorded {len(back):,} frames of {back.duration:.1f} s, "
            f"{len(back.dropped):,} missing"
        )


@contextmanager
def command(rig: str, *more: str) -> Iterator[tuple[subprocess.Popen[str], dict[str, Any]]]:
    """``elastomorph live``, and what it says when it begins."""
    words = [sys.executable, "-m", "elastomorph", "live", rig, "--port", "0", "--method", "linear"]
    process = subprocess.Popen(
        [*words, "--no-open", "--json", *more], stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        text = ""
        while not text.endswith("}\n"):
            text += process.stdout.readline()
        yield process, json.loads(text)
    finally:
        process.kill()
        process.wait()


def ended(process: subprocess.Popen[str]) -> dict[str, Any]:
    """What the command says at its end."""
    process.send_signal(signal.SIGTERM)
    said, _ = process.communicate(timeout=60)
    found: dict[str, Any] = json.loads(said)
    return found


def delay(outcome: dict[str, Any]) -> str:
    """The delay in words."""
    found = outcome["status"]["delay"]
    return f"packet to frame {found['median']:.1f} ms (95 % within {found['most']:.1f} ms)"


def answer(address: str, seconds: float) -> None:
    """Do what the page does, but for the drawing: what is left are the sockets and our own work."""
    with urllib.request.urlopen(address, timeout=10) as reply:
        page = reply.read().decode()
    live = re.search(r"ws://[^\"]+", page.split('id="elastomorph-scene">')[1])
    assert live is not None
    end = time.monotonic() + seconds
    with connect(live[0], origin=Origin(address[: address.index("/", 7)])) as connection:
        while time.monotonic() < end:
            pose = json.loads(connection.recv()).get("pose")
            if pose is not None:
                connection.send(json.dumps({"drawn": pose}))


@contextmanager
def opened(address: str) -> Iterator[Page]:
    """The page of the command."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=chromium(), args=ARGUMENTS, chromium_sandbox=False
        )
        page = browser.new_page(viewport=WINDOW)
        page.goto(address)
        page.evaluate("elastomorph.ready")
        yield page
        browser.close()


def watch(process: int, page: Page, minutes: float) -> None:
    """A line a minute, and at the beginning and the end."""
    print("minute  command MB  heap MB  the page says", flush=True)
    session = page.context.new_cdp_session(page)
    begun, due = time.monotonic(), 0.0
    while True:
        passed = (time.monotonic() - begun) / 60
        if passed >= min(due, minutes):
            session.send("HeapProfiler.collectGarbage")
            heap = session.send("Runtime.getHeapUsage")["usedSize"] / 1e6
            words = page.locator(".live .words").inner_text()
            print(f"{passed:6.1f}  {resident(process):10.1f}  {heap:7.2f}  {words}", flush=True)
            due += 1.0
        if passed >= minutes:
            return
        page.wait_for_timeout(250)


def resident(process: int) -> float:
    """Megabytes of a process in memory, as Linux tells."""
    pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


if __name__ == "__main__":
    main()
