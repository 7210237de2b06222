"""Rigs from wherever they are: a file, our own head, or a folder of meshes, one a neutral.

Files are read one after another: on two cores, threads save nothing, as parsing holds the
interpreter, and processes save no more than they cost to start (``benchmarks/rig_loading.py``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from elastomorph.curves import CurveNetwork
from elastomorph.errors import FileError, ParameterError
from elastomorph.io.atomic import is_file, is_folder, require_name, same_file
from elastomorph.io.npz.confidence import NAME as CONFIDENCE
from elastomorph.io.registry import (
    BUILT_IN,
    MESH_FORMATS,
    RIG_FORMATS,
    Format,
    format_of,
    known_suffixes,
    read,
    require_there,
)
from elastomorph.io.rig_cache import RigCache, read_or_build
from elastomorph.io.scan_colours import dressed
from elastomorph.model.mesh import Mesh, require_same_topology
from elastomorph.paths import Method
from elastomorph.rig import Rig
from elastomorph.rig.build import bare_rig, with_paths

_WORD = "neutral"


class RigFiles(NamedTuple):
    """The file of the neutral, and that of each target by its name, the file's without suffix."""

    neutral: Path
    targets: dict[str, Path]

    @property
    def all(self) -> tuple[Path, ...]:
        """The neutral, and the targets in the order of their names."""
        return (self.neutral, *self.targets.values())


def read_rig(path: str | Path, *, method: str | Method | None = None, **options: Any) -> Rig:
    """The rig in a file or a folder, or our own head.

    Args:
        path: A file (.glb, .gltf, .vrm, .usd, .usda, .usdc, .usdz, .fbx, .npz), a folder of mesh
            files, one of them with ``neutral`` in its name, or ``built-in``.
        method: Makes all paths anew, as for `elastomorph.interpolate`. Without it, paths that the
            file holds stay as they are, and targets without get the method ``auto``.
        **options: ``mesh`` of the reader, for a file with several meshes; ``root``, the folder in
            which all layers of a USD file must lie; ``neutral``, ``cache`` and ``say`` of
            `elastomorph.io.rig_folder.read_rig_folder`, for a folder, the last two
            for our own head too; ``curves``, and fields of `elastomorph.paths.Method`.

    Raises:
        FileError: The file or folder is missing or cannot be read.
        FormatError: The suffix is unknown, or the content is not what the format allows.
        TopologyError: A target of a folder has other vertices or polygons than the neutral.
        ParameterError: The method cannot be applied, or an option is not understood.
        MissingExtraError: The format needs a package that is not installed.
    """
    require_name(path)
    if is_folder(path) and str(path) != BUILT_IN:
        _refuse_options(path, options, ("mesh",), "a folder")
        return read_rig_folder(path, method=Method() if method is None else method, **options)
    _refuse_options(path, options, ("neutral",), "no folder")
    if str(path) == BUILT_IN:
        _refuse_options(path, options, ("mesh",), "our own head")
        return _built_in(method, **options)
    _refuse_options(path, options, ("cache",), "no folder")
    beside = {name: options.pop(name, None) for name in ("mesh", "root")}
    return with_paths(rig_as_stored(path, **beside, still=False), method, **options)


def _built_in(
    method: str | Method | None,
    *,
    cache: bool | str | Path | None = True,
    say: Callable[[str], None] = lambda _: None,
    **settings: Any,
) -> Rig:
    """Our own head: with the paths it comes with, or others, kept as those of a folder are."""
    from elastomorph import samples

    rig = samples.built_in_rig()
    if method is None and all(value is None for value in settings.values()):
        return rig
    folder = Path(samples.__file__).parent
    sources = {folder / f"{name}.npz": name for name in ("neutral", "shapes")}
    place = RigCache.of(
        cache if all(map(is_file, sources)) else None,
        folder / "shapes.npz",
        [method, sorted(settings.items())],
    )

    def built() -> Rig:
        return with_paths(rig, method, say=say, **settings)

    # An archive says of its neutral where it is from; this one is that of the samples.
    return _on(rig.neutral, read_or_build(place, sources, BUILT_IN, built, say))


def _on(neutral: Mesh, rig: Rig) -> Rig:
    """A rig on a neutral that is its own in all but what it says of itself."""
    morphs = {
        name: replace(own, neutral=neutral, target=neutral.with_vertices(own.target.vertices))
        for name, own in rig.morphs.items()
    }
    return Rig(neutral, morphs, correctives=rig.sliders.correctives)


def rig_as_stored(
    path: str | Path,
    *,
    mesh: str | Sequence[str] | None = None,
    root: str | Path | None = None,
    still: bool = True,
) -> Rig:
    """The rig in a file or a folder, or our own head, without a path where the source has none.

    Targets whose path the source leaves open are marked `elastomorph.Morph.bare`;
    `elastomorph.rig.build.with_paths` chooses one. Meshes without targets, ``still``, are a rig
    without morphs.
    """
    beside: dict[str, Any] = {} if mesh is None else {"mesh": mesh}
    if root is not None:
        if not str(path).lower().endswith((".usd", ".usda", ".usdc", ".usdz")):
            raise ParameterError(f"{path} is no USD file: leave out 'root'")
        beside["root"] = root
    if str(path) == BUILT_IN:
        from elastomorph.samples import built_in_rig

        _refuse_options(path, beside, ("mesh",), "our own head")
        return built_in_rig()
    if is_folder(path):
        _refuse_options(path, beside, ("mesh",), "a folder")
        straight = read_rig(path, method="linear")
        return bare_rig(straight.neutral, {n: m.target for n, m in straight.morphs.items()})
    require_there(path)
    known = format_of(path, RIG_FORMATS)
    if ".npz" in known.suffixes:
        _refuse_options(path, beside, ("mesh",), "an archive of one rig")
    return known.read(path, **beside, **(known.still if still else {}))


def _refuse_options(
    path: str | Path, options: dict[str, Any], names: Sequence[str], what: str
) -> None:
    for name in names:
        if options.get(name) is not None:
            raise ParameterError(f"{path} is {what}: leave out '{name}'")
        options.pop(name, None)


def read_rig_folder(
    folder: str | Path,
    *,
    neutral: str | Path | None = None,
    method: str | Method = "auto",
    curves: CurveNetwork | None = None,
    cache: bool | str | Path | None = True,
    say: Callable[[str], None] = lambda _: None,
    **settings: object,
) -> Rig:
    """The rig in a folder of mesh files.

    Args:
        folder: Where the files are. Hidden files and those of other formats are left alone.
        neutral: File of the neutral, by its name in the folder (with or without suffix) or by its
            path; by default the one with "neutral" in its name.
        method: The path from the neutral to every target, as for `elastomorph.interpolate`.
        curves: The curves that beams follow; found on the neutral by default.
        cache: Where the finished rig is kept to be read faster next time: True for the user's
            cache folder, a folder, None for nowhere. A cache that was not made from exactly these
            files, this method and this version of the package is not used.
        say: Told what is being done.
        **settings: Further settings of the method.

    Returns:
        The rig; its morphs in the order of their names, capitals first. Its neutral has the looks
        that the material library of an OBJ, or the images of a PLY, give it.

    Raises:
        FileError: No such folder, no neutral or several, no targets, or two of one name.
        FormatError: A file is not what its format allows.
        TopologyError: A target has other vertices or polygons than the neutral.
        ParameterError: A setting of the method is not understood.
    """
    files = find_rig_files(folder, neutral)
    place = RigCache.of(
        cache, Path(folder), [files.neutral.name, method, curves, sorted(settings.items())]
    )

    def built() -> Rig:
        say(f"reading {files.neutral.name}")
        face = read(files.neutral)
        # All targets first: how far they reach decides how close a straight line is to a turn.
        bare = bare_rig(face, read_targets(face, files.targets, say))
        return with_paths(bare, method, curves=curves, say=say, **settings)  # type: ignore[arg-type]

    rig = read_or_build(place, {file: file.name for file in files.all}, folder, built, say)
    face = dressed(rig.neutral)
    return rig if face is rig.neutral else _on(face, rig)


def find_rig_files(folder: str | Path, neutral: str | Path | None = None) -> RigFiles:
    """Which file of a folder is the neutral of a rig, and which are its targets.

    The neutral is named by its name in the folder, with or without suffix, or by its path; else it
    is the file called "neutral", or the only one with that word in its name.
    """
    place = Path(folder)
    files = _meshes_in(place)
    chosen = _only_neutral(place, files) if neutral is None else _named(place, files, neutral)
    targets: dict[str, Path] = {}
    for file in files:
        if file == chosen:
            continue
        if file.stem in targets:
            raise FileError(
                folder,
                f"{targets[file.stem].name} and {file.name} are both called '{file.stem}'; keep "
                "one file for each target",
            )
        targets[file.stem] = file
    if not targets:
        raise FileError(
            folder,
            f"there are no targets beside the neutral {chosen.name}; expected a mesh file "
            f"({', '.join(known_suffixes(MESH_FORMATS))}) for each",
        )
    return RigFiles(chosen, targets)


def find_neutral(folder: str | Path) -> Path:
    """The file of a folder that is the neutral of a rig by its name."""
    return _only_neutral(Path(folder), _meshes_in(Path(folder)))


def read_targets(
    neutral: Mesh, files: Mapping[str, Path], say: Callable[[str], None] = lambda _: None
) -> dict[str, Mesh]:
    """The targets of a neutral, which share its polygons and labels."""
    targets: dict[str, Mesh] = {}
    for name, file in files.items():
        say(f"reading {file.name}, {len(targets) + 1} of {len(files)}")
        target = read(file)
        require_same_topology(neutral, target)
        targets[name] = neutral.with_vertices(target.vertices)
    return targets


def _meshes_in(place: Path, formats: tuple[Format[Any], ...] = MESH_FORMATS) -> list[Path]:
    if not is_folder(place):
        what = "this is a file" if is_file(place) else "there is no such folder"
        raise FileError(place, f"{what}; name a folder with a neutral and its targets")
    try:
        return sorted(
            file
            for file in place.iterdir()
            if file.suffix.lower() in known_suffixes(formats)
            and not file.name.startswith(".")
            and file.name != CONFIDENCE
            and not file.is_dir()
        )
    except OSError as error:
        raise FileError(place, f"this folder cannot be listed: {error.strerror}") from error


def _only_neutral(place: Path, files: list[Path]) -> Path:
    # Where no mesh is called so, it may be the file of a rig, one without targets.
    called = [file for file in files if _WORD in file.stem.lower()] or [
        file for file in _meshes_in(place, RIG_FORMATS) if _WORD in file.stem.lower()
    ]
    exactly = [file for file in called if file.stem.lower() == _WORD]
    found = exactly if len(exactly) == 1 else called
    if len(found) == 1:
        return found[0]
    names = ", ".join(file.name for file in found) or "none"
    raise FileError(
        place,
        f"expected one mesh file with '{_WORD}' in its name among the {len(files)} there, found "
        f"{names}; rename it or say which file is the neutral",
    )


def _named(place: Path, files: list[Path], neutral: str | Path) -> Path:
    path = Path(neutral)
    for file in files:
        if str(neutral) in (file.name, file.stem):
            return file
    if is_file(path):
        return next((file for file in files if same_file(path, file)), path)
    raise FileError(
        place,
        f"there is no neutral '{neutral}', neither among the {len(files)} mesh files of this "
        "folder nor as a path; check the name",
    )
