"""``elastomorph init``: settings for a folder, that change nothing until somebody edits them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from calls import status_of as run

import elastomorph as em
from elastomorph.character import read_settings, rig_from_settings
from elastomorph.io.npz.rig import rig_arrays
from elastomorph.io.rig_folder import read_rig_folder
from small_head import head, shapes


@pytest.fixture(scope="module")
def face(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The built-in head as a folder of meshes."""
    folder = tmp_path_factory.mktemp("face")
    em.write(folder / "neutral.obj", head())
    for name, mesh in shapes().items():
        em.write(folder / f"{name}.obj", mesh)
    return folder


@pytest.mark.slow
def test_the_rig_is_the_same_as_without(face: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """To the last bit, in the same order; and every line is a setting or a comment."""
    expected = rig_arrays(read_rig_folder(face, cache=None))
    assert run("init", face, "--json") == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["targets"] == facts["ARKit names"] == len(shapes())
    looks = [f"eyeLook{way}_{side}" for way in ("Down", "In", "Out", "Up") for side in "LR"]
    assert facts["turning"] == ["eyeBlink_L", "eyeBlink_R", *looks, "jawOpen"]
    settings = read_settings(face)
    found = rig_arrays(rig_from_settings(settings, cache=None))
    assert set(found) == set(expected)
    for name, array in expected.items():
        np.testing.assert_array_equal(found[name], array, err_msg=name)
    text = (face / "elastomorph.toml").read_text()
    assert f"# {len(shapes())} targets of {len(head().vertices):,} vertices" in text
    assert '#jawOpen = "rotation"' in text
    assert "#mouthClose" not in text  # a pair bend keeps it, and no product


def test_settings_are_not_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    em.write(tmp_path / "rest.obj", head())
    em.write(tmp_path / "jawOpen.obj", shapes()["jawOpen"])
    assert run("init", tmp_path) == 1
    assert "expected one mesh file with 'neutral'" in capsys.readouterr().err
    assert run("init", tmp_path, "--neutral", "rest.obj") == 0
    said = capsys.readouterr().out
    assert "elastomorph.toml" in said
    assert "jawOpen" in said
    (tmp_path / "elastomorph.toml").write_text("# mine")
    assert run("init", tmp_path, "--neutral", "rest.obj") == 1
    assert "--force" in capsys.readouterr().err
    assert (tmp_path / "elastomorph.toml").read_text() == "# mine"
    assert run("init", tmp_path, "--neutral", "rest.obj", "--force") == 0
    assert read_settings(tmp_path).character.neutral == "rest.obj"
    assert sorted(file.name for file in tmp_path.iterdir()) == [
        "elastomorph.toml",
        "jawOpen.obj",
        "rest.obj",
    ]
