"""A method of interpolation with its settings: what a table's row or a command's option names."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from elastomorph.errors import ParameterError
from elastomorph.physics import BASES, CLOSURES, STIFFNESSES, Load, Material

__all__ = ["METHODS", "Method"]

METHODS = ("linear", "cosine", "ease", "beam", "plate", "arc", "rotation", "auto")
_WITH_ORDER = ("ease", "beam", "plate")
_ELASTIC = ("beam", "plate")


@dataclass(frozen=True)
class Method:
    """How the path from neutral to target is made.

    Attributes:
        name: ``linear`` (Eq. 34), ``cosine`` ((1 - cos πt)/2), ``ease`` (p(t)/p(1) on the straight
            line), ``beam`` (Eqs. 31-33 for any order), ``plate`` (the same on the surface), ``arc``
            (circular arcs of the local rotation), ``rotation`` (least distortion), ``auto`` (the
            straight line where ``rotation`` stays close to it, else ``rotation``).
        order: R of the load t^R, from 1 to 20.
        material: m, c, k of ``beam`` and ``plate``.
        closure: Time law of the mean of a curve, or of a piece of the surface, see
            `elastomorph.physics.mean_response`.
        load: Any polynomial load instead of t^R.
        basis: Modes of open curves, ``cosine`` or the paper's ``fourier``.
        stiffness: ``uniform``: u from 0 to 1 along every curve. ``length``: short curves are
            stiffer, B_n over (L/D)⁴.
        harmonics: Modes above this number follow the limit law; all are solved by default.
        tolerance: How closely the bends of ``arc`` and ``rotation`` hold their path, as a fraction
            of D; smaller ones cost more bends.
        straight_within: How far from the straight line ``auto`` lets the path of ``rotation`` be,
            halfway and as a fraction of D, and still goes straight.

    Raises:
        ParameterError: A setting is unknown or out of range.
    """

    name: str = "beam"
    order: int = 2
    material: Material = field(default_factory=Material)
    closure: str = "limit"
    load: Load | None = None
    basis: str = "cosine"
    stiffness: str = "uniform"
    harmonics: int | None = None
    tolerance: float = 1e-4
    straight_within: float = 5e-4

    def __post_init__(self) -> None:
        for value, allowed, what in (
            (self.name, METHODS, "method"),
            (self.closure, CLOSURES, "closure"),
            (self.basis, BASES, "basis"),
            (self.stiffness, STIFFNESSES, "stiffness"),
        ):
            if value not in allowed:
                raise ParameterError(f"{what} must be one of {', '.join(allowed)}, found {value!r}")
        if not isinstance(self.material, Material):
            raise ParameterError(f"material must be a Material, found {self.material!r}")
        if self.load is None:
            Load.power(self.order)
        if not isinstance(self.tolerance, float) or not self.tolerance > 0:
            raise ParameterError(f"tolerance must be a number above 0, found {self.tolerance!r}")
        if not isinstance(self.straight_within, float) or not self.straight_within >= 0:
            raise ParameterError(
                f"straight_within must be a number ≥ 0, found {self.straight_within!r}"
            )
        if self.harmonics is not None and (
            not isinstance(self.harmonics, int) or self.harmonics < 0
        ):
            raise ParameterError(f"harmonics must be a whole number ≥ 0, found {self.harmonics!r}")

    @property
    def external_load(self) -> Load:
        """p(t): the load given, or t^R."""
        return Load.power(self.order) if self.load is None else self.load

    @property
    def label(self) -> str:
        """A short name for tables, with the settings that differ from the usual ones."""
        words = [self.name]
        if self.name in _WITH_ORDER:
            if self.load is None:
                words.append(f"R={self.order}")
            else:
                words.append(f"load {','.join(f'{p:g}' for p in self.load.coefficients)}")
        if self.name in _ELASTIC:
            usual = Method()
            words += [
                value
                for value, plain in ((self.closure, usual.closure), (self.basis, usual.basis))
                if value != plain
            ]
            if self.stiffness != usual.stiffness:
                words.append(f"by {self.stiffness}")
            if self.harmonics is not None:
                words.append(f"N={self.harmonics}")
            if self.material != usual.material:
                m = self.material
                words.append(f"m={m.mass:g} c={m.damping:g} k={m.rigidity:g}")
        return " ".join(words)

    @classmethod
    def parse(cls, text: str, **settings: object) -> Method:
        """A method from ``name``, ``name:order`` or ``beam:order:closure``.

        Args:
            text: For example ``linear``, ``ease:2``, ``beam:3:unforced``.
            **settings: Any other field, for all that the text leaves open.

        Raises:
            ParameterError: The text or a setting is not understood.
        """
        name, *options = text.strip().split(":")
        found: dict[str, object] = {"name": name}
        for option in options:
            if option.isascii() and option.isdigit():
                found["order"] = int(option)
            elif option in CLOSURES:
                found["closure"] = option
            else:
                raise ParameterError(
                    f"method {text!r}: {option!r} is neither an order (a whole number) nor a "
                    f"closure ({', '.join(CLOSURES)}); examples: linear, ease:2, beam:3:unforced"
                )
        if len(options) != len(found) - 1:
            raise ParameterError(f"method {text!r} names an option twice")
        if name in METHODS and name not in _WITH_ORDER and options:
            raise ParameterError(f"method {text!r}: {name} has no order and no closure")
        if name in METHODS and name not in _ELASTIC and "closure" in found:
            raise ParameterError(f"method {text!r}: {name} has no closure")
        return cls(**{**settings, **found})  # type: ignore[arg-type]

    def with_material(self, material: Material) -> Method:
        """The same method for another material."""
        return replace(self, material=material)
