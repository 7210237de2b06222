"""The panel in Mesh data > Shape Keys, and the slider of the preview."""

import bpy
from bpy.props import FloatProperty

from .face import selected_objects
from .operators import _has_keys
from .preview import preview
from .record import bend_names, driver_of


class ShapeKeyBends(bpy.types.Panel):
    """Bends of shape keys."""

    bl_idname = "DATA_PT_elastomorph"
    bl_label = "Bends"
    bl_parent_id = "DATA_PT_shape_keys"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "data"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Shown for meshes with shape keys."""
        return _has_keys(context)

    def draw(self, context: bpy.types.Context) -> None:
        """Blender asks for this at every redraw."""
        layout, keys = self.layout, context.object.data.shape_keys
        row = layout.row(align=True)
        row.operator("elastomorph.bend")
        row.operator("elastomorph.remove", text="", icon="X")
        slider = layout.row()
        slider.enabled = _movable(context.object)
        slider.prop(context.object, "elastomorph_preview", slider=True)
        column = layout.column(align=True)
        column.operator("elastomorph.import_performance", icon="IMPORT")
        column.operator("elastomorph.bake", icon="KEYFRAME")
        names = bend_names(keys)
        layout.label(text=f"{len(names)} bends of {len({*names.values()})} keys")


def _previewed(thing: bpy.types.Object) -> bpy.types.ShapeKey | None:
    """The key that the slider moves: the active one, or the one whose bend is active."""
    block, keys = thing.active_shape_key, thing.data.shape_keys
    if block is None or block == keys.reference_key:
        return None
    return keys.key_blocks.get(bend_names(keys).get(block.name, block.name))


def _movable(thing: bpy.types.Object) -> bool:
    block = _previewed(thing)
    if block is None:
        return False
    return driver_of(thing.data.shape_keys, block.path_from_id("value")) is None


def _shown(thing: bpy.types.Object) -> float:
    block = _previewed(thing)
    return 0.0 if block is None else block.value


def _show(thing: bpy.types.Object, t: float) -> None:
    block = _previewed(thing)
    if block is None:
        return
    together = thing == bpy.context.active_object
    preview(selected_objects(bpy.context) if together else [thing], block.name, t)


def register() -> None:
    """Make the panel and its slider known to Blender."""
    bpy.types.Object.elastomorph_preview = FloatProperty(
        name="Preview Path",
        description="Move the active key of the selected objects along its path",
        soft_min=0.0,
        soft_max=1.0,
        min=-10.0,
        max=10.0,
        get=_shown,
        set=_show,
        options=set(),
    )
    bpy.utils.register_class(ShapeKeyBends)


def unregister() -> None:
    """Take them back."""
    bpy.utils.unregister_class(ShapeKeyBends)
    del bpy.types.Object.elastomorph_preview
