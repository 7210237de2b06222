"""Which weights of a recording drive which sliders of a rig."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import ParameterError
from elastomorph.numbers import first_few
from elastomorph.rig.naming import is_rotation, shape_of, wholes


class Drive(NamedTuple):
    """What drives one slider: the sum of weights, each times its factor.

    Attributes:
        names: Names of weights.
        factors: One factor each.
    """

    names: tuple[str, ...]
    factors: tuple[float, ...]


@dataclass(frozen=True)
class Match:
    """Which weights of a recording drive which sliders of a rig.

    Attributes:
        weights: Names in the recording, the columns that `drive` takes.
        sliders: Names on the rig, the columns that `drive` returns.
        drives: What drives each slider; those that nothing drives are left out.

    Raises:
        ParameterError: It names a weight or slider that is not there.
    """

    weights: tuple[str, ...]
    sliders: tuple[str, ...]
    drives: Mapping[str, Drive]

    def __post_init__(self) -> None:
        drives = {slider: Drive(*drive) for slider, drive in self.drives.items()}
        for slider, drive in drives.items():
            if slider not in self.sliders:
                raise ParameterError(f"the rig has no slider {slider!r} to drive")
            for name in drive.names:
                if name not in self.weights:
                    raise ParameterError(f"the recording has no weight {name!r} for {slider!r}")
            if len(drive.names) != len(drive.factors) or not np.isfinite(drive.factors).all():
                raise ParameterError(f"the slider {slider!r} needs one finite factor a weight")
        object.__setattr__(self, "drives", MappingProxyType(drives))

    @property
    def rotations(self) -> tuple[str, ...]:
        """Weights that are angles of the head and the eyes; they never drive a slider."""
        return tuple(name for name in self.weights if is_rotation(name))

    @property
    def unmatched_weights(self) -> tuple[str, ...]:
        """Weights in the recording that drive nothing, without the rotations."""
        used = {name for drive in self.drives.values() for name in drive.names}
        return tuple(n for n in self.weights if n not in used and not is_rotation(n))

    @property
    def unmatched_sliders(self) -> tuple[str, ...]:
        """Sliders on the rig that nothing drives: they stay at 0."""
        return tuple(name for name in self.sliders if name not in self.drives)

    @cached_property
    def factors(self) -> NDArray[np.float64]:
        """(N, J) what each weight adds to each slider."""
        table = np.zeros((len(self.weights), len(self.sliders)))
        for slider, drive in self.drives.items():
            column = self.sliders.index(slider)
            for name, factor in zip(drive.names, drive.factors, strict=True):
                table[self.weights.index(name), column] += factor
        return table

    def drive(self, weights: ArrayLike) -> NDArray[np.float64]:
        """(T, J) slider weights, in the order of the rig.

        Args:
            weights: (T, N) recorded weights.

        Raises:
            ParameterError: Another shape, or numbers that are not finite.
        """
        table = np.asarray(weights, dtype=np.float64)
        if table.ndim != 2 or table.shape[1] != len(self.weights):
            raise ParameterError(
                f"weights must have shape (T, {len(self.weights)}), found {table.shape}"
            )
        if not np.isfinite(table).all():
            raise ParameterError("weights must be finite numbers")
        return table @ self.factors

    def text(self, most: int | None = None) -> str:
        """The match for people: what drives what under another name, and what is left over.

        Args:
            most: How many of a kind are named; all by default.
        """
        used = len(self.weights) - len(self.rotations) - len(self.unmatched_weights)
        lines = [
            f"{used} of {len(self.weights) - len(self.rotations)} weights drive "
            f"{len(self.drives)} of {len(self.sliders)} sliders"
        ]
        otherwise = [
            f"  {slider} = {_formula(drive)}"
            for slider, drive in self.drives.items()
            if drive.factors != (1.0,) or shape_of(slider) != shape_of(drive.names[0])
        ]
        lines += otherwise[:most]
        if len(otherwise) > len(otherwise[:most]):
            lines.append(f"  and {len(otherwise[most:])} more")
        for title, names in (
            ("in the recording but not on the rig", self.unmatched_weights),
            ("on the rig but not driven", self.unmatched_sliders),
            ("rotations, which drive no slider", self.rotations),
        ):
            if names:
                lines.append(f"{title}: {first_few(names, len(names) if most is None else most)}")
        return "\n".join(lines)


def match(weights: Sequence[str], sliders: Sequence[str]) -> Match:
    """Find which weights drive which sliders.

    Equal shapes are matched first, whatever their spelling (see `naming`). Then, of what is left:
    one weight for both sides drives each side in full (``browInnerUp`` → ``browInnerUp_L``,
    ``browInnerUp_R``). Two sides drive one slider for both by their mean, not their maximum: the
    mean is right where they agree, closest to both where they do not, and never drives a wink to
    two closed eyes; both sides must be there. No weight drives in two of these ways, so a rig with
    a whole and its halves is not driven twice.

    Args:
        weights: Names in the recording.
        sliders: Names on the rig.

    Raises:
        ParameterError: A name is there twice, or two spellings of one shape leave it open which
            is meant.
    """
    for kind, names in (("recording", weights), ("rig", sliders)):
        if len(set(names)) != len(names):
            twice = next(name for name in names if list(names).count(name) > 1)
            raise ParameterError(f"the {kind} has {twice!r} twice; each needs its own name")
    recorded = _by_shape((n for n in weights if not is_rotation(n)), "recording")
    on_rig = _by_shape((n for n in sliders if not is_rotation(n)), "rig", weights)
    drives: dict[str, Drive] = {}
    used: set[str] = set()
    for shape, names in recorded.items():
        for slider in on_rig.pop(shape, []):
            drives[slider] = Drive((names[0],), (1.0,))
            used.add(shape)
    for whole, parts in wholes():
        if whole in recorded and whole not in used:
            for part in parts:
                for slider in on_rig.pop(part, []):
                    drives[slider] = Drive((recorded[whole][0],), (1.0,))
                    used.add(whole)
        elif whole in on_rig and all(part in recorded and part not in used for part in parts):
            drive = Drive(
                tuple(recorded[part][0] for part in parts), (1 / len(parts),) * len(parts)
            )
            drives.update(dict.fromkeys(on_rig.pop(whole), drive))
            used.update(parts)
    ordered = {slider: drives[slider] for slider in sliders if slider in drives}
    return Match(tuple(weights), tuple(sliders), ordered)


def _by_shape(
    names: Iterable[str], kind: str, preferred: Iterable[str] = ()
) -> dict[str, list[str]]:
    """The names of each shape; a name that no table has is a shape of its own.

    Several nodes of a rig (``face.jawOpen``, ``teeth.jawOpen``) may each have a shape once.
    """
    found: dict[str, dict[str, list[str]]] = {}
    for name in names:
        shape = shape_of(name) or name
        node = name[: max(name.rfind(":"), name.rfind(".")) + 1] if kind == "rig" else ""
        found.setdefault(shape, {}).setdefault(node, []).append(name)
    wanted = set(preferred)
    return {
        shape: [_only(shape, same, kind, wanted) for same in nodes.values()]
        for shape, nodes in found.items()
    }


def _only(shape: str, names: list[str], kind: str, wanted: set[str]) -> str:
    exact = [name for name in names if name in wanted] if len(names) > 1 else names
    if len(exact) != 1:
        raise ParameterError(
            f"the {kind} has {' and '.join(names)}, which are both {shape}; rename or leave out "
            "one of them"
        )
    return exact[0]


def _formula(drive: Drive) -> str:
    return " + ".join(
        name if factor == 1 else f"{factor:g} {name}"
        for name, factor in zip(drive.names, drive.factors, strict=True)
    )
