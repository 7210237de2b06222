"""The page of ``elastomorph live``: it follows a phone, and says how its stream stands."""

from __future__ import annotations

import re
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from faces import Faces, distances
from projecting import as_turned, spots
from test_looks import LAYOUT, SIZES, needs_axe, violations
from visiting import COARSE, SMALL, Visit, positions, settled, state, update, wait

from elastomorph.io.performance import read_performance
from elastomorph.live import LivePage, Replay, Weather, encode
from elastomorph.rig.performance import Performance
from needs import extra
from streams import packet, weights

if TYPE_CHECKING:
    from playwright.sync_api import Page

WITHIN = 1e-4  # of D
SMILE = weights(MouthSmileLeft=0.75, MouthSmileRight=0.5, JawOpen=0.25, HeadYaw=1.0)
BLINK = weights(EyeBlinkLeft=1.0, BrowInnerUp=0.5)


class Phone:
    """Sends packets, each a frame later than the one before."""

    def __init__(self, port: int, name: str = "iPhone") -> None:
        self._port, self._name = port, name
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._frame = 0

    def send(self, face: tuple[float, ...]) -> None:
        one = packet(self._frame, subject=self._name, device=self._name, face=face)
        self._socket.sendto(encode(one), ("127.0.0.1", self._port))
        self._frame += 1

    def close(self) -> None:
        self._socket.close()


class Stage:
    """A live page with a phone, or several."""

    def __init__(self, live: LivePage, stack: ExitStack) -> None:
        self.live, self._stack = live, stack
        self.phone = self.another("iPhone")

    def stop_the_clock(self, ahead: float = 0.0) -> None:
        """From now on no time passes for the session, but for these seconds."""
        now = self.live.session._clock() + ahead
        self.live.session._clock = lambda: now

    def another(self, name: str) -> Phone:
        phone = Phone(self.live.port, name)
        self._stack.callback(phone.close)
        return phone


@pytest.fixture
def stage(faces: Faces, tmp_path: Path) -> Iterator[Stage]:
    extra("websockets", "live")
    with ExitStack() as stack:
        live = LivePage(faces.rigs["beam:2"], port=0, name="face", record=tmp_path / "take.csv")
        yield Stage(stack.enter_context(live), stack)


# In a small window what is said of the stream takes its lines from the picture.
FIXED = """Object.assign(document.querySelector('.picture').style,
    {position: 'fixed', width: '400px', height: '200px', zIndex: -1})"""


def says(page: Page, words: str) -> None:
    """Waits for the line about the stream to say something."""
    wait(page, f"document.querySelector('.live').textContent.includes({words!r})")


def follows(page: Page, faces: Faces, **wanted: float) -> None:
    """Waits for these weights, and compares the face with what the rig makes of them."""
    until = time.monotonic() + 240
    while state(page)["weights"] != pytest.approx(wanted, abs=1e-4):
        assert time.monotonic() < until, state(page)["weights"]
        time.sleep(0.03)
    rig = faces.rigs["beam:2"]
    drawn = positions(page, 0, len(rig.neutral.vertices))
    assert distances(drawn, rig.pose(wanted)).max() < WITHIN * faces.diameter


def test_the_face_follows_the_phone(visit: Visit, faces: Faces, stage: Stage) -> None:
    stage.stop_the_clock()
    page = visit(stage.live.address, size=SMALL)
    says(page, "no packets yet")
    stage.phone.send(SMILE)
    follows(page, faces, mouthSmile_L=0.75, mouthSmile_R=0.5, jawOpen=0.25)
    stage.phone.send(BLINK)
    follows(page, faces, eyeBlink_L=1.0, browInnerUp=0.5)
    says(page, "Receiving")


def test_the_head_turns_with_the_phone(visit: Visit, faces: Faces, stage: Stage) -> None:
    """About the neck, while the phone leads; from what is set as neutral on, and if people wish."""
    page = visit(stage.live.address, size=SMALL)
    page.evaluate(FIXED)
    head = (0.4, -0.3, 0.2)
    angles = dict(zip(("HeadYaw", "HeadPitch", "HeadRoll"), head, strict=True))
    stage.phone.send(weights(MouthSmileLeft=0.75, **angles))
    follows(page, faces, mouthSmile_L=0.75)
    rig = faces.rigs["beam:2"]
    points = rig.neutral.vertices[::1000]
    turned = spots(page, points)
    update(page, headTurns=False)
    straight = spots(page, points)
    np.testing.assert_allclose(turned, spots(page, as_turned(points, rig, head)), atol=0.01)
    assert np.abs(turned - straight).max() > 1  # of a small picture
    update(page, headTurns=True)
    np.testing.assert_allclose(spots(page, points), turned, atol=1e-6)
    page.get_by_role("button", name="Set as neutral").click()
    follows(page, faces)
    np.testing.assert_allclose(spots(page, points), straight, atol=1e-6)


def test_a_stream_that_stops_and_comes_back(visit: Visit, faces: Faces, stage: Stage) -> None:
    stage.stop_the_clock()
    page = visit(stage.live.address, size=SMALL)
    stage.phone.send(SMILE)
    says(page, "Receiving")
    stage.stop_the_clock(1.2)
    says(page, "no packets for 1 s")
    says(page, "Stopped")
    follows(page, faces, mouthSmile_L=0.75, mouthSmile_R=0.5, jawOpen=0.25)
    stage.phone.send(BLINK)
    says(page, "Receiving")
    follows(page, faces, eyeBlink_L=1.0, browInnerUp=0.5)


def test_delays_are_shown(visit: Visit, stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("elastomorph.live.serving._PATIENCE", 1000.0)  # a busy machine draws slowly
    begun = time.monotonic()
    page = visit(stage.live.address, size=SMALL, **COARSE)
    says(page, "no packets yet")
    for face in (SMILE, BLINK, SMILE):
        stage.phone.send(face)
        page.wait_for_timeout(300)
    says(page, "packet to frame")
    delay = stage.live.session.status().delay
    assert delay is not None
    assert 0 < delay.median < 1000 * (time.monotonic() - begun)


def test_a_neutral_is_set_by_keys(visit: Visit, faces: Faces, stage: Stage) -> None:
    page = visit(stage.live.address, size=SMALL)
    stage.phone.send(SMILE)
    follows(page, faces, mouthSmile_L=0.75, mouthSmile_R=0.5, jawOpen=0.25)
    button = page.get_by_role("button", name="Set as neutral")
    button.press("Enter")
    follows(page, faces)
    wait(page, "document.querySelectorAll('.live [aria-pressed=true]').length === 3")
    stage.phone.send(weights(MouthSmileLeft=1.0, BrowInnerUp=0.5))
    follows(page, faces, mouthSmile_L=0.25, browInnerUp=0.5)
    button.press("Space")
    follows(page, faces, mouthSmile_L=1.0, browInnerUp=0.5)


def test_recording_is_begun_and_ended(visit: Visit, stage: Stage, tmp_path: Path) -> None:
    page = visit(stage.live.address, size=SMALL, **COARSE)
    record = page.get_by_role("button", name="Record")
    says(page, "recording from the next packet on")
    for _ in range(10):
        stage.phone.send(SMILE)
    says(page, "recording take.csv, 10 frames")
    record.click()
    wait(page, "document.querySelectorAll('.live [aria-pressed=true]').length === 1")
    assert len(read_performance(tmp_path / "take.csv")) == 10


def test_a_phone_is_chosen(visit: Visit, faces: Faces, stage: Stage) -> None:
    stage.stop_the_clock()
    page = visit(stage.live.address, size=SMALL)
    choice = page.get_by_role("combobox", name="Phone")
    stage.phone.send(SMILE)
    follows(page, faces, mouthSmile_L=0.75, mouthSmile_R=0.5, jawOpen=0.25)
    assert not choice.is_visible()
    stage.another("<b>iPad</b>").send(BLINK)
    says(page, "also sending: <b>iPad</b>")
    choice.select_option("<b>iPad</b>")
    follows(page, faces, eyeBlink_L=1.0, browInnerUp=0.5)


def test_sliders_are_free_again(visit: Visit, faces: Faces, stage: Stage) -> None:
    """What the phone did last stays; then people move, and Ctrl+Z undoes only what they did."""
    page = visit(stage.live.address, size=SMALL)
    stage.phone.send(SMILE)
    follows(page, faces, mouthSmile_L=0.75, mouthSmile_R=0.5, jawOpen=0.25)
    page.get_by_role("button", name="Live").click()
    wait(page, "!elastomorph.state().live")
    stage.phone.send(BLINK)
    update(page, weights={"jawOpen": 0.5})
    page.wait_for_timeout(400)
    assert state(page)["weights"] == {"jawOpen": 0.5}
    page.keyboard.press("Control+z")
    assert state(page)["weights"]["mouthSmile_L"] == 0.75
    page.get_by_role("button", name="Live").click()
    follows(page, faces, eyeBlink_L=1.0, browInnerUp=0.5)


def test_what_plays_takes_the_sliders(visit: Visit, stage: Stage) -> None:
    page = visit(stage.live.address, size=SMALL, **COARSE)
    assert state(page)["live"]
    update(page, playing=True)
    assert not state(page)["live"]
    page.get_by_role("button", name="Live").click()
    assert state(page)["live"]
    assert not state(page)["playing"]


def test_a_command_that_ends(visit: Visit, faces: Faces, stage: Stage) -> None:
    """The page says so and the face stays; browsers complain of a server that is gone."""
    visit.forgiven = "WebSocket"
    page = visit(stage.live.address, size=SMALL)
    stage.phone.send(SMILE)
    follows(page, faces, mouthSmile_L=0.75, mouthSmile_R=0.5, jawOpen=0.25)
    stage.live.__exit__(None, None, None)
    says(page, "Not connected")
    assert page.get_by_role("button", name="Set as neutral").is_disabled()
    follows(page, faces, mouthSmile_L=0.75, mouthSmile_R=0.5, jawOpen=0.25)


def test_other_pages_have_no_live(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, size=SMALL, **COARSE)
    assert not page.locator(".live").is_visible()


@needs_axe
def test_it_is_in_order_at_every_size(
    visit: Visit, stage: Stage, keep: Callable[[Page, str], None]
) -> None:
    stage.stop_the_clock()
    page = visit(stage.live.address, **COARSE)
    other = stage.another("Studio iPad")
    long = stage.another("x" * 200)
    for _ in range(3):
        stage.phone.send(SMILE)
        other.send(BLINK)
        long.send(BLINK)
    says(page, "also sending")
    within = "words => words.scrollWidth <= words.clientWidth"
    assert page.locator(".live p").evaluate(within)
    wrong = []
    for size, (width, height) in SIZES.items():
        page.set_viewport_size({"width": width, "height": height})
        for theme in ("light", "dark"):
            page.emulate_media(color_scheme=theme)
            settled(page)
            keep(page, f"live-{size}-{theme}")
            wrong += [f"{size}, {theme}: {words}" for words in page.evaluate(LAYOUT)]
            wrong += [f"{size}, {theme}: {words}" for words in violations(page)]
    assert wrong == []


def test_a_stream_takes_no_memory(visit: Visit, stage: Stage) -> None:
    """The short form of ten minutes: some seconds of 2 % lost and shuffled, several times as fast.

    The heap of the page is as large afterwards as when it had settled, within a part of what the
    stream was.
    """
    jaw = np.abs(np.sin(np.arange(300) / 20))
    take = Performance(("jawOpen", "browInnerUp"), np.arange(300) / 60, np.c_[jaw, jaw], 60.0)
    page = visit(stage.live.address, size=SMALL, **COARSE)
    session = page.context.new_cdp_session(page)

    def heap() -> float:
        session.send("HeapProfiler.collectGarbage")
        return float(session.send("Runtime.getHeapUsage")["usedSize"])

    with Replay(take, stage.live.port, weather=Weather(0.02, 0.02, 0.003), pace=4) as replay:
        page.wait_for_timeout(2500)
        drawn = stage.live.session.drawn
        before = max(heap(), heap())
        page.wait_for_timeout(4000)
        grown = min(heap(), heap()) - before
        assert stage.live.session.drawn > drawn
        words = page.locator(".live .words").inner_text()
    assert replay.sent > 500
    assert grown < 300_000
    assert re.search(r"replay: \d+ packets a second, [\d.]+ % lost, \d+ late", words)
