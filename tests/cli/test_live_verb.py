"""``elastomorph live``: what it says, what it serves, and how it ends."""

from __future__ import annotations

import json
import signal
import socket
import urllib.request
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from subprocess import PIPE
from typing import Any

import numpy as np
import pytest
from calls import status_of as run
from small_files import sheet, turned

import elastomorph as em
from children import started
from elastomorph.io.performance import read_performance, write_performance_csv
from elastomorph.live import encode
from elastomorph.rig.performance import Performance
from needs import extra
from streams import packet

HANGUP = getattr(signal, "SIGHUP", signal.SIGTERM)  # of a terminal that is closed


@pytest.fixture(autouse=True)
def _files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    extra("websockets", "live")
    monkeypatch.chdir(tmp_path)
    morph = em.interpolate(sheet(), turned(0.5), "linear")
    em.write("face.npz", em.Rig(sheet(), {"jawOpen": morph, "smile": morph}))
    em.write("other.npz", em.Rig(sheet(), {"smile": morph}))
    times = np.arange(60) / 60
    write_performance_csv("take.csv", Performance(("jawOpen",), times, times[:, None], 60.0))


def documents(text: str) -> list[Any]:
    """JSON documents, one after the other."""
    found, decoder, place = [], json.JSONDecoder(), 0
    while place < len(text.rstrip()):
        value, place = decoder.raw_decode(text, place)
        found.append(value)
        place += 1  # the line feed
    return found


@pytest.fixture
def hung_up() -> Iterator[None]:
    """Tests that were started to outlive their terminal hand that on to what they start."""
    before = signal.signal(HANGUP, signal.SIG_DFL)
    yield
    signal.signal(HANGUP, before)


@pytest.mark.usefixtures("hung_up")
@pytest.mark.parametrize("number", [signal.SIGINT, HANGUP])
def test_it_serves_records_and_ends_when_asked(number: signal.Signals) -> None:
    """Ctrl-C is how one leaves: what was recorded is kept, and the outcome is said."""
    words = ("live", "face.npz", "--port", "0", "--no-open", "--json", "--record", "new.csv")
    with started("-m", "elastomorph", *words, stdout=PIPE, stderr=PIPE) as process:
        assert process.stdout is not None
        text = ""
        while not text.endswith("}\n"):
            text += process.stdout.readline()
        (said,) = documents(text)
        with urllib.request.urlopen(said["address"], timeout=60) as reply:
            assert b'"services":{"live":"ws://127.0.0.1:' in reply.read()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as phone:
            for frame in range(20):
                phone.sendto(encode(packet(frame)), ("127.0.0.1", said["port"]))
            phone.sendto(b"nothing", ("127.0.0.1", said["port"]))
        process.send_signal(number)
        text, complaints = process.communicate(timeout=60)
    assert process.returncode == (0 if number is signal.SIGINT else 128 + number)
    assert complaints == ""
    (outcome,) = documents(text)
    assert outcome["status"]["phones"][0]["packets"] == 20
    assert outcome["status"]["refused"] == 1
    assert [frames for _, frames in outcome["recorded"]] == [20]
    assert len(read_performance("new.csv")) == 20


def test_a_take_is_replayed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """For people without a phone; what is said at the beginning and at the end."""
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    lines: list[str] = []

    def tell(text: str) -> None:
        lines.append(text)
        if "packets a second" in text:
            raise KeyboardInterrupt

    monkeypatch.setattr("elastomorph.cli.live.progress", lambda quiet: nullcontext(tell))
    assert run("live", "face.npz", "--port", "0", "--replay", "take.csv") == 0
    said = capsys.readouterr().out
    assert opened[0] in said
    assert "shown to this machine only; Ctrl-C ends it" in said
    assert "programs of this machine may send; for a phone add --listen 0.0.0.0" in said
    assert "1 of 52 weights drive 1 of 2 sliders" in said
    assert "replay: " in said
    assert "replay: " in lines[-1]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["nowhere.glb"], "nowhere.glb"),
        (["other.npz"], "no weight of ARKit drives a slider of the rig (smile)"),
        (["face.npz", "--listen", "example.org"], "'example.org' is no address to listen on"),
        (["face.npz", "--port", "70000"], "UDP port 70000"),
        (["face.npz", "--record", "take.npz"], "takes are recorded as .csv"),
        (["face.npz", "--record", "nowhere/take.csv"], "nowhere"),
        (["face.npz", "--record", "take.csv", "--replay", "take.csv"], "over the input take.csv"),
        (["face.npz", "--replay", "face.npz"], "face.npz"),
        (["face.npz", "--page-port", "70000"], "70000"),
    ],
)
def test_mistakes(words: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    before = sorted(Path().iterdir())
    assert run("live", *words, *([] if "--port" in words else ["--port", "0"]), "--no-open") == 1
    said = capsys.readouterr()
    assert said.err.startswith("error: ")
    assert message in said.err
    assert sorted(Path().iterdir()) == before
