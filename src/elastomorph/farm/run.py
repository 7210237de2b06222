"""Data sets made by the threads of one process, begun or gone on with."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any

from elastomorph.blas_threads import usable_cores
from elastomorph.errors import ParameterError
from elastomorph.farm.beginning import begin
from elastomorph.farm.encoding import Encoding
from elastomorph.farm.faces import FaceSet, open_faces
from elastomorph.farm.layout import DataSet
from elastomorph.farm.posing import Poser
from elastomorph.farm.recipe import Recipe
from elastomorph.farm.sampler import FaceSampler
from elastomorph.farm.stores import Order, naming_store, order_of
from elastomorph.farm.unit import Made, make_unit
from elastomorph.farm.words import size_text, time_text
from elastomorph.numbers import is_whole
from elastomorph.rig.rig import Rig


@dataclass
class Progress:
    """How far a run is. Its text is for people."""

    faces: int  # To be made in all
    done: int  # Finished, before this run and in it
    bytes: int = 0  # Written in this run
    before: int = field(default=0)  # Finished before this run
    start: float = field(default_factory=time.monotonic)

    def __post_init__(self) -> None:
        self.before = self.done

    def add(self, made: Made) -> None:
        """Count a unit."""
        self.done += made.faces
        self.bytes += made.bytes

    @property
    def rate(self) -> float:
        """Faces a second in this run."""
        return (self.done - self.before) / max(time.monotonic() - self.start, 1e-9)

    def __str__(self) -> str:
        left = (self.faces - self.done) / self.rate if self.rate else float("inf")
        per_face = self.bytes / max(self.done - self.before, 1)
        return (
            f"{self.done:,} of {self.faces:,} faces, {self.rate:,.0f} a second, "
            f"{size_text(self.bytes)} written, {time_text(left)} and "
            f"{size_text((self.faces - self.done) * per_face)} to go"
        )


def make_faces(
    rig: Rig,
    output: str | PathLike[str],
    faces: int | None = None,
    *,
    recipe: Recipe | Mapping[str, Any] | str | Path | None = None,
    seed: int | None = None,
    vertices: str | None = None,
    tolerance: float | None = None,
    normals: bool = False,
    landmarks: Mapping[str, int] | None = None,
    codec: str = "lz4",
    storage_options: Mapping[str, Any] | None = None,
    progress: Callable[[Progress], object] = lambda _: None,
) -> FaceSet:
    """Make a data set of faces, or go on where it stood.

    It holds the recipe, the rig and the weights of each face; positions are made from them when
    they are read, or stored too. Units of some thousand faces are made on all cores, and written
    whole: whatever ends the process, the same call goes on.

    Args:
        rig: The rig.
        output: A folder, made where it is missing, or an address that fsspec knows.
        faces: How many; more than there are make a data set grow. May be left out for a recipe
            of finite many.
        recipe: As for `FaceSampler`.
        seed: As for `FaceSampler`.
        vertices: Store positions as ``float32``, ``float16`` or ``int16``.
        tolerance: Largest error of stored positions in units of D. By default that of the type;
            for int16 1e-4, or the least that the rig allows.
        normals: Store (V, 3) float32 normals.
        landmarks: Store (L, 3) float32 positions of vertices, by name.
        codec: How what is stored is compressed: ``lz4``, ``zstd``, which is slower and a quarter
            smaller, or ``none``.
        storage_options: What fsspec needs to reach the address.
        progress: Told how far it is, an object that prints as a sentence, after each unit.

    Returns:
        The data set, open for reading.

    Raises:
        FileError: The output cannot be written; what is finished stays.
        FormatError: The output is something else, or a data set begun with another rig, recipe,
            seed or contents.
        ParameterError: An argument that cannot be meant.
        MissingExtraError: Zarr is not installed.
    """
    order = order_of(output, storage_options)
    sampler = FaceSampler(rig, recipe, seed=seed)
    with naming_store(order):
        data = begun(
            order,
            rig,
            sampler,
            faces,
            vertices=vertices,
            tolerance=tolerance,
            normals=normals,
            landmarks=landmarks,
            codec=codec,
        )
        work_off(data, progress)
    return open_faces(order.url, storage_options=storage_options)


def begun(
    order: Order,
    rig: Rig,
    sampler: FaceSampler,
    faces: int | None,
    *,
    vertices: str | None = None,
    tolerance: float | None = None,
    normals: bool = False,
    landmarks: Mapping[str, int] | None = None,
    codec: str = "lz4",
) -> DataSet:
    """The data set that is asked for, laid out with what was finished before."""
    count = sampler.count if faces is None else faces
    if not is_whole(count) or count < 1:
        raise ParameterError(f"a data set has one face or more, found {faces!r}")
    chosen: dict[str, Any] = {}
    if vertices is not None:
        encoding = Encoding.of(Poser(rig, sampler.columns), vertices, tolerance)
        chosen["vertices"] = encoding.as_json()
    elif tolerance is not None:
        raise ParameterError("a tolerance is for stored vertices: name their type, as 'int16'")
    if normals:
        chosen["normals"] = {}
    if landmarks is not None:
        chosen["landmarks"] = _landmarks(rig, landmarks)
    data = begin(order, rig, sampler, count, chosen, codec)
    data.objects.sweep(all_of_them=False)
    return data


def _landmarks(rig: Rig, given: Mapping[str, int]) -> dict[str, int]:
    count = len(rig.neutral.vertices)
    if not isinstance(given, Mapping) or not given:
        raise ParameterError(f"landmarks are vertices by name, found {given!r}")
    for name, vertex in given.items():
        if not is_whole(vertex) or not 0 <= vertex < count:
            raise ParameterError(
                f"the landmark {name!r} is the vertex {vertex!r}, expected 0 to {count - 1:,}"
            )
    return {str(name): int(vertex) for name, vertex in given.items()}


def work_off(data: DataSet, progress: Callable[[Progress], object] = lambda _: None) -> None:
    """Make all units that are not finished, on all cores of this process."""
    waiting = data.manifest.pending()
    if waiting:
        data.prepare()
    sizes = {unit: len(data.manifest.rows(unit)) for unit in waiting}
    state = Progress(data.faces, data.faces - sum(sizes.values()))
    progress(state)
    try:
        for made in made_units(data.order, waiting):
            state.add(made)
            progress(state)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"interrupted after {state.done:,} of {data.faces:,} faces; the same command goes on"
        ) from None
    data.objects.sweep(all_of_them=True)


def made_units(order: Order, units: list[int]) -> Iterator[Made]:
    """Make units in threads, a few more under way than there are cores; as they are finished."""
    threads = min(usable_cores(), len(units)) or 1
    pool = ThreadPoolExecutor(threads)
    try:
        left, going = iter(units), set[Future[Made]]()
        while True:
            for unit in left:
                going.add(pool.submit(make_unit, order, unit))
                if len(going) > threads:
                    break
            if not going:
                return
            done, going = wait(going, return_when=FIRST_COMPLETED)
            for future in done:
                yield future.result()
    finally:
        pool.shutdown(cancel_futures=True)
