"""Scans of a posed head, of a topology of their own: with noise, holes and a texture.

A scan is a grid over the directions from the middle of the head, met from outside, torn where the
depth jumps: nothing of it lies at a vertex of the head.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from photographs.rendering import Scene

__all__ = ["Scan", "scanned"]

_OUTSIDE = 40.0  # cm from the middle, where rays start
_LOW, _HIGH = -62.0, 80.0  # degrees of elevation: neither down the neck nor around the pole
_TORN = 3.0  # times the even distance of neighbours
_GAMMA = 1 / 1.4


@dataclass(frozen=True, eq=False)
class Scan:
    """A scan.

    Attributes:
        vertices: (V, 3).
        triangles: (T, 3).
        uv: (V, 2) in the texture, from its lower left corner.
        texture: (H, W, 3) uint8, red, green and blue; None without.
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]
    uv: NDArray[np.float64]
    texture: NDArray[np.uint8] | None

    def save(self, path: Path) -> None:
        """Write an OBJ; with a texture also its MTL and PNG beside it."""
        lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in self.vertices]
        corners = self.triangles + 1
        if self.texture is None:
            lines += [f"f {a} {b} {c}" for a, b, c in corners]
        else:
            lines = [f"mtllib {path.stem}.mtl", *lines, "usemtl skin"]
            lines += [f"vt {u:.6f} {v:.6f}" for u, v in self.uv]
            lines += [f"f {a}/{a} {b}/{b} {c}/{c}" for a, b, c in corners]
            path.with_suffix(".mtl").write_text(f"newmtl skin\nmap_Kd {path.stem}.png\n")
            cv2.imwrite(str(path.with_suffix(".png")), self.texture[:, :, ::-1])
        path.write_text("\n".join(lines) + "\n")


def scanned(
    scene: Scene,
    middle: tuple[float, float, float],
    seed: int,
    *,
    grid: tuple[int, int] = (430, 280),
    noise: float = 0.015,
    holes: int = 6,
    texture: int = 2048,
) -> Scan:
    """A scan of a posed head.

    Args:
        scene: The head.
        middle: (3,) within it, from which every part is seen.
        seed: Of noise, holes and how the grid is turned.
        grid: Columns around and rows down.
        noise: Standard deviation along the ray, in cm.
        holes: 0.4 to 1 cm in radius.
        texture: Width of the texture in pixels; 0 for none.
    """
    random = np.random.default_rng(seed)
    start = random.uniform(160, 200)  # where the texture is cut: at the back
    ways = _ways(*grid, start)
    points, colours = _met(scene, np.array(middle), ways.reshape(-1, 3), colour=False)
    del colours
    found = np.isfinite(points[:, 0])
    points = points + noise * random.normal(size=(len(points), 1)) * ways.reshape(-1, 3)
    for _ in range(holes):
        centre = points[random.choice(np.flatnonzero(found))]
        found &= np.linalg.norm(points - centre, axis=1) > random.uniform(0.4, 1.0)
    triangles = _untorn(points, found, grid)
    used, triangles = np.unique(triangles, return_inverse=True)
    columns, rows = grid
    across = (np.arange(columns) + 0.5) / columns
    down = 1 - (np.arange(rows) + 0.5) / rows
    uv = np.stack(np.meshgrid(across, down), axis=-1).reshape(-1, 2)[used]
    picture = _texture(scene, np.array(middle), texture, start) if texture else None
    return Scan(points[used], triangles.reshape(-1, 3), uv, picture)


def _ways(columns: int, rows: int, start: float) -> NDArray[np.float64]:
    """(rows, columns, 3) unit directions from the middle, high rows first."""
    around = np.radians(start + 360 * (np.arange(columns) + 0.5) / columns)
    up = np.radians(_HIGH - (_HIGH - _LOW) * (np.arange(rows) + 0.5) / rows)[:, None]
    parts = [np.sin(around) * np.cos(up), np.sin(up) + 0 * around, np.cos(around) * np.cos(up)]
    return np.stack(parts, axis=-1)


def _met(
    scene: Scene, middle: NDArray[np.float64], ways: NDArray[np.float64], *, colour: bool
) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
    """(n, 3) points met from outside, not finite where none; (n, 3) their colour if asked."""
    triangle, weights = scene.met(middle + _OUTSIDE * ways, -ways)
    hit = triangle >= 0
    points = np.full((len(ways), 3), np.nan)
    corners = scene.vertices[scene.surface.triangles[triangle[hit]]]
    points[hit] = np.einsum("nc,nca->na", weights[hit], corners)
    colours = np.zeros((len(ways) if colour else 0, 3), np.float32)
    if colour:
        colours[hit] = scene.unlit(triangle[hit], weights[hit])
    return points, colours


def _untorn(
    points: NDArray[np.float64], found: NDArray[np.bool_], grid: tuple[int, int]
) -> NDArray[np.int64]:
    """(T, 3) triangles between neighbours of the grid whose sides are short."""
    columns, rows = grid
    number = np.arange(columns * rows).reshape(rows, columns)
    quads = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    a, b, c, d = (corner.ravel() for corner in quads)
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    triangles = triangles[found[triangles].all(axis=1)]
    sides = points[triangles] - points[np.roll(triangles, 1, axis=1)]
    lengths = np.linalg.norm(sides, axis=2).max(axis=1)
    return triangles[lengths < _TORN * np.median(lengths)]


def _texture(
    scene: Scene, middle: NDArray[np.float64], width: int, start: float
) -> NDArray[np.uint8]:
    """The colour in every direction, in even light."""
    height = round(width * (_HIGH - _LOW) / 360)
    _, colours = _met(scene, middle, _ways(width, height, start).reshape(-1, 3), colour=True)
    shown = np.clip(0.9 * colours, 0, 1) ** _GAMMA * 255
    return shown.astype(np.uint8).reshape(height, width, 3)
