"""The server gives the page to whoever knows its address on this machine, and nothing else."""

from __future__ import annotations

import base64
import hashlib
import http.client
import socket
import struct
import sys
import threading
from collections.abc import Iterator

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pages import STAND_IN, scene_in

import elastomorph as em
from elastomorph.rig import Rig
from elastomorph.viewer import Scene, ViewerServer, rig_scene, serve
from elastomorph.viewer.listening import Answer, Receiver, text
from elastomorph.viewer.page import alone_policy, served_policy
from elastomorph.viewer.server import serve_page


@pytest.fixture(scope="module")
def scene(rig: Rig) -> Scene:
    return rig_scene(rig, name="tip")


@pytest.fixture(scope="module")
def server(scene: Scene) -> Iterator[ViewerServer]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("elastomorph.viewer.page.shipped_page", lambda: STAND_IN)
        started = serve(scene)
    with started:
        yield started


class Reply:
    """What came back."""

    def __init__(self, server: ViewerServer, path: str, method: str = "GET", **headers: str):
        connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)
        connection.putrequest(method, path, skip_host="host" in headers)
        for name, value in headers.items():
            if value:
                connection.putheader(name, value)
        connection.endheaders()
        response = connection.getresponse()
        self.status, self.body = response.status, response.read()
        self.headers = {name: value for name, value in response.getheaders() if name != "Date"}
        connection.close()


def test_the_page_and_its_models(server: ViewerServer, scene: Scene) -> None:
    page = Reply(server, f"/{server.token}/")
    assert page.status == 200
    assert page.headers["Content-Type"] == "text/html; charset=utf-8"
    assert '"glb":"model-0.glb"' in page.body.decode()
    model = Reply(server, f"/{server.token}/model-0.glb")
    assert model.status == 200
    assert model.headers["Content-Type"] == "model/gltf-binary"
    assert model.body == scene.models[0].glb


def test_the_address_is_loopback_with_a_secret(server: ViewerServer) -> None:
    assert server.address == f"http://127.0.0.1:{server.port}/{server.token}/"
    assert len(base64.urlsafe_b64decode(server.token)) >= 24


def test_every_start_has_its_own_secret(scene: Scene, stand_in: str) -> None:
    tokens = []
    for _ in range(3):
        with serve(scene) as server:
            tokens.append(server.token)
    assert len(set(tokens)) == 3


def test_other_addresses_of_this_machine_do_not_answer(server: ViewerServer) -> None:
    """Bound to 127.0.0.1 alone: another loopback address finds nobody there."""
    with pytest.raises(OSError), socket.create_connection(("127.0.0.2", server.port), timeout=2):  # noqa: PT011
        pass


def wrong_paths(token: str) -> list[str]:
    return [
        "/",
        "/index.html",
        f"/{token}",
        f"/{token[:-1]}/",
        f"/{token}x/",
        f"/{token.swapcase()}/",
        f"/x/{token}/",
        f"/{token}/index.html",
        f"/{token}/model-1.glb",
        f"/{token}/../",
        f"/{token}/../../etc/passwd",
        f"/{token}/%2e%2e/%2e%2e/etc/passwd",
        f"/{token}//etc/passwd",
        f"/{token}/./",
        f"/{token}/model-0.glb/",
        f"http://127.0.0.1/{token}/",
    ]


def test_all_else_is_not_found_and_looks_alike(server: ViewerServer) -> None:
    """Nothing tells a wrong secret from a wrong path: status, headers and body are the same."""
    replies = [Reply(server, path) for path in wrong_paths(server.token)]
    raw = _raw(server, f"GET /\xff/ HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n\r\n")
    assert raw.startswith("HTTP/1.1 404")
    assert {reply.status for reply in replies} == {404}
    assert len({reply.body for reply in replies}) == 1
    assert all(reply.headers == replies[0].headers for reply in replies)
    assert server.token.encode() not in replies[0].body
    # What a page shows that is loaded again after its command has begun anew.
    assert b"started anew, open the address that it prints now" in replies[0].body


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=50)
@given(st.text(st.characters(min_codepoint=33, max_codepoint=126), max_size=40))
def test_no_path_without_the_secret_finds_anything(server: ViewerServer, path: str) -> None:
    assert Reply(server, f"/{path}").status == 404


@pytest.mark.parametrize(
    "host", ["", "evil.example", "evil.example:{port}", "127.0.0.1", "127.0.0.1:1", "[::1]:{port}"]
)
def test_a_name_of_somebody_else_is_refused(server: ViewerServer, host: str) -> None:
    """DNS rebinding: the secret is right, but the page would belong to another site."""
    reply = Reply(server, f"/{server.token}/", host=host.format(port=server.port))
    assert reply.status == 404
    assert reply.body == Reply(server, "/").body


def test_two_hosts_are_refused(server: ViewerServer) -> None:
    host = f"Host: 127.0.0.1:{server.port}\r\n"
    reply = _raw(server, f"GET /{server.token}/ HTTP/1.1\r\n{host}Host: evil.example\r\n\r\n")
    assert reply.startswith("HTTP/1.1 404")


def test_the_local_name_will_do(server: ViewerServer) -> None:
    reply = Reply(server, f"/{server.token}/?light", host=f"localhost:{server.port}")
    assert reply.status == 200


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS", "TRACE", "PATCH", "CAKE"])
@pytest.mark.parametrize("known", [True, False])
def test_only_reading(server: ViewerServer, method: str, known: bool) -> None:
    reply = Reply(server, f"/{server.token if known else 'x'}/", method)
    assert reply.status == 405
    assert reply.headers["Allow"] == "GET, HEAD"


def test_who_goes_away_or_lies_leaves_no_trace(
    server: ViewerServer, capfd: pytest.CaptureFixture[str]
) -> None:
    """Nobody fills the terminal: the address is all that stands there."""
    head = f"/{server.token}/ HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n"
    for _ in range(5):
        with socket.create_connection(("127.0.0.1", server.port)) as gone:
            gone.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            gone.sendall(f"GET {head}\r\n".encode())
    server._server.shelf["given"] = Receiver(lambda sent: Answer(text("taken")))
    own = f"Origin: http://127.0.0.1:{server.port}\r\nContent-Length: {'9' * 5000}\r\n"
    reply = _raw(server, f"POST {head.replace('/ ', '/given ', 1)}{own}\r\n")
    assert reply.startswith("HTTP/1.1 411")
    assert capfd.readouterr().err == ""


def test_head_is_get_without_a_body(server: ViewerServer) -> None:
    for path in (f"/{server.token}/model-0.glb", "/"):
        head, get = Reply(server, path, "HEAD"), Reply(server, path)
        assert head.body == b""
        assert (head.status, head.headers) == (get.status, get.headers)


def test_everything_is_sent_with_care(server: ViewerServer) -> None:
    for path in (f"/{server.token}/", f"/{server.token}/model-0.glb", "/"):
        headers = Reply(server, path).headers
        assert headers["Cache-Control"] == "no-store"
        assert headers["X-Content-Type-Options"] == "nosniff"
        assert headers["Referrer-Policy"] == "no-referrer"
        assert headers["Cross-Origin-Resource-Policy"] == "same-origin"
        assert headers["Content-Security-Policy"].startswith("default-src 'none'")
        assert "Python" not in headers["Server"]
        assert "Access-Control-Allow-Origin" not in headers


def test_the_page_may_run_its_own_scripts_only(server: ViewerServer) -> None:
    """The policy names the hash of the page's script, and neither data nor other scripts."""
    script = STAND_IN.partition('<script type="module">')[2].partition("</script>")[0]
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    policy = Reply(server, f"/{server.token}/").headers["Content-Security-Policy"]
    rules = dict(rule.strip().split(" ", 1) for rule in policy.split(";"))
    assert rules["script-src"] == f"'sha256-{digest}'"
    assert rules["connect-src"] == "'self' data: blob:"
    assert rules["frame-ancestors"] == rules["form-action"] == rules["base-uri"] == "'none'"
    assert not any("http" in rule for rule in rules.values())


def test_a_page_without_scripts_may_run_none() -> None:
    assert "script-src 'none'" in served_policy("<p>text</p>")


def test_only_a_page_with_decoders_may_compile_them() -> None:
    """And nothing else than WebAssembly: text is never a script."""
    unpacks = "<script>new WebAssembly.Module(bytes)</script>"
    for policy in (alone_policy, served_policy):
        assert "eval" not in policy(STAND_IN)
        assert policy(unpacks).count("eval") == policy(unpacks).count("'wasm-unsafe-eval'") == 1


def test_a_page_alone_may_not_even_ask_its_own_server() -> None:
    assert "'self'" in served_policy(STAND_IN)
    assert "'self'" not in alone_policy(STAND_IN)


def test_a_report_is_served_as_it_is() -> None:
    content = b"<!doctype html><script>let a = 1</script>\xc3\xa9"
    with serve_page(content) as server:
        reply = Reply(server, f"/{server.token}/")
    assert reply.body == content
    assert "'unsafe-inline'" in reply.headers["Content-Security-Policy"]


@pytest.mark.parametrize("port", [-1, 70000])
def test_ports_that_do_not_exist(port: int) -> None:
    with pytest.raises(em.ParameterError, match=str(port)):
        serve_page(b"", port)


@pytest.fixture
def port() -> Iterator[int]:
    """A port that only those get who ask for it: Linux gives no other program one that is bound."""
    with socket.socket() as holder:
        holder.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        holder.bind(("127.0.0.1", 0))
        found = holder.getsockname()[1]
        if sys.platform != "linux":  # others refuse it to all
            holder.close()
        yield found


def test_the_usual_port_or_a_free_one(
    scene: Scene, stand_in: str, port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same every time, so that browsers find what they kept; else it is said that it is not."""
    monkeypatch.setattr("elastomorph.viewer.server.USUAL_PORT", port)
    with serve(scene, None) as some:
        assert some.port == port
        with serve(scene, None) as other:
            assert other.port != some.port
            assert f"port {some.port} is in use, so the page begins without" in other.words
            assert Reply(other, f"/{other.token}/").status == 200
    for _ in range(2):
        with serve(scene, None) as again:
            assert again.port == some.port
            assert again.words == f"{again.address}\nshown to this machine only; Ctrl-C ends it"


def test_a_port_that_is_taken(server: ViewerServer) -> None:
    with pytest.raises(em.ParameterError, match=f"{server.port}.*free one"):
        serve_page(b"", server.port)


def test_it_ends_with_its_block(scene: Scene, stand_in: str) -> None:
    """Afterwards nobody listens and no thread of it is left."""
    before = set(threading.enumerate())
    with serve(scene) as server:
        assert Reply(server, f"/{server.token}/").status == 200
    with pytest.raises(ConnectionError):
        Reply(server, f"/{server.token}/")
    left = [t for t in set(threading.enumerate()) - before if "serve_forever" in t.name]
    assert not left


def test_an_embedded_page_is_the_same_scene(server: ViewerServer, scene: Scene) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("elastomorph.viewer.page.shipped_page", lambda: STAND_IN)
        from elastomorph.viewer import viewer_page

        _, (glb,) = scene_in(viewer_page(scene))
    assert glb == Reply(server, f"/{server.token}/model-0.glb").body


def _raw(server: ViewerServer, request: str) -> str:
    with socket.create_connection(("127.0.0.1", server.port), timeout=60) as connection:
        connection.sendall(request.encode("latin-1"))
        return connection.recv(65536).decode("latin-1")
