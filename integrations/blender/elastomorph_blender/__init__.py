"""elastomorph in Blender: shape keys that move along bent paths.

Bends are ordinary shape keys, driven by the keys they belong to. What Blender plays and exports
needs nothing of this extension.
"""

from . import gltf, operators, panel

__all__ = ["glTF2ExportUserExtension", "register", "unregister"]

# Blender's glTF exporter asks each enabled extension for a class of this name.
glTF2ExportUserExtension = gltf.CurvesOfMeshes  # noqa: N816


def register() -> None:
    """Called by Blender when the extension is enabled."""
    operators.register()
    panel.register()


def unregister() -> None:
    """Called by Blender when the extension is disabled."""
    panel.unregister()
    operators.unregister()
