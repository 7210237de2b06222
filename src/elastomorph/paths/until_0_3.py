"""Old spellings of methods. In 0.3 this file goes, and with it the few lines that name it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import fields
from typing import Any, ClassVar

from elastomorph.errors import warn
from elastomorph.physics import Load

__all__ = ["OldAttributes", "old_names", "with_new_spelling"]

_POSITIONAL = ("order", "material", "closure", "load", "basis", "stiffness", "harmonics")


class OldAttributes:
    """Every method once had every option, which said nothing with its default."""

    name: ClassVar[str]
    known: ClassVar[tuple[Any, ...]]

    def __getattr__(self, name: str) -> Any:
        if name == "external_load":
            _warn(f"{self.name} has no load")
            return Load.power(2)
        defaults = {} if name.startswith("_") else _defaults(self.known)
        if name not in defaults:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        _warn(f"{self.name} has no {name}")
        return defaults[name]


def with_new_spelling(
    kind: type[OldAttributes], positional: tuple[Any, ...], options: dict[str, Any]
) -> dict[str, Any]:
    """Options by their names, without defaults of those that a method has not."""
    if len(positional) > 1:
        _warn("options behind the order go by their names")
    options |= dict(zip(_POSITIONAL, positional, strict=False))
    defaults, own = _defaults(kind.known), _defaults([kind])
    for name in [*options]:
        if name in defaults and name not in own and options[name] == defaults[name]:
            _warn(f"{kind.name} has no {name}")
            del options[name]
    return options


def old_names(method: type[OldAttributes]) -> Callable[[str], tuple[str, ...]]:
    """The ``__getattr__`` of `elastomorph.paths`."""

    def find(name: str) -> tuple[str, ...]:
        if name != "METHODS":
            raise AttributeError(f"module 'elastomorph.paths' has no attribute {name!r}")
        message = "METHODS is now Method.known; the old name works until elastomorph 0.3."
        warn(message, DeprecationWarning)
        return tuple(each.name for each in method.known)

    return find


def _defaults(kinds: Iterable[Any]) -> dict[str, Any]:
    return {own.name: own.default for kind in kinds for own in fields(kind)}


def _warn(problem: str) -> None:
    message = f"{problem}; this is let pass until elastomorph 0.3"
    warn(message, DeprecationWarning)
