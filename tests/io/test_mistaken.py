"""What lies there in place of a file is named for what it is, at every door."""

from __future__ import annotations

from pathlib import Path

import pytest

import elastomorph as em

POINTER = b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n"
PAGE = b"\xef\xbb\xbf\n<!DOCTYPE html>\n<html><body>Sign in</body></html>"


@pytest.mark.parametrize("suffix", [".glb", ".gltf", ".vrm", ".fbx", ".usda", ".usdz", ".npz"])
@pytest.mark.parametrize(("content", "words"), [(POINTER, "git lfs pull"), (PAGE, "web page")])
def test_a_rig_that_has_yet_to_be_fetched(
    tmp_path: Path, suffix: str, content: bytes, words: str
) -> None:
    path = tmp_path / f"face{suffix}"
    path.write_bytes(content)
    with pytest.raises(em.FormatError, match=words) as refused:
        em.read_rig(path)
    assert str(path) in str(refused.value)


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".npz"])
def test_a_mesh_that_has_yet_to_be_fetched(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"face{suffix}"
    path.write_bytes(POINTER)
    with pytest.raises(em.FormatError, match="git lfs pull"):
        em.read(path)


def test_characters_are_bent_from_files_of_their_own(tmp_path: Path) -> None:
    for content, words in ((POINTER, "git lfs pull"), (PAGE, "web page"), (b"", "empty")):
        (tmp_path / "a.vrm").write_bytes(content)
        with pytest.raises(em.FormatError, match=words):
            em.bend(tmp_path / "a.vrm", tmp_path / "b.vrm")
        assert not (tmp_path / "b.vrm").exists()
