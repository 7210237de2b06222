"""The operators: each parses what was asked, makes one call and reports.

Blender reads properties from annotations as they are, so this module must not postpone them.
"""

import warnings

import bpy
import numpy as np
from bpy.props import EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from .baking import bake
from .bending import adopt, bend
from .face import selected_objects
from .holding import hold_face
from .preview import preview
from .record import bend_names, remove_bends
from .recording import import_performance
from .refusal import RefusedError, reported

_METHODS = (
    ("auto", "along the turn where a key turns the face, else straight"),
    ("rotation", "least distortion, for jaws, lids and eyes"),
    ("arc", "each neighbourhood turns by itself; fast"),
    ("beam:2", "elastic curves under a force that grows with t²"),
    ("beam:3", "elastic curves under a force that grows with t³"),
    ("plate:2", "an elastic surface under a force that grows with t²"),
    ("ease:2", "straight, and slow at the start"),
    ("cosine", "straight, slow at both ends"),
)


_KEYS = EnumProperty(
    name="Keys",
    items=(
        ("ALL", "All", "Bend all shape keys"),
        ("ACTIVE", "Active", "Bend the active shape key only"),
    ),
    default="ALL",
)


def _methods(_operator: object, _context: object, _text: str) -> list[tuple[str, str]]:
    """What the field of the method offers; any other of elastomorph may be typed."""
    return list(_METHODS)


def _has_keys(context: bpy.types.Context) -> bool:
    active = context.active_object
    return active is not None and active.type == "MESH" and active.data.shape_keys is not None


class _OfShapeKeys:
    """What all of the operators share: they can be undone, and their errors are reports."""

    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return _has_keys(context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        with warnings.catch_warnings(record=True) as told, reported(self):
            warnings.simplefilter("always")
            said = self.done(context, selected_objects(context))
            for warning in told:
                self.report({"WARNING"}, str(warning.message))
            self.report({"INFO"}, said)
        return {"CANCELLED"} if self.failed else {"FINISHED"}


class BendShapeKeys(_OfShapeKeys, bpy.types.Operator):
    """Bends as shape keys, driven by the keys they belong to."""

    bl_idname = "elastomorph.bend"
    bl_label = "Bend Shape Keys"
    bl_description = "Let shape keys move along paths that turn and bend as a face does"

    method: StringProperty(
        name="Method",
        description="How paths are made: auto, rotation, arc, beam:2, plate:2, ease:2, …",
        default="auto",
        search=_methods,
        search_options={"SUGGESTION"},
    )
    tolerance: FloatProperty(
        name="Tolerance",
        description="How closely the bends of each key hold its path, as a part of the face",
        default=1e-6,
        min=1e-7,
        soft_max=1e-2,
        max=1.0,
        precision=7,
    )
    keys: _KEYS

    def done(self, context: bpy.types.Context, things: list[bpy.types.Object]) -> str:
        only = None if self.keys == "ALL" else _active_targets(context)
        outcome = bend(things, self.method, self.tolerance, only)
        if not outcome.names:
            return "No shape key bends: straight lines are within the tolerance of their paths"
        return (
            f"{len(outcome.names)} keys bent by {outcome.bends} keys in {len(things)} objects, "
            f"within {100 * outcome.error:.2g} % of the size of the face ({outcome.extent:.4g})"
        )


class HoldLids(_OfShapeKeys, bpy.types.Operator):
    """Lids that meet where several keys shut them."""

    bl_idname = "elastomorph.hold"
    bl_label = "Hold Lids"
    bl_description = "Add keys that keep lids from sliding past each other, driven by all that shut"

    def done(self, context: bpy.types.Context, things: list[bpy.types.Object]) -> str:
        rows = hold_face(things).corrections
        fractions = np.array([row.fractions for row in rows if row.targets]).reshape(-1, 2)
        notes = [row.note for row in rows if row.note]
        if len(fractions):
            before, after = 100 * fractions.max(axis=0)
            said = f"{len(fractions)} keys hold lids: at most {after:.2g} % of the size of the face"
            notes.insert(0, f"{said} past each other in place of {before:.2g} %")
        return "; ".join(notes) or "There is nothing to hold"


class RemoveBends(_OfShapeKeys, bpy.types.Operator):
    """The shape keys as they were before."""

    bl_idname = "elastomorph.remove"
    bl_label = "Remove Bends"
    bl_description = "Remove the bends of the selected objects: their keys, drivers and keyframes"

    keys: _KEYS

    def done(self, context: bpy.types.Context, things: list[bpy.types.Object]) -> str:
        only = None if self.keys == "ALL" else _active_targets(context)
        for thing in things:
            adopt(thing)
        gone = sum(remove_bends(thing, only) for thing in things)
        return f"{gone} bends removed" if gone else "There were no bends"


class PreviewPath(_OfShapeKeys, bpy.types.Operator):
    """The active key along its path."""

    bl_idname = "elastomorph.preview"
    bl_label = "Preview Path"
    bl_description = "Move the active shape key of all selected objects along its path"

    t: FloatProperty(
        name="Path",
        description="How far along its path the active key is: 0 is the basis, 1 the key",
        default=0.5,
        min=-10.0,
        soft_min=0.0,
        soft_max=1.0,
        max=10.0,
    )

    def done(self, context: bpy.types.Context, things: list[bpy.types.Object]) -> str:
        names = _active_targets(context)
        preview(things, names, self.t)
        return f"{' and '.join(names)} at {self.t:g}"


class ImportPerformance(_OfShapeKeys, ImportHelper, bpy.types.Operator):
    """Recorded weights as keyframes."""

    bl_idname = "elastomorph.import_performance"
    bl_label = "Import Performance (CSV)"
    bl_description = "Key recorded weights, such as a take of Live Link Face, on the shape keys"

    filename_ext = ".csv"
    filter_glob: StringProperty(default="*.csv", options={"HIDDEN"})
    start: IntProperty(name="Start Frame", description="Frame of the first weights", default=1)

    def done(self, context: bpy.types.Context, things: list[bpy.types.Object]) -> str:
        return import_performance(context, things, self.filepath, self.start)


class BakeForExport(_OfShapeKeys, bpy.types.Operator):
    """Keyframes in place of drivers."""

    bl_idname = "elastomorph.bake"
    bl_label = "Bake for Export"
    bl_description = "Key bends in place of driving them, for exporters that play no drivers"

    def done(self, context: bpy.types.Context, things: list[bpy.types.Object]) -> str:
        baked = bake(context, things)
        return f"Keyframes for {baked.moving} bends; {baked.still} stand still"


def _active_targets(context: bpy.types.Context) -> tuple[str, ...]:
    """Name of the active key; those of the keys it follows where it is a bend."""
    thing = context.active_object
    block = thing.active_shape_key
    keys = thing.data.shape_keys
    if block is None or block == keys.reference_key:
        raise RefusedError(f"The active shape key of {thing.name} is its basis: select another key")
    return bend_names(keys).get(block.name, (block.name,))


CLASSES = (BendShapeKeys, HoldLids, RemoveBends, PreviewPath, ImportPerformance, BakeForExport)


def register() -> None:
    """Make the operators known to Blender."""
    for operator in CLASSES:
        bpy.utils.register_class(operator)


def unregister() -> None:
    """Take them back."""
    for operator in reversed(CLASSES):
        bpy.utils.unregister_class(operator)
