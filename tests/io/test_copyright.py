"""Whose a mesh is stands in every file that is written, and comes back from those that keep it."""

from __future__ import annotations

from pathlib import Path

import pytest

import elastomorph as em
from elastomorph.io.obj import ownership

MIT = "© 2020 somebody, MIT licence"
POINTS = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]


def triangle(copyright: str) -> em.Mesh:
    return em.Mesh(POINTS, [[0, 1, 2]], copyright=copyright)


@pytest.mark.parametrize("suffix", ["glb", "npz", "usda", "usdc", "usdz"])
@pytest.mark.parametrize("said", ["", MIT])
def test_rigs_come_back_with_it(suffix: str, said: str, tmp_path: Path) -> None:
    if suffix.startswith("usd"):
        pytest.importorskip("pxr")
    mesh = triangle(said)
    rig = em.Rig(mesh, {"wide": mesh.with_vertices(2 * mesh.vertices)})
    em.write(tmp_path / f"rig.{suffix}", rig)
    assert em.read_rig(tmp_path / f"rig.{suffix}").neutral.copyright == said


def test_a_comment_of_another_program_is_no_copyright(tmp_path: Path) -> None:
    usd = pytest.importorskip("pxr.Usd")
    mesh = triangle("")
    em.write(tmp_path / "rig.usda", em.Rig(mesh, {"wide": mesh.with_vertices(2 * mesh.vertices)}))
    stage = usd.Stage.Open(str(tmp_path / "rig.usda"))
    stage.GetRootLayer().comment = "Exported by a program"
    stage.Save()
    assert not em.read_rig(tmp_path / "rig.usda").neutral.copyright


@pytest.mark.parametrize("said", ["", MIT])
def test_meshes_and_motions_of_arrays_come_back_with_it(said: str, tmp_path: Path) -> None:
    mesh = triangle(said)
    em.write(tmp_path / "mesh.npz", mesh)
    assert em.read(tmp_path / "mesh.npz").copyright == said
    frames = [mesh.vertices, 2 * mesh.vertices]
    em.write_sequence(tmp_path / "motion.npz", em.MeshSequence(mesh, frames, [0, 1]))
    assert em.read_sequence(tmp_path / "motion.npz").mesh.copyright == said


@pytest.mark.parametrize(
    ("suffix", "line"), [("obj", f"# {MIT}"), ("ply", "comment ? 2020 somebody, MIT licence")]
)
def test_text_says_it_in_a_comment(suffix: str, line: str, tmp_path: Path) -> None:
    for said in (MIT, ""):
        em.write(tmp_path / f"mesh.{suffix}", triangle(said))
        content = (tmp_path / f"mesh.{suffix}").read_bytes()
        assert (line.encode() in content.splitlines()) == bool(said)
        assert em.read(tmp_path / f"mesh.{suffix}").vertices.tolist() == POINTS


@pytest.mark.parametrize(
    ("said", "line"),
    [
        ("two\nlines\r\nv 1 2 3", ["two lines v 1 2 3"]),
        ("a\0b \\", ["a b"]),
        ("—", ["?"]),
        (" \n", []),
    ],
)
def test_a_comment_is_one_line_of_its_file(said: str, line: list[str]) -> None:
    """Nothing of it may be taken for a statement, nor the next line for a part of it."""
    assert ownership(triangle(said), "latin-1") == line
