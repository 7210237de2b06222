"""Opens a stage whose files all lie where they may, in the process of a worker."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Sequence
from dataclasses import dataclass
from os.path import commonpath, normpath
from pathlib import Path
from tempfile import gettempdir
from typing import Any

from elastomorph.io.atomic import is_file
from elastomorph.io.isolated import RefusedError, allow_for
from elastomorph.io.usd.library import ROOT_VARIABLE, original_in, pxr

_LEAST_DEPTH = 3
"""Parts of a folder that is a project's own: not ``/``, nor ``/mnt``, but ``/mnt/show``."""


@dataclass(frozen=True, eq=False)
class Composed:
    """A stage, its root layer, and the files that it is composed of besides."""

    layer: Any
    stage: Any
    files: tuple[str, ...]  # Whole paths of the other files, those in packages left out
    folders: tuple[Path, ...]  # Below which they lie
    size_of_others: int  # Their size in bytes


def open_composed(source: str, root: str | None = None) -> Composed:
    """The stage in a file.

    Sublayers, references and payloads, in all variants, must be files below a folder: ``root``, the
    one that the environment names (`ROOT_VARIABLE`), or the common parent of the files that layers
    name relative to themselves, as far as it is no place that other projects share (see
    `_is_shared`). Links are resolved before they are judged, and neither they nor absolute paths
    make that folder larger. Files of a layer in a package (.usdz) must lie in that package. Search
    paths, URLs and value clips are not followed. A layer of `elastomorph.bend` may lie anywhere:
    what it says of the content of its original proves that whoever wrote it had that file.
    """
    root = root or os.environ.get(ROOT_VARIABLE) or None
    file = Path(source).parent.resolve() / Path(source).name
    folder = file.parent if root is None else Path(root).resolve()
    if not file.resolve().is_relative_to(folder) and root is not None:
        raise RefusedError(
            f"it is not in the root {folder}, as its files must be; name a higher one"
        )
    layer = pxr("Sdf").Layer.FindOrOpen(str(file))
    if layer is None:
        raise RefusedError("USD cannot read it")
    roots = [folder]
    files, size = _follow(layer, roots, fixed=root is not None)
    stage = pxr("Usd").Stage.Open(layer)
    for used in stage.GetUsedLayers():
        # what was judged is what USD has opened, whatever its resolver made of the names
        own = pxr("Ar").SplitPackageRelativePathOuter(used.realPath)[0]
        if own and Path(own) != file and not _is_below(own, roots):
            raise RefusedError(_refusal(layer, own))
    return Composed(layer, stage, files, tuple(roots), size)


def _is_shared(folder: Path) -> bool:
    """Whether a folder is the disk, one on top of it, all homes, a home, or for what passes by."""
    home = Path.home().resolve()
    shared = (home, *home.parents, Path(gettempdir()).resolve())
    return len(folder.parts) < _LEAST_DEPTH or folder in shared


def _is_below(path: str | Path, roots: Sequence[Path]) -> bool:
    """Whether a file, links resolved, lies in one of some folders."""
    try:
        whole = Path(path).resolve()
        return whole.is_file() and any(map(whole.is_relative_to, roots))
    except (OSError, ValueError, RuntimeError):
        return False


def digest_of(path: str | Path) -> str:
    """SHA-256 of the content of a file."""
    with Path(path).open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _follow(layer: Any, roots: list[Path], *, fixed: bool) -> tuple[tuple[str, ...], int]:
    """Open the files that a layer is composed of; their paths, and bytes of those beside it.

    The first root becomes larger by what layers name, unless it is fixed; the folder of an original
    that lies elsewhere is a second.
    """
    waiting, seen = [(layer, 0)], {layer.identifier}
    known: dict[str, None] = {}
    size_of_others = 0
    while waiting:
        current, root = waiting.pop()
        _refuse_clips(current)
        for asset in filter(None, current.GetCompositionAssetDependencies()):
            there = root
            original = original_in(current) if current is layer else None
            target = _in_package(current, asset) or _proven(layer, asset) * (original is not None)
            if original and target and not _is_below(target, roots):
                roots.append(Path(target).parent.resolve())
                there = 1
            if not target and not _is_packed(current):
                target = _beside(current, asset)
                if not (fixed or original or Path(asset).is_absolute()):
                    roots[root] = _widened(roots[root], target)
                target = target if _is_below(target, roots[root : root + 1]) else ""
            if not target:
                raise RefusedError(_refusal(current, asset))
            if target in known:
                continue
            known[target] = None
            if not pxr("Ar").IsPackageRelativePath(target):
                size = Path(target).stat().st_size
                size_of_others += size
                allow_for(size)
            opened = pxr("Sdf").Layer.FindOrOpen(target)
            if opened is None:
                raise RefusedError(f"it is composed of '{asset[:200]}', which cannot be read")
            if opened.identifier not in seen:
                seen.add(opened.identifier)
                waiting.append((opened, there))
    return tuple(own for own in known if not pxr("Ar").IsPackageRelativePath(own)), size_of_others


def _refusal(layer: Any, asset: str) -> str:
    original = original_in(layer)
    if original is None or original.asset != asset:
        return (
            f"it is composed of '{asset[:200]}', which is no file in the folder of its files; "
            "name a higher folder, which holds all of them, as the root (--root), or write it as "
            "one file (usdcat --flatten)"
        )
    if is_file(_beside(layer, asset)):
        return (
            f"it is a layer over '{asset[:200]}', which has changed since and lies in another "
            "folder; bend that file again"
        )
    return (
        f"it is a layer over '{asset[:200]}', which is not there; put that file back, or bend it "
        "again where it is now"
    )


def _beside(layer: Any, asset: str) -> str:
    """The whole path that a layer names, as USD makes it: links are resolved when it is opened."""
    return normpath(Path(layer.realPath).parent / asset)


def _widened(root: Path, target: str) -> Path:
    """The common parent of a folder and a file, or the folder where others share that."""
    try:
        common = Path(commonpath([root, Path(target).parent]))
    except ValueError:  # on another drive
        return root
    return root if _is_shared(common) or not is_file(target) else common


def _is_packed(layer: Any) -> bool:
    packed = pxr("Ar").IsPackageRelativePath(layer.identifier)
    return bool(packed or layer.GetFileFormat().IsPackage())


def _proven(layer: Any, asset: str) -> str:
    """The original of a layer of ours, wherever it is, if its content is the one stated there."""
    original = original_in(layer)
    if original is None or original.asset != asset:
        return ""
    target = _beside(layer, asset)
    try:
        same = Path(target).is_file() and digest_of(target) == original.digest
    except (OSError, ValueError):
        same = False
    return target if same else ""


def _in_package(layer: Any, asset: str) -> str:
    """What a layer in a package names in it, or nothing."""
    paths = pxr("Ar")
    target: str = pxr("Sdf").ComputeAssetPathRelativeToLayer(layer, asset)
    if not paths.IsPackageRelativePath(target):
        return ""
    package, part = paths.SplitPackageRelativePathOuter(target)
    own = paths.SplitPackageRelativePathOuter(layer.realPath)[0]
    return target if package == own and ".." not in part.split("/") else ""


def _refuse_clips(layer: Any) -> None:
    def visit(path: Any) -> None:
        if path.IsPrimPath() or path.IsPrimVariantSelectionPath():
            spec = layer.GetObjectAtPath(path)
            if spec is not None and spec.HasInfo("clips"):
                raise RefusedError(
                    f"the prim {path} takes its values from clips in other files, which is not "
                    "supported"
                )

    layer.Traverse(pxr("Sdf").Path.absoluteRootPath, visit)
