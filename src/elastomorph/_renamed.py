"""Modules under the names they had: imported as before until 0.3, with a warning."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.machinery import ModuleSpec
from types import ModuleType

from elastomorph.errors import warn

__all__ = ["accept_old_names"]

_MODEL = """
    bend_curve mesh morph polygons sequence surface
"""
_GEOMETRY = "components extent rigid"
_DRAW = """
    actors camera clips curves_picture figure framing graphs materials movie pictures
    posed stage strips time_laws window
"""
_NEW_NAMES = {
    **{f"elastomorph.{name}": f"elastomorph.model.{name}" for name in _MODEL.split()},
    **{f"elastomorph.report.{name}": f"elastomorph.draw.{name}" for name in _DRAW.split()},
    **{f"elastomorph.{name}": "elastomorph.model.geometry" for name in _GEOMETRY.split()},
    "elastomorph.baking": "elastomorph.paths.bake",
    "elastomorph.io.performance_csv": "elastomorph.io.performance",
    "elastomorph.performance": "elastomorph.rig.performance",
    "elastomorph.physics.load": "elastomorph.physics.equation",
    "elastomorph.physics.material": "elastomorph.physics.equation",
    "elastomorph.polygon_normals": "elastomorph.model.polygons",
    "elastomorph.report.page": "elastomorph.report",
    "elastomorph.rotations": "elastomorph.paths.rotations",
    "elastomorph.settings": "elastomorph.character",
    "elastomorph.timing": "elastomorph.rig.timing",
}
"""Today's name of each module or package that had another."""


def accept_old_names() -> None:
    """Let `import` find renamed modules.

    Asked first: what is in a renamed package would be found in its folder, and loaded twice.
    """
    if not any(isinstance(finder, _RenamedModules) for finder in sys.meta_path):
        sys.meta_path.insert(0, _RenamedModules())


class _RenamedModules:
    """Finds a module by its old name and hands out the one there is today.

    A finder and a loader without their base classes, whose import would cost more than all of ours.
    """

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        return ModuleSpec(fullname, self) if _new_name(fullname) else None  # type: ignore[arg-type]

    def create_module(self, spec: ModuleSpec) -> None:
        """None: the usual module, to be replaced."""

    def exec_module(self, module: ModuleType) -> None:
        old = module.__name__
        new = _new_name(old)
        assert new is not None
        if old in _NEW_NAMES:
            message = f"{old} is now {new}; the old name works until elastomorph 0.3."
            warn(message, DeprecationWarning)
        sys.modules[old] = import_module(new)


def _new_name(old: str) -> str | None:
    package = old if old.startswith("elastomorph.") else ""
    while package and package not in _NEW_NAMES:
        package, _, _ = package.rpartition(".")
    return _NEW_NAMES[package] + old[len(package) :] if package else None
