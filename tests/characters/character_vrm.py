"""What VRM 0.x and 1.0 say about a character: its bones, its expressions, its licence."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from character_skins import JOINTS, Skeleton
from gltf_builder import GltfBuilder

_BONES = {"hips": "hips", "spine": "spine", "neck": "neck", "head": "head", "arm.L": "leftUpperArm"}
# Name of an expression, and the weights of targets when it is fully on.
EXPRESSIONS = {
    "aa": {"jawOpen": 1.0},
    "happy": {"mouthSmileLeft": 1.0, "eyeBlinkLeft": 0.5, "jawOpen": 0.25},
    "blink": {"eyeBlinkLeft": 1.0, "eyeBlinkRight": 1.0},
    "lookDown": {"eyeLookDownLeft": 0.75},
}
_OLD_NAMES = {"aa": "a", "happy": "joy", "blink": "blink", "lookDown": "lookdown"}


def add_vrm(
    builder: GltfBuilder,
    version: int,
    nodes: dict[str, int],
    meshes: dict[str, int],
    skeleton: Skeleton,
    names: Sequence[str],
) -> None:
    """State the expressions of a character as VRM 0.x or 1.0 does."""
    bones = {
        bone: skeleton.joints[k]
        for k, (joint, _, _) in enumerate(JOINTS)
        if (bone := _BONES.get(joint)) is not None
    }
    faces = {name: own for name, own in meshes.items() if name != "body"}
    if version == 0:
        builder.use("VRM")
        builder.json["extensions"]["VRM"] = _old(bones, faces, names)
    else:
        builder.use("VRMC_vrm")
        shown = {name: nodes[name] for name in faces}
        builder.json["extensions"]["VRMC_vrm"] = _new(bones, shown, names)


def _old(bones: dict[str, int], meshes: dict[str, int], names: Sequence[str]) -> dict[str, Any]:
    groups = [
        {
            "name": name.title(),
            "presetName": _OLD_NAMES[name],
            "binds": [
                {"mesh": mesh, "index": names.index(target), "weight": 100 * weight}
                for mesh in meshes.values()
                for target, weight in weights.items()
            ],
            "materialValues": [],
            "isBinary": name == "blink",
        }
        for name, weights in EXPRESSIONS.items()
    ]
    return {
        "exporterVersion": "by hand",
        "specVersion": "0.0",
        "meta": {"title": "head", "version": "1", "licenseName": "CC0"},
        "humanoid": {"humanBones": [{"bone": b, "node": n} for b, n in bones.items()]},
        "firstPerson": {"meshAnnotations": [{"mesh": m} for m in meshes.values()]},
        "blendShapeMaster": {"blendShapeGroups": groups},
        "secondaryAnimation": {"boneGroups": [], "colliderGroups": []},
        "materialProperties": [],
    }


def _new(bones: dict[str, int], nodes: dict[str, int], names: Sequence[str]) -> dict[str, Any]:
    expressions = {
        name: {
            "morphTargetBinds": [
                {"node": node, "index": names.index(target), "weight": weight}
                for node in nodes.values()
                for target, weight in weights.items()
            ],
            "isBinary": name == "blink",
            "overrideMouth": "none",
        }
        for name, weights in EXPRESSIONS.items()
    }
    custom = {"look": expressions.pop("lookDown")}
    return {
        "specVersion": "1.0",
        "meta": {"name": "head", "authors": ["nobody"], "licenseUrl": "about:blank"},
        "humanoid": {"humanBones": {bone: {"node": node} for bone, node in bones.items()}},
        "expressions": {"preset": expressions, "custom": custom},
        "lookAt": {"type": "expression", "offsetFromHeadBone": [0, 0.06, 0]},
    }
