"""What the settings of a character mean for a file that its rig is written to."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from elastomorph.character.settings import UNITS, Settings
from elastomorph.character.tables import settings_tables
from elastomorph.rig.timing import by_name

__all__ = ["export_options"]


def export_options(settings: Settings, path: str | Path) -> dict[str, Any]:
    """Options of `elastomorph.io.write` for a rig, with the settings themselves to be kept.

    Args:
        settings: The settings.
        path: The file to be written; its suffix says what its format can hold.
    """
    kept = {"settings": settings_tables(settings)}
    suffix = Path(path).suffix.lower()
    if suffix == ".glb":
        timed = {} if settings.timing is None else {"timing": by_name(settings.timing)}
        return {**settings.glb, **timed, **kept}
    if suffix in (".usd", ".usda", ".usdc"):
        unit = settings.character.unit
        measured = {} if unit is None else {"meters_per_unit": UNITS[unit]}
        return {**settings.usd, **measured, **kept}
    return kept if suffix == ".npz" else {}
