"""The bend curves in what Blender's glTF exporter writes, so that a runtime can follow sliders.

The exporter writes bends as the morph targets they are. With the curves beside them, programs that
know elastomorph play the file by its sliders alone.
"""

from __future__ import annotations

from typing import Any

from elastomorph.io.blend_shapes import curve_to_json
from elastomorph.model.bend_curve import BendCurve

from .record import KeptBend, kept_bends


class CurvesOfMeshes:
    """What Blender's glTF exporter calls while it writes."""

    def gather_mesh_hook(self, gltf2_mesh: Any, blender_mesh: Any, *_: Any) -> None:
        """Add the curves to a mesh that has bends among its targets."""
        extras = gltf2_mesh.extras
        if not isinstance(extras, dict) or "targetNames" not in extras:
            return
        keys = blender_mesh.shape_keys
        written = extras["targetNames"]
        bends = [bend for bend in kept_bends(keys) if {bend.name, bend.target} <= {*written}]
        if bends:
            extras["elastomorph"] = description(written, bends)


def description(written: list[str], bends: list[KeptBend]) -> dict[str, Any]:
    """``extras.elastomorph`` of a mesh with these morph targets."""
    own = {bend.name for bend in bends}
    morphs = []
    for name in written:
        if name in own:
            continue
        mine = [bend for bend in bends if bend.target == name]
        morphs.append(
            {
                "name": name,
                "target": name,
                "method": mine[0].method if mine else "linear",
                "bake_error": 0.0,
                "choice": None,
                "limit_law": curve_to_json(BendCurve.polynomial([0.0])),
                "bends": [{"target": b.name, "curve": curve_to_json(b.curve)} for b in mine],
            }
        )
    return {"version": 1, "morphs": morphs}
