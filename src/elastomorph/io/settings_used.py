"""How a file of ours was made: the settings that its writer kept in it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from elastomorph.io.atomic import read_bytes
from elastomorph.io.gltf.container import open_gltf
from elastomorph.io.npz.members import open_npz

__all__ = ["settings_used"]


def settings_used(path: str | Path) -> dict[str, Any] | None:
    """The settings of the character that a file was made with.

    Args:
        path: A rig (.glb, .gltf, .vrm, .usd, .usda, .usdc, .npz), or an evaluation (.json).

    Returns:
        The settings as tables, as `elastomorph.character.settings_tables` made them; None where
        the file was made without any, or is of another kind.

    Raises:
        FileError: The file is missing or cannot be read.
        FormatError: The file is damaged.
        MissingExtraError: The format needs a package that is not installed.
    """
    suffix = Path(path).suffix.lower()
    if suffix in (".glb", ".gltf", ".vrm"):
        return _in_gltf(path)
    if suffix in (".usd", ".usda", ".usdc"):
        from elastomorph.io.usd.reader import read_usd_settings

        return _parsed(read_usd_settings(path) or "")
    if suffix == ".npz":
        with open_npz(path) as members:
            there = "rig_version" in members.names and "settings" in members.names
            return _parsed(str(members.array("settings", "U", ()))) if there else None
    if suffix == ".json":
        page = _parsed(read_bytes(path)) or {}
        return _table(page.get("settings"))
    return None


def _in_gltf(path: str | Path) -> dict[str, Any] | None:
    """What the first mesh has that holds any."""
    for mesh in open_gltf(path).items("meshes"):
        own: Any = mesh
        for name in ("extras", "elastomorph", "settings"):
            own = own.get(name) if isinstance(own, dict) else None
        if isinstance(own, dict):
            return own
    return None


def _parsed(text: str | bytes) -> dict[str, Any] | None:
    try:
        return _table(json.loads(text))
    except (ValueError, RecursionError):
        return None


def _table(content: Any) -> dict[str, Any] | None:
    return content if isinstance(content, dict) else None
