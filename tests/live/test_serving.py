"""A live page with real sockets: packets in, poses out, and nothing for anybody else."""

from __future__ import annotations

import json
import re
import socket
import time
import tracemalloc
import urllib.request
from collections.abc import Iterator
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import elastomorph as em
from elastomorph.errors import FileError, MissingExtraError, ParameterError
from elastomorph.io.performance import read_performance
from elastomorph.live import LivePage, Replay, Weather, encode
from elastomorph.live.packets import COLUMNS
from elastomorph.live.serving import Receiver
from elastomorph.rig import Rig
from elastomorph.rig.performance import Performance
from needs import extra
from streams import packet, wait, weights

if TYPE_CHECKING:
    from websockets.sync.client import ClientConnection

STAND_IN = "<!doctype html><head>\n<!-- elastomorph scene -->\n</head><body></body>\n"
LOOPBACK = "127.0.0.1"


@pytest.fixture(autouse=True)
def _page(monkeypatch: pytest.MonkeyPatch) -> None:
    extra("websockets", "live")
    monkeypatch.setattr("elastomorph.viewer.page.shipped_page", lambda: STAND_IN)


@pytest.fixture(scope="module")
def rig() -> Rig:
    mesh = em.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3]])
    morph = em.interpolate(mesh, mesh.with_vertices(mesh.vertices * 1.5), "linear")
    return Rig(mesh, {"smile": morph, "jawOpen": morph, "browInnerUp_L": morph})


@pytest.fixture
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """A page that takes long to draw, as on a busy machine, is waited for."""
    monkeypatch.setattr("elastomorph.live.serving._PATIENCE", 1000.0)


class Watcher:
    """What a page does, without a browser."""

    def __init__(self, connection: ClientConnection) -> None:
        self.connection = connection

    def next(self, key: str, seconds: float = 60) -> dict[str, Any]:
        """The next message with a key."""
        while True:
            found: dict[str, Any] = json.loads(self.connection.recv(seconds))
            if key in found:
                return found

    def say(self, **wish: object) -> None:
        self.connection.send(json.dumps(wish))

    def until(self, **wanted: object) -> dict[str, Any]:
        """The first status that says all this."""
        while True:
            status: dict[str, Any] = self.next("status")["status"]
            if all(status[key] == value for key, value in wanted.items()):
                return status


class Live:
    """A live page, and what phones send to it."""

    def __init__(self, page: LivePage, stack: ExitStack) -> None:
        self.page, self._stack = page, stack
        self.phone = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        with urllib.request.urlopen(page.address, timeout=60) as reply:
            self.policy = reply.headers["Content-Security-Policy"]
            text = reply.read().decode()
        scene = json.loads(text.split('id="elastomorph-scene">')[1].split("</script>")[0])
        self.address, self.start = scene["services"]["live"], scene["start"]

    def stop_the_clock(self) -> None:
        """From now on no time passes for the session: nobody falls silent."""
        now = time.monotonic()
        self.page.session._clock = lambda: now

    def send(self, *contents: bytes) -> None:
        for content in contents:
            self.phone.sendto(content, (LOOPBACK, self.page.port))

    def connection(self, address: str | None = None, **options: Any) -> ClientConnection:
        from websockets.sync.client import connect

        port = self.page.server.port
        options = {"origin": f"http://{LOOPBACK}:{port}", "compression": None, **options}
        options = {"open_timeout": 60, **options}
        return self._stack.enter_context(connect(address or self.address, **options))

    def watcher(self) -> Watcher:
        return Watcher(self.connection())


@pytest.fixture
def live(rig: Rig, tmp_path: Path) -> Iterator[Live]:
    with ExitStack() as stack:
        page = stack.enter_context(LivePage(rig, port=0, record=tmp_path / "take.csv"))
        yield Live(page, stack)


def test_a_packet_becomes_a_pose(live: Live) -> None:
    live.stop_the_clock()
    page = live.watcher()
    assert page.next("sliders") == {"sliders": ["smile", "jawOpen", "browInnerUp_L"]}
    live.send(encode(packet(1, face=weights(JawOpen=0.25, BrowInnerUp=0.5))))
    assert page.next("weights")["weights"] == [0, 0.25, 0.5]
    assert page.until(flows=True)["phones"] == [[0, "iPhone", True]]
    assert live.start == {"live": True}


@pytest.mark.usefixtures("patient")
def test_the_newest_is_sent_and_nothing_waits(live: Live) -> None:
    """A page that draws nothing gets two poses; when it has drawn, it gets the last of all."""
    page = live.watcher()
    page.until(flows=False)
    live.send(encode(packet(0)))
    first = page.next("pose")["pose"]
    for frame in range(1, 33):
        live.send(encode(packet(frame)))
        if frame == 1:
            page.next("pose")
    wait(lambda: live.page.session.status().phones[0].packets == 33)
    page.say(drawn=first + 1)
    assert page.next("pose")["weights"][1] == 0.5
    wait(lambda: live.page.session.drawn == 1)


@pytest.mark.usefixtures("patient")
def test_delays_are_measured(live: Live) -> None:
    begun = time.monotonic()
    page = live.watcher()
    page.until(flows=False)
    for frame in range(5):
        live.send(encode(packet(frame)))
        page.say(drawn=page.next("pose")["pose"])
    wait(lambda: live.page.session.drawn == 4)  # the first may be as old as the stream
    delay = live.page.session.status().delay
    assert delay is not None
    assert 0 < delay.median <= delay.most < 1000 * (time.monotonic() - begun)
    while "packet to frame" not in page.until()["words"]:
        pass


def test_late_packets_do_not_move_the_face(live: Live) -> None:
    page = live.watcher()
    live.send(encode(packet(32)), encode(packet(31)), encode(packet(32)))
    pose = page.next("pose")
    page.say(drawn=pose["pose"])
    wait(lambda: live.page.session.status().phones[0].packets == 3)
    assert live.page.session.newest(0, 0).weights[1] == 0.5  # type: ignore[union-attr]
    found = live.page.session.status().phones[0]
    assert (found.late, found.twice) == (1, 1)


def test_a_face_out_of_sight_and_a_stream_that_stops_stay_as_they_are(live: Live) -> None:
    page = live.watcher()
    now = time.monotonic()
    live.page.session._clock = lambda: now
    live.send(encode(packet(32)), encode(packet(33, face=())))
    wait(lambda: "sees no face" in live.page.session.status().text())
    now += 2
    wait(lambda: "no packets for" in live.page.session.status().text())
    page.until(flows=False)
    late = live.watcher()
    assert late.next("weights")["weights"][1] == 0.5
    live.send(encode(packet(100)))
    assert page.until(flows=True)


def test_neutral_is_subtracted(live: Live) -> None:
    page = live.watcher()
    live.send(encode(packet(1, face=weights(JawOpen=0.25, BrowInnerUp=0.5, HeadYaw=0.5))))
    first = page.next("pose")
    assert first["head"] == [0.5, 0, 0]
    page.say(drawn=first["pose"])
    page.say(neutral=True)
    page.until(neutral=True)
    live.send(encode(packet(2, face=weights(JawOpen=0.75, BrowInnerUp=0.25))))
    wait(lambda: live.page.session.status().phones[0].packets == 2)
    shown = live.watcher().next("weights")
    assert shown["weights"] == [0, 0.5, 0]
    assert shown["head"] == [-0.5, 0, 0]  # angles have both signs
    page.say(neutral=False)
    page.until(neutral=False)
    assert live.watcher().next("weights")["weights"] == [0, 0.75, 0.25]


def test_another_phone_is_chosen(live: Live) -> None:
    live.stop_the_clock()
    page = live.watcher()
    live.send(encode(packet(16)), encode(packet(48, subject="iPad", device="two")))
    status = page.until(phones=[[0, "iPhone", True], [1, "iPad", False]])
    assert "also sending: iPad" in status["words"]
    page.say(phone=1)
    page.until(phones=[[0, "iPhone", False], [1, "iPad", True]])
    assert live.watcher().next("weights")["weights"][1] == 0.75


def test_recording_is_begun_and_ended_by_the_page(live: Live, tmp_path: Path) -> None:
    page = live.watcher()
    for name, first in (("take.csv", 0), ("take-2.csv", 30)):
        page.say(record=True)
        page.until(recording=True)
        live.send(*(encode(packet(first + frame)) for frame in range(30)))
        wait(partial(_arrived, live, first + 30))
        assert f"recording {name}" in live.page.session.status().text()
        page.say(record=False)
        page.until(recording=False)
        assert len(read_performance(tmp_path / name)) == 30


def _arrived(live: Live, packets: int) -> bool:
    return sum(phone.packets for phone in live.page.session.status().phones) == packets


def test_what_was_recorded_is_kept_at_the_end(rig: Rig, tmp_path: Path) -> None:
    with ExitStack() as stack:
        page = stack.enter_context(LivePage(rig, port=0, record=tmp_path / "take.csv"))
        live = Live(page, stack)
        live.send(*(encode(packet(frame)) for frame in range(30)))
        wait(
            lambda: (
                page.session.status().phones[:1] and page.session.status().phones[0].packets == 30
            )
        )
        assert not (tmp_path / "take.csv").exists()
    assert [file.name for file in tmp_path.iterdir()] == ["take.csv"]
    assert len(read_performance(tmp_path / "take.csv")) == 30
    assert "30 frames → " in page.session.outcome().text()


@pytest.mark.parametrize(
    "wrong",
    ["secret", "no secret", "origin", "no origin", "own port", "host"],
)
def test_nobody_else_may_connect(live: Live, wrong: str) -> None:
    """Not without the secret, not from another page, not by another name of this machine."""
    from websockets.exceptions import InvalidStatus

    base, token = live.address.removesuffix("/").rsplit("/", 1)
    address = {"secret": f"{base}/{token.swapcase()}/", "no secret": f"{base}/"}.get(wrong)
    options: dict[str, Any] = {
        "origin": {"origin": "http://example.org"},
        "no origin": {"origin": None},
        "own port": {"origin": base.replace("ws:", "http:")},
        "host": {"additional_headers": {"Host": "example.org"}},
    }.get(wrong, {})
    with pytest.raises(InvalidStatus) as refusal:
        live.connection(address, **options)
    assert refusal.value.response.status_code == 404


def test_the_page_may_connect_there_and_nowhere_else(live: Live) -> None:
    origin = live.address.rsplit("/", 2)[0]
    assert f"connect-src 'self' data: blob: {origin};" in live.policy


@pytest.mark.parametrize(
    "said",
    ["", "no", "[]", "{}", '{"drawn":"1"}', '{"drawn":true}', '{"neutral":1}', '{"phone":0.5}',
     '{"record":"/etc/passwd"}', '{"drawn":1,"phone":1}', "[" * 200, "x" * 300, b"\xff\xfe"],
)  # fmt: skip
def test_a_page_that_says_anything_else_is_left(live: Live, said: str | bytes) -> None:
    from websockets.exceptions import ConnectionClosed

    connection = live.connection()
    connection.send(said)
    with pytest.raises(ConnectionClosed) as end:
        Watcher(connection).next("nothing that is ever sent")
    assert end.value.rcvd is not None
    assert end.value.rcvd.code in (1008, 1009, 1007)
    assert live.watcher().next("status")


def test_too_many_pages(live: Live) -> None:
    from websockets.exceptions import ConnectionClosed

    pages = [live.watcher() for _ in range(8)]
    for page in pages:
        page.next("status")
    with pytest.raises(ConnectionClosed):
        live.watcher().next("status")
    pages[0].connection.close()
    wait(lambda: _answers(live))


def _answers(live: Live) -> bool:
    from websockets.exceptions import ConnectionClosed

    try:
        live.watcher().next("status")
    except ConnectionClosed:
        return False
    return True


def test_hostile_packets_are_counted_and_told(live: Live) -> None:
    good = encode(packet(1))
    live.send(b"", b"\x06", good[:-1], bytes(60_000), b"\x01" * 584)
    status = live.page.session.status
    wait(lambda: status().refused == 5)
    assert "5 packets refused, the last from 127.0.0.1: its layout" in status().text()
    live.send(good)
    assert live.watcher().next("weights")


def test_a_flood_takes_no_memory(live: Live) -> None:
    """Tens of thousands of packets, none of which anybody waits for; the last pose is shown."""
    page = live.watcher()
    page.next("status")
    session = live.page.session

    def flood(first: int, count: int) -> None:
        for frame in range(first, first + count):
            live.send(encode(packet(frame)), b"nothing" * 9)

    flood(0, 1000)
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    flood(1000, 9000)
    grown = tracemalloc.get_traced_memory()[0] - before
    tracemalloc.stop()
    assert grown < 500_000
    assert session.status().refused > 0

    def arrived() -> bool:
        live.send(encode(packet(20_033)))  # until the system has room for it
        pose = session.newest(0, 0)
        return pose is not None and pose.weights[1] == round(1 / 64, 5)

    wait(arrived)


def test_replayed_through_bad_weather(live: Live, tmp_path: Path) -> None:
    """The short form of the long run: 2 % lost and shuffled, all else arrives, and is recorded."""
    jaw = np.abs(np.sin(np.arange(120) / 20))
    take = Performance(("jawOpen", "headYaw"), np.arange(120) / 60, np.c_[jaw, jaw], 60.0)
    page = live.watcher()
    weather = Weather(lost=0.02, shuffled=0.02, jitter=0.003)
    drawn = 0
    with Replay(take, live.page.port, weather=weather, pace=4) as replay:
        while replay.sent < 1200 or drawn <= 100:
            pose = page.next("pose")
            page.say(drawn=pose["pose"])
            drawn += 1
    session = live.page.session
    wait(lambda: session.status().phones[0].packets == replay.sent)
    found = session.status().phones[0]
    assert found.late == replay.shuffled
    assert abs(found.missing - replay.lost) <= 2
    session.record(False)
    back = read_performance(tmp_path / "take.csv")
    assert len(back) == replay.sent
    yaw = back.weights[:, COLUMNS.index("HeadYaw")]
    assert np.array_equal(yaw, back.weights[:, COLUMNS.index("JawOpen")])


def test_a_rig_that_nothing_drives(rig: Rig) -> None:
    with pytest.raises(ParameterError, match=r"no weight of ARKit drives .* \(smile\)"):
        LivePage(rig.only(["smile"]), port=0)
    with pytest.raises(ParameterError, match="has no sliders"):
        LivePage(Rig(rig.neutral, {}), port=0)


@pytest.mark.parametrize(
    ("host", "port", "words"),
    [
        ("nowhere", 0, "'nowhere' is no address to listen on"),
        ("192.0.2.1", 0, "192.0.2.1 is no address of this machine"),
        ("fe80::1%none", 0, "fe80::1%none is no address of this machine"),
        (LOOPBACK, 70_000, "UDP port 70000 of 127.0.0.1 cannot be listened on"),
    ],
)
def test_addresses_that_cannot_be(host: str, port: int, words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        Receiver(lambda content, address: None, host, port)


def test_a_port_that_is_taken(live: Live) -> None:
    with pytest.raises(ParameterError, match="end the program that uses it, or choose another"):
        Receiver(lambda content, address: None, port=live.page.port)


def has_ipv6() -> bool:
    """Whether this machine has it; many containers have not."""
    try:
        with socket.socket(socket.AF_INET6, socket.SOCK_DGRAM) as tried:
            tried.bind(("::1", 0))
    except OSError:
        return False
    return True


def test_listening_says_what_it_means() -> None:
    meanings = [(LOOPBACK, "programs of this machine"), ("0.0.0.0", "anybody on that")]
    if has_ipv6():
        meanings.append(("::1", r"UDP [::1]:"))
    for host, words in meanings:
        receiver = Receiver(lambda content, address: None, host, 0)
        with receiver:
            assert words in receiver.meaning


def test_the_address_to_type_into_the_app_is_said() -> None:
    """It is one of this machine, on which it can listen."""
    receiver = Receiver(lambda content, address: None, "0.0.0.0", 0)
    named = re.search(r"\(in the app: (.*)\)", receiver.meaning)
    receiver.close()
    if named is None:
        pytest.skip("this machine is on no network")
    Receiver(lambda content, address: None, named[1], 0).close()
    assert not named[1].startswith("0.")


def test_files_are_tried_before_anything_is_served(rig: Rig, tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match=r"recorded as \.csv"):
        LivePage(rig, port=0, record=tmp_path / "take.glb")
    with pytest.raises(FileError, match="nowhere"):
        LivePage(rig, port=0, record=tmp_path / "nowhere" / "take.csv")


def test_without_websockets(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "websockets.sync.server", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'elastomorph\[live\]'"):
        LivePage(rig, port=0)
