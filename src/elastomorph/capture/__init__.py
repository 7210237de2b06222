"""Photographs and scans become poses that share one topology.

This room has the name of what it is called for: ``em.capture`` is the function of
`elastomorph.capture.capture`, also where this module took its place when it was imported.
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any


class _CallableRoom(ModuleType):
    def __call__(self, *arguments: Any, **options: Any) -> Any:
        from elastomorph.capture.capture import capture

        return capture(*arguments, **options)


sys.modules[__name__].__class__ = _CallableRoom
