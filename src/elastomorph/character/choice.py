"""What settings say about a method, which may be little: the rest comes from a more general place.

A region stands on the target, the target on the default of the file, and that on the defaults of
the program. What names a method brings the order or load with it; everything else stays until it
is said again.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from elastomorph.errors import ParameterError
from elastomorph.paths import Method
from elastomorph.paths.options import options_of
from elastomorph.physics import Material


@dataclass(frozen=True)
class MethodChoice:
    """The part of a method that one place of the settings states."""

    name: str | None = None
    # Of its options, as a settings file holds them, and of the constants of its material (``mass``,
    # ``damping``, ``rigidity``).
    stated: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.name is not None:
            Method.named(self.name)
        for name, value in _fields(self.stated).items():
            Method.every_option()[name].check(value, name)

    @classmethod
    def of(cls, text: str | None = None, **stated: Any) -> MethodChoice:
        """A choice from a text such as ``beam:3`` and from options; None leaves one open."""
        given = {name: value for name, value in stated.items() if value is not None}
        alike = [f"'{name}'" for name in given if _with_name(name)]
        if len(alike) > 1:
            raise ParameterError(f"{' and '.join(alike)} state the same; leave one of them out")
        if text is None:
            return cls(None, given)
        kind, found = Method.read(text)
        for name in given:
            instead = name not in found and _with_name(name) and any(map(_with_name, found))
            if name in found or instead:
                raise ParameterError(
                    f"{text!r} and '{name}' state the same; leave one of them out"
                    + (" (a load takes the place of the order)" if instead else "")
                )
        kind(**found)
        return cls(kind.name, found | given)

    def __bool__(self) -> bool:
        """Whether anything is stated."""
        return self.name is not None or bool(self.stated)

    @property
    def idle(self) -> dict[str, tuple[str, ...]]:
        """What is stated that its method has no use for, and the methods that have."""
        method = self.method()
        return {
            name: Method.with_option(own)
            for name in self.stated
            if not method.has(own := _option_of(name))
        }

    def over(self, general: MethodChoice) -> MethodChoice:
        """This choice where it states something, a more general one where it does not."""
        kept = general.without(self)
        name = kept.name if self.name is None else self.name
        return MethodChoice(name, {**kept.stated, **self.stated})

    def without(self, said: MethodChoice) -> MethodChoice:
        """What is left of this choice where another one has the say."""
        anew = said.name is not None or any(map(_with_name, said.stated))
        kept = {
            name: value
            for name, value in self.stated.items()
            if name not in said.stated and not (anew and _with_name(name))
        }
        return MethodChoice(None if said.name is not None else self.name, kept)

    def method(self) -> Method:
        """The method, with the program's defaults for what is not stated; without what is idle."""
        kind = type(Method()) if self.name is None else Method.named(self.name)
        given = _fields(self.stated)
        return kind(**{name: value for name, value in given.items() if kind.has(name)})

    def values(self) -> dict[str, Any]:
        """The options of the method, defaults too, as a settings file holds them."""
        method = self.method()
        found: dict[str, Any] = {}
        for name, its in options_of(method).items():
            value = getattr(method, name)
            if value is not None:
                found |= {part: getattr(value, part) for part in its.parts} or {name: value}
        return found

    @property
    def material(self) -> Material:
        """The material, with the program's defaults for what is not stated."""
        found: Material = _fields(self.stated).get("material", Material())
        return found


def _option_of(name: str) -> str:
    """The option that a name stands for: its own, or that of the table it is a part of."""
    every = Method.every_option()
    return next((own for own, its in every.items() if name in its.parts), name)


def _with_name(name: str) -> bool:
    its = Method.every_option().get(name)
    return its is not None and its.with_name


def _fields(stated: Mapping[str, Any]) -> dict[str, Any]:
    """Fields of methods, made of what is stated."""
    found: dict[str, Any] = {}
    for name, its in Method.every_option().items():
        parts = {part: stated[part] for part in its.parts if part in stated}
        if parts:
            found[name] = its.made(parts)
        elif name in stated:
            found[name] = its.made(stated[name])
    return found
