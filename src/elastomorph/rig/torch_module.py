"""The rig as a differentiable PyTorch module, on any device.

For fitting faces to images and for batches on a GPU. PyTorch is optional: importing this module
without it raises `MissingExtraError`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from elastomorph.errors import MissingExtraError, ParameterError
from elastomorph.model.bend_curve import BendCurve
from elastomorph.rig.laws import PRODUCT, Corrective
from elastomorph.rig.rig import Rig

try:
    import torch
except ImportError:
    raise MissingExtraError("torch", "torch") from None


class RigModule(torch.nn.Module):
    """Faces from slider weights, differentiable with respect to weights and times.

    The neutral and the fields are buffers: ``module.to("cuda")`` moves them, and they are not
    trained unless you make them parameters.

    Args:
        rig: The rig.
        dtype: torch.float32 or torch.float64.
    """

    def __init__(self, rig: Rig, dtype: torch.dtype = torch.float32) -> None:
        super().__init__()
        self.names = rig.names
        self._drivers = rig.sliders.driver_columns
        self._laws = [rig.sliders.correctives.get(name) for name in rig.sliders.morphs]
        self._first_driver = [columns[0] for columns in self._drivers]
        matrix = rig.fields.matrix(np.float64)
        self.register_buffer("neutral", torch.from_numpy(matrix[0]).to(dtype))
        self.register_buffer("fields", torch.from_numpy(matrix[1:]).to(dtype))
        self._curves: list[list[int]] = []
        curves: list[BendCurve] = []
        for fields in rig.fields.morphs:
            self._curves.append(list(range(len(curves), len(curves) + len(fields.bend_curves))))
            curves += fields.bend_curves
        for number, curve in enumerate(curves):
            self.register_buffer(f"breaks{number}", torch.tensor(curve.breaks, dtype=dtype))
            rows = torch.tensor(curve.coefficients, dtype=dtype)
            self.register_buffer(f"coefficients{number}", rows)
        self._slopes = [curve.end_slopes for curve in curves]

    def forward(self, weights: torch.Tensor, times: torch.Tensor | None = None) -> torch.Tensor:
        """Positions of many faces.

        Args:
            weights: (S, J) one column for each slider in the order of ``names``.
            times: None: weights are path parameters, as `Rig.pose`. Otherwise (S, J) or anything
                that broadcasts to it: weights are ζ at these times, as `Rig.blend`.

        Returns:
            (S, V, 3) of the module's type, on its device.

        Raises:
            ParameterError: Weights of another shape.
        """
        if weights.ndim != 2 or weights.shape[1] != len(self.names):
            raise ParameterError(
                f"weights must have shape (S, {len(self.names)}), found {tuple(weights.shape)}"
            )
        given = zip(self._drivers, self._laws, strict=True)
        driven = torch.stack([_driven(weights[:, columns], law) for columns, law in given], dim=1)
        if times is None:
            zeta, moments = torch.ones_like(driven), driven
        else:
            zeta = driven
            moments = torch.broadcast_to(times, weights.shape)[:, self._first_driver]
        columns = []
        for number, curves in enumerate(self._curves):
            t = moments[:, number]
            factors = [t, *(self._bend(curve, t) for curve in curves)]
            columns += [zeta[:, number] * factor for factor in factors]
        faces = self.neutral + torch.stack(columns, dim=1) @ self.fields
        return faces.reshape(len(weights), -1, 3)

    def _bend(self, number: int, t: torch.Tensor) -> torch.Tensor:
        """A bend curve at times t: pieces inside [0, 1], end tangents beyond."""
        breaks: Any = getattr(self, f"breaks{number}")
        rows: Any = getattr(self, f"coefficients{number}")
        inside = t.clamp(0.0, 1.0)
        pieces = (torch.searchsorted(breaks, inside.detach(), right=True) - 1).clamp(
            0, len(breaks) - 2
        )
        local = inside - breaks[pieces]
        value = torch.zeros_like(t)
        for column in range(rows.shape[1] - 1, -1, -1):
            value = value * local + rows[pieces, column]
        first, last = self._slopes[number]
        return value + first * t.clamp(max=0.0) + last * (t - 1.0).clamp(min=0.0)


def _driven(weights: torch.Tensor, own: Corrective | None) -> torch.Tensor:
    """(S,) what the law of a corrective makes of the (S, n) weights of its drivers."""
    if own is None or own.law == PRODUCT:
        return weights.prod(dim=1)
    if own.law == "hinge":
        return (weights @ weights.new_tensor(own.numbers) - 1.0).clamp(min=0.0)
    if own.law == "min":
        return weights.amin(dim=1).clamp(min=0.0)
    if own.law == "softmin":
        # Where it is 0, all are 1, so that derivatives stay numbers.
        alive = (weights > 0).all(dim=1)
        above = torch.where(alive[:, None], weights, 1.0)
        least, power = above.amin(dim=1), own.numbers[0]
        mean = ((least[:, None] / above) ** power).mean(dim=1)
        return torch.where(alive, least * mean ** (-1.0 / power), 0.0)
    clamped = weights.clamp(0.0, 1.0)
    product, low, high = clamped.prod(dim=1), clamped.amin(dim=1), clamped.amax(dim=1)
    if own.law == "allMul":
        return product
    if own.law == "extMul":
        return low * high
    if own.law == "mulAvgExt":
        above, below = 2.0 * low * high, low + high
    else:
        above, below = weights.shape[1] * product, clamped.sum(dim=1)
    return above / torch.where(below > 0, below, 1.0)
