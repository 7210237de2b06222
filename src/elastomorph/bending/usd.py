"""Bends the paths of a character in USD: a layer over its file, which stays as it is.

UsdSkel plays a blend shape in straight pieces through its in-betweens, whose only input is the
weight: animations of weights play bent without a change. In-betweens are those of all meshes that
a target moves together, at the same weights, so that no seam between meshes opens.

Where two targets meet, their pair bend is a blend shape that the layer adds: at weight 1 it moves
nothing, and its in-betweens are the bend. The layer extends the animation that a mesh follows by
its weight; others drive it by the least of the weights of both. Correctives that hold a rig
together are blend shapes of the layer too, with weights by their laws.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from elastomorph.bending.keys import Columns, Driven, bent_keys
from elastomorph.bending.plan import BentMorph, Plan, make_plan, not_bare, plan_as_is
from elastomorph.errors import FormatError, ParameterError
from elastomorph.io.atomic import read_bytes, replacing, same_file
from elastomorph.io.untrusted import naming_file
from elastomorph.io.usd.inbetweens import Placement, place_inbetweens
from elastomorph.io.usd.layer import (
    BentShape,
    OriginalAnimation,
    OriginalFile,
    OriginalMesh,
    OriginalShape,
    added_shapes,
    bent_shape,
    original_of,
    read_original,
    require_layer_path,
    require_other_file,
    straight_shape,
    write_layer,
)
from elastomorph.io.usd.reader import read_usd
from elastomorph.model.morph import Morph
from elastomorph.numbers import as_number
from elastomorph.paths import Method
from elastomorph.paths.welding import Welding
from elastomorph.rig import Rig
from elastomorph.rig.build import bare_rig

_TOLERANCE = 5e-4  # up to which `auto` takes a straight line: what it bends has an in-between
_OF_PATHS = 1e-5  # of the curved paths beside the in-betweens
_MOST = 62  # in-betweens 1/64 apart


@dataclass(frozen=True)
class UsdBentTarget:
    """What becomes of one target.

    Attributes:
        name: Its name.
        method: That of its path, ``linear`` where it stays straight.
        gain: Largest distance between its path and the straight line, as a fraction of D.
        inbetweens: Weights of the in-betweens it gets, rising between 0 and 1.
        error: Largest distance between the straight pieces that UsdSkel plays and the path, as a
            fraction of D, for weights from 0 to 1.
        bytes: Of the numbers that are added for it.
        meshes: Paths of the meshes in which it bends.
        note: Why it stays as it is, where it does.
    """

    name: str
    method: str
    gain: float
    inbetweens: tuple[float, ...]
    error: float
    bytes: int
    meshes: tuple[str, ...]
    note: str = ""


@dataclass(frozen=True)
class UsdBendReport:
    """What a layer of bends holds, or would hold.

    Attributes:
        path: The character.
        original: The file that the layer lies over: the same, unless that is a layer of bends.
        output: The layer; None where nothing was written, as where nothing bends.
        bytes: Size of the layer.
        tolerance: The error asked for, as a fraction of D.
        extent: D, the largest distance between two vertices that the targets move, in the unit of
            the file.
        targets: One entry a target, in the order of the file.
        notes: What is not covered.
    """

    path: Path
    original: Path
    output: Path | None
    bytes: int
    tolerance: float
    extent: float
    targets: tuple[UsdBentTarget, ...]
    notes: tuple[str, ...]

    @property
    def bent(self) -> tuple[UsdBentTarget, ...]:
        """The targets that bend."""
        return tuple(target for target in self.targets if target.meshes)

    @property
    def error(self) -> float:
        """The largest error of all targets, as a fraction of D."""
        return max((target.error for target in self.targets), default=0.0)


def bend_usd(
    path: str | Path,
    output: str | Path | None,
    *,
    method: str | Method | Mapping[str, str | Method] | None = None,
    only: Collection[str] | None = None,
    tolerance: float | None = None,
    say: Callable[[str], None] = lambda _: None,
) -> UsdBendReport:
    """Write a layer that bends the blend shapes of a USD file.

    The layer sublayers the file and overrides its BlendShape prims: each gets the fewest
    in-betweens that hold it within the tolerance of its path, and beside them the path itself,
    which `elastomorph.read_rig` gives back. Of targets that meet it adds pair bends, to the lists
    of their meshes and to the animation that these follow, with keys where it takes them. Targets
    that have in-betweens, or a path of elastomorph's, keep them. A layer of bends is made anew from
    the file that it lies over, and keeps correctives that `hold_usd` wrote.

    Args:
        path: A .usd, .usda, .usdc or .usdz file, or a layer that this function wrote.
        output: The layer: .usda is text, .usdc and .usd are binary. None writes nothing and tells
            what a binary one would be.
        method: A method for all targets, or by name of the target; ``auto`` by default.
        only: Names of the only targets that may bend.
        tolerance: Of in-betweens, as a fraction of D; 0.0005 by default.
        say: Called with what is being done.

    Raises:
        MissingExtraError: usd-core is not installed.
        ParameterError: A name or method is unknown, or the tolerance no number above 0.
        FormatError: The file is damaged, has no blend shapes, or they lie in an instance.
        FileError: A file is missing, cannot be read or written, or the output is an input.
    """
    allowed = as_number(_TOLERANCE if tolerance is None else tolerance, "the tolerance", above=0)
    face = _Face.read(path, output)
    names = _names(only, face.original.rig)
    plan = make_plan(
        face.bare(),
        method,
        only=[name for name in names if name not in face.kept],
        tolerance=min(_OF_PATHS, allowed),
        say=say,
    ).with_correctives(face.welded(face.rig))
    return _Bends(face, plan, frozenset(names), face.kept, allowed).written(path, output, say)


def hold_usd(
    path: str | Path,
    output: str | Path | None,
    held: Callable[[Rig], Rig],
    *,
    say: Callable[[str], None] = lambda _: None,
) -> UsdBendReport:
    """Write a layer that adds correctives to a USD file, and to its animations; its paths stay.

    What a layer of bends says is said by the new layer too, with in-betweens within the same
    tolerance: both lie over the same file.

    Args:
        path: As of `bend_usd`.
        output: The layer, if anything is added; None: only say what would come of it.
        held: From the rig of the file to that with correctives.
        say: Called with what is being done.

    Raises:
        MissingExtraError: As of `bend_usd`.
        FormatError: As of `bend_usd`.
        FileError: As of `bend_usd`.
    """
    say(f"reading {path}")
    face = _Face.read(path, output)
    more = held(not_bare(face.rig))
    allowed = face.original.tolerance or _TOLERANCE
    plan = plan_as_is(face.original.rig, face.welded(more), min(_OF_PATHS, allowed))
    # Nothing is said of what the original says, nor of paths that are still to be chosen.
    stay = {name for name, morph in face.rig.morphs.items() if face.whole or morph.bare}
    bends = _Bends(face, plan, frozenset(face.rig.morphs), face.kept | stay, allowed)
    return bends.written(path, output if len(more) > len(face.rig) else None, say)


def unbend_usd(path: str | Path, output: str | Path) -> Path:
    """Copy the file that a layer of bends lies over, byte for byte; the path of that file.

    Args:
        path: A layer that `bend_usd` wrote.
        output: The copy. A file that may name others stays in its folder; a package (.usdz) may go
            anywhere.

    Raises:
        MissingExtraError: usd-core is not installed.
        FormatError: It is no such layer, or the copy would be no file of the same kind.
        FileError: A file is missing, cannot be read or written, or the output is an input.
    """
    original, files = original_of(path)
    suffix = original.suffix.lower()
    if Path(output).suffix.lower() != suffix:
        raise FormatError(
            output, f"the original is {original.name}, which is as it was; name a {suffix} file"
        )
    require_other_file(output, original, files)
    if suffix != ".usdz" and Path(output).resolve().parent != original.parent:
        raise FormatError(
            output,
            f"the original is {original}, which is as it was and may name files beside it; use it "
            "there, or name a copy in its folder",
        )
    content = read_bytes(original)
    with replacing(output) as file:
        file.write(content)
    return original


def _require_reach(path: str | Path, original: OriginalFile) -> None:
    """Refuse blend shapes that no layer can override."""
    for mesh in original.meshes:
        for shape in mesh.shapes:
            if shape.instance is not None:
                raise FormatError(
                    path,
                    f"{shape.prim} lies in the instance {shape.instance}, and nothing in an "
                    "instance can be overridden; take the file that it refers to, or make the "
                    "instance a plain reference (instanceable = false)",
                )


@dataclass(frozen=True, eq=False)
class _Face:
    """The meshes of a file that have blend shapes, as one."""

    original: OriginalFile
    rig: Rig  # With the paths and correctives of the file: of a layer, not those of its original
    whole: bool  # Whether the file is no layer, but the original
    welding: Welding
    kept: frozenset[str]  # Morphs with in-betweens or paths in the original

    @classmethod
    def read(cls, path: str | Path, output: str | Path | None) -> _Face:
        """The face in a file, over which a layer may be written to the output."""
        if output is not None:
            require_layer_path(output)
        original = read_original(path)
        if output is not None:
            require_other_file(output, original.path, original.files)
        _require_reach(path, original)
        rig, whole = original.rig, same_file(path, original.path)
        targets = [morph.target.vertices for morph in rig.morphs.values()]
        if all(np.array_equal(target, rig.neutral.vertices) for target in targets):
            raise FormatError(
                original.path,
                "none of its blend shapes moves any vertex, so there is nothing to bend; export it "
                "with blend shapes that move",
            )
        shapes = [shape for mesh in original.meshes for shape in mesh.shapes]
        kept = frozenset(shape.name for shape in shapes if shape.has_path)
        welding = Welding.of(rig.neutral, targets)
        return cls(original, rig if whole else read_usd(path), whole, welding, kept)

    def bare(self) -> Rig:
        """The targets of the original, as of the face that paths are made for."""
        morphs = self.original.rig.morphs
        ends = {name: self.welding.mesh(morph.target) for name, morph in morphs.items()}
        return bare_rig(self.welding.neutral, ends)

    def welded(self, rig: Rig) -> Rig:
        """A rig of the face likewise, without the bends that the original keeps."""
        with naming_file(self.original.path):
            morphs = {
                name: self.welding.welded(
                    replace(own, bends=own.bends[:0], bend_curves=()) if name in self.kept else own
                )
                for name, own in rig.morphs.items()
            }
        return Rig(self.welding.neutral, morphs, correctives=rig.sliders.correctives)


@dataclass(frozen=True, eq=False)
class _Bends:
    """What a layer adds to a file, and where in-betweens are."""

    face: _Face
    plan: Plan
    asked: frozenset[str]  # Morphs that may bend
    silent: frozenset[str]  # Morphs of the original of which the layer says nothing
    tolerance: float  # Of the in-betweens, as a fraction of D

    @cached_property
    def placements(self) -> Mapping[str, Placement]:
        """The fewest in-betweens that hold each morph that bends."""
        within = self.tolerance * self.plan.extent / (self.face.welding.neutral.diameter or 1.0)
        return {
            own.name: place_inbetweens(own.morph, tolerance=within, most=_MOST)
            for own in self.plan.bent
        }

    def written(
        self, path: str | Path, output: str | Path | None, say: Callable[[str], None]
    ) -> UsdBendReport:
        """Write the layer if there is anything to add, or only find out how large it would be."""
        say(f"Placing in-betweens for {len(self.plan.bent)} targets")
        original, allowed = self.face.original, self.tolerance
        output = output if self.plan.bent else None
        shapes = list(self.shapes(path if output is None else output)) if self.plan.bent else []
        clips = [own for one in original.animations if (own := _extended(one, shapes, allowed))]
        if not shapes:
            size = 0
        elif output is None:
            with tempfile.TemporaryDirectory(prefix="elastomorph-") as folder:
                place = Path(folder) / "bends.usdc"
                size = write_layer(place, original, shapes, clips, tolerance=allowed)
        else:
            size = write_layer(output, original, shapes, clips, tolerance=allowed)
        return UsdBendReport(
            Path(path),
            original.path,
            None if output is None else Path(output),
            size,
            allowed,
            self.plan.extent,
            tuple(self.targets(shapes)),
            tuple(self._notes()),
        )

    def _notes(self) -> Iterator[str]:
        original, kept = self.face.original, self.face.kept
        if not self.face.whole:
            yield "the file is a layer: what is written lies over the file under it, in its place"
        if kept:
            names = ", ".join(name for name in original.rig.morphs if name in kept)
            yield f"targets that have in-betweens already, and keep them: {names}"
        shapes = [shape for mesh in original.meshes for shape in mesh.shapes]
        variants = {own for shape in shapes for own in shape.variants}
        if variants:
            yield (
                f"only the selected variants ({', '.join(sorted(variants))}) are changed; the "
                "blend shapes of others stay as they are"
            )

    def shapes(self, output: str | Path) -> Iterator[BentShape]:
        """What the layer says of each blend shape of which it says something."""
        bent = {own.name: own for own in self.plan.bent}
        known: dict[str, BentShape] = {}
        whole: dict[str, Morph] = {}
        original = self.face.original
        for mesh in original.meshes:
            for shape in mesh.shapes:
                if shape.name in self.silent:
                    continue
                if shape.name in bent and shape.name not in whole:
                    whole[shape.name] = self._whole(bent[shape.name])
                own = self._shape(output, mesh, shape, whole.get(shape.name))
                if shape.prim not in known:
                    known[shape.prim] = own
                    yield own
                else:
                    _require_same(original, known[shape.prim], own)
        for one in self.plan.bent:
            if one.law is not None:
                weights, extent = self.placements[one.name].weights, self.plan.extent
                yield from added_shapes(
                    output, original, one.name, one.law, self._whole(one), weights, extent
                )

    def _whole(self, bent: BentMorph) -> Morph:
        rig, welding = self.face.original.rig, self.face.welding
        if bent.name in rig:
            target = rig.morphs[bent.name].target
        else:
            moved = welding.fields(bent.morph.delta)
            target = rig.neutral.with_vertices(rig.neutral.vertices + moved)
        return welding.morph(rig.neutral, target, bent.morph)

    def _shape(
        self, output: str | Path, mesh: OriginalMesh, shape: OriginalShape, morph: Morph | None
    ) -> BentShape:
        if morph is None:
            return straight_shape(output, shape, self.plan.rig.morphs[shape.name])
        weights = self.placements[shape.name].weights
        return bent_shape(output, mesh, shape, morph, weights, self.plan.extent)

    def targets(self, shapes: list[BentShape]) -> Iterator[UsdBentTarget]:
        """What becomes of each target."""
        bent = {own.name: own for own in self.plan.bent}
        scale = (self.face.welding.neutral.diameter or 1.0) / (self.plan.extent or 1.0)
        added: dict[str, list[BentShape]] = {}
        for shape in shapes:
            if shape.bent or shape.original.driven:
                added.setdefault(shape.original.name, []).append(shape)
        added_names = [own.name for own in self.plan.bent if own.law is not None]
        for name in (*self.face.original.rig.morphs, *added_names):
            if name not in bent:
                yield UsdBentTarget(name, "linear", 0.0, (), 0.0, 0, (), self._why(name))
                continue
            own, placement = added.get(name, []), self.placements[name]
            yield UsdBentTarget(
                name,
                bent[name].morph.method,
                bent[name].gain,
                tuple(placement.weights.tolist()),
                placement.error * scale,
                sum(shape.bytes for shape in own),
                tuple(shape.original.prim.rpartition("/")[0] for shape in own),
            )

    def _why(self, name: str) -> str:
        if name in self.face.kept:
            return "keeps the in-betweens it has"
        if name not in self.asked:
            return "not asked for"
        choice = self.plan.rig.morphs[name].choice
        return "straight" if choice is None else choice.text


def _extended(
    own: OriginalAnimation, shapes: Collection[BentShape], tolerance: float
) -> OriginalAnimation | None:
    """The animation with the weights of shapes that are added, within a tolerance; None if none.

    It has a key wherever the straight lines that USD plays between keys would leave it.
    """
    place = {token: column for column, token in enumerate(own.tokens)}
    added = {s.original.found.token: s.original.driven for s in shapes if s.original.driven}
    driven = {t: one for t, one in added.items() if not place.keys().isdisjoint(one.drivers)}
    if not driven:
        return None
    count = len(own.tokens)  # The column behind stands for drivers that are not animated, at 0
    bends = tuple(
        (Driven(tuple(place.get(name, count) for name in one.drivers), one.law), None, one.speed)
        for one in driven.values()
    )
    columns, (rest, *rows) = Columns(count + 1, bends, {}), np.pad(own.weights, ((0, 0), (0, 1)))
    times, weights = own.times, columns.weights(rest)[None]
    if rows:
        # Keys are in single precision, time codes are not and may begin anywhere.
        since = times - times[0]
        keys = bent_keys(since, rows, "LINEAR", columns, tolerance)
        exact = dict(zip(since.astype(np.float32).tolist(), times.tolist(), strict=True))
        times = np.array([exact.get(time, times[0] + time) for time in keys.times.tolist()])
        weights = np.concatenate([weights, keys.values])
    weights = np.delete(weights, count, axis=1)
    return replace(own, tokens=(*own.tokens, *driven), times=times, weights=weights)


def _names(only: Collection[str] | None, rig: Rig) -> list[str]:
    """The morphs that may bend."""
    if only is None:
        return list(rig.morphs)
    if isinstance(only, str):
        raise ParameterError(f"only is a list of names, such as [{only!r}], found a text")
    for name in only:
        rig.sliders.require(name, tuple(rig.morphs))
    return [name for name in rig.morphs if name in set(only)]


def _require_same(original: OriginalFile, one: BentShape, other: BentShape) -> None:
    """Refuse a blend shape of two meshes that would have to bend in two ways."""
    same = one.offsets.shape == other.offsets.shape and np.allclose(
        one.offsets, other.offsets, rtol=0, atol=1e-5 * float(np.abs(one.offsets).max(initial=0))
    )
    if not same:
        raise FormatError(
            original.path,
            f"several meshes share the blend shape {one.original.prim} and would bend it in "
            "different ways; give each mesh its own",
        )
