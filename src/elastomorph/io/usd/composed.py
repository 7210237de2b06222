"""Opens a stage whose files all lie where they may, in the process of a worker."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from elastomorph.io.isolated import RefusedError, allow_for
from elastomorph.io.usd.library import original_in, pxr


@dataclass(frozen=True, eq=False)
class Composed:
    """A stage, its root layer, and the files that it is composed of besides."""

    layer: Any
    stage: Any
    files: tuple[str, ...]  # Whole paths of the other files, those in packages left out
    folders: tuple[Path, ...]  # Below which they lie
    size_of_others: int  # Their size in bytes


def open_composed(source: str) -> Composed:
    """The stage in a file.

    Sublayers, references and payloads, in all variants, must be files below its folder; links are
    resolved first. Those of a layer in a package (.usdz) must lie in that package. Search paths,
    URLs and value clips are not followed. A layer of `elastomorph.bend` may lie anywhere: what it
    says of the content of its original proves that whoever wrote it had that file.
    """
    layer = pxr("Sdf").Layer.FindOrOpen(source)
    if layer is None:
        raise RefusedError("USD cannot read it")
    folder = Path(source).resolve().parent
    files, size = _follow(layer, folder)
    original = _proven_below(layer, folder, files)
    return Composed(layer, pxr("Usd").Stage.Open(layer), files, (folder, *original), size)


def _proven_below(layer: Any, folder: Path, files: tuple[str, ...]) -> list[Path]:
    """The folder of an original that lies elsewhere."""
    if original_in(layer) is None or not files:
        return []
    there = Path(files[0]).parent
    return [] if there.is_relative_to(folder) else [there]


def digest_of(path: str | Path) -> str:
    """SHA-256 of the content of a file."""
    with Path(path).open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _follow(layer: Any, folder: Path) -> tuple[tuple[str, ...], int]:
    """Open the files that a layer is composed of; their paths, and bytes of those beside it."""
    waiting, seen = [(layer, folder)], {layer.identifier}
    known: dict[str, None] = {}
    size_of_others = 0
    while waiting:
        current, own_folder = waiting.pop()
        _refuse_clips(current)
        for asset in filter(None, current.GetCompositionAssetDependencies()):
            target = _in_package(current, asset) or _in_folder(current, asset, own_folder)
            folder_there = own_folder
            if not target and current is layer:
                target = _proven(layer, asset)
                folder_there = Path(target).parent
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
                waiting.append((opened, folder_there))
    return tuple(own for own in known if not pxr("Ar").IsPackageRelativePath(own)), size_of_others


def _refusal(layer: Any, asset: str) -> str:
    original = original_in(layer)
    if original is None or original.asset != asset:
        return (
            f"it is composed of '{asset[:200]}', which is no file in its own folder; write "
            "it as one file (usdcat --flatten) and read that"
        )
    if Path(_beside(layer, asset) or "").is_file():
        return (
            f"it is a layer over '{asset[:200]}', which has changed since and lies in another "
            "folder; bend that file again"
        )
    return (
        f"it is a layer over '{asset[:200]}', which is not there; put that file back, or bend it "
        "again where it is now"
    )


def _beside(layer: Any, asset: str) -> str:
    """The whole path that a layer names, or nothing."""
    try:
        return str((Path(layer.realPath).parent / asset).resolve())
    except (OSError, ValueError, RuntimeError):
        return ""


def _in_folder(layer: Any, asset: str, folder: Path) -> str:
    """The file below the folder that a layer names, or nothing."""
    target = _beside(layer, asset)
    try:
        inside = bool(target) and Path(target).is_relative_to(folder) and Path(target).is_file()
    except (OSError, ValueError):
        inside = False
    return target if inside else ""


def _proven(layer: Any, asset: str) -> str:
    """The original of a layer of ours, wherever it is, if its content is the one stated there."""
    original = original_in(layer)
    if original is None or original.asset != asset:
        return ""
    target = _beside(layer, asset)
    try:
        same = bool(target) and Path(target).is_file() and digest_of(target) == original.digest
    except OSError:
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
