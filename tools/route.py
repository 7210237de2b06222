"""Follows a vertex from an OBJ file to a GLB file, and tells whose functions run on the way.

    python tools/route.py

What runs only because a module is imported does not count. Printed as JSON: the files, and the
modules of the package that are imported by a name in a text.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FrameType
from typing import Any

PACKAGE = "elastomorph"
OURS = f"/{PACKAGE}/"


def followed(folder: Path) -> tuple[set[str], list[str]]:
    """The files whose functions run, and the modules imported by a name."""
    import elastomorph as em
    from elastomorph.samples import expressions, head

    neutral, smile = folder / "neutral.obj", folder / "smile.obj"
    em.write(neutral, head())
    em.write(smile, expressions()["grinning"])
    # Imported anew, so that names by which modules are imported are seen.
    for name in [name for name in sys.modules if name.partition(".")[0] == PACKAGE]:
        del sys.modules[name]
    files: set[str] = set()
    named: list[str] = []

    def note(frame: FrameType, event: str, argument: Any) -> None:
        if event != "call":
            return
        file, before = frame.f_code.co_filename, frame.f_back
        if OURS in file and file not in files and not imported(frame):
            files.add(file)
        by_name = frame.f_code.co_name == "import_module"
        if by_name and before is not None and OURS in before.f_code.co_filename:
            module = str(frame.f_locals["name"])
            named.extend([module] if module.startswith(PACKAGE) else [])

    sys.setprofile(note)
    import elastomorph as em

    mesh, target = em.read(neutral), em.read(smile)
    curves = em.extract_curves(mesh)
    morph = em.interpolate(mesh, target, method="beam", order=2, curves=curves)
    rig = em.Rig(mesh, {"smile": morph})
    rig.pose({"smile": 0.5})
    em.write(folder / "x.glb", rig)
    sys.setprofile(None)
    return files, named


def imported(frame: FrameType | None) -> bool:
    """Whether something runs because a module of the package is being imported."""
    while frame is not None:
        if frame.f_code.co_name == "<module>" and OURS in frame.f_code.co_filename:
            return True
        frame = frame.f_back
    return False


def main() -> None:
    """Print the files and the names."""
    with TemporaryDirectory() as folder:
        files, named = followed(Path(folder))
    print(json.dumps([sorted(files), named]))


if __name__ == "__main__":
    main()
