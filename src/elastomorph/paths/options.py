"""What is to be known of one option of a method: stated once, where the method has it as a field.

Short texts (``beam:3``), labels, settings files, the command line, messages and the documentation
are made from this. Options that several methods have are the functions at the end.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, Literal, NamedTuple

from elastomorph.errors import ParameterError
from elastomorph.numbers import as_number
from elastomorph.physics import CLOSURES, Load, Material

Kind = Literal["text", "number", "whole", "numbers", "table"]
Check = Callable[[Any, str], Any]


@dataclass(frozen=True)
class Word:
    """How an option stands behind the name in a short text, as the 3 of ``beam:3``."""

    read: Callable[[str], Any]  # the value that a word stands for; None where it is no such word
    shown: str  # in a pattern, as the R of ``beam:R``
    kind: str  # what such a word is, without an article, for messages
    examples: tuple[str, ...] = ()  # words that the tab key offers
    needed: bool = False  # whether patterns show it without brackets


@dataclass(frozen=True)
class Option:
    """One option of a method, beside its name, type and default.

    Attributes:
        kind: What a settings file holds for it.
        means: What it is for, in a few words.
        example: A value as TOML.
        check: The value as it is kept, from a value and what it is called; a ParameterError says
            what is wrong with it.
        label: What a value other than the default adds to the label.
        word: How it stands in a short text, if it does.
        with_name: Whether naming a method brings it along: there is one such at a time, and what
            was said of them before is unsaid.
        made: The value of a field from that of a settings file.
        parts: What each key means of an option that is a table.
    """

    kind: Kind
    means: str
    example: str
    check: Check
    label: Callable[[Any], str] = lambda _: ""
    word: Word | None = None
    with_name: bool = False
    made: Callable[[Any], Any] = lambda value: value
    parts: Mapping[str, str] = field(default_factory=dict)


class OptionRow(NamedTuple):
    """One option of all methods; in place of one that is a table, each of its parts."""

    name: str
    kind: str
    means: str
    default: str  # empty where it has none
    methods: tuple[str, ...]


def option(default: Any, kind: Kind, means: str, example: str, check: Check, **more: Any) -> Any:
    """A field of a method; ``more`` are further attributes of `Option`."""
    return field(default=default, metadata={"option": Option(kind, means, example, check, **more)})


def options_of(method: Any) -> dict[str, Option]:
    """The options of a method, or of a class of methods, by name."""
    return {own.name: own.metadata["option"] for own in fields(method) if "option" in own.metadata}


def option_rows(methods: Sequence[Any]) -> list[OptionRow]:
    """The options of methods, each once, in the order in which they have them."""
    found: dict[str, OptionRow] = {}
    for method in methods:
        for name, its in options_of(method).items():
            default = getattr(method, name)
            for own in its.parts or [name]:
                value = getattr(default, own) if its.parts else default
                found.setdefault(
                    own,
                    OptionRow(
                        own,
                        "number" if its.parts else its.kind,
                        its.parts.get(own, its.means),
                        f"{value:g}" if isinstance(value, float) else str(value or ""),
                        tuple(each.name for each in methods if name in options_of(each)),
                    ),
                )
    return list(found.values())


def number(
    default: float, means: str, example: str, *, above: float | None = None,
    least: float | None = None, **more: Any,
) -> Any:  # fmt: skip
    """A field that holds a number within bounds."""
    return option(
        default,
        "number",
        means,
        example,
        lambda value, what: as_number(value, what, above=above, least=least),
        **more,
    )


def whole_number(default: int | None, means: str, example: str, least: int, **more: Any) -> Any:
    """A field that holds a whole number, or None where that is the default."""

    def check(value: Any, what: str) -> int | None:
        if value is None and default is None:
            return None
        if not isinstance(value, int) or isinstance(value, bool) or value < least:
            raise ParameterError(f"{what} must be a whole number ≥ {least}, found {value!r}")
        return value

    return option(default, "whole", means, example, check, **more)


def choice(default: str, among: Sequence[str], means: str, **more: Any) -> Any:
    """A field that holds one of a few texts."""

    def check(value: Any, what: str) -> Any:
        if value not in among:
            raise ParameterError(f"{what} must be one of {', '.join(among)}, found {value!r}")
        return value

    example = f'"{next(text for text in among if text != default)}"'
    more.setdefault("label", str)
    return option(default, "text", means, example, check, **more)


def order() -> Any:
    """R of the load t^R."""
    return option(
        2,
        "whole",
        "order R of the load t^R",
        "3",
        lambda value, _: Load.power(value).order,
        word=Word(_digits, "R", "order (a whole number)", ("2", "3"), needed=True),
        with_name=True,
    )


def load() -> Any:
    """A polynomial load in place of t^R."""
    return option(
        None,
        "numbers",
        "polynomial load p₁t + p₂t² + … in place of an order: p₁, p₂, …",
        "[0.2, 0.8]",
        _instance(Load | None, "Load, such as Load([0, 1])"),
        with_name=True,
        made=Load,
    )


def closure() -> Any:
    """The time law of a mean."""
    return choice(
        "limit",
        CLOSURES,
        f"time law of the mean of a curve: {', '.join(CLOSURES)}",
        word=Word(
            lambda text: text if text in CLOSURES else None,
            "closure",
            f"closure ({', '.join(CLOSURES)})",
        ),
    )


def harmonics() -> Any:
    """How many modes are solved."""
    return whole_number(
        None, "modes above this number follow the limit law", "8", 0, label=lambda n: f"N={n}"
    )


def material() -> Any:
    """m, c and k."""
    return option(
        Material(),
        "table",
        "mass, damping and rigidity of what moves",
        "{ damping = 2.0 }",
        _instance(Material, "Material"),
        label=lambda m: f"m={m.mass:g} c={m.damping:g} k={m.rigidity:g}",
        made=lambda constants: Material(**constants),
        parts={
            "mass": "mass m of the material, above 0",
            "damping": "damping c of the material, above 0",
            "rigidity": "rigidity k = EI of the material, above 0",
        },
    )


def tolerance() -> Any:
    """How closely bends hold a path."""
    return number(1e-4, "how closely bends hold their path, as a fraction of D", "1e-5", above=0)


def _instance(kind: Any, words: str) -> Check:
    def check(value: Any, what: str) -> Any:
        if not isinstance(value, kind):
            raise ParameterError(f"{what} must be a {words}, found {value!r}")
        return value

    return check


def as_float(text: str) -> float | None:
    """The number that a word is, None where it is none."""
    try:
        return float(text)
    except ValueError:
        return None


def _digits(text: str) -> int | None:
    # Python refuses to read very many digits.
    return int(text) if text.isascii() and text.isdigit() and len(text) < 20 else None
