"""A small character and settings for it, as tables that can be changed and written."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import numpy as np

import elastomorph as em
from foreign_files import write_foreign_glb
from small_meshes import cut_open, grid

SIDE = 7
LEFT = [SIDE * row + column for row in range(SIDE) for column in range(4)]


def sheet() -> em.Mesh:
    """A bent sheet of 6 × 6 quads."""
    return grid(SIDE, SIDE, lambda x, _: 0.05 * x * x)


def shapes() -> dict[str, em.Mesh]:
    """A sheet that turns, one that bulges, and one that bulges elsewhere."""
    neutral = sheet()
    x, y, z = neutral.vertices.T
    turned = np.stack([x, y * np.cos(1.0) - z * np.sin(1.0), y * np.sin(1.0)], axis=1)
    bulge = np.stack([0.1 * x * y, 0 * y, np.sin(x) + 0.2 * y], axis=1)
    other = np.stack([0 * x, 0.3 * np.sin(y), np.cos(x * y)], axis=1)
    return {
        "jawOpen": neutral.with_vertices(turned),
        "smile": neutral.with_vertices(neutral.vertices + bulge),
        "brow": neutral.with_vertices(neutral.vertices + other),
    }


def write_character(folder: Path) -> None:
    """The files that `TABLES` and its changes name."""
    neutral, targets = sheet(), shapes()
    em.write(folder / "neutral.obj", neutral)
    em.write(folder / "other_rest.obj", neutral.with_vertices(1.5 * neutral.vertices))
    (folder / "shapes").mkdir()
    for name, mesh in targets.items():
        em.write(folder / "shapes" / f"{name}.obj", mesh)
    for share in (0.3, 0.6):
        way = neutral.vertices + share**2 * (targets["brow"].vertices - neutral.vertices)
        em.write(folder / f"brow_{share * 100:.0f}.obj", neutral.with_vertices(way))
    (folder / "left.json").write_text(json.dumps(LEFT))
    (folder / "top.json").write_text(json.dumps(list(range(2 * SIDE))))
    drawn = [[SIDE * row + column for row in range(SIDE)] for column in range(SIDE)]
    (folder / "curves.json").write_text(json.dumps(drawn))
    (folder / "simplex.json").write_text(json.dumps(simplex_definition()))
    rig = em.Rig(neutral, {"smile": em.interpolate(neutral, targets["smile"])})
    em.write(folder / "head.npz", rig)
    write_foreign_glb(folder / "heads.glb", rig, nodes=("left", "right"))
    cut, origin = cut_open(neutral, np.arange(len(neutral.faces)) % 6 > 2)
    ends = {name: cut.with_vertices(mesh.vertices[origin]) for name, mesh in targets.items()}
    (folder / "cut").mkdir()
    em.write(folder / "cut" / "cut.npz", em.Rig(cut, ends, method="linear"))


def simplex_definition() -> dict[str, Any]:
    """What Simplex would write of two sliders and a combo of both: brow."""
    pairs = [[[0, 0.0], [number, 1.0]] for number in (1, 2, 3)]
    return {
        "encodingVersion": 3,
        "shapes": [{"name": name} for name in ("Rest", "jawOpen", "smile", "brow")],
        "progressions": [{"pairs": own} for own in pairs],
        "sliders": [{"name": "jaw", "prog": 0}, {"name": "smiling", "prog": 1}],
        "combos": [
            {"name": "both", "prog": 2, "pairs": [[0, 1.0], [1, 1.0]], "solveType": "extMul"}
        ],
    }


TABLES: dict[str, Any] = {
    "character": {"neutral": "neutral.obj", "targets": "shapes/*.obj"},
    "method": {"default": "beam:3"},
}


def changed(tables: dict[str, Any], **changes: Any) -> dict[str, Any]:
    """Tables with other values, as in ``changed(tables, method__default="arc")``; None is none."""
    new = copy.deepcopy(tables)
    for path, value in changes.items():
        *outer, last = path.split("__")
        inner = new
        for name in outer:
            inner = inner.setdefault(name, {})
        if value is None:
            inner.pop(last)
        else:
            inner[last] = value
    return new


def as_toml(tables: dict[str, Any], above: str = "") -> str:
    """The tables as TOML."""
    plain = {key: value for key, value in tables.items() if not isinstance(value, dict)}
    lines = [f"{json.dumps(key)} = {json.dumps(value)}" for key, value in plain.items()]
    page = "\n".join(([f"[{above}]"] if above else []) + lines) + "\n"
    for key, value in tables.items():
        if isinstance(value, dict):
            inner = f"{above}.{json.dumps(key)}" if above else json.dumps(key)
            page += "\n" + as_toml(value, inner)
    return page


def write_settings_file(
    folder: Path, tables: dict[str, Any], name: str = "elastomorph.toml"
) -> Path:
    """The tables as a settings file."""
    path = folder / name
    path.write_text(as_toml(tables))
    return path
