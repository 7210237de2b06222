"""A method of interpolation with its settings: what a table's row or a command's option names."""

from __future__ import annotations

from dataclasses import MISSING, dataclass, field, fields, replace

from elastomorph.errors import ParameterError
from elastomorph.numbers import as_number
from elastomorph.physics import BASES, CLOSURES, STIFFNESSES, Load, Material

__all__ = ["METHODS", "SETTINGS", "Method"]

_PLATE = ("order", "load", "material", "closure", "harmonics")

SETTINGS: dict[str, tuple[str, ...]] = {
    "linear": (),
    "cosine": (),
    "ease": ("order", "load"),
    "beam": (*_PLATE, "basis", "stiffness"),
    "plate": _PLATE,
    "arc": ("tolerance",),
    "rotation": ("tolerance",),
    "auto": ("tolerance", "straight_within"),
}
"""The settings that each method has."""

METHODS = tuple(SETTINGS)


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
        ParameterError: A setting is unknown or out of range, or differs from its default although
            the method has no such setting.
    """

    name: str = "auto"
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
        elif not isinstance(self.load, Load):
            raise ParameterError(f"load must be a Load, such as Load([0, 1]), found {self.load!r}")
        tolerance = as_number(self.tolerance, "tolerance", above=0)
        within = as_number(self.straight_within, "straight_within", least=0)
        object.__setattr__(self, "tolerance", tolerance)
        object.__setattr__(self, "straight_within", within)
        whole = isinstance(self.harmonics, int) and not isinstance(self.harmonics, bool)
        if self.harmonics is not None and not (whole and self.harmonics >= 0):
            raise ParameterError(f"harmonics must be a whole number ≥ 0, found {self.harmonics!r}")
        for setting, usual in _USUAL.items():
            if getattr(self, setting) != usual:
                _require_setting(self.name, setting, repr(self.name))

    def has(self, setting: str) -> bool:
        """Whether a setting changes what this method does."""
        return setting in SETTINGS[self.name]

    @property
    def external_load(self) -> Load:
        """p(t): the load given, or t^R."""
        return Load.power(self.order) if self.load is None else self.load

    @property
    def label(self) -> str:
        """A short name for tables, with the settings that differ from the usual ones."""
        words = [self.name]
        if self.has("order"):
            if self.load is None:
                words.append(f"R={self.order}")
            else:
                words.append(f"load {','.join(f'{p:g}' for p in self.load.coefficients)}")
        usual = Method()
        for setting in ("closure", "basis"):
            value = getattr(self, setting)
            if self.has(setting) and value != getattr(usual, setting):
                words.append(value)
        if self.has("stiffness") and self.stiffness != usual.stiffness:
            words.append(f"by {self.stiffness}")
        if self.has("harmonics") and self.harmonics is not None:
            words.append(f"N={self.harmonics}")
        if self.has("material") and self.material != usual.material:
            m = self.material
            words.append(f"m={m.mass:g} c={m.damping:g} k={m.rigidity:g}")
        if self.has("straight_within") and self.straight_within != usual.straight_within:
            words.append(f"{self.straight_within:g}")
        return " ".join(words)

    @classmethod
    def of(cls, method: str | Method) -> Method:
        """The method that a text names, or the method itself.

        Raises:
            ParameterError: As `parse`.
        """
        return method if isinstance(method, Method) else cls.parse(method)

    @classmethod
    def parse(cls, text: str, **settings: object) -> Method:
        """A method from ``name``, ``name:order``, ``beam:order:closure`` or ``auto:distance``.

        Args:
            text: For example ``linear``, ``ease:2``, ``beam:3:unforced``, or ``auto:0.001`` with
                ``straight_within``.
            **settings: Other fields that this method has; None leaves one open.

        Raises:
            ParameterError: The text or a setting is not understood, the method has no such
                setting, or it is given twice.
        """
        if not isinstance(text, str):
            raise ParameterError(
                f"a method is a text such as 'beam:2' or a Method, found {type(text).__name__}"
            )
        name, *options = text.strip().split(":")
        found: dict[str, object] = {"name": name}
        for option in options:
            if name == "auto":
                found["straight_within"] = _distance(text, option)
            elif option.isascii() and option.isdigit():
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
        stated = [key for key, value in settings.items() if value is not None]
        for key in [*found, *stated] if name in METHODS else []:
            if key != "name":
                _require_setting(name, key, repr(text))
        for key in stated:
            if key in found or (key == "load" and "order" in {*found, *stated}):
                raise ParameterError(
                    f"method {text!r}: the {key} is given twice; leave one of them out"
                    + (" (the order R stands for the load t^R)" if key == "load" else "")
                )
        return cls(**{**found, **{key: settings[key] for key in stated}})  # type: ignore[arg-type]

    def with_material(self, material: Material) -> Method:
        """The same method for another material, where it has one."""
        return replace(self, material=material) if self.has("material") else self


_USUAL: dict[str, object] = {
    each.name: each.default if each.default_factory is MISSING else each.default_factory()
    for each in fields(Method)
    if each.name != "name"
}
"""The default of each setting."""


def _require_setting(name: str, setting: str, text: str) -> None:
    if setting not in SETTINGS[name]:
        has = ", ".join(SETTINGS[name]) or "no settings"
        raise ParameterError(f"method {text}: {name} has no {setting}; it has {has}")


def _distance(text: str, option: str) -> float:
    try:
        return float(option)
    except ValueError:
        raise ParameterError(
            f"method {text!r}: {option!r} is no number; auto takes the distance within which it "
            "goes straight, as a fraction of D, as in auto:0.001"
        ) from None
