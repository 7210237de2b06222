"""Keys of a recipe: each stated once, as a field of what it describes.

Reading, refusing, the canonical text and the documentation are made from this.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any, TypeVar

from elastomorph.character.document import Document, Where, as_found, nearest, shown
from elastomorph.character.schema import Key

Described = TypeVar("Described")


@dataclass(frozen=True)
class RecipeKey:
    """One key, beside its name and default.

    Attributes:
        kind: What the file holds, as for `elastomorph.character.schema.Key`.
        means: What it is for, in a few words.
        example: A value as TOML.
        above: What a number must be above, or None.
        least: What it must be at least.
        most: What it must be at most.
    """

    kind: str
    means: str
    example: str
    above: float | None = None
    least: float | None = None
    most: float | None = None
    needed: bool = False  # whether a table without it is none
    choices: tuple[str, ...] = ()  # the texts that it may be

    @property
    def bounds(self) -> str:
        """What its numbers must be, in words; empty where they may be any."""
        said = [
            f"{word} {bound:g}"
            for word, bound in (("above", self.above), ("at least", self.least))
            if bound is not None
        ]
        said += [f"at most {self.most:g}"] if self.most is not None else []
        return " and ".join(said)

    def holds(self, number: float) -> bool:
        """Whether a number is within the bounds."""
        return not (
            (self.above is not None and number <= self.above)
            or (self.least is not None and number < self.least)
            or (self.most is not None and number > self.most)
        )


def key(default: Any, kind: str, means: str, example: str, **more: Any) -> Any:
    """A field that a key of a recipe fills."""
    return field(default=default, metadata={"key": RecipeKey(kind, means, example, **more)})


def keys_of(described: Any) -> dict[str, RecipeKey]:
    """The keys of a class, or of an instance, by name."""
    return {own.name: own.metadata["key"] for own in fields(described) if "key" in own.metadata}


def stated(described: Any) -> dict[str, Any]:
    """The values of its keys, without those that are left out."""
    values = {name: getattr(described, name) for name in keys_of(described)}
    return {name: value for name, value in values.items() if value not in (None, ())}


def read_keys(
    document: Document, where: Where, described: type[Described], *others: str
) -> Described:
    """What a table describes; every value is checked, and others than its keys are refused."""
    keys = keys_of(described)
    document.require_known(where, [*others, *keys])
    table = document.table(where)
    for name, own in keys.items():
        if own.needed and name not in table:
            document.refuse(where, f"[{shown(where)}] needs '{name}', such as {own.example}")
    values = {
        name: read_value(document, (*where, name), keys[name], table[name])
        for name in table
        if name in keys
    }
    return described(**values)


def read_value(document: Document, where: Where, own: RecipeKey, given: Any) -> Any:
    """One value of a recipe, checked; lists become tuples, and a span the lowest and highest."""
    value = document.value(where, Key(own.kind, own.example), given)
    if own.kind == "span":
        low, high = value if isinstance(value, tuple) else (value, value)
        value = (float(low), float(high))
        if low > high:
            document.refuse(
                where, f"'{shown(where)}' goes from {low:g} to {high:g}; the lowest stands first"
            )
    bounds = own.bounds
    for each in value if isinstance(value, tuple) else (value,):
        if bounds and not own.holds(each):
            document.refuse(where, f"'{shown(where)}' must be {bounds}, found {as_found(each)}")
        if own.choices and each not in own.choices:
            hint = nearest(each, own.choices)
            document.refuse(where, f"'{shown(where)}' cannot be {each!r}: {hint}")
    return float(value) if own.kind == "number" else value
