"""Photographs that are rendered once and used again."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from photographs.sessions import Session, photograph

__all__ = ["rendered"]


def rendered(
    session: Session, folder: Path, told: Callable[[str], None] = lambda line: None
) -> Path:
    """The folder, with the photographs of this session: rendered unless they are there."""
    wanted, kept = json.dumps(asdict(session)), folder / "session.json"
    if not kept.exists() or kept.read_text() != wanted:
        shutil.rmtree(folder, ignore_errors=True)
        photograph(session, folder, told)
        kept.write_text(wanted)
    return folder
