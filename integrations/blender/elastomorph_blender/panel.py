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
        column.operator("elastomorph.hold")
        column.operator("elastomorph.import_performance", icon="IMPORT")
        column.operator("elastomorph.bake", icon="KEYFRAME")
        names = bend_names(keys)
        followed = {name for own in names.values() for name in own}
        layout.label(text=f"{len(names)} bends of {len(followed)} keys")


def _previewed(thing: bpy.types.Object) -> list[bpy.types.ShapeKey]:
    """The keys that the slider moves: the active one, or those that the active bend follows."""
    block, keys = thing.active_shape_key, thing.data.shape_keys
    if block is None or block == keys.reference_key:
        return []
    names = bend_names(keys).get(block.name, (block.name,))
    return [keys.key_blocks[name] for name in names if name in keys.key_blocks]


def _movable(thing: bpy.types.Object) -> bool:
    keys, blocks = thing.data.shape_keys, _previewed(thing)
    free = (driver_of(keys, block.path_from_id("value")) is None for block in blocks)
    return bool(blocks) and all(free)


def _shown(thing: bpy.types.Object) -> float:
    return min((block.value for block in _previewed(thing)), default=0.0)


def _show(thing: bpy.types.Object, t: float) -> None:
    names = [block.name for block in _previewed(thing)]
    together = thing == bpy.context.active_object
    preview(selected_objects(bpy.context) if together else [thing], names, t)


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
