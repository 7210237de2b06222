"""The conformance kit: its vectors, and what a runtime must answer to them."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
from numpy.typing import NDArray

import elastomorph as em
from acceptance.runtime import bent_weights
from elastomorph.io.gltf import write_glb
from elastomorph.model.mesh import FaceLabels
from foreign_files import chunks_of, glb

RUNTIMES = Path(__file__).parents[2] / "runtimes"
KIT = RUNTIMES / "conformance"
REFUSED = json.loads((KIT / "vectors" / "refused.json").read_text(encoding="utf-8"))
SCHEMA = json.loads((KIT / "elastomorph.schema.json").read_text(encoding="utf-8"))
VECTORS: dict[str, dict[str, Any]] = {
    path.stem: json.loads(path.read_text(encoding="utf-8"))
    for path in sorted((KIT / "vectors").glob("*.json"))
    if path.stem != "refused"
}

# Products and sums differ in the last bits between processors and compilers.
DOUBLE, SINGLE = 1e-12, 1e-6


def require_same(found: Any, expected: Any, relative: float) -> None:
    """Numbers (…) agree, as a fraction of themselves, of 1 where they are smaller."""
    np.testing.assert_allclose(found, expected, rtol=relative, atol=relative)


def require_conforming(program: list[str]) -> None:
    """A program that answers the kit answers it as Python does.

    It is given the path of a file of the kit, and prints JSON: for a vector one object a pose with
    ``double`` and ``single``, the weights in both precisions; for ``refused.json`` one text an
    entry, why it was refused, null where it was not. A slider that a pose does not name is NaN.
    """
    for name, vector in VECTORS.items():
        answers = _answers(program, KIT / "vectors" / f"{name}.json")
        assert len(answers) == len(vector["poses"])
        for answer, pose in zip(answers, vector["poses"], strict=True):
            require_same(answer["double"], pose["weights"], DOUBLE)
            require_same(answer["single"], pose["weights"], SINGLE)
    whys = _answers(program, KIT / "vectors" / "refused.json")
    assert len(whys) == len(REFUSED)
    accepted = [own["why"] for own, why in zip(REFUSED, whys, strict=True) if not why]
    assert not accepted, f"not refused: {accepted}"


def face(*, materials: bool = False) -> em.Rig:
    """A rig with bends of several kinds of curve, correctives and a pair bend.

    In two materials if asked, of which the teeth have what jaw and both do.
    """
    rng = np.random.default_rng(3)
    of_faces = FaceLabels(("skin", "teeth"), np.array([0, 0, 1], np.int32)) if materials else None
    polygons = [[0, 1, 2], [2, 3, 4, 5], [6, 7, 8]]
    neutral = em.Mesh(rng.normal(size=(9, 3)), polygons, materials=of_faces)
    tent = em.BendCurve([0, 0.25, 1], [[0, 4], [1, -4 / 3]])

    def moved(count: int, vertices: int) -> NDArray[np.float64]:
        return rng.normal(size=(count, 9, 3)) * (np.arange(9) < vertices)[:, None]

    def morph(*curves: em.BendCurve, vertices: int = 9) -> em.Morph:
        shifts = moved(1 + len(curves), vertices)
        target = neutral.with_vertices(neutral.vertices + shifts[0])
        return em.Morph(neutral, target, shifts[1:], curves)

    morphs = {
        "jaw": morph(em.BendCurve.power(3), tent),
        "smile": morph(em.BendCurve.polynomial([0, 1, -1]), vertices=6),  # of the skin alone
        "both": morph(tent),
        "lids": morph(vertices=6),
        "jaw_smile": em.Morph(neutral, neutral, moved(1, 6), (em.BendCurve.power(2),)),
    }
    correctives = {
        "both": ["jaw", "both"],
        "lids": em.Corrective(("smile", "jaw"), "hinge", (0.5, 1.25)),
        "jaw_smile": em.Corrective(("jaw", "smile"), "min"),
    }
    return em.Rig(neutral, morphs, correctives=correctives)


def require_each_mesh_bent(program: list[str], folder: Path) -> None:
    """A program that answers the kit bends each mesh of a face in materials by its own extras."""
    write_glb(folder / "face.glb", face(materials=True), tolerance=0)
    meshes = chunks_of(folder / "face.glb")[0]["meshes"]
    assert ["smile" in own["extras"]["targetNames"] for own in meshes] == [True, False]
    sliders = {"jaw": 0.6, "smile": 1.2, "both": -0.3}
    for mesh in meshes:
        extras = mesh["extras"]
        vector = {"extras": extras, "poses": [{"sliders": sliders}]}
        (folder / "vector.json").write_text(json.dumps(vector), encoding="utf-8")
        (answer,) = _answers(program, folder / "vector.json")
        expected = bent_weights(extras["elastomorph"], extras["targetNames"], sliders)
        require_same(answer["double"], expected, DOUBLE)
        require_same(answer["single"], expected, SINGLE)


def _answers(program: list[str], path: Path) -> list[Any]:
    done = subprocess.run(
        [*program, str(path)], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 0, f"{path.name}: {done.stderr[-2000:]}"
    assert not done.stderr, done.stderr
    found: list[Any] = json.loads(done.stdout)
    return found


def written_now(folder: Path) -> dict[str, Any]:
    """The files of the kit as the command writes them now."""
    command = [sys.executable, str(KIT / "make_vectors.py"), str(folder)]
    subprocess.run(command, check=True, timeout=100, capture_output=True)
    return {
        path.stem: json.loads(path.read_text(encoding="utf-8")) for path in folder.glob("*.json")
    }


def glb_of(vector: dict[str, Any], path: Path) -> Path:
    """A file with the mesh of a vector; its numbers are the same in single precision."""
    neutral = np.array(vector["neutral"], dtype="<f4")
    shapes = [neutral, *(np.array(shape, dtype="<f4") for shape in vector["targets"])]
    triangles = np.array([0, 1, 2, 0, 2, 3], dtype="<u4")
    parts = [own.tobytes() for own in (*shapes, triangles)]
    starts = np.cumsum([0, *map(len, parts)]).tolist()
    kinds = [(5126, len(neutral), "VEC3")] * len(shapes) + [(5125, len(triangles), "SCALAR")]
    targets = [{"POSITION": 1 + i} for i in range(len(vector["targets"]))]
    primitive = {"attributes": {"POSITION": 0}, "indices": len(shapes), "targets": targets}
    document: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "face"}],
        "meshes": [{"extras": vector["extras"], "primitives": [primitive]}],
        "buffers": [{"byteLength": starts[-1]}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": start, "byteLength": len(part)}
            for start, part in zip(starts, parts, strict=False)
        ],
        "accessors": [
            {"bufferView": i, "componentType": kind, "count": count, "type": form}
            for i, (kind, count, form) in enumerate(kinds)
        ],
    }
    for accessor, shape in zip(document["accessors"], shapes, strict=False):
        accessor |= {"min": shape.min(axis=0).tolist(), "max": shape.max(axis=0).tolist()}
    path.write_bytes(glb(document, b"".join(parts)))
    return path


def strict_schema() -> jsonschema.Draft202012Validator:
    """The schema, refusing keys that it does not tell of."""
    return jsonschema.Draft202012Validator(_closed(SCHEMA))


def _closed(schema: Any) -> Any:
    """A schema that refuses keys it does not name, but where it names none, or some of them."""
    if isinstance(schema, list):
        return [_closed(entry) for entry in schema]
    if not isinstance(schema, dict):
        return schema
    conditions = ("if", "then", "dependentSchemas")
    inner = {k: value if k in conditions else _closed(value) for k, value in schema.items()}
    named = isinstance(schema.get("properties"), dict)
    return inner | {"additionalProperties": False} if named else inner
