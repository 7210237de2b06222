"""The rig: named morphs on one neutral (Eqs. 36-40).

The paths of a rig: those given, and those made to targets that are meshes.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cached_property, partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from elastomorph.blas_threads import in_own_threads
from elastomorph.errors import ParameterError
from elastomorph.model.geometry import moved_extent
from elastomorph.model.mesh import Mesh, require_mesh, require_same_topology
from elastomorph.model.morph import Morph
from elastomorph.numbers import as_numbers, real_type
from elastomorph.rig.fields import MorphFields, RigFields, block_length, checked_output
from elastomorph.rig.handles import Handle, Place
from elastomorph.rig.laws import Corrective
from elastomorph.rig.pairs import is_pair_bend, pair_bends
from elastomorph.rig.sliders import (
    Sliders,
    Times,
    Weights,
    named_correctives,
    named_lists,
    named_moments,
    table_moments,
)
from elastomorph.rig.tracking import PRIOR, Bounds, Solved, solve, track

if TYPE_CHECKING:
    from elastomorph.curves import CurveNetwork
    from elastomorph.paths import Method


def paths_to(
    neutral: Mesh,
    morphs: Mapping[str, Morph | Mesh],
    method: str | Method | None = None,
    *,
    curves: CurveNetwork | None = None,
    extent: float | None = None,
    correctives: Mapping[str, Corrective] = MappingProxyType({}),
    turned: Collection[str] = (),
    say: Callable[[str], None] = lambda _: None,
    **settings: object,
) -> tuple[dict[str, Morph], dict[str, Corrective]]:
    """A path from the neutral by each name, in their order: those given, and made to targets.

    They are made on all cores, by ``auto`` where no method is named, with D of what all move.
    Vertices at one place in the neutral and at the end of every path move as one, as for `prepare`.
    Behind them are the pair bends of those that were made and meet each other, or one of those
    given that are ``turned``; the correctives are those given and theirs.
    """
    require_mesh(neutral, "the neutral of a rig")
    if not isinstance(morphs, Mapping):
        raise ParameterError(
            "a rig needs a mapping from names to morphs or meshes, such as "
            f"{{'jawOpen': mesh}}, found {type(morphs).__name__}"
        )
    targets = _bare_targets(neutral, morphs)
    if not targets:
        if method is not None:
            raise ParameterError("every path of the rig is there: a method has nothing to make")
        return dict(morphs), dict(correctives)  # type: ignore[arg-type]
    # Imported here: a rig whose paths are there needs nothing of what makes them.
    from elastomorph.paths import Method, prepare

    chosen = "auto" if method is None else method
    ends = {name: m.target if isinstance(m, Morph) else m for name, m in morphs.items()}
    if extent is None and "extent" in Method.of(chosen).inputs():
        extent = moved_extent(neutral.vertices, [end.vertices for end in ends.values()])
    to = prepare(
        neutral,
        chosen,
        curves=curves,
        extent=extent,
        targets=list(ends.values()),
        **settings,  # type: ignore[arg-type]
    )
    whole = dict(morphs)

    def make(task: tuple[int, str]) -> None:
        number, name = task
        say(f"the path to {name}, {number} of {len(targets)}")
        whole[name] = to(targets[name])

    in_own_threads(make, enumerate(targets, start=1))
    paths: dict[str, Morph] = whole  # type: ignore[assignment]
    if not Method.of(chosen).turns:
        return paths, dict(correctives)
    scale = neutral.diameter if extent is None else extent
    among = {*targets, *turned}
    pairs, driven = pair_bends(neutral, paths, correctives, to, scale, among, say, targets)
    return paths | pairs, {**correctives, **driven}


def _bare_targets(neutral: Mesh, morphs: Mapping[str, Morph | Mesh]) -> dict[str, Mesh]:
    """The targets that paths are still to be made to; all must fit the neutral."""
    targets: dict[str, Mesh] = {}
    for name, given in morphs.items():
        if not isinstance(name, str):
            raise ParameterError(f"the names of a rig are texts, found {name!r}")
        if isinstance(given, Morph):
            require_same_topology(neutral, given.neutral)
            if not np.array_equal(neutral.vertices, given.neutral.vertices):
                raise ParameterError(
                    f"the morph {name!r} starts at another neutral than that of the rig"
                )
        else:
            require_mesh(given, f"{name!r} of the rig (if it is no Morph)")
            require_same_topology(neutral, given)
            targets[name] = given
    return targets


class Rig:
    """Named morphs on one neutral. Immutable.

    Args:
        neutral: The face at rest.
        morphs: Path of each expression by name, all from this neutral; or its target, a mesh, to
            which a path is made.
        correctives: How sliders drive each combination shape: a `Corrective`, or its drivers alone,
            whose product is its weight. Name the corrective itself among them if it has a slider of
            its own, as in ``{"mouthClose": ("jawOpen", "mouthClose")}``.
        groups: Names of groups and the morphs in each.
        method: How paths are made to the targets that are meshes, as for `elastomorph.interpolate`;
            ``auto`` by default, with D the extent of what the targets move.

    Attributes:
        neutral: The face at rest.
        morphs: Path of each expression, read-only.
        sliders: Names, correctives and groups.

    Raises:
        TopologyError: A morph belongs to another mesh.
        MeshError: The neutral is no mesh.
        ParameterError: A morph starts at another neutral, a name is unknown, or a method was given
            although every path is there.
    """

    def __init__(
        self,
        neutral: Mesh,
        morphs: Mapping[str, Morph | Mesh],
        *,
        correctives: Mapping[str, Corrective | Sequence[str]] | None = None,
        groups: Mapping[str, Sequence[str]] | None = None,
        method: str | Method | None = None,
    ) -> None:
        self.neutral = neutral
        paths, driven = paths_to(
            neutral, morphs, method, correctives=named_correctives(correctives)
        )
        self.morphs: Mapping[str, Morph] = MappingProxyType(paths)
        self.sliders = Sliders(tuple(paths), driven, named_lists(groups, "groups"))

    def __reduce__(self) -> tuple[Any, ...]:
        """What copies are made of, such as those that other processes get."""
        own = self.sliders
        made = partial(type(self), correctives=dict(own.correctives), groups=dict(own.groups))
        return made, (self.neutral, dict(self.morphs))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the sliders, the columns of `batch`."""
        return self.sliders.names

    @cached_property
    def fields(self) -> RigFields:
        """Δ and bends of all morphs, only where they move anything."""
        return RigFields(
            self.neutral.vertices, tuple(MorphFields.of(m) for m in self.morphs.values())
        )

    def only(self, names: Sequence[str]) -> Rig:
        """A rig of some of the morphs, in the order of the names, without correctives.

        The pair bends of those that meet are a part of their paths and stay, behind them.

        Raises:
            ParameterError: An unknown name.
        """
        if isinstance(names, str) or not isinstance(names, Iterable):
            raise ParameterError(f"names are a list of morphs, found {names!r}")
        known = tuple(self.targets)
        for name in names:
            self.sliders.require(name, known)
        pairs = self.pair_bends(set(self.morphs).difference(names))
        kept = {name: self.morphs[name] for name in (*names, *pairs)}
        return Rig(self.neutral, kept, correctives=pairs)

    def pair_bends(self, without: Collection[str] = ()) -> dict[str, Corrective]:
        """What drives each pair bend: a corrective that has bends and no shape.

        Args:
            without: Morphs that do not count; what they drive is left out, and they are.
        """
        return {
            name: own
            for name, own in self.sliders.correctives.items()
            if is_pair_bend(self.morphs[name]) and not {*own.drivers} & {*without}
        }

    @property
    def targets(self) -> dict[str, Mesh]:
        """The target of each morph that has a shape: of all but the pair bends."""
        pairs = self.pair_bends()
        return {name: morph.target for name, morph in self.morphs.items() if name not in pairs}

    def pose(self, weights: Weights) -> NDArray[np.float64]:
        """Positions under slider weights, as an animator sets them.

        The weight of a morph is the parameter t of its path: V = V₀ + Σ_j (w^j(t_j) - V₀). Only
        morphs that are not at 0, and only their vertices, are computed.

        Args:
            weights: Weight of each slider by name; those left out are 0. Or (J,) weights of all
                sliders in the order of `names`.

        Returns:
            (V, 3) float64.

        Raises:
            ParameterError: An unknown name, a weight that is not a finite number, or more or fewer
                weights than sliders.
        """
        times = self.sliders.drive(self.sliders.row(weights)[None])[0]
        return self.fields.posed((times != 0).astype(float), times)

    def blend(
        self, weights: Weights, t: Times = 1.0, *, normalize: bool = False
    ) -> NDArray[np.float64]:
        """Positions under blend weights ζ at one common time: V₀ + Σ ζ_j (w^j(t) - V₀).

        For Σζ = 1 this is Eq. 38; otherwise Eq. 38 would scale the neutral.

        Args:
            weights: ζ of each slider, by name or in order as for `pose`.
            t: The time, or one for each slider by name (1 where left out).
            normalize: Divide the weights by their sum, as the paper does.

        Returns:
            (V, 3) float64.

        Raises:
            ParameterError: An unknown name, a number that is not finite, or weights to normalize
                whose sum is 0.
        """
        zeta, times = named_moments(self.sliders, weights, t, normalize)
        return self.fields.posed(zeta, times)

    def velocity(self, weights: Weights, rates: Weights) -> NDArray[np.float64]:
        """How fast the vertices of a pose move while sliders move.

        Args:
            weights: Weight of each slider, as for `pose`.
            rates: How fast each weight changes, per unit of time, likewise.

        Returns:
            (V, 3) float64, unit of length per the same unit of time.

        Raises:
            ParameterError: An unknown name, or a number that is not finite.
        """
        times, slopes = self.sliders.drive_rates(self.sliders.row(weights))
        return self.fields.moving(times, slopes @ self.sliders.row(rates))

    def solve(
        self,
        handles: Mapping[Handle, ArrayLike],
        weights: Weights | None = None,
        bounds: Bounds = (0.0, 1.0),
        *,
        prior: float = PRIOR,
        landmarks: Mapping[str, Place] | None = None,
    ) -> Solved:
        """Slider weights that bring points of the face to positions, as when it is dragged.

        Where several faces do, that with the least change of the sliders; where none does, the
        one with the least sum of squared distances, and what is left is said.

        Args:
            handles: (3,) position of each handle: a vertex, several with their shares of a point
                between them, as in ``((12, 40, 41), (0.2, 0.3, 0.5))``, or a landmark.
            weights: Pose to start from, as for `pose`, moved into the bounds; at rest by default.
            bounds: Least and greatest weight of every slider, or of some by name; others 0 and 1.
            prior: Cost of moving a slider by 1, beside half the squared distances over the farthest
                that a slider moves a handle. 1e-3 and more for positions with noise.
            landmarks: Vertex of each landmark that handles name.

        Returns:
            The weights, and how far each handle is left from its position.

        Raises:
            ParameterError: No handles, or a handle, position or weight that cannot be.
        """
        return solve(self, handles, weights, bounds, prior, landmarks)

    track = track

    def batch(
        self,
        weights: ArrayLike,
        times: ArrayLike | None = None,
        out: NDArray[np.floating] | None = None,
        *,
        normalize: bool = False,
        dtype: DTypeLike = np.float32,
        backend: str = "numpy",
    ) -> NDArray[np.floating]:
        """Many faces by one matrix product.

        Args:
            weights: (S, J) one row a face, one column for each slider in the order of `names`.
            times: (S,) one time a face, (S, J) one for each slider, or one number: the weights
                are ζ of `blend`. None: the weights are those of `pose`.
            out: (S, V, 3) C-contiguous float32 or float64 array to write into.
            normalize: Divide the weights of each face by their sum.
            dtype: Of the result where `out` is not given, float32 or float64.
            backend: ``numpy``, or ``torch``, which is faster on many processors. For a GPU see
                `elastomorph.rig.torch_module.RigModule`.

        Returns:
            (S, V, 3), `out` where it was given.

        Raises:
            ParameterError: Shapes that do not fit, numbers that are not finite, weights to
                normalize whose sum is 0, or a buffer of another type or layout.
            MissingExtraError: PyTorch was asked for and is not installed.
        """
        zeta, moments = table_moments(self.sliders, weights, times, normalize)
        shape = (len(zeta), *self.neutral.vertices.shape)
        out = np.empty(shape, dtype=real_type(dtype)) if out is None else checked_output(out, shape)
        flat = out.reshape(len(out), shape[1] * 3)
        self.fields.product(out.dtype).into(zeta, moments, flat, backend)
        return out

    def stream(
        self,
        weights: ArrayLike,
        times: ArrayLike | None = None,
        *,
        normalize: bool = False,
        dtype: DTypeLike = np.float32,
        block: int | None = None,
    ) -> Iterator[NDArray[np.floating]]:
        """Many faces in blocks of fixed memory.

        Args:
            weights: As for `batch`.
            times: As for `batch`.
            normalize: As for `batch`.
            dtype: float32 or float64.
            block: Faces in a block; as many as fit 64 MiB by default.

        Yields:
            (s, V, 3) arrays, one after another; each is overwritten by the next, so copy what
            you keep.

        Raises:
            ParameterError: As for `batch`.
        """
        table = self.sliders.table(weights)
        real = real_type(dtype)
        length = block_length(block, self.neutral.vertices.size * real.itemsize)
        when = None if times is None else as_numbers(times, "times")
        buffer = np.empty((min(length, max(len(table), 1)), *self.neutral.vertices.shape), real)
        for start in range(0, len(table), length):
            part = table[start : start + length]
            now = when if when is None or when.ndim == 0 else when[start : start + length]
            yield self.batch(part, now, buffer[: len(part)], normalize=normalize)

    def save(self, path: str | Path, **options: Any) -> Any:
        """Write the rig to a file (.glb, .usd, .usda, .usdc, .usdz, .npz): `elastomorph.write`.

        Args:
            path: The file; its suffix names the format and its folder must exist.
            **options: Of the format, see its writer.

        Returns:
            What the writer reports.

        Raises:
            FormatError: The suffix is unknown, or the format cannot hold the rig.
            FileError: The file cannot be written.
            MissingExtraError: The format needs a package that is not installed.
        """
        from elastomorph.io import write  # Upward, as pyproject.toml names it

        return write(path, self, **options)

    def view(self, *, say: Callable[[str], object] = print) -> None:
        """Show the rig in the browser, served to this machine only, until Ctrl-C.

        Args:
            say: Told the address.

        Raises:
            ParameterError: The mesh has no polygons.
            FormatError: Coordinates too large for single precision.
        """
        import webbrowser

        from elastomorph.viewer import rig_scene, serve

        with serve(rig_scene(self, title=repr(self)), None) as server:
            say(server.words)
            webbrowser.open(server.address)
            server.wait()

    def _repr_html_(self) -> str:
        """The viewer, for a notebook."""
        from elastomorph.viewer.notebook import notebook_html

        return notebook_html(self)

    def __getitem__(self, name: str) -> Morph:
        """The path of this name.

        Raises:
            ParameterError: There is none.
        """
        self.sliders.require(name, self.sliders.morphs)
        return self.morphs[name]

    def __contains__(self, name: object) -> bool:
        return name in self.sliders.morphs

    def __iter__(self) -> Iterator[str]:
        return iter(self.morphs)

    def __len__(self) -> int:
        return len(self.morphs)

    def __repr__(self) -> str:
        bends = sum(len(morph.bends) for morph in self.morphs.values())
        return f"Rig({len(self)} morphs, {bends} bends, {len(self.neutral.vertices):,} vertices)"
