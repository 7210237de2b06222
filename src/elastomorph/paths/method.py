"""A method of interpolation: a class, whose fields are the options it has."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, ClassVar

from elastomorph.errors import ParameterError
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths.options import Option, options_of
from elastomorph.physics import Material

if TYPE_CHECKING:
    from elastomorph.curves import CurveNetwork

Prepared = Callable[[Mesh], Morph]
"""From a target to the path that leads there."""


class _ByName(type):
    """Lets ``Method("beam", order=3)`` make a `Beam`, and refuses options a method has not."""

    def __call__(cls, *positional: Any, **options: Any) -> Any:
        if cls is Method:
            return _by_name(*positional, **options)
        cls._require(options, repr(cls.name))  # type: ignore[attr-defined]
        return super().__call__(*positional, **options)

    @property
    def __signature__(cls) -> inspect.Signature:
        own = inspect.signature(cls.__init__)  # type: ignore[misc]
        return own.replace(parameters=list(own.parameters.values())[1:])


@dataclass(frozen=True, init=False)
class Method(metaclass=_ByName):
    """How the path from neutral to target is made.

    Every method is a class of its own in `elastomorph.paths`, with its options as fields:
    ``Linear``, ``Cosine``, ``Ease``, ``Beam``, ``Plate``, ``Arc``, ``Rotation``, ``Auto`` (and
    ``Through``, for shapes on the way). ``Method("beam", order=3)`` is ``Beam(order=3)``.

    Attributes:
        name: What texts and tables call it.
        path: What its path is, in a few words.
        known: The classes that names stand for, in the order in which lists show them.
        on_surfaces: Whether it needs polygons.
        on_curves: Whether it needs curves, of a surface too.
        pointwise: Whether the path of a vertex depends on its own ends only.
        turns: Whether it turns what moves, so that the bend to a sum of targets is no sum of bends.

    Raises:
        ParameterError: The name or an option is unknown, or a value is out of its range.
    """

    name: ClassVar[str]
    path: ClassVar[str]
    known: ClassVar[tuple[type[Method], ...]] = ()
    on_surfaces: ClassVar[bool] = False
    on_curves: ClassVar[bool] = False
    pointwise: ClassVar[bool] = False
    turns: ClassVar[bool] = False

    if TYPE_CHECKING:

        def __init__(self, *name: str, **options: Any) -> None: ...
        def __getattr__(self, option: str) -> Any: ...

    def __post_init__(self) -> None:
        for name, its in options_of(self).items():
            object.__setattr__(self, name, its.check(getattr(self, name), name))

    def prepare(self, neutral: Mesh, curves: CurveNetwork | None = None) -> Prepared:
        """A function from target to path, for many targets of one neutral.

        What a method takes beside curves for one call, such as painted rigidity, its own
        ``prepare`` has as keywords.

        Args:
            neutral: The mesh at t = 0, of three vertices or more.
            curves: The curves of the neutral, where they are known.
        """
        raise NotImplementedError

    @classmethod
    def inputs(cls) -> tuple[str, ...]:
        """What ``prepare`` takes beside the neutral and curves."""
        return tuple(inspect.signature(cls.prepare).parameters)[3:]

    @classmethod
    def has(cls, option: str) -> bool:
        """Whether this method has an option."""
        return option in options_of(cls)

    @property
    def label(self) -> str:
        """A short name for tables, with the options that differ from the usual ones."""
        return " ".join([self.name, *self._differences])

    @property
    def _differences(self) -> list[str]:
        said = [
            each.metadata["option"].label(getattr(self, each.name))
            for each in fields(self)
            if getattr(self, each.name) != each.default
        ]
        return [words for words in said if words]

    def with_material(self, material: Material) -> Method:
        """The same method for another material, where it has one."""
        return replace(self, material=material) if self.has("material") else self  # type: ignore[call-arg]

    @classmethod
    def of(cls, method: str | Method) -> Method:
        """The method that a text names, or the method itself.

        Raises:
            ParameterError: As `parse`.
        """
        return method if isinstance(method, Method) else cls.parse(method)

    @classmethod
    def parse(cls, text: str, **options: object) -> Method:
        """A method from ``name``, ``name:order``, ``beam:order:closure`` or ``auto:distance``.

        Args:
            text: For example ``linear``, ``ease:2``, ``beam:3:unforced``, or ``auto:0.001`` with
                ``straight_within``.
            **options: Other fields that this method has; None leaves one open.

        Raises:
            ParameterError: The text or an option is not understood, the method has no such
                option, or it is given twice.
        """
        kind, found = cls.read(text)
        stated = {name: value for name, value in options.items() if value is not None}
        kind._require(stated, repr(text))
        for name in stated:
            if name in found or (name == "load" and "order" in {*found, *stated}):
                raise ParameterError(
                    f"method {text!r}: the {name} is given twice; leave one of them out"
                    + (" (the order R stands for the load t^R)" if name == "load" else "")
                )
        return kind(**found, **stated)

    @classmethod
    def read(cls, text: str) -> tuple[type[Method], dict[str, Any]]:
        """The class that a text names and the options it states.

        Raises:
            ParameterError: As `parse`.
        """
        if not isinstance(text, str):
            raise ParameterError(
                f"a method is a text such as 'beam:2' or a Method, found {type(text).__name__}"
            )
        name, *words = text.strip().split(":")
        kind = cls.named(name)
        found: dict[str, Any] = {}
        for word in words:
            option, value = _read_word(kind, word, text)
            if option in found:
                raise ParameterError(f"method {text!r} names an option twice")
            found[option] = value
        return kind, found

    @classmethod
    def named(cls, name: str) -> type[Method]:
        """The class that a name stands for.

        Raises:
            ParameterError: It stands for none.
        """
        for each in cls.known:
            if each.name == name:
                return each
        names = ", ".join(each.name for each in cls.known)
        raise ParameterError(f"method must be one of {names}, found {name!r}")

    @classmethod
    def every_option(cls) -> dict[str, Option]:
        """The options of all methods by name."""
        return {name: its for each in cls.known for name, its in options_of(each).items()}

    @classmethod
    def texts(cls) -> list[str]:
        """Texts that name the methods, and some with an option behind the name."""
        longer = [
            f"{kind.name}:{word}"
            for kind in cls.known
            for its in options_of(kind).values()
            if its.word is not None
            for word in its.word.examples
        ]
        return [*(kind.name for kind in cls.known), *longer]

    @classmethod
    def with_option(cls, name: str) -> tuple[str, ...]:
        """The names of the methods that have an option."""
        return tuple(each.name for each in cls.known if each.has(name))

    @classmethod
    def pattern(cls) -> str:
        """How a text names this method, as ``beam:R[:closure]``."""
        words = [its.word for its in options_of(cls).values() if its.word is not None]
        return cls.name + "".join(
            f":{word.shown}" if word.needed else f"[:{word.shown}]" for word in words
        )

    @classmethod
    def _require(cls, options: Iterable[str], text: str) -> None:
        own = [each.name for each in fields(cls)]
        for option in options:
            if option not in own:
                has = ", ".join(own) or "no settings"
                raise ParameterError(f"method {text}: {cls.name} has no {option}; it has {has}")


def _by_name(name: str = "auto", **options: Any) -> Method:
    return Method.named(name)(**options)


def _read_word(kind: type[Method], text: str, whole: str) -> tuple[str, Any]:
    """The option that a word behind a name states, and its value."""
    for own in (kind, *Method.known):
        for name, its in options_of(own).items():
            value = None if its.word is None else its.word.read(text)
            # A number that another method would take says little about what was meant.
            if value is not None and (own is kind or not isinstance(value, float)):
                kind._require([name], repr(whole))
                return name, value
    kinds = [its.word.kind for its in options_of(kind).values() if its.word is not None]
    if len(kinds) == 1:
        raise ParameterError(f"method {whole!r}: {text!r} is no {kinds[0]}")
    among = " nor ".join(f"an {own}" if own[0] in "aeiou" else f"a {own}" for own in kinds)
    problem = f"is neither {among}" if kinds else f"is nothing that {kind.name} has"
    raise ParameterError(
        f"method {whole!r}: {text!r} {problem}; examples: linear, ease:2, beam:3:unforced"
    )
