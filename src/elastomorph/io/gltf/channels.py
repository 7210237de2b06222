"""The keys of one channel of an animation, straight between them, in steps, or along splines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.gltf.accessors import read_floats
from elastomorph.io.gltf.container import GltfFile

__all__ = ["Channel", "read_channel"]

Floats = NDArray[np.float64]

_JUMP = 1e-4
"""Seconds before a jump, where the value before it ends."""
_BETWEEN = 8
"""Keys put into each stretch of a spline."""


@dataclass(frozen=True, eq=False)
class Channel:
    """Keys, as glTF plays them.

    Attributes:
        names: What it moves: morph targets, or the parts of a quaternion.
        times: (T,) seconds, rising.
        values: (T, J), or (T, 3, J) of a spline: tangent before, value, tangent after.
        kind: LINEAR, STEP or CUBICSPLINE.
    """

    names: list[str]
    times: Floats
    values: Floats
    kind: str

    def moments(self) -> Floats:
        """(N,) times between which it is straight."""
        if self.kind == "STEP":
            return np.concatenate([self.times, self.times[1:] - _JUMP])
        if self.kind == "CUBICSPLINE":
            share = np.arange(1, _BETWEEN) / _BETWEEN
            between = self.times[:-1, None] + np.diff(self.times)[:, None] * share
            return np.concatenate([self.times, between.reshape(-1)])
        return self.times

    def at(self, when: Floats) -> Floats:
        """(N, J) weights at (N,) times."""
        last = len(self.times) - 1
        key = np.clip(np.searchsorted(self.times, when, side="right") - 1, 0, last)
        after = np.minimum(key + 1, last)
        length = np.where(after > key, self.times[after] - self.times[key], 1.0)
        share = np.clip((when - self.times[key]) / length, 0.0, 1.0)[:, None]
        if self.kind == "STEP":
            return np.asarray(self.values[key])
        if self.kind != "CUBICSPLINE":
            return np.asarray(self.values[key] * (1 - share) + self.values[after] * share)
        start, end = self.values[key, 1], self.values[after, 1]
        out, into = (length[:, None] * t for t in (self.values[key, 2], self.values[after, 0]))
        s, s2, s3 = share, share**2, share**3
        return np.asarray(
            (2 * s3 - 3 * s2 + 1) * start
            + (s3 - 2 * s2 + s) * out
            + (3 * s2 - 2 * s3) * end
            + (s3 - s2) * into
        )


def read_channel(
    file: GltfFile,
    samplers: list[Any],
    channel: dict[str, Any],
    names: list[str],
    of: str,
    width: int = 1,
) -> Channel:
    """The keys of a channel, one number a name, of so many in a row of the file."""
    number, what = channel.get("sampler"), "weights" if width == 1 else "rotations"
    if type(number) is not int or not 0 <= number < len(samplers):
        file.refuse(f"a channel of {of} has no sampler")
    sampler = samplers[number] if isinstance(samplers[number], dict) else {}
    kind = str(sampler.get("interpolation", "LINEAR"))
    times = read_floats(file, sampler.get("input"), 1, f"the times of {of}").reshape(-1)
    values = read_floats(file, sampler.get("output"), width, f"the {what} of {of}").reshape(-1)
    tangents = (3,) if kind == "CUBICSPLINE" else ()
    if not names or len(values) != len(times) * len(names) * (3 if tangents else 1):
        file.refuse(f"{of} has {len(values):,} {what} for {len(times):,} keys")
    if not (np.isfinite(times).all() and np.isfinite(values).all() and times[0] >= 0):
        file.refuse(f"{of} has times or {what} that are no finite numbers from 0")
    if (np.diff(times) <= 0).any():
        file.refuse(f"the times of {of} do not rise")
    return Channel(names, times, values.reshape(len(times), *tangents, len(names)), kind)
