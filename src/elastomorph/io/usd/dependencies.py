"""Other files that a USD file is composed of: followed inside its folder or package, never out."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from elastomorph.io.usd.library import pxr

__all__ = ["outside_problem"]


def outside_problem(layer: Any, folder: Path, opening: Callable[[Path], None]) -> str:
    """Why a layer must not be composed, or nothing where it may.

    Sublayers, references and payloads, in all variants, must be files below the folder; links
    are resolved first. Those of a layer in a package (.usdz) must lie in that package. Search
    paths, URLs and value clips are not followed.

    Args:
        layer: The opened layer of the file.
        folder: Folder of the file, resolved.
        opening: Told of each other file before it is opened.
    """
    waiting, seen = [layer], {layer.identifier}
    known: set[str] = set()
    while waiting:
        current = waiting.pop()
        problem = _clips_problem(current)
        if problem:
            return problem
        for asset in filter(None, current.GetCompositionAssetDependencies()):
            target = _in_package(current, asset) or _in_folder(current, asset, folder)
            if not target:
                return (
                    f"it is composed of '{asset[:200]}', which is no file in its own folder; write "
                    "it as one file (usdcat --flatten) and read that"
                )
            if target in known:
                continue
            known.add(target)
            if not pxr("Ar").IsPackageRelativePath(target):
                opening(Path(target))
            opened = pxr("Sdf").Layer.FindOrOpen(target)
            if opened is None:
                return f"it is composed of '{asset[:200]}', which cannot be read"
            if opened.identifier not in seen:
                seen.add(opened.identifier)
                waiting.append(opened)
    return ""


def _in_folder(layer: Any, asset: str, folder: Path) -> str:
    """The file below the folder that a layer names, or nothing."""
    try:
        target = (Path(layer.realPath).parent / asset).resolve()
        inside = target.is_relative_to(folder) and target.is_file()
    except (OSError, ValueError, RuntimeError):
        inside = False
    return str(target) if inside else ""


def _in_package(layer: Any, asset: str) -> str:
    """What a layer in a package names in it, or nothing."""
    paths = pxr("Ar")
    target: str = pxr("Sdf").ComputeAssetPathRelativeToLayer(layer, asset)
    if not paths.IsPackageRelativePath(target):
        return ""
    package, part = paths.SplitPackageRelativePathOuter(target)
    own = paths.SplitPackageRelativePathOuter(layer.realPath)[0]
    return target if package == own and ".." not in part.split("/") else ""


def _clips_problem(layer: Any) -> str:
    found: list[str] = []

    def visit(path: Any) -> None:
        if path.IsPrimPath() or path.IsPrimVariantSelectionPath():
            spec = layer.GetObjectAtPath(path)
            if spec is not None and spec.HasInfo("clips"):
                found.append(str(path))

    layer.Traverse(pxr("Sdf").Path.absoluteRootPath, visit)
    if not found:
        return ""
    return f"the prim {found[0]} takes its values from clips in other files, which is not supported"
