"""Which function reads and writes which file: one table a kind of thing, found by suffix.

A format joins by one line in a table and a function that imports its package when a file of it is
first met, so a program that reads OBJ files never loads the rest.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from importlib.util import find_spec
from inspect import signature
from pathlib import Path
from typing import Any, Generic, TypeVar

from elastomorph.errors import FileError, FormatError, MissingExtraError, ParameterError
from elastomorph.io.atomic import is_file, is_folder, read_bytes, require_name
from elastomorph.io.untrusted import require_meant
from elastomorph.model.mesh import Mesh
from elastomorph.rig import Rig

T = TypeVar("T")

BUILT_IN = "built-in"
"""What our own head is called where a rig is named; a file of that name is ``./built-in``."""

Reader = Callable[..., T]
Writer = Callable[..., Any]


@dataclass(frozen=True)
class Format(Generic[T]):
    """How things of one kind are read from and written to files of one format.

    Attributes:
        name: What people call the format.
        suffixes: The suffixes its files have, in lower case, with the dot.
        load: Imports and returns its reader (path to thing) and its writer (path, thing and
            options of the format, through `atomic.replacing`; None if there is none).
        read_only: Whether files with these suffixes are not written.
        still: Options of its reader that let it read a rig without targets.
        package: What the writer imports, what that is called where it is installed from, and the
            extra of ours that brings it; None where the writer needs nothing more.
    """

    name: str
    suffixes: tuple[str, ...]
    load: Callable[[], tuple[Reader[T], Writer | None]]
    read_only: bool = False
    package: tuple[str, str, str] | None = None
    still: Mapping[str, bool] = field(default_factory=dict)

    def read(self, path: str | Path, **options: Any) -> T:
        """The thing in a file."""
        return self.load()[0](path, **options)


def _obj() -> tuple[Reader[Mesh], Writer]:
    from elastomorph.io.obj import read_obj, write_obj

    return read_obj, write_obj


def _ply() -> tuple[Reader[Mesh], Writer]:
    from elastomorph.io.ply import read_ply, write_ply

    return read_ply, write_ply


def _npz() -> tuple[Reader[Mesh], Writer]:
    from elastomorph.io.npz import read_npz, write_npz

    return read_npz, write_npz


def _npz_rig() -> tuple[Reader[Rig], Writer]:
    from elastomorph.io.npz.rig import read_rig_npz, write_rig_npz

    return read_rig_npz, write_rig_npz


def _gltf() -> tuple[Reader[Rig], Writer]:
    from elastomorph.io.gltf import read_glb, write_glb

    return read_glb, write_glb


def _usd() -> tuple[Reader[Rig], Writer]:
    from elastomorph.io.usd import read_usd, write_usd

    return read_usd, write_usd


def _fbx() -> tuple[Reader[Rig], None]:
    from elastomorph.io.fbx import read_fbx

    return read_fbx, None


MESH_FORMATS: tuple[Format[Mesh], ...] = (
    Format("Wavefront OBJ", (".obj",), _obj),
    Format("Stanford PLY", (".ply",), _ply),
    Format("NumPy archive", (".npz",), _npz),
)

_USD_FILES = (".usd", ".usda", ".usdc", ".usdz")
_STILL = {"still": True}
_USD_CORE = ("pxr", "usd-core", "usd")

RIG_FORMATS: tuple[Format[Rig], ...] = (
    Format("glTF binary", (".glb",), _gltf),
    Format("glTF", (".gltf",), _gltf, read_only=True),
    Format("VRM", (".vrm",), _gltf, read_only=True),
    Format("USD", _USD_FILES, _usd, package=_USD_CORE, still=_STILL),
    Format("Autodesk FBX", (".fbx",), _fbx, read_only=True, still=_STILL),
    Format("NumPy archive", (".npz",), _npz_rig),
)


def known_suffixes(formats: tuple[Format[Any], ...]) -> tuple[str, ...]:
    """The suffixes of a table, in its order."""
    return tuple(suffix for known in formats for suffix in known.suffixes)


def format_of(path: str | Path, formats: tuple[Format[T], ...]) -> Format[T]:
    """The format that the suffix of a path names; capitals do not matter."""
    require_name(path)
    suffix = Path(path).suffix.lower()
    for known in formats:
        if suffix in known.suffixes:
            return known
    found = f"unknown suffix '{suffix}'" if suffix else "the name has no suffix"
    expected = ", ".join(known_suffixes(formats))
    raise FormatError(path, f"{found}; expected one of {expected}{_other_door(path, formats)}")


def _other_door(path: str | Path, formats: tuple[Format[Any], ...]) -> str:
    """What opens a path whose suffix is that of another kind of thing."""
    suffix = Path(path).suffix.lower()
    if formats is MESH_FORMATS and is_folder(path):
        return ". This is a folder, perhaps of a rig; name the file of one mesh"
    if formats is MESH_FORMATS and suffix in known_suffixes(RIG_FORMATS):
        return f": files of {suffix} hold rigs, and this is for one mesh"
    if formats is RIG_FORMATS and suffix in known_suffixes(MESH_FORMATS):
        return f": files of {suffix} hold one mesh, and this is for a rig"
    return ""


def read(path: str | Path) -> Mesh:
    """The mesh in a file, in the vertex and polygon order of the file.

    Args:
        path: A file whose suffix names its format: .obj, .ply or .npz; or that of a rig (.glb,
            .gltf, .vrm, .usd, .usda, .usdc, .usdz, .fbx, .npz) without targets, its meshes as one.

    Raises:
        FileError: The file is missing or cannot be read.
        FormatError: The suffix is unknown, the content is not what the format allows, or it is a
            rig with targets.
        MissingExtraError: The format needs a package that is not installed.
    """
    require_there(path)
    if not _is_rig(path):
        return format_of(path, MESH_FORMATS).read(path)
    known = format_of(path, RIG_FORMATS)
    rig = known.read(path, **known.still)
    if rig.morphs:
        raise FormatError(
            path,
            f"this is a rig, targets: {len(rig.morphs):,}; expected a mesh without any: name it "
            "where a rig is asked for, or a file of the one mesh that is meant",
        )
    return rig.neutral


def _is_rig(path: str | Path) -> bool:
    if Path(path).suffix.lower() != ".npz":
        return Path(path).suffix.lower() in known_suffixes(RIG_FORMATS)
    from elastomorph.io.npz.members import open_npz

    with open_npz(path) as members:
        return "rig_version" in members.names


def require_there(path: str | Path) -> None:
    """Refuse a name without a suffix that nothing has: a mistyped folder, not an unknown format.

    A file that only stands for another is refused too, before any reader wonders about it.
    """
    require_name(path)
    if is_file(path):
        require_meant(path)
    if not Path(path).suffix and not is_file(path) and not is_folder(path):
        raise FileError(
            path, "there is no such file or folder; check the name and where it is looked for"
        )


def write(path: str | Path, thing: Mesh | Rig, **options: Any) -> Any:
    """Write a mesh or a rig, whole or not at all.

    Args:
        path: The file; its suffix names the format and its folder must exist.
        thing: A mesh (.obj, .ply, .npz): positions come back bit for bit; PLY keeps vertices and
            polygons, OBJ and NPZ everything. Or a rig (.glb, .usd, .usda, .usdc, .usdz,
            .npz).
        **options: Of the format, see its writer.

    Returns:
        What the writer reports: sizes and errors for .glb and USD, otherwise nothing.

    Raises:
        FormatError: The suffix is unknown, or the format cannot hold this thing.
        FileError: The file cannot be written.
        ParameterError: Neither a mesh nor a rig, or the format has no such option.
        MissingExtraError: The format needs a package that is not installed.
    """
    require_name(path)
    if isinstance(thing, Mesh | Rig):
        writer = writer_of(path, RIG_FORMATS if isinstance(thing, Rig) else MESH_FORMATS)
        _require_options(path, options, writer)
        return writer(path, thing, **options)
    raise ParameterError(
        f"expected a Mesh or a Rig to write, found {type(thing).__name__}; a MeshSequence is "
        "written with write_sequence"
    )


def _require_options(path: str | Path, options: Iterable[str], writer: Writer) -> None:
    own = [
        each.name for each in signature(writer).parameters.values() if each.default != each.empty
    ]
    for name in options:
        if name not in own:
            known = f"there are {', '.join(own)}" if own else "there are none"
            raise ParameterError(f"{path}: this format has no option {name!r}; {known}")


def writer_of(path: str | Path, formats: tuple[Format[Any], ...]) -> Writer:
    """The function that writes the format a path names."""
    writable = tuple(known for known in formats if not known.read_only)
    suffix = Path(path).suffix.lower()
    if suffix in known_suffixes(formats) and suffix not in known_suffixes(writable):
        raise FormatError(
            path,
            f"this format is only read; write one of {', '.join(known_suffixes(writable))} instead",
        )
    known = format_of(path, writable)
    if known.package is not None and find_spec(known.package[0]) is None:
        raise MissingExtraError(*known.package[1:])
    writer = known.load()[1]
    assert writer is not None
    return writer


def settings_used(path: str | Path) -> dict[str, Any] | None:
    """The tables of a character's settings that a rig or an evaluation (.json) was made with.

    None where it was made without any, or is a file of another kind.
    """
    suffix = Path(path).suffix.lower()
    if suffix in (".glb", ".gltf", ".vrm"):
        from elastomorph.io.gltf.container import open_gltf

        for mesh in open_gltf(path).items("meshes"):
            own: Any = mesh
            for name in ("extras", "elastomorph", "settings"):
                own = own.get(name) if isinstance(own, dict) else None
            if isinstance(own, dict):
                return own
    if suffix in _USD_FILES:
        from elastomorph.io.usd.reader import read_usd_settings

        return _parsed(read_usd_settings(path) or "")
    if suffix == ".npz":
        from elastomorph.io.npz.members import open_npz

        with open_npz(path) as members:
            there = "rig_version" in members.names and "settings" in members.names
            return _parsed(str(members.array("settings", "U", ()))) if there else None
    if suffix == ".json":
        return _table((_parsed(read_bytes(path)) or {}).get("settings"))
    return None


def _parsed(text: str | bytes) -> dict[str, Any] | None:
    try:
        return _table(json.loads(text))
    except (ValueError, RecursionError):
        return None


def _table(content: Any) -> dict[str, Any] | None:
    return content if isinstance(content, dict) else None
