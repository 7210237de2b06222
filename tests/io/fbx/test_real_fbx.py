"""A production head from Maya: what arrives is what its text says, read a second way."""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np
import pytest

from elastomorph.errors import FormatError
from elastomorph.io.fbx import read_fbx
from elastomorph.rig import Rig
from needs import installed

installed("ufbx", "fbx")

pytestmark = pytest.mark.realdata

ARKIT = re.findall(
    r"\w+",
    """
browInnerUp browDown_L browDown_R browOuterUp_L browOuterUp_R eyeLookUp_L eyeLookUp_R eyeLookDown_L
eyeLookDown_R eyeLookIn_L eyeLookIn_R eyeLookOut_L eyeLookOut_R eyeBlink_L eyeBlink_R eyeSquint_L
eyeSquint_R eyeWide_L eyeWide_R cheekPuff cheekSquint_L cheekSquint_R noseSneer_L noseSneer_R
jawOpen jawForward jawLeft jawRight mouthFunnel mouthPucker mouthLeft mouthRight mouthRollUpper
mouthRollLower mouthShrugUpper mouthShrugLower mouthClose mouthSmile_L mouthSmile_R mouthFrown_L
mouthFrown_R mouthDimple_L mouthDimple_R mouthUpperUp_L mouthUpperUp_R mouthLowerDown_L
mouthLowerDown_R mouthPress_L mouthPress_R mouthStretch_L mouthStretch_R tongueOut
""",
)


@pytest.fixture(scope="module")
def file(data_dir: Path) -> Path:
    path = data_dir / "facecap" / "FaceCapHeadGeneric.fbx"
    if not path.is_file():
        pytest.skip(f"needs real data: {path} is not there")
    return path


@pytest.fixture(scope="module")
def rig(file: Path) -> Rig:
    return read_fbx(file, mesh="head")


@pytest.fixture(scope="module")
def geometries(file: Path) -> dict[str, dict[str, np.ndarray]]:
    """The arrays of the largest mesh (called "") and of every shape, by their names."""
    found: dict[str, dict[str, np.ndarray]] = {}
    text = file.read_text("utf-8")
    for name, body in re.findall(
        r'Geometry: \d+, "Geometry::(\w*)", "\w+" \{(.*?)\n\t\}', text, re.DOTALL
    ):
        arrays = {
            key: np.array(values.replace("\n", "").split(","), dtype=float)
            for key, values in re.findall(r"(\w+): \*\d+ \{\s*a: ([^}]*?)\s*\}", body)
        }
        if name not in found or arrays["Vertices"].size > found[name]["Vertices"].size:
            found[name] = arrays
    return found


def test_all_52_shapes_have_their_arkit_names(rig: Rig) -> None:
    assert list(rig.names) == ARKIT


def test_points_and_polygons_are_those_of_the_text(
    rig: Rig, geometries: dict[str, dict[str, np.ndarray]]
) -> None:
    points = geometries[""]["Vertices"].reshape(-1, 3)
    assert len(points) == 2659
    assert rig.neutral.vertices.tobytes() == points.tobytes()
    flat = geometries[""]["PolygonVertexIndex"].astype(int)
    assert rig.neutral.faces.indices.tolist() == np.where(flat < 0, ~flat, flat).tolist()
    assert rig.neutral.faces.offsets[1:].tolist() == (np.flatnonzero(flat < 0) + 1).tolist()


@pytest.mark.parametrize("name", ARKIT)
def test_every_shape_is_that_of_the_text(
    rig: Rig, geometries: dict[str, dict[str, np.ndarray]], name: str
) -> None:
    shape = geometries[name]
    expected = geometries[""]["Vertices"].reshape(-1, 3).copy()
    expected[shape["Indexes"].astype(int)] += shape["Vertices"].reshape(-1, 3)
    assert rig.morphs[name].target.vertices.tobytes() == expected.tobytes()


def test_the_head_stands_upright_and_looks_at_us(rig: Rig) -> None:
    """Open jaw: down. Blinking lids: in the upper half, in front. Left: on the face's left, +X."""
    low, high = rig.neutral.vertices.min(axis=0), rig.neutral.vertices.max(axis=0)
    middle = (low + high) / 2

    def moved(name: str) -> tuple[np.ndarray, np.ndarray]:
        delta = rig.morphs[name].delta
        strength = np.linalg.norm(delta, axis=1)
        return np.average(rig.neutral.vertices, axis=0, weights=strength), delta.sum(axis=0)

    jaw, motion = moved("jawOpen")
    assert jaw[1] < middle[1]
    assert motion[1] < -abs(motion[0]) * 10
    for side, sign in (("L", 1), ("R", -1)):
        lid, motion = moved(f"eyeBlink_{side}")
        assert sign * lid[0] > 0
        assert lid[2] > middle[2]
        assert lid[1] > jaw[1]
        assert motion[1] < 0


def test_teeth_and_eyes_come_along_in_their_places(file: Path, rig: Rig) -> None:
    """In the order of the file; of them only the head has shapes."""
    whole = read_fbx(file)
    labels = whole.neutral.groups
    assert labels is not None
    counts = {"head": 2659, "teeth": 614, "eyeLeft": 482, "eyeRight": 482}
    assert set(labels.names) == set(counts)
    stops = np.cumsum([counts[name] for name in labels.names])
    of = {
        name: whole.neutral.vertices[stop - counts[name] : stop]
        for name, stop in zip(labels.names, stops, strict=True)
    }
    assert len(whole.neutral.vertices) == stops[-1]
    assert of["head"].tobytes() == rig.neutral.vertices.tobytes()
    assert whole.names == rig.names
    head = slice(*(stops[labels.names.index("head")] - [2659, 0]))
    for name in rig.names:
        delta = whole.morphs[name].delta
        assert delta[head].tobytes() == rig.morphs[name].delta.tobytes()
        assert not np.delete(delta, head, axis=0).any()
    left, right = of["eyeLeft"], of["eyeRight"]
    # behind the lids, mirror images of each other
    shut = rig.morphs["eyeBlink_R"].delta.any(axis=1)
    assert np.abs(right.mean(axis=0) - left.mean(axis=0) * [-1, 1, 1]).max() < 1e-3
    on_that_side = (left, right)[int(right.mean(axis=0)[0] < 0)]
    lids = rig.neutral.vertices[shut]
    assert (np.abs(on_that_side.mean(axis=0) - lids.mean(axis=0))[:2] < 1).all()


def test_the_file_cut_off_at_a_sample_of_lengths(file: Path, tmp_path: Path) -> None:
    """Never a crash: a refusal that names the file, or what of it is whole."""
    whole = file.read_bytes()
    path = tmp_path / "cut.fbx"
    path.write_bytes(whole)
    for length in np.linspace(0, len(whole) - 2, 14).astype(int)[::-1].tolist():
        os.truncate(path, length)
        try:
            assert len(read_fbx(path).neutral.vertices) > 0
        except FormatError as error:
            if str(path) not in str(error):
                raise
