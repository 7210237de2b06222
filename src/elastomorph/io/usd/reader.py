"""A rig from USD: our own files as they were, any other as straight pieces between in-betweens."""

from __future__ import annotations

import os
import subprocess
import sys
import warnings
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from elastomorph.errors import ElastomorphWarning, FormatError, MissingExtraError
from elastomorph.io.atomic import opened
from elastomorph.io.checked import naming_file
from elastomorph.io.npz_members import open_npz
from elastomorph.io.usd import worker
from elastomorph.io.usd.names import prim_names
from elastomorph.io.usd.paths import morph_of, values_needed
from elastomorph.io.usd.scene import FoundShape, Scene
from elastomorph.io.usd.writer import SUFFIXES
from elastomorph.morph import Morph
from elastomorph.rig import Rig

__all__ = ["read_usd"]

_ALLOWANCE = 4 << 30
_EXPANSION = 200
# each thread reserves address space, which the limit of a machine with many cores would not allow
_ONE_THREAD = {"PXR_WORK_THREAD_LIMIT": "1", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
_SECONDS = 120.0
_SECONDS_PER_BYTE = 1e-6


def read_usd(path: str | Path, *, mesh: str | None = None) -> Rig:
    """The rig in a USD file.

    A file of `write_usd` comes back with its curved paths. Of any other, each in-between becomes
    a bend whose curve is a hat, so that the path is exactly the one UsdSkel plays. Positions are
    those of the mesh in its own space; polygons of a left-handed mesh are turned around. USD reads
    the file in a process of its own, as it ends the whole program on some damaged files.

    Args:
        path: A .usd, .usda or .usdc file. References, payloads and sublayers are followed within
            its own folder only.
        mesh: Name or path of the mesh to read, where several have blend shapes.

    Raises:
        MissingExtraError: usd-core is not installed.
        FileError: The file is missing or cannot be read.
        FormatError: It is not USD or damaged, several meshes have blend shapes or none has, or
            it is composed of files outside its folder.
    """
    if Path(path).suffix.lower() not in SUFFIXES:
        raise FormatError(path, f"expected a name that ends in {', '.join(SUFFIXES)}")
    with opened(path) as file:
        size = file.seek(0, 2)
    if find_spec("pxr") is None:
        raise MissingExtraError("usd-core", "usd")
    with TemporaryDirectory(prefix="elastomorph-") as folder:
        archive = Path(folder) / "scene.npz"
        _extract(path, archive, size, mesh or "")
        with open_npz(archive) as members:
            return _rig(path, Scene(path, members), _most_bytes(size))


def _most_bytes(size: int) -> int:
    """Most memory that a file of some size may take: USD itself needs much address space."""
    return _ALLOWANCE + _EXPANSION * size


def _extract(path: str | Path, archive: Path, size: int, mesh: str) -> None:
    """Have the worker write an archive of the file's content."""
    problem = archive.with_name("problem.txt")
    source = str(Path(path).absolute())
    command = [sys.executable, "-m", "elastomorph.io.usd.worker"]
    try:
        ended = subprocess.run(
            [*command, source, str(archive), str(problem), str(_most_bytes(size)), mesh],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            env=os.environ | _ONE_THREAD,
            timeout=_SECONDS + _SECONDS_PER_BYTE * size,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise FormatError(
            path, f"USD did not finish reading it within {error.timeout:.0f} seconds"
        ) from None
    if ended.returncode == worker.REFUSED and problem.is_file():
        raise FormatError(path, problem.read_text(encoding="utf-8"))
    if ended.returncode != 0:
        last = ended.stderr.decode("utf-8", "replace").strip().splitlines()[-1:]
        said = f": {last[0][:200]}" if last and ended.returncode == 1 else ""
        raise FormatError(
            path,
            f"USD broke while reading it (exit status {ended.returncode}){said}; "
            "the file is damaged",
        )


def _rig(path: str | Path, scene: Scene, most_bytes: int) -> Rig:
    neutral = scene.mesh()
    count = len(neutral.vertices)
    found = [scene.shape(i, count) for i in range(scene.shape_count())]
    needed = 24 * count * sum(values_needed(shape) for shape in found)
    if needed > most_bytes:
        raise FormatError(
            path, f"its shapes would need {needed / 2**30:,.0f} GiB of memory, far beyond its size"
        )
    names = _names(found)
    morphs: dict[str, Morph] = {}
    for name, shape in zip(names, found, strict=True):
        morphs[name] = morph_of(path, neutral, name, shape)
    correctives = _lists(scene.sliders.get("correctives"))
    groups = _lists(scene.sliders.get("groups"))
    known = set(names)
    lost = any({n, *own} - known for n, own in correctives.items())
    lost = lost or any(set(own) - known for own in groups.values())
    if lost:
        warnings.warn(
            f"{path}: blend shapes that correctives or groups name are gone; both are left out",
            ElastomorphWarning,
            stacklevel=3,
        )
        correctives, groups = {}, {}
    with naming_file(path):
        return Rig(neutral, morphs, correctives=correctives, groups=groups)


def _names(shapes: list[FoundShape]) -> list[str]:
    """Our own names where the prims still have the names made from them; all different."""
    names: list[str] = []
    for shape in shapes:
        name = shape.token
        if shape.name is not None:
            plain = prim_names([shape.name])[0]
            rest = shape.token.removeprefix(plain)
            if shape.token.startswith(plain) and (not rest or rest[0] == "_"):
                name = shape.name
        free, number = name, 1
        while free in names:
            free, number = f"{name}_{number}", number + 1
        names.append(free)
    return names


def _lists(content: Any) -> dict[str, list[str]]:
    if not isinstance(content, Mapping):
        return {}
    return {
        str(name): [str(n) for n in own] for name, own in content.items() if isinstance(own, list)
    }
