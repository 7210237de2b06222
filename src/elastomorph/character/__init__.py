"""The settings of a character: one TOML file that says what it is made of and how it moves."""

from __future__ import annotations

from elastomorph.character.build import PathMaker, rig_from_settings
from elastomorph.character.read import FILE_NAME, find_settings, read_settings
from elastomorph.character.schema import settings_tables
from elastomorph.character.settings import Character, Inbetweens, Region, Settings

__all__ = [
    "FILE_NAME",
    "Character",
    "Inbetweens",
    "PathMaker",
    "Region",
    "Settings",
    "find_settings",
    "read_settings",
    "rig_from_settings",
    "settings_tables",
]
