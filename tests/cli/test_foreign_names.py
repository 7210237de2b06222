"""Names in another encoding than UTF-8 are shown and exported like any other."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from calls import status_of as run

import elastomorph as em

OBJ = b"v 0 0 0\nv 1 0 0\nv 0 1 0\ng \x96j\x83\x5c\nusemtl wei\xdf\nf 1 2 3\n"


def test_inspect_shows_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "face.obj").write_bytes(OBJ)
    assert run("inspect", tmp_path / "face.obj") == 0
    assert "weiß" in capsys.readouterr().out
    assert run("inspect", tmp_path / "face.obj", "--json") == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["materials"] == ["weiß"]
    assert facts["groups"] == [b"\x96j\x83\x5c".decode("latin-1")]


@pytest.mark.parametrize("suffix", [".glb", ".usda", ".npz"])
def test_rigs_keep_them(tmp_path: Path, suffix: str) -> None:
    (tmp_path / "face.obj").write_bytes(OBJ)
    neutral = em.read(tmp_path / "face.obj")
    moved = neutral.with_vertices(neutral.vertices + [[0, 0, 0], [0, 0, 0], [0, 0, 1]])
    rig = em.Rig(neutral, {"jawOpen": em.interpolate(neutral, moved, "linear")})
    em.write(tmp_path / f"rig{suffix}", rig)
    again = em.read_rig(tmp_path / f"rig{suffix}").neutral
    assert again.materials is not None
    assert again.groups is not None
    assert neutral.groups is not None
    assert again.materials.names == ("weiß",)
    assert again.groups.names == neutral.groups.names
