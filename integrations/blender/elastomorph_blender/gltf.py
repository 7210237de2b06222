"""The bend curves in what Blender's glTF exporter writes, so that a runtime can follow sliders.

The exporter writes bends as the morph targets they are. With the curves beside them, programs that
know elastomorph play the file by its sliders alone.
"""

from __future__ import annotations

from typing import Any

from elastomorph.io.blend_shapes import curve_to_json
from elastomorph.io.gltf.rig_extras import corrective_entries, least_version
from elastomorph.model.bend_curve import BendCurve

from .record import Follower, followers


class CurvesOfMeshes:
    """What Blender's glTF exporter calls while it writes."""

    def gather_mesh_hook(self, gltf2_mesh: Any, blender_mesh: Any, *_: Any) -> None:
        """Add the curves and laws to a mesh that has bends or correctives among its targets."""
        extras = gltf2_mesh.extras
        if not isinstance(extras, dict) or "targetNames" not in extras:
            return
        keys = blender_mesh.shape_keys
        written = extras["targetNames"]
        found = [own for own in followers(keys) if {own.name, *own.law.drivers} <= {*written}]
        if found:
            extras["elastomorph"] = description(written, found)


def description(written: list[str], found: list[Follower]) -> dict[str, Any]:
    """``extras.elastomorph`` of a mesh with these morph targets."""
    bends = [own for own in found if own.curve is not None]
    names = {bend.name for bend in bends}
    pairs = {bend.target: bend.law for bend in bends if bend.of_pair}
    laws = {own.name: own.law for own in found if own.curve is None}
    morphs = []
    for name in (*(name for name in written if name not in names), *pairs):
        mine = [bend for bend in bends if bend.target == name]
        morphs.append(
            {
                "name": name,
                **({} if name in pairs else {"target": name}),
                "method": mine[0].method if mine else "linear",
                "bake_error": 0.0,
                "choice": None,
                "limit_law": curve_to_json(BendCurve.polynomial([0.0])),
                "bends": [{"target": b.name, "curve": curve_to_json(b.curve)} for b in mine],
            }
        )
    entries = corrective_entries(laws | pairs)
    return {"version": least_version(morphs, entries), "morphs": morphs, "correctives": entries}
