"""Asks the command that shows a page for something, as the page does."""

from __future__ import annotations

import http.client
import json
from pathlib import Path
from typing import Any

from elastomorph.viewer import ViewerServer


def post(server: ViewerServer, path: str, body: bytes, **headers: str) -> tuple[int, bytes]:
    """Status and content of the answer; a header without a value is left out."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)
    own = {"Origin": f"http://127.0.0.1:{server.port}", **headers}
    kept = {name: value for name, value in own.items() if value}
    connection.request("POST", f"/{server.token}/{path}", body, kept)
    reply = connection.getresponse()
    found = reply.status, reply.read()
    connection.close()
    return found


def get(server: ViewerServer, path: str) -> tuple[int, bytes]:
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)
    connection.request("GET", f"/{server.token}/{path}")
    reply = connection.getresponse()
    found = reply.status, reply.read()
    connection.close()
    return found


def ask(server: ViewerServer, service: str, **question: Any) -> dict[str, Any]:
    """What comes of it: ``done`` or ``problem``, and what was said before under ``says``."""
    return told(*post(server, service, json.dumps(question).encode()))


def send(server: ViewerServer, files: dict[str, bytes | Path], service: str = "open") -> Any:
    """Files as a page sends them."""
    return told(*post(server, service, packed(files)))


def packed(files: dict[str, bytes | Path]) -> bytes:
    read = {
        name: each if isinstance(each, bytes) else each.read_bytes() for name, each in files.items()
    }
    listed = [[name, len(content)] for name, content in read.items()]
    return json.dumps({"files": listed}).encode() + b"\n" + b"".join(read.values())


def told(status: int, content: bytes) -> dict[str, Any]:
    assert status == 200, content
    lines = [json.loads(line) for line in content.splitlines()]
    assert all(list(line) == ["says"] for line in lines[:-1])
    return {**lines[-1], "says": [line["says"] for line in lines[:-1]]}
