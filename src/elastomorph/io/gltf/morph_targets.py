"""Which Δ and bends of a rig become morph targets, what they are called, and what is lost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.gltf.accessors import Grid, largest_move
from elastomorph.io.gltf.mesh_extras import Layout
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.morph import Morph
from elastomorph.model.polygons import Polygons
from elastomorph.rig import Rig

_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class KeptMorph:
    """The targets of one morph: Δ, then its bends, less one that Δ itself can play.

    A pair bend has no Δ.
    """

    first: int  # Number of its first target
    whole: bool  # Whether that is Δ
    bends: tuple[int, ...]  # The bends k that became targets
    # (V, 3) float64 of each of these bends, zero where it hardly moves
    displacements: tuple[NDArray[np.float64], ...]
    dropped: NDArray[np.float64]  # (V,) how far what was left out can move each, fraction of D
    rounding_error: float  # How far storing the numbers can move a vertex, fraction of D
    curves: tuple[BendCurve, ...]  # Of these bends
    folded: tuple[int, BendCurve] | None  # The bend that Δ plays, and what it adds to its weight

    @property
    def dropped_error(self) -> float:
        """How far what was left out can move a vertex, fraction of D."""
        return float(self.dropped.max(initial=0.0))

    @property
    def fold(self) -> BendCurve | None:
        """What is added to the weight of Δ."""
        return None if self.folded is None else self.folded[1]

    @classmethod
    def of(
        cls,
        morph: Morph,
        first: int,
        tolerance: float,
        grid: Grid | None = None,
        *,
        slider: bool = True,
    ) -> KeptMorph:
        """The targets of a morph from number ``first`` on; the tolerance is a fraction of D.

        A slider has a Δ in any case; other morphs have one where it moves anything.
        """
        scale = morph.neutral.diameter or 1.0
        kept: dict[int, NDArray[np.float64]] = {}
        dropped = np.zeros(len(morph.delta))
        rounded = [
            _rounding(morph.neutral.vertices, grid, placed=True),
            _rounding(morph.delta, grid),
        ]
        folded = _folded(morph)
        for k, (curve, bend) in enumerate(zip(morph.bend_curves, morph.bends, strict=True)):
            if folded is not None and k == folded[0]:
                continue
            peak = curve.height
            moves = peak / scale * np.linalg.norm(bend, axis=1)
            # What storing rounds away is left out too, not written as a bend that moves nothing.
            stored = bend + _rounding(bend, grid)
            small = (moves < tolerance) | (moves == 0) | ~stored.any(axis=1)
            dropped += np.where(small, moves, 0.0)
            if not small.all():
                kept[k] = np.where(small[:, None], 0.0, bend)
                rounded.append(peak * _rounding(kept[k], grid))
        error = largest_move(rounded) / scale
        curves = tuple(morph.bend_curves[k] for k in kept)
        whole = slider or bool(morph.delta.any()) or not kept
        return cls(first, whole, tuple(kept), tuple(kept.values()), dropped, error, curves, folded)

    def fields(self, morph: Morph) -> tuple[NDArray[np.float64], ...]:
        """What each of its targets moves, (V, 3)."""
        return (*((morph.delta,) if self.whole else ()), *self.displacements)

    def weights(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """(targets, T) weights of its targets at each t."""
        pace = times if self.fold is None else times + self.fold(times)
        whole = [pace] if self.whole else []
        return np.stack([*whole, *(curve(times) for curve in self.curves)])


def _folded(morph: Morph) -> tuple[int, BendCurve] | None:
    """The bend that is Δ itself and its curve, if the weight of Δ with it never runs back.

    Only then does a weight of Δ, as in an animation, say which t it stands for.
    """
    for k, (curve, bend) in enumerate(zip(morph.bend_curves, morph.bends, strict=True)):
        for sign in (1.0, -1.0) if bend.any() else ():
            if np.array_equal(bend, sign * morph.delta):
                times = np.unique(curve.times_within(65))
                rises = (np.diff(times + sign * curve(times)) >= -_ROUNDING).all()
                return (k, BendCurve(curve.breaks, sign * curve.coefficients)) if rises else None
    return None


@dataclass(frozen=True, eq=False)
class MorphTargets:
    """The morph targets of a rig."""

    names: tuple[str, ...]  # One a target
    morphs: tuple[KeptMorph, ...]  # The targets of each morph, in the order of the rig
    dropped: tuple[str, ...]  # Names of the bends left out

    @classmethod
    def of(cls, rig: Rig, tolerance: float, grid: Grid | None = None) -> MorphTargets:
        """All Δ, and of the bends what moves vertices farther than a fraction of D.

        They are stored in single precision, or in the steps of a grid.
        """
        names: list[str] = []
        dropped: list[str] = []
        morphs: list[KeptMorph] = []
        taken = set(rig.morphs)
        for name, morph in rig.morphs.items():
            slider = name in rig.sliders.drivers(name)
            own = KeptMorph.of(morph, len(names), tolerance, grid, slider=slider)
            morphs.append(own)
            names += [name] if own.whole else []
            for k in range(len(morph.bends)):
                if own.folded is not None and k == own.folded[0]:
                    continue
                title = f"{name}.bend{k + 1}"
                while title in taken:
                    title += "_"
                taken.add(title)
                (names if k in own.bends else dropped).append(title)
        return cls(tuple(names), tuple(morphs), tuple(dropped))


def targets_of_parts(
    rig: Rig, targets: MorphTargets, layout: Layout, tolerance: float
) -> tuple[NDArray[np.bool_], float]:
    """(P, T) which targets each mesh of a file has, and how far what is left out moves a vertex.

    A mesh has those that move a vertex of it, or of polygons around it, by more than a fraction of
    D; with a bend it has Δ, and with a corrective what drives that. What moves nothing is in the
    first.
    """
    count, faces = len(layout.primitives), rig.neutral.faces
    if count == 1 or not targets.names:
        dropped = max((kept.dropped_error for kept in targets.morphs), default=0.0)
        return np.ones((count, len(targets.names)), dtype=bool), dropped
    lengths = np.array(
        [
            np.linalg.norm(shape, axis=1) / (rig.neutral.diameter or 1.0)
            for morph, kept in zip(rig.morphs.values(), targets.morphs, strict=True)
            for shape in kept.fields(morph)
        ]
    )
    has = np.zeros((count, lengths.shape[1]), dtype=bool)
    for own, part in zip(has, layout.primitives, strict=True):
        own[layout.vertex_of[part.rows]] = True
    touched = np.logical_or.reduceat(has[:, faces.indices], faces.offsets[:-1], axis=1)
    lit = has.copy()
    mesh, corner = np.nonzero(np.repeat(touched, faces.sizes, axis=1))
    lit[mesh, faces.indices[corner]] = True
    found: NDArray[np.bool_] = lit @ (lengths > tolerance).T
    found[0] |= ~found.any(axis=0)
    first = {name: kept.first for name, kept in zip(rig.morphs, targets.morphs, strict=True)}
    starts = list(first.values())
    found[:, starts] = np.logical_or.reduceat(found, starts, axis=1)
    for name, law in rig.sliders.correctives.items():
        found[:, [first[driver] for driver in law.drivers]] |= found[:, [first[name]]]
    missed = np.add.reduceat(lengths * (~found.T @ has), starts, axis=0)
    return found, float((missed + [kept.dropped for kept in targets.morphs]).max())


def _rounding(
    values: NDArray[np.float64], grid: Grid | None, *, placed: bool = False
) -> NDArray[np.float64]:
    """(V, 3) how far storing moves displacements, or positions that are placed on a grid."""
    if grid is None:
        stored = values.astype(np.float32).astype(np.float64)
    else:
        stored = grid.stored_positions(values) if placed else grid.stored_displacements(values)
    return stored - values


# A bend that moves vertices less than this fraction of D turns no normal: what a fit would find
# for it is rounding over nothing.
_NOTHING = 1e-12

_UP = (0.0, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class NormalField:
    """The corners that vertex normals are summed over."""

    before: NDArray[np.int32]  # (C,) vertex before each corner
    at: NDArray[np.int32]  # (C,) vertex of each corner
    after: NDArray[np.int32]  # (C,) vertex after each corner

    @classmethod
    def of(cls, faces: Polygons) -> NormalField:
        """The corners of all polygons."""
        after = faces.next_corners
        before = np.empty_like(after)
        before[after] = np.arange(len(after))
        return cls(faces.indices[before], faces.indices, faces.indices[after])

    def normals(self, vertices: NDArray[np.float64]) -> NDArray[np.float64]:
        """(V, 3) unit normals of the vertices; (0, 0, 1) where there is no area around one."""
        here = vertices[self.at]
        to_next, to_last = vertices[self.after] - here, vertices[self.before] - here
        normal = np.cross(to_next, to_last)
        length = np.linalg.norm(normal, axis=1)
        angle = np.arctan2(length, np.einsum("ij,ij->i", to_next, to_last))
        weight = np.divide(angle, length, out=np.zeros_like(angle), where=length > 0)
        summed = np.stack(
            [
                np.bincount(self.at, weights=weight * normal[:, axis], minlength=len(vertices))
                for axis in range(3)
            ],
            axis=1,
        ).astype(np.float64)
        length = np.linalg.norm(summed, axis=1, keepdims=True)
        # Where polygons back on each other cancel, what is left is rounding and no direction.
        solid = length > 1e-9
        return np.where(solid, summed / np.where(solid, length, 1.0), _UP)


def normal_deltas(
    field: NormalField,
    morph: Morph,
    bends: Sequence[int],
    neutral_normals: NDArray[np.float64],
    fold: BendCurve | None = None,
) -> NDArray[np.float64]:
    """(1 + bends, V, 3) what Δ and some bends of a morph add to (V, 3) normals n₀: δ and d_k.

    δ has the weight of Δ, t or what a fold makes of it.
    """
    delta = field.normals(morph.target.vertices) - neutral_normals
    if not bends:
        return delta[None]
    times = _nodes(len(bends) + 3)
    pace = times if fold is None else times + fold(times)
    curves: list[BendCurve] = [morph.bend_curves[k] for k in bends]
    weights = np.stack([curve(times) for curve in curves], axis=1)
    missing = np.stack([field.normals(shape) for shape in morph.at(times)])
    missing -= neutral_normals + pace[:, None, None] * delta
    reach = np.abs(weights).max(axis=0) * np.abs(morph.bends[list(bends)]).max(axis=(1, 2))
    turns = reach > _NOTHING * (morph.neutral.diameter or 1.0)
    fitted = np.zeros((len(bends), *delta.shape))
    fitted[turns] = np.tensordot(np.linalg.pinv(weights[:, turns]), missing, axes=1)
    return np.concatenate([delta[None], fitted])


def _nodes(count: int) -> NDArray[np.float64]:
    return np.asarray((1 - np.cos(np.pi * (np.arange(count) + 0.5) / count)) / 2)
