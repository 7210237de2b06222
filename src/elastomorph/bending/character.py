"""`bend` and `unbend`: which file is bent by what, and what is no character."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from elastomorph.bending.report import BendReport
from elastomorph.errors import FileError, FormatError, ParameterError
from elastomorph.io.atomic import is_folder, require_name, require_writable
from elastomorph.io.registry import BUILT_IN, require_there
from elastomorph.paths import Method

if TYPE_CHECKING:
    from elastomorph.bending.usd import UsdBendReport
    from elastomorph.rig import Rig

_GLTF = (".glb", ".gltf", ".vrm")
_USD = (".usd", ".usda", ".usdc", ".usdz")
BENDABLE = _GLTF + _USD
"""Suffixes of files that are bent as they are."""


def bend(
    path: str | Path,
    output: str | Path | None,
    *,
    method: str | Method | Mapping[str, str | Method] | None = None,
    only: Collection[str] | None = None,
    tolerance: float | None = None,
    keys_tolerance: float | None = None,
    max_targets: int | None = None,
    fold: bool = False,
    compress: bool = False,
    source: str | Path | None = None,
    curves: str | Path | None = None,
    say: Callable[[str], None] = lambda _: None,
) -> BendReport | UsdBendReport:
    """Bend the paths of a character in its own file, and keep all the rest of it.

    All meshes with targets of the same names are one face, where the scene shows them at rest. For
    each target that bends, its bends are added as further morph targets behind all others
    (``jawOpen.bend1``), with names, default weights, animations of weights and the curves that a
    runtime follows (``extras.elastomorph`` of each mesh). Nothing else is touched, and the source
    is never written. A file that was bent before is bent anew from its original. Where nothing
    bends, nothing is written: the report's ``output`` is None.

    Of a USD file, the output is a layer over it: see `elastomorph.bending.usd.bend_usd`.

    Args:
        path: The character: .glb, .vrm, .gltf, .usd, .usda, .usdc, .usdz.
        output: The file to write, of the same format; None: nothing is written, and the report
            says what would be.
        method: How paths are made, as for `elastomorph.interpolate`, or by name of the target;
            ``auto`` by default.
        only: Names of the only targets that bend.
        tolerance: How closely bends hold the paths, as a fraction of D, the extent of what the
            targets move: 1.1e-4 by default (of which methods bake their paths within 1e-4), of the
            in-betweens of USD 5e-4.
        keys_tolerance: How closely animations follow the paths between their keys, likewise: 1e-4
            by default. Only for glTF, as the three that follow.
        max_targets: The most morph targets that a mesh may have; the bends that gain most come
            first.
        fold: Whether a bend that is a multiple of its Δ becomes a curve of the weight of Δ, which
            costs no target, but needs a runtime or an animation to be seen.
        compress: Whether what is added is packed by meshoptimizer, bends rounded to a
            ten-thousandth of their largest displacement; what the file had stays as it is. Of a
            file that it has packed, what is added always is. Players need its decoder:
            EXT_meshopt_compression.
        source: A bent character, or a file of its curves (.json), that a pipeline has made this
            file from. It gets the curves of that back, and no paths are made: its targets are
            found by their names, then by their numbers, then by their shapes.
        curves: A file to write the curves to as well (.json), for engines without access to extras.
        say: Told what is being done.

    Returns:
        What bends, by how much, and what it costs.

    Raises:
        FileError: A file is missing, or cannot be written.
        FormatError: The file is damaged, is no character, or has no targets.
        ParameterError: An option is out of its range, or names what is not there.
        BakeError: A turn is too sharp to be stored.
        MissingExtraError: The file needs a package that is not installed.
    """
    _require_character(path, "bend", output)
    options: dict[str, Any] = {"method": method, "only": only, "say": say}
    _require_curves(path, output, source, curves)
    if source is not None:
        made = (method, only, tolerance, keys_tolerance, max_targets, fold or compress or None)
        if any(given is not None for given in made):
            raise ParameterError(
                f"{path}: the curves of {source} are given back as they are; leave out what says "
                "how paths are made"
            )
        from elastomorph.bending.curves import give_back

        return give_back(path, output, source, curves, say)
    if Path(path).suffix.lower() in _USD:
        given = {"keys_tolerance": keys_tolerance, "max_targets": max_targets, "fold": fold or None}
        given["compress"] = compress or None
        return _bend_usd(path, output, given, tolerance=tolerance, **options)
    from elastomorph.bending.gltf import bend_gltf

    options |= {"tolerance": tolerance, "keys_tolerance": keys_tolerance}
    options |= {"fold": fold, "compress": compress, "curves": curves}
    return bend_gltf(path, output, max_targets=max_targets, **options)


def in_place(path: str | Path, output: str | Path | None) -> bool:
    """Whether `hold` changes a file where it is, or lies a layer over it, to write the output."""
    suffixes = {Path(name).suffix.lower() for name in (path, output or path)}
    return suffixes <= {*_GLTF} or suffixes <= {*_USD}


def hold(
    path: str | Path,
    output: str | Path | None,
    held: Callable[[Rig], Rig],
    *,
    say: Callable[[str], None] = lambda _: None,
) -> BendReport | UsdBendReport:
    """Add correctives to a character in its own file, bent or not, and keep all the rest of it.

    Args:
        path: The character, as for `bend`.
        output: The file to write if anything is added, of the same format; None: nothing is
            written, and the report says what would be.
        held: From the rig of the file to that with correctives.
        say: Told what is being done.

    Raises:
        ElastomorphError: As for `bend`, and what ``held`` raises.
    """
    _require_character(path, "hold", output)
    if Path(path).suffix.lower() in _USD:
        from elastomorph.bending.usd import hold_usd

        return hold_usd(path, output, held, say=say)
    from elastomorph.bending.gltf import hold_gltf

    return hold_gltf(path, output, held, say=say)


def _require_curves(
    path: str | Path,
    output: str | Path | None,
    source: str | Path | None,
    curves: str | Path | None,
) -> None:
    """Refuse what curves are not given back to, or written of."""
    if (source is not None or curves is not None) and Path(path).suffix.lower() in _USD:
        raise ParameterError(f"{path}: curves apart from a file are for glTF; USD has in-betweens")
    if source is not None:
        require_there(source)
        if Path(source).suffix.lower() not in (*_GLTF, ".json"):
            raise FormatError(source, f"curves are in a file of {', '.join(_GLTF)}, or .json")
    if curves is not None:
        if output is None and source is None:
            raise ParameterError(
                f"{curves}: curves are of a bent file; name an output for that too"
            )
        if Path(curves).suffix.lower() != ".json":
            raise FormatError(curves, "curves are written as JSON; name it with the suffix .json")
        require_writable(curves)


def _bend_usd(
    path: str | Path, output: str | Path | None, given: dict[str, Any], **options: Any
) -> UsdBendReport:
    for name, value in given.items():
        if value is not None:
            raise ParameterError(f"{path}: {name} is for glTF; a layer of USD has none")
    from elastomorph.bending.usd import bend_usd

    return bend_usd(path, output, **options)


def unbend(path: str | Path, output: str | Path) -> None:
    """Write the original of a bent character: its document equal as data, its bytes all the same.

    Args:
        path: A file that `bend` wrote. Of a layer of USD, the file it lies over is copied.
        output: The file to write, of the same format.

    Raises:
        FileError: A file is missing, or cannot be written.
        FormatError: The file was not made by `bend`, or has been changed since.
    """
    _require_character(path, "unbend", output)
    if Path(path).suffix.lower() in _USD:
        from elastomorph.bending.usd import unbend_usd

        unbend_usd(path, output)
        return
    from elastomorph.bending.gltf import unbend_gltf

    unbend_gltf(path, output)


def _require_character(path: str | Path, verb: str, output: str | Path | None) -> None:
    """Refuse what is no file of a character and say what to do instead, or no name of a file."""
    require_name(path)
    suffix = Path(path).suffix.lower()
    if str(path) == BUILT_IN:
        raise ParameterError(
            f"the built-in head is in no file to {verb}; export it first: "
            "elastomorph export built-in --method linear -o head.glb"
        )
    if is_folder(path):
        raise FileError(
            path,
            f"this is a folder of meshes, and no character to {verb}; "
            "'elastomorph export' makes one file with bent paths of it",
        )
    if suffix == ".fbx":
        raise FormatError(
            path,
            "FBX is only read; export the character as .glb or .vrm from the program that made it, "
            f"and {verb} that",
        )
    if suffix == ".npz":
        raise FormatError(
            path,
            "an archive of a rig has nothing but paths, and those are bent already where a method "
            "says so; 'elastomorph export' writes it as .glb",
        )
    require_there(path)
    if suffix not in BENDABLE:
        found = f"unknown suffix '{suffix}'" if suffix else "the name has no suffix"
        expected = ", ".join(_GLTF + _USD)
        raise FormatError(path, f"{found}; a character is a file of {expected}")
    if output is not None or verb == "unbend":
        require_name(output)
