"""Data sets of faces: begun or gone on with, and made to the end."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from elastomorph.errors import ParameterError
from elastomorph.farm.making.executors import client_of, make_units
from elastomorph.farm.making.progress import Progress
from elastomorph.farm.reading.faces import FaceSet, open_faces
from elastomorph.farm.sampling.recipe import Recipe
from elastomorph.farm.sampling.sampler import FaceSampler
from elastomorph.farm.storage.beginning import begin
from elastomorph.farm.storage.layout import DataSet
from elastomorph.farm.storage.stores import Order, naming_store, order_of
from elastomorph.farm.storage.wanted import Wanted, pictured
from elastomorph.numbers import is_whole
from elastomorph.rig.rig import Rig

if TYPE_CHECKING:
    from distributed import Client


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
    landmarks: Mapping[str, int] | str | None = None,
    render: int | None = None,
    codec: str = "lz4",
    unit: int | None = None,
    storage_options: Mapping[str, Any] | None = None,
    scheduler: str | Client = "none",
    progress: Callable[[Progress], object] = lambda _: None,
) -> FaceSet:
    """Make a data set of faces, or go on where it stood.

    It holds recipe, rig and weights; positions are made when they are read, or stored too. Units
    are made on all cores and written whole: whatever ends the process, the same call goes on.

    Args:
        rig: The rig.
        output: A folder, made where it is missing, or an address that fsspec knows.
        faces: How many; more than there are make a data set grow. None: all of a finite recipe.
        recipe: As for `FaceSampler`.
        seed: As for `FaceSampler`.
        vertices: Store positions as ``float32``, ``float16`` or ``int16``.
        tolerance: Largest error of stored positions in units of D. By default that of the type;
            for int16 1e-4, or the least that the rig allows.
        normals: Store (V, 3) float32 normals.
        landmarks: Store (L, 3) float32 positions of vertices, by name; ``clicks``, ``68`` or
            ``mediapipe`` of a rig whose points are known. Default: the recipe's.
        render: Store pictures with labels, so many pixels a side. Default: the recipe's.
        codec: ``lz4``, ``zstd``, which is slower and a quarter smaller, or ``none``.
        unit: Faces made and written together, a power of two. Default: as many as make 32
            MiB of the largest array, fewer with pictures.
        storage_options: What fsspec needs to reach the address.
        scheduler: ``none``, the threads of this process; ``local``, processes of this machine, in
            a script below ``if __name__ == "__main__"``; the address of a Dask scheduler, or a
            ``distributed.Client``.
        progress: Told how far it is, an object that prints as a sentence, after each unit.

    Returns:
        The data set, open for reading.

    Raises:
        FileError: The output cannot be written; what is finished stays.
        FormatError: The output is something else, or a data set begun with other arguments.
        ParameterError: An argument that cannot be meant.
        ClusterError: The scheduler does not answer or is gone, or its workers do not suit.
        MissingExtraError: Zarr or Dask is not installed.
    """
    order = order_of(output, storage_options)
    sampler = FaceSampler(rig, pictured(recipe, render), seed=seed)
    wanted = Wanted(vertices, tolerance, normals, landmarks, codec, unit)
    with naming_store(order), client_of(scheduler) as client:
        work_off(begun(order, rig, sampler, faces, wanted), client, progress)
    return open_faces(order.url, storage_options=storage_options)


def begun(
    order: Order, rig: Rig, sampler: FaceSampler, faces: int | None, wanted: Wanted
) -> DataSet:
    """The data set that is asked for, laid out with what was finished before."""
    count = sampler.count if faces is None else faces
    if count is None:
        raise ParameterError("say how many faces are to be made; this recipe has any number")
    if not is_whole(count) or count < 1:
        raise ParameterError(f"a data set has one face or more, found {faces!r}")
    if sampler.count is not None and count > sampler.count:
        raise ParameterError(
            f"the recipe has {sampler.count:,} faces, and {count:,} were asked for: leave the "
            "number out for all of them"
        )
    data = begin(order, rig, sampler, count, wanted)
    data.objects.sweep(all_of_them=False)
    return data


def work_off(
    data: DataSet,
    client: Client | None = None,
    progress: Callable[[Progress], object] = lambda _: None,
) -> None:
    """Make all units that are not finished."""
    waiting = data.manifest.pending()
    sizes = {unit: len(data.manifest.rows(unit)) for unit in waiting}
    state = Progress(data.faces, data.faces - sum(sizes.values()))
    progress(state)
    try:
        for made in make_units(data, waiting, client):
            state.add(made)
            progress(state)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"interrupted after {state.done:,} of {data.faces:,} faces; the same command goes on"
        ) from None
    data.objects.sweep(all_of_them=True)
