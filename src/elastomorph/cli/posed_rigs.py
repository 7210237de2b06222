"""From what a user names to posed rigs: files, folders, meshes, methods to compare."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from elastomorph.cli import options

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from elastomorph.draw.posed import PosedRig
    from elastomorph.model.mesh import Mesh
    from elastomorph.rig import Rig

__all__ = ["posed_rigs", "reference"]

Say = Callable[[str], None]


def posed_rigs(
    named: str,
    methods: Sequence[str],
    weights: Mapping[str, float],
    say: Say,
    settings: Path | None = None,
    mesh: Sequence[str] | None = None,
) -> list[PosedRig]:
    """The rig once, or once for each method.

    Args:
        named: A rig file, a folder of meshes, a plain mesh, or ``built-in``.
        methods: Whose paths the rigs have; without any, those of the file.
        weights: Weights of the sliders.
        say: Told what is being done.
        settings: A settings file, where the folder of the rig has not its own.
        mesh: Names of the meshes meant, in a file with several.

    Raises:
        ParameterError: A method or slider is unknown, a method twice, or weights for a plain mesh.
        FileError: The file cannot be read.
    """
    from elastomorph.draw.posed import PosedRig, with_paths
    from elastomorph.errors import ParameterError
    from elastomorph.paths import Method

    parsed = [Method.parse(text) for text in methods]
    for number, text in enumerate(methods):
        if text in methods[:number]:
            raise ParameterError(f"--method {text} was given twice")
    rig = _rig(named, say, settings, mesh, as_stored=bool(parsed))
    if weights and not rig.names:
        raise ParameterError(f"{named} is a mesh without sliders, so there is nothing to --pose")
    rig.sliders.row(weights)
    if not parsed:
        return [PosedRig("", with_paths(rig, None, weights), weights)]
    say("finding paths")
    return [PosedRig(m.label, with_paths(rig, m, weights), weights) for m in parsed]


def reference(
    against: str, posed: PosedRig, say: Say
) -> tuple[str, Callable[[float], NDArray[np.float64]]]:
    """What distances are measured from: its name, and its positions at each time.

    Args:
        against: A method, for other paths to the same targets; another rig, under the same
            weights; or a mesh.
        posed: The rig whose distance is of interest.
        say: Told what is being done.

    Raises:
        ParameterError: No such method.
        FileError: No such file, or it cannot be read.
        TopologyError: The rig or mesh has other vertices or polygons.
    """
    from elastomorph.draw.posed import PosedRig, with_paths
    from elastomorph.errors import ParameterError
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
    rig = _rig(against, say)
    require_same_topology(posed.rig.neutral, rig.neutral)
    name = Path(against).stem
    if not rig.names:
        return name, lambda _: rig.neutral.vertices
    return name, PosedRig(name, with_paths(rig, None, posed.weights), posed.weights).at


def _rig(
    named: str,
    say: Say,
    settings: Path | None = None,
    mesh: Sequence[str] | None = None,
    *,
    as_stored: bool = False,
) -> Rig:
    """A rig, paths that no one has chosen left out; a plain mesh becomes one without sliders."""
    from elastomorph.errors import FormatError, ParameterError
    from elastomorph.io.registry import BUILT_IN, MESH_FORMATS, RIG_FORMATS, known_suffixes
    from elastomorph.io.rig_folder import rig_as_stored
    from elastomorph.rig import Rig

    path = options.named_rig(named, settings)
    chosen = options.settings_of(path, settings, "linear" if as_stored else None)
    if chosen is not None:
        return options.full_rig(path, None, say, chosen, mesh=mesh)
    say("building the head" if path is None else f"reading {path}")
    suffix = "" if path is None else path.suffix.lower()
    beside: dict[str, Any] = {"mesh": list(mesh)} if mesh else {}
    if path is None or path.is_dir() or suffix not in known_suffixes(MESH_FORMATS):
        return rig_as_stored(BUILT_IN if path is None else path, **beside)
    if mesh:
        raise ParameterError(f"{path} holds one mesh: leave out --mesh")
    if suffix in known_suffixes(RIG_FORMATS):  # .npz holds either
        try:
            return rig_as_stored(path)
        except FormatError as error:
            return Rig(_mesh(path, error), {})
    return Rig(_mesh(path), {})


def _mesh(path: Path, no_rig: Exception | None = None) -> Mesh:
    from elastomorph.errors import FormatError
    from elastomorph.io import read

    try:
        return read(path)
    except FormatError as error:
        raise no_rig or error from error
