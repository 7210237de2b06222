"""What expressions of VRM 1.0 do to each other: a smile that keeps the eyes from blinking.

An expression overrides groups of others: ``blend`` multiplies their weights by 1 - Σ of the weights
of all that do, down to 0, and ``block`` by 0 as soon as its own is above 0. Players do so before
they set morph targets, and what is driven by the weights of these, bends and correctives, follows.
A corrective in the file for the same would count twice: overrides are told, and not read as laws.
VRM 0.x has none.
"""

from __future__ import annotations

from elastomorph.io.gltf.container import GltfFile, object_of
from elastomorph.io.untrusted import shortened
from elastomorph.numbers import first_few

_GROUPS = {
    "overrideBlink": ("blink", ("blink", "blinkLeft", "blinkRight")),
    "overrideLookAt": ("look", ("lookUp", "lookDown", "lookLeft", "lookRight")),
    "overrideMouth": ("mouth", ("aa", "ih", "ou", "ee", "oh")),
}


def overrides_of(file: GltfFile) -> dict[str, dict[str, str]]:
    """The groups that each expression of a VRM 1.0 file overrides; empty where none does.

    Args:
        file: Of glTF, damaged or not: what is not as VRM says counts as not there.

    Returns:
        By name of the expression ``blend`` or ``block`` for ``blink``, ``look`` and ``mouth``. That
        of a member on its own group, which VRM calls invalid, is left out.
    """
    extension = object_of(object_of(file.document.get("extensions")).get("VRMC_vrm"))
    expressions = object_of(extension.get("expressions"))
    named = object_of(expressions.get("preset")) | object_of(expressions.get("custom"))
    found = {
        name: {
            group: how
            for key, (group, members) in _GROUPS.items()
            if (how := object_of(own).get(key)) in ("blend", "block") and name not in members
        }
        for name, own in named.items()
    }
    return {name: groups for name, groups in found.items() if groups}


def overrides_note(overrides: dict[str, dict[str, str]]) -> str:
    """One sentence about overrides, and why they need no change where a file is bent."""
    said = [
        f"{shortened(name)} ({', '.join(f'{group}: {how}' for group, how in groups.items())})"
        for name, groups in overrides.items()
    ]
    return (
        f"expressions that override others: {first_few(said, 8)}; players do so before they set "
        "morph targets, and bends and correctives follow these"
    )
