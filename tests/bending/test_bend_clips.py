"""Clips of a bent character play bent: every channel of weights, and what shares its samplers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from small_characters import SmallFile, flap_character
from test_bend_characters import _value, bent_file

import elastomorph as em
from elastomorph.io.gltf.accessors import read_floats
from elastomorph.io.gltf.container import GltfFile

TIMES = [0.0, 0.5, 2.0]
WEIGHTS = np.array([[0, 0], [1, 0.25], [0.25, 1]], dtype=float)


def sampler(file: SmallFile, values: Any, kind: str | None = "LINEAR", **fields: Any) -> Any:
    own = {"input": file.array(TIMES, min=[0.0], max=[2.0])}
    own["output"] = file.array(np.asarray(values).reshape(-1), **fields)
    return own if kind is None else own | {"interpolation": kind}


def clip(file: SmallFile, channels: list[tuple[int, Any]], samplers: list[Any]) -> None:
    listed = [{"sampler": number, "target": target} for number, target in channels]
    animation = {"name": "talk", "channels": listed, "samplers": samplers}
    file.json.setdefault("animations", []).append(animation)


def of_node(number: int) -> dict[str, Any]:
    return {"node": number, "path": "weights"}


def pointing(pointer: str) -> dict[str, Any]:
    return {"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}}


def keys(file: GltfFile, channel: int, count: int) -> tuple[Any, NDArray[np.float64], str]:
    """Times, values (T, count) or (T, 3, count) and interpolation of a channel of a clip."""
    animation = file.document["animations"][0]
    own = animation["samplers"][animation["channels"][channel]["sampler"]]
    times = read_floats(file, own["input"], 1, "a test")[:, 0]
    values = read_floats(file, own["output"], 1, "a test")
    kind = own.get("interpolation", "LINEAR")
    shape = (len(times), 3, count) if kind == "CUBICSPLINE" else (len(times), count)
    return times, values.reshape(shape), kind


def curves(file: GltfFile, mesh: int = 0) -> list[Any]:
    """The curve of each target that was added."""
    morphs = file.document["meshes"][mesh]["extras"]["elastomorph"]["morphs"]
    return [bend["curve"] for morph in morphs for bend in morph["bends"]]


@pytest.mark.parametrize("kind", ["STEP", "LINEAR", None])
def test_bends_follow_their_sliders_within_the_tolerance(tmp_path: Path, kind: str | None) -> None:
    file = flap_character()
    clip(file, [(0, of_node(0))], [sampler(file, WEIGHTS, kind)])
    bent = bent_file(file, tmp_path, keys_tolerance=1e-4)
    own = curves(bent)
    times, values, found = keys(bent, 0, 2 + len(own))
    assert found == (kind or "LINEAR")
    at = np.searchsorted(times, TIMES)
    np.testing.assert_array_equal(times[at], TIMES)
    np.testing.assert_array_equal(values[at, :2], WEIGHTS)
    if kind == "STEP":
        assert len(times) == len(TIMES)
        exact = [[_value(curve, t) for curve in own] for t in values[:, 0]]
        np.testing.assert_allclose(values[:, 2:], exact, atol=1e-6)
        return
    moments = np.linspace(0, 2, 401)
    t = np.interp(moments, TIMES, WEIGHTS[:, 0])
    lengths = [bend_length(bent, 2 + k) for k in range(len(own))]
    off = np.zeros(len(moments))
    for k, curve in enumerate(own):
        played = np.interp(moments, times, values[:, 2 + k])
        off += lengths[k] * np.abs(played - [_value(curve, each) for each in t])
    assert off.max() <= 1.1e-4 * em.bend(tmp_path / "a.glb", None).extent


def bend_length(file: GltfFile, target: int) -> float:
    primitives = file.document["meshes"][0]["primitives"]
    moved = [read_floats(file, p["targets"][target]["POSITION"], 3, "a test") for p in primitives]
    return max(float(np.linalg.norm(own, axis=1).max()) for own in moved)


def test_splines_keep_their_keys_and_what_sliders_do_between(tmp_path: Path) -> None:
    file = flap_character()
    values = np.zeros((3, 3, 2))
    values[:, 1] = WEIGHTS
    values[1, 0], values[1, 2] = [0.5, 0], [-0.25, 0]
    clip(file, [(0, of_node(0))], [sampler(file, values, "CUBICSPLINE")])
    bent = bent_file(file, tmp_path)
    times, found, kind = keys(bent, 0, 2 + len(curves(bent)))
    assert kind == "CUBICSPLINE"
    at = np.searchsorted(times, TIMES)
    np.testing.assert_array_equal(found[at, 1, :2], WEIGHTS)
    for moment in np.linspace(0, 2, 57):
        expected = spline(np.array(TIMES), values, moment)
        played = spline(times, found, moment)
        np.testing.assert_allclose(played[:2], expected, atol=2e-6)


def spline(times: Any, values: Any, moment: float) -> Any:
    """The formula of the specification of glTF."""
    k = min(int(np.searchsorted(times, moment, side="right")) - 1, len(times) - 2)
    span = times[k + 1] - times[k]
    u = (moment - times[k]) / span
    return (
        (2 * u**3 - 3 * u**2 + 1) * values[k, 1]
        + span * (u**3 - 2 * u**2 + u) * values[k, 2]
        + (-2 * u**3 + 3 * u**2) * values[k + 1, 1]
        + span * (u**3 - u**2) * values[k + 1, 0]
    )


def test_a_sampler_of_several_channels_serves_those_that_stay(tmp_path: Path) -> None:
    """It moves the teeth and another mesh of one target, that nothing bends."""
    file = flap_character()
    plain = {"POSITION": file.array(np.eye(3))}
    straight = {"POSITION": file.array(np.eye(3) * 0.1)}
    still = file.mesh([{"attributes": plain, "targets": [straight]}], name="ear")
    node = file.node(mesh=still)
    shared = sampler(file, WEIGHTS[:, 0])
    other = {"input": shared["input"], "output": file.array(WEIGHTS.reshape(-1))}
    clip(file, [(0, of_node(1)), (0, of_node(node)), (1, of_node(0))], [shared, other])
    before = dict(shared)
    bent = bent_file(file, tmp_path)
    animation = bent.document["animations"][0]
    assert animation["samplers"][0] == before
    # Nothing uses the other any more: what was added last is in its place.
    assert len(animation["samplers"]) == 3
    assert [own["sampler"] for own in animation["channels"]] == [2, 0, 1]
    assert keys(bent, 0, 1 + len(curves(bent, 1)))[1].shape[1] > 1
    assert "interpolation" not in animation["samplers"][1]


@pytest.mark.parametrize("dtype", ["|u1", "|i1", "<u2", "<i2"])
@pytest.mark.parametrize("kind", ["STEP", "LINEAR"])
def test_weights_of_whole_numbers_stay_whole(tmp_path: Path, kind: str, dtype: str) -> None:
    """In as many bits as hold sliders and bends together within the tolerance of keys."""
    file, largest = flap_character(), np.iinfo(dtype).max
    given = np.round(WEIGHTS * largest)
    number = file.array(given.reshape(-1), kind=dtype, normalized=True)
    clip(file, [(0, of_node(0))], [{**sampler(file, WEIGHTS, kind), "output": number}])
    bent = bent_file(file, tmp_path)
    own = curves(bent)
    times, values, _ = keys(bent, 0, 2 + len(own))
    output = bent.document["animations"][0]["samplers"][0]["output"]
    stored = bent.document["accessors"][output]
    assert stored["normalized"] is True
    assert stored["componentType"] in (5121, 5120, 5123, 5122)
    moments = TIMES if kind == "STEP" else np.linspace(0, 2, 401)
    sliders = [np.interp(moments, TIMES, each) for each in given.T / largest]
    asked = [*sliders, *([_value(curve, t) for t in sliders[0]] for curve in own)]
    played = [np.interp(moments, times, each) for each in values.T]
    lengths = [bend_length(bent, target) for target in range(2 + len(own))]
    off = sum(s * np.abs(a - b) for s, a, b in zip(lengths, played, asked, strict=True))
    assert off.max() <= 1.0e-4 * em.bend(tmp_path / "a.glb", None).extent
    floats = bent_file(file, tmp_path, keys_tolerance=1e-7)
    output = floats.document["animations"][0]["samplers"][0]["output"]
    assert floats.document["accessors"][output]["componentType"] == 5126
    assert "normalized" not in floats.document["accessors"][output]


@pytest.mark.parametrize("holder", ["nodes", "meshes"])
def test_pointers_to_all_weights_are_extended(tmp_path: Path, holder: str) -> None:
    file = flap_character()
    clip(file, [(0, pointing(f"/{holder}/0/weights"))], [sampler(file, WEIGHTS)])
    bent = bent_file(file, tmp_path)
    times, values, _ = keys(bent, 0, 2 + len(curves(bent)))
    assert len(times) > len(TIMES)
    assert values[:, 2:].any()


def test_a_pointer_to_one_weight_is_joined_by_those_of_its_bends(tmp_path: Path) -> None:
    file = flap_character()
    channels = [(0, pointing("/nodes/0/weights/0")), (1, pointing("/nodes/0/weights/1"))]
    clip(file, channels, [sampler(file, WEIGHTS[:, 0]), sampler(file, WEIGHTS[:, 1])])
    bent = bent_file(file, tmp_path)
    own = curves(bent)
    animation = bent.document["animations"][0]
    pointers = [
        each["target"]["extensions"]["KHR_animation_pointer"]["pointer"]
        for each in animation["channels"]
    ]
    expected = [f"/nodes/0/weights/{number}" for number in range(2 + len(own))]
    assert pointers == expected
    assert [each["sampler"] for each in animation["channels"][:2]] == [0, 1]
    for k, curve in enumerate(own):
        times, values, _ = keys(bent, 2 + k, 1)
        t = np.interp(times, TIMES, WEIGHTS[:, 0])
        np.testing.assert_allclose(values[:, 0], [_value(curve, each) for each in t], atol=1e-6)


def test_a_folded_path_is_played_by_the_weight_of_its_target(tmp_path: Path) -> None:
    """Of an ease, which is a multiple of its target, nothing is added but keys."""
    file = flap_character()
    clip(file, [(0, of_node(0))], [sampler(file, WEIGHTS)])
    bent = bent_file(file, tmp_path, method={"slide": "ease"}, only=["slide"], fold=True)
    mesh = bent.document["meshes"][0]
    assert len(mesh["primitives"][0]["targets"]) == 2
    fold = mesh["extras"]["elastomorph"]["morphs"][1]["fold"]
    assert mesh["extras"]["elastomorph"]["version"] == 2
    times, values, _ = keys(bent, 0, 2)
    t = np.interp(times, TIMES, WEIGHTS[:, 1])
    expected = [each + _value(fold, min(each, 1.0)) for each in t]
    np.testing.assert_allclose(values[:, 1], expected, atol=1e-6)
    assert "elastomorph" not in bent.document["meshes"][1]["extras"]


def test_other_channels_stay_as_they_are(tmp_path: Path) -> None:
    file = flap_character()
    moved = {"input": file.array(TIMES), "output": file.array(np.eye(3))}
    lit = pointing("/materials/0/emissiveFactor")
    clip(file, [(0, {"node": 0, "path": "translation"}), (0, lit)], [moved])
    bent = bent_file(file, tmp_path)
    assert bent.document["animations"] == file.json["animations"]
    report = em.bend(tmp_path / "a.glb", None)
    assert (report.clips, report.added_keys, report.key_error) == (0, 0, 0)
