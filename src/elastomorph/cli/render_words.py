"""What the words of ``elastomorph render`` stand for: rigs, references, sizes, views, colours."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from elastomorph.cli import options
from elastomorph.cli.output import Say
from elastomorph.errors import ParameterError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from elastomorph.draw.posed import Comparison, PosedRig
    from elastomorph.draw.stage import Lines
    from elastomorph.paths import Method
    from elastomorph.rig import Rig

_SMALLEST, _LARGEST = 16, 4096


def posed_rigs(
    rig: Rig, methods: Sequence[str], weights: Mapping[str, float], say: Say
) -> list[PosedRig]:
    """The rig once, or once for each method. Without methods it has the paths of its file."""
    from elastomorph.draw.posed import PosedRig, with_paths

    if not methods:
        return [PosedRig("", with_paths(rig, None, weights), weights)]
    say("finding paths")
    parsed = parsed_methods(methods)
    return [PosedRig(m.label, with_paths(rig, m, weights), weights) for m in parsed]


def parsed_methods(methods: Sequence[str]) -> list[Method]:
    """The methods that texts name, each once."""
    from elastomorph.paths import Method

    for number, text in enumerate(methods):
        if text in methods[:number]:
            raise ParameterError(f"--method {text} was given twice")
    return [Method.parse(text) for text in methods]


def comparison(
    rigs: Sequence[PosedRig],
    times: Sequence[float],
    against: str | None,
    highest: float | None,
    unit: str,
    say: Say,
) -> Comparison | None:
    """How far the rigs are from what ``--against`` names, or None where it names nothing."""
    from elastomorph.draw.posed import compare

    if against is None:
        return None
    name, at = _reference(against, rigs[0], say)
    say("measuring distances")
    return compare(rigs, sorted(set(times)), name, at, highest=highest, unit=unit)


def _reference(
    against: str, posed: PosedRig, say: Say
) -> tuple[str, Callable[[float], NDArray[np.float64]]]:
    """The name and the positions, at each time, of a method, another rig or a mesh."""
    from elastomorph.draw.posed import PosedRig, with_paths
    from elastomorph.model.mesh import require_same_topology
    from elastomorph.paths import Method

    try:
        method = Method.parse(against)
    except ParameterError as error:
        if not (Path(against).exists() or Path(against).suffix or against == "built-in"):
            raise ParameterError(
                f"--against {against!r} is neither a file nor a method: {error}"
            ) from None
    else:
        other = PosedRig(method.label, with_paths(posed.rig, method, posed.weights), posed.weights)
        return other.label, other.at
    rig = drawn_rig(against, say)
    require_same_topology(posed.rig.neutral, rig.neutral)
    name = Path(against).stem
    if not rig.names:
        return name, lambda _: rig.neutral.vertices
    return name, PosedRig(name, with_paths(rig, None, posed.weights), posed.weights).at


def curves_of(rig: Rig, say: Say) -> tuple[Lines, ...]:
    """The curves that beams follow, as lines."""
    from elastomorph.curves import extract_curves
    from elastomorph.draw.curves_picture import network_lines

    say("finding curves")
    return network_lines(rig.neutral, extract_curves(rig.neutral))


def drawn_rig(
    named: str,
    say: Say,
    settings: Path | None = None,
    mesh: Sequence[str] | None = None,
    *,
    as_stored: bool = False,
) -> Rig:
    """A rig, paths that no one has chosen left out; a plain mesh becomes one without sliders."""
    from elastomorph.io import read
    from elastomorph.rig import Rig

    source = options.NamedRig.of(named, settings, "linear" if as_stored else None, mesh)
    if source.settings is not None:
        return source.full(say)
    if source.place is None or not holds_mesh(source.place):
        return source.stored(say)
    say(f"reading {source.place}")
    if mesh:
        raise ParameterError(f"{source.place} holds one mesh: leave out --mesh")
    return Rig(read(source.place), {})


def holds_mesh(path: Path) -> bool:
    """Whether a file is a mesh without targets; an archive (.npz) may be one or a rig."""
    from elastomorph.io.npz.members import open_npz
    from elastomorph.io.registry import MESH_FORMATS, known_suffixes

    suffix = path.suffix.lower()
    if path.is_dir() or suffix not in known_suffixes(MESH_FORMATS):
        return False
    if suffix != ".npz":
        return True
    with open_npz(path) as members:
        return "rig_version" not in members.names


def picture_size(text: str | None, otherwise: tuple[int, int]) -> tuple[int, int]:
    """Width and height from ``720x900``."""
    if text is None:
        return otherwise
    found = re.fullmatch(r"(\d{1,9})\s*[x×*,]\s*(\d{1,9})", text.strip().lower())
    if found is None:
        raise ParameterError(f"--size {text!r}: expected width and height in pixels, as in 720x900")
    width, height = int(found[1]), int(found[2])
    if not all(_SMALLEST <= side <= _LARGEST for side in (width, height)):
        raise ParameterError(
            f"--size {text!r}: width and height must be from {_SMALLEST} to {_LARGEST} pixels"
        )
    return width, height


def view_of(text: str) -> str | tuple[float, float]:
    """A view by name, or degrees to the face's left and up from ``30,10``."""
    from elastomorph.draw.camera import VIEWS

    name = text.strip().lower()
    if name in VIEWS:
        return name
    try:
        left, up = (float(word) for word in name.split(","))
    except ValueError:
        left = up = math.nan
    if not (math.isfinite(left) and abs(up) < 90):
        raise ParameterError(
            f"--view {text!r}: expected one of {', '.join(VIEWS)}, or degrees to the face's left "
            "and up (above -90 and below 90), as in 30,10"
        )
    return left, up


def background_of(text: str | None) -> tuple[float, float, float] | None:
    """Red, green, blue from 0 to 1 of a colour's name or #rrggbb; None is transparent."""
    from elastomorph.draw.pictures import colour_named
    from elastomorph.draw.stage import BACKGROUND

    if text is None:
        return BACKGROUND
    return None if text.strip().lower() == "transparent" else colour_named(text)
