"""What settings say about a method, which may be little: the rest comes from a more general place.

A region stands on the target, the target on the default of the file, and that on the defaults of
the program. What names a method brings the order or load with it; everything else stays until it
is said again.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

from elastomorph.errors import ParameterError
from elastomorph.paths import Method
from elastomorph.paths.method import SETTINGS
from elastomorph.physics import CLOSURES, Load, Material

__all__ = ["OF_NAME", "MethodChoice"]

_MATERIAL = ("mass", "damping", "rigidity")
OF_NAME = ("name", "order", "load")
"""What a name of a method brings with it."""


@dataclass(frozen=True)
class MethodChoice:
    """The part of a `Method` that one place of the settings states; None is not stated.

    Attributes:
        name: As in `Method`.
        order: As in `Method`.
        closure: As in `Method`.
        load: p₁, p₂, … of a polynomial load.
        basis: As in `Method`.
        stiffness: As in `Method`.
        harmonics: As in `Method`.
        tolerance: As in `Method`.
        straight_within: As in `Method`.
        mass: m of the material.
        damping: c of the material.
        rigidity: k of the material.

    Raises:
        ParameterError: No method can be made of it.
    """

    name: str | None = None
    order: int | None = None
    closure: str | None = None
    load: tuple[float, ...] | None = None
    basis: str | None = None
    stiffness: str | None = None
    harmonics: int | None = None
    tolerance: float | None = None
    straight_within: float | None = None
    mass: float | None = None
    damping: float | None = None
    rigidity: float | None = None

    def __post_init__(self) -> None:
        if self.name is not None:
            Method(self.name)
        for setting, value in self._settings.items():
            somebody = next(name for name, own in SETTINGS.items() if setting in own)
            Method(somebody, **{setting: value})

    @classmethod
    def of(cls, text: str | None, **stated: Any) -> MethodChoice:
        """A choice from a text such as ``beam:3`` and from single fields.

        Raises:
            ParameterError: The text or a field is not understood, or both state the same.
        """
        if text is None:
            return cls(**stated)
        named = Method.parse(text)
        options = text.strip().split(":")[1:]
        if named.name == "auto" and options:
            if stated.get("straight_within") is not None:
                raise ParameterError(
                    f"{text!r} and 'straight_within' state the same; leave one of them out"
                )
            return cls(**{**stated, "name": "auto", "straight_within": named.straight_within})
        closures = [option for option in options if option in CLOSURES]
        order = named.order if len(options) > len(closures) else None
        for what, twice in (
            ("closure", closures and stated.get("closure") is not None),
            ("load", order is not None and stated.get("load") is not None),
        ):
            if twice:
                raise ParameterError(
                    f"{text!r} and '{what}' state the same; leave one of them out"
                    + (" (a load takes the place of the order)" if what == "load" else "")
                )
        if closures:
            stated["closure"] = closures[0]
        return cls(name=named.name, order=order, **stated)

    def __bool__(self) -> bool:
        """Whether anything is stated."""
        return any(value is not None for value in self.stated.values())

    @property
    def stated(self) -> dict[str, Any]:
        """Every field by name; None where nothing is stated."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @property
    def idle(self) -> dict[str, tuple[str, ...]]:
        """What is stated that its method has no use for, and the methods that have."""
        method = self.method()
        settings = {
            field: "material" if field in _MATERIAL else field
            for field, value in self.stated.items()
            if value is not None and field != "name"
        }
        return {
            field: tuple(name for name, own in SETTINGS.items() if setting in own)
            for field, setting in settings.items()
            if not method.has(setting)
        }

    def over(self, general: MethodChoice) -> MethodChoice:
        """This choice where it states something, a more general one where it does not."""
        kept = {name: value for name, value in self.stated.items() if value is not None}
        if self.name is not None:
            kept |= {name: getattr(self, name) for name in OF_NAME}
        elif self.load is not None:
            kept["order"] = None
        return replace(general, **kept)

    def method(self) -> Method:
        """The method, with the program's defaults for what is not stated; without what is idle."""
        name = Method().name if self.name is None else self.name
        has = SETTINGS[name]
        return Method(name, **{key: value for key, value in self._settings.items() if key in has})

    @property
    def material(self) -> Material:
        """The material, with the program's defaults for what is not stated."""
        stated = {name: getattr(self, name) for name in _MATERIAL}
        return Material(**{name: value for name, value in stated.items() if value is not None})

    @property
    def _settings(self) -> dict[str, Any]:
        """Fields of `Method` as far as they are stated, without the name."""
        stated = {name: value for name, value in self.stated.items() if value is not None}
        given = {key: value for key, value in stated.items() if key not in ("name", *_MATERIAL)}
        if stated.keys() & set(_MATERIAL):
            given["material"] = self.material
        if "load" in given:
            given["load"] = Load(given["load"])
        for name in ("tolerance", "straight_within"):
            if name in given:
                given[name] = float(given[name])
        return given
