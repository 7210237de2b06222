"""What a page may ask of the command that shows it: addresses in the scene, receivers, sockets."""

from __future__ import annotations

import http.client
import io
import json
from collections.abc import Iterator

import pytest
from asking import post
from pages import STAND_IN, scene_in

import elastomorph as em
from elastomorph.rig import Rig
from elastomorph.viewer import Scene, ViewerServer, rig_scene, serve, viewer_page
from elastomorph.viewer.listening import Answer, Receiver, Resource, Sent, text
from elastomorph.viewer.page import served_policy

LIVE = "ws://127.0.0.1:4321/secret/"


@pytest.fixture(scope="module")
def scene(rig: Rig) -> Scene:
    return rig_scene(rig, name="tip")


def backwards(sent: Sent) -> Answer:
    if sent.words == "refuse":
        raise em.ParameterError("not today")
    return Answer(Resource("application/octet-stream", sent.read()[::-1]), sent.words == "last")


@pytest.fixture(scope="module")
def server(scene: Scene) -> Iterator[ViewerServer]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("elastomorph.viewer.page.shipped_page", lambda: STAND_IN)
        started = serve(scene, services={"open": Receiver(backwards, most=9), "live": LIVE})
    with started:
        yield started


def test_the_scene_names_the_addresses_of_services(server: ViewerServer) -> None:
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)
    connection.request("GET", f"/{server.token}/")
    reply = connection.getresponse()
    page, policy = reply.read().decode(), reply.headers["Content-Security-Policy"]
    connection.close()
    block = page.partition('id="elastomorph-scene">')[2].partition("</script>")[0]
    assert json.loads(block)["services"] == {"open": "open", "live": LIVE}
    assert "connect-src 'self' data: blob: ws://127.0.0.1:4321;" in policy


def test_a_page_alone_has_none(scene: Scene, stand_in: str) -> None:
    assert "services" not in scene_in(viewer_page(scene))[0]


def test_a_receiver_answers_with_content(server: ViewerServer) -> None:
    assert post(server, "open", b"abc") == (200, b"cba")


def test_what_is_refused_is_a_sentence(server: ViewerServer) -> None:
    assert post(server, "open?refuse", b"abc") == (400, b"not today\n")


def test_each_receiver_has_its_own_limit(server: ViewerServer) -> None:
    assert post(server, "open", b"123456789")[0] == 200
    assert post(server, "open", b"1234567890")[0] == 413


@pytest.mark.parametrize("origin", ["", "http://evil.example", "null", "http://127.0.0.1:1"])
def test_pages_of_others_send_nothing(server: ViewerServer, origin: str) -> None:
    assert post(server, "open", b"abc", Origin=origin)[0] == 405


def test_what_is_cut_short_is_told() -> None:
    sent = Sent(io.BytesIO(b"abc"), 5, "")
    with pytest.raises(em.ParameterError, match="2 bytes of what was sent are missing"):
        sent.read()


def test_the_last_one_ends_the_waiting(scene: Scene, stand_in: str) -> None:
    with serve(scene, services={"done": Receiver(lambda _: Answer(text("bye"), True))}) as server:
        assert post(server, "done", b"") == (200, b"bye\n")
        server.wait()


@pytest.mark.parametrize(
    "address",
    [
        "",
        "http://127.0.0.1:80/",
        "ws://evil.example/",
        "ws://127.0.0.1:80.evil.example/",
        "ws://127.0.0.1:80/; script-src *",
    ],
)
def test_only_sockets_of_this_machine(address: str) -> None:
    with pytest.raises(em.ParameterError, match="no address such as ws://127"):
        served_policy(STAND_IN, [address])
