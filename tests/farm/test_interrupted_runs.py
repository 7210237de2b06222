"""Runs that end early, disks that are full, files that are damaged: the same call goes on."""

from __future__ import annotations

import dataclasses
import errno
import json
import os
import shutil
import threading
import tracemalloc
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import dask.array
import numpy as np
import pytest
import zarr

import elastomorph as em
from elastomorph.errors import FileError, FormatError
from elastomorph.farm.making import executors
from elastomorph.farm.making import run as beginning
from elastomorph.farm.making.executors import unit_shards
from elastomorph.farm.making.verify import verify_faces
from elastomorph.farm.storage.layout import DataSet, Plan
from elastomorph.farm.storage.stores import Objects
from elastomorph.io.performance import write_performance_csv
from elastomorph.rig.performance import Performance

UNIT = 32
FACES = 10 * UNIT + 7


@pytest.fixture(autouse=True)
def _small_units(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(beginning, "_MOST_UNIT", UNIT)


@pytest.fixture
def make(rig: em.Rig, tmp_path: Path) -> Callable[..., em.FaceSet]:
    """Makes or goes on with a data set in units of 32 faces."""

    def made(name: str = "faces.zarr", faces: int = FACES, **options: Any) -> em.FaceSet:
        return em.make_faces(rig, tmp_path / name, faces, vertices="int16", **options)

    return made


def stop_after(count: int, error: BaseException) -> Callable[[object], None]:
    """Raises in the middle of a run."""
    told = []

    def progress(state: object) -> None:
        told.append(state)
        if len(told) > count:
            raise error

    return progress


def content(folder: Path) -> dict[str, bytes]:
    """Every shard by its name."""
    return {str(f.relative_to(folder)): f.read_bytes() for f in folder.rglob("c.*")}


def test_an_interrupted_run_goes_on_and_ends_with_the_same_bytes(
    make: Callable[..., em.FaceSet], tmp_path: Path
) -> None:
    make("whole.zarr")
    with pytest.raises(KeyboardInterrupt, match="the same command goes on"):
        make(progress=stop_after(3, KeyboardInterrupt()))
    manifest = em.open_faces(tmp_path / "faces.zarr").data.manifest
    assert 0 < len(manifest.all_finished()) < 11
    there = content(tmp_path / "faces.zarr")
    times = {name: (tmp_path / "faces.zarr" / name).stat().st_mtime_ns for name in there}
    make()
    assert content(tmp_path / "faces.zarr") == content(tmp_path / "whole.zarr")
    for name, time in times.items():  # what was finished was not made again
        unit = name.split(".")[1]
        if f"manifest/c.{unit}.0" in there:
            assert (tmp_path / "faces.zarr" / name).stat().st_mtime_ns == time


def test_what_is_swept_away_by_another_run_is_written_again(
    make: Callable[..., em.FaceSet], monkeypatch: pytest.MonkeyPatch
) -> None:
    objects, flush = Objects(make(faces=UNIT).data.order), os.fsync

    def sweep_once(handle: int) -> None:
        monkeypatch.setattr(os, "fsync", flush)
        assert objects.sweep(all_of_them=True) == 1

    monkeypatch.setattr(os, "fsync", sweep_once)
    objects.put({"weights/c.9.0": b"whole"})
    assert objects.get("weights/c.9.0") == b"whole"


def test_shards_that_are_lost_or_cut_are_not_read(
    make: Callable[..., em.FaceSet], tmp_path: Path
) -> None:
    before = make()[:]
    (tmp_path / "faces.zarr/vertices/c.3.0.0").unlink()
    os.truncate(tmp_path / "faces.zarr/weights/c.4.0", 0)
    faces = em.open_faces(tmp_path / "faces.zarr")
    assert (faces[: 3 * UNIT] == before[: 3 * UNIT]).all()
    with pytest.raises(FormatError, match=r"vertices/c.3.0.0 is not as large as it was written"):
        faces[3 * UNIT]
    with pytest.raises(FormatError, match=r"weights/c.4.0 is not as large as it was written"):
        faces.codes[5 * UNIT - 1]
    assert (make()[:] == before).all()


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("zarr.json", "zarr.json cannot be read"),
        ("weights/zarr.json", "weights cannot be read"),
        ("vertices/zarr.json", "vertices cannot be read"),
        ("rig/c.0", "the rig cannot be read"),
    ],
)
def test_damaged_metadata_is_one_sentence(
    make: Callable[..., em.FaceSet], tmp_path: Path, name: str, said: str
) -> None:
    make(faces=UNIT)
    os.truncate(tmp_path / "faces.zarr" / name, 20)
    with pytest.raises(FormatError, match=f"{said}.*take it from a copy, or begin another"):
        verify_faces(tmp_path / "faces.zarr")


def test_faces_that_are_not_made_yet_are_not_read(
    make: Callable[..., em.FaceSet], tmp_path: Path
) -> None:
    with pytest.raises(KeyboardInterrupt):
        make(progress=stop_after(0, KeyboardInterrupt()))
    faces = em.open_faces(tmp_path / "faces.zarr")
    with pytest.raises(FormatError, match=f"faces {FACES - 7} to {FACES - 1} are not made yet"):
        faces[-1]


def test_of_units_that_are_not_made_there_is_no_list(
    make: Callable[..., em.FaceSet], tmp_path: Path
) -> None:
    """A list of 67 million takes seconds, and gigabytes, before the first face."""
    tracemalloc.start()
    try:
        with pytest.raises(KeyboardInterrupt, match="of 2,147,483,648 faces; the same command"):
            make(faces=UNIT * 2**26, progress=stop_after(1, KeyboardInterrupt()))
        assert tracemalloc.get_traced_memory()[1] < 2**27
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("damage", ["cut", "gone", "no entry", "half an entry"])
def test_a_damaged_unit_is_made_again(
    make: Callable[..., em.FaceSet], tmp_path: Path, damage: str
) -> None:
    make()
    folder = tmp_path / "faces.zarr"
    before = content(folder)
    shard, entry = folder / "vertices/c.4.0.0", folder / "manifest/c.4.0"
    if damage == "cut":
        shard.write_bytes(shard.read_bytes()[:-5])
    elif damage == "half an entry":
        entry.write_bytes(entry.read_bytes()[:-5])
    else:
        (shard if damage == "gone" else entry).unlink()
    assert em.open_faces(folder).data.manifest.all_finished() == {*range(11)} - {4}
    make()
    assert content(folder) == before


def test_a_full_disk_is_one_sentence_and_the_same_call_goes_on(
    make: Callable[..., em.FaceSet], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    replace = Path.replace

    def full(self: Path, target: Path) -> Path:
        if target.name == "c.5.0.0":
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return replace(self, target)

    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", full)
        with pytest.raises(FileError, match=r"No space left on device.*same command goes on$"):
            make()
    make()
    manifest = em.open_faces(tmp_path / "faces.zarr").data.manifest
    assert manifest.all_finished() == set(range(manifest.units))


def test_what_killed_writers_left_is_removed(
    make: Callable[..., em.FaceSet], tmp_path: Path
) -> None:
    make()
    left = tmp_path / "faces.zarr/vertices/c.3.0.0123.partial"
    left.write_bytes(b"half")
    make()
    assert not left.exists()


def test_a_beginning_that_was_cut_short_is_begun_again(
    make: Callable[..., em.FaceSet], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def killed(*_: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(beginning, "_make_array", killed)
        with pytest.raises(KeyboardInterrupt):
            make()
    with pytest.raises(FormatError, match="not begun to the end"):
        em.open_faces(tmp_path / "faces.zarr")
    assert len(make()) == FACES


def test_a_data_set_grows_but_does_not_shrink(
    make: Callable[..., em.FaceSet], tmp_path: Path
) -> None:
    make("whole.zarr", FACES)
    make(faces=2 * UNIT + 5)
    grown = make()
    assert len(grown) == FACES
    assert content(tmp_path / "faces.zarr") == content(tmp_path / "whole.zarr")
    with pytest.raises(FormatError, match="has 327 faces, and 9 were asked for"):
        make(faces=9)


def test_a_run_whose_data_set_is_replaced_writes_nothing_into_the_other(
    make: Callable[..., em.FaceSet], rig: em.Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of another seed, and of recorded weights that have changed under their name."""
    take = {"mixture": [{"kind": "take", "files": [str(tmp_path / "take.csv")]}]}
    monkeypatch.setattr(executors, "usable_cores", lambda: 1)
    place = tmp_path / "faces.zarr"
    for recipe, seed in ((None, 1), (take, 0)):
        record(tmp_path / "take.csv", rig, 1.0)

        def replaced(
            data: DataSet, rows: range, recipe: Any = recipe, seed: int = seed
        ) -> dict[str, bytes]:
            made = unit_shards(data, rows)
            if rows.start == UNIT:  # The second unit, which is written now
                monkeypatch.setattr(executors, "unit_shards", unit_shards)
                shutil.rmtree(place)
                record(tmp_path / "take.csv", rig, 0.5)
                make(recipe=recipe, seed=seed)
            return made

        monkeypatch.setattr(executors, "unit_shards", replaced)
        with pytest.raises(FormatError, match="not the data set that it was"):
            make(recipe=recipe, seed=0)
        make("alone.zarr", recipe=recipe, seed=seed)
        assert content(place) == content(tmp_path / "alone.zarr")
        shutil.rmtree(place)
        shutil.rmtree(tmp_path / "alone.zarr")


def record(file: Path, rig: em.Rig, strongest: float) -> None:
    """Record weights that rise from 0."""
    weights = np.linspace(0, strongest, 40)[:, None] * np.ones(len(rig.names))
    write_performance_csv(file, Performance(rig.names, np.arange(40) / 30, weights, 30))


def test_what_is_no_data_set_of_ours_is_refused(rig: em.Rig, tmp_path: Path) -> None:
    file, folder, foreign = (tmp_path / name for name in ("file", "folder", "foreign.zarr"))
    file.write_text("x")
    folder.mkdir()
    (folder / "photo.jpg").write_text("x")
    zarr.create_group(foreign)
    for place, said in [
        (file, "this is a file"),
        (folder, "holds something else"),
        (foreign, "no data set of ours"),
    ]:
        with pytest.raises(FormatError, match=said):
            em.make_faces(rig, place, 9)
    assert sorted(own.name for own in folder.iterdir()) == ["photo.jpg"]
    with pytest.raises(FormatError, match="there is no data set"):
        em.open_faces(tmp_path / "nowhere.zarr")
    assert not (tmp_path / "nowhere.zarr").exists()


def test_verification_finds_what_was_changed(
    make: Callable[..., em.FaceSet], tmp_path: Path
) -> None:
    faces = make()
    place = tmp_path / "faces.zarr"
    found = verify_faces(place, 99)
    assert (found.units, found.faces, found.same) == (11, FACES, True)
    assert verify_faces(place, 2, seed=1).units == 2
    array = DataSet(faces.data.order).array("vertices")
    array[70, 5, 1] = 1 + array[70, 5, 1]
    with pytest.raises(FormatError, match=r"vertices/c\.2\.0\.0: not what was written"):
        verify_faces(place, 1)


@pytest.mark.parametrize("codec", ["lz4", "none"])
def test_no_reader_takes_a_flipped_bit_for_a_face(rig: em.Rig, tmp_path: Path, codec: str) -> None:
    """Plain Zarr, Dask, ours; what is made again of what is removed is as it was."""
    place = tmp_path / "faces.zarr"
    options: dict[str, Any] = {"vertices": "int16", "normals": True, "landmarks": {"nose": 4}}
    options |= {"render": 16, "codec": codec, "unit": UNIT}
    em.make_faces(rig, place, 2 * UNIT, **options)
    random = np.random.default_rng(0)
    for name in ("neutral", "weights", "vertices", "normals", "images/colour", "images/depth"):
        file = min((place / name).glob("c.*"))
        before = file.read_bytes()
        array = zarr.open_array(place / name, mode="r")
        lazy = dask.array.from_zarr(str(place), component=name)[:1]
        ours = em.open_faces(place)
        assert (lazy.compute(scheduler="sync") == array[:1]).all()
        for _ in range(30):
            flipped = bytearray(before)
            flipped[random.integers(len(before))] ^= 1 << random.integers(8)
            file.write_bytes(flipped)
            with pytest.raises(ValueError, match="checksum"):
                array[:UNIT]
            with pytest.raises(ValueError, match="checksum"):
                lazy.compute(scheduler="sync")
            if name != "neutral":
                with pytest.raises(FormatError, match=f"{name} cannot be read"):
                    ours.labels[name][:UNIT]
        with pytest.raises(FormatError, match=f"{name}.*(not what was written|cannot be read)"):
            verify_faces(place, 1, seed=1)
        if name != "neutral":
            file.unlink()
            em.make_faces(rig, place, 2 * UNIT, **options)
        assert name == "neutral" or file.read_bytes() == before
        file.write_bytes(before)
    for entry in (place / "manifest").glob("c.0.*"):
        before = entry.read_bytes()
        for place_of_bit in random.permutation(8 * len(before))[:30]:
            flipped = bytearray(before)
            flipped[place_of_bit // 8] ^= 1 << (place_of_bit % 8)
            entry.write_bytes(flipped)
            with pytest.raises(FormatError, match="not made yet"):
                ours.codes[0]


def test_data_sets_without_checksums_are_read_and_gone_on_with(
    make: Callable[..., em.FaceSet], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As format 1 was: no codec of checksums, none in the manifest, no sign of when it was made."""
    codecs, planned = beginning.zarr_codecs, beginning._planned

    def of_format_1(*arguments: Any) -> tuple[Plan, Any]:
        plan, labels = planned(*arguments)
        return dataclasses.replace(plan, format=1), labels

    with monkeypatch.context() as patch:
        patch.setattr(beginning, "zarr_codecs", lambda name: codecs(name)[:-1])
        patch.setattr(beginning, "_planned", of_format_1)
        make(faces=3 * UNIT + 5, codec="none")
    place = tmp_path / "faces.zarr"
    root = json.loads((place / "zarr.json").read_text())
    del root["attributes"]["elastomorph"]["created"]
    (place / "zarr.json").write_text(json.dumps(root))
    assert "crc32c" not in str(json.loads((place / "neutral/zarr.json").read_text())["codecs"])
    assert (place / "manifest/c.0.0").stat().st_size == 8 * 5
    grown, whole = make(codec="none"), make("whole.zarr")
    assert grown.data.plan.format == 1
    assert (grown[:] == whole[:]).all()
    assert (grown.codes[:] == whole.codes[:]).all()
    assert verify_faces(place, 99).same
    file = place / "vertices/c.2.0.0"
    file.write_bytes(file.read_bytes()[:-9] + b"x" + file.read_bytes()[-8:])
    with pytest.raises(FormatError, match=r"vertices/c\.2\.0\.0: not what was written"):
        verify_faces(place, 1)


@pytest.mark.parametrize("stored", ["normals", "float16", "float32", "int16"])
def test_what_another_processor_makes_is_as_stored_but_for_rounding(
    rig: em.Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stored: str
) -> None:
    """Sums in another order; a number that is off by more than rounding is found all the same."""
    place = tmp_path / "faces.zarr"
    chosen: dict[str, Any] = {"normals": True} if stored == "normals" else {"vertices": stored}
    faces = em.make_faces(small_and_far(rig), place, 4 * UNIT, seed=2, **chosen)
    matmul = np.matmul

    def in_reverse(a: Any, b: Any, out: Any = None) -> Any:
        return matmul(a[:, ::-1], b[::-1], out=out)

    monkeypatch.setattr(np, "matmul", in_reverse)
    assert not verify_faces(place, 99).same
    data = DataSet(faces.data.order)
    name = data.plan.arrays[1]
    array = data.array(name)
    row = array[70]
    row[30] = {"int16": row[30] + 2, "normals": -row[30]}.get(stored, 1.01 * row[30])
    array[70] = row
    shards = {n: data.objects.get(data.manifest.shard(n, 2)) or b"" for n in data.plan.arrays}
    data.manifest.finish(2, shards)
    with pytest.raises(FormatError, match=f"faces 64 to 95: of {name} the recipe makes other"):
        verify_faces(place, 99)


def small_and_far(rig: em.Rig) -> em.Rig:
    """Triangles a few thousandths wide that move together by about 1."""
    random = np.random.default_rng(1)
    small = em.Mesh(rig.neutral.vertices * 0.02, rig.neutral.faces)
    targets = {
        name: small.with_vertices(
            small.vertices * random.uniform(0.9, 1.1, 3) + random.normal(size=3)
        )
        for name in rig.names
    }
    return em.Rig(small, {n: em.interpolate(small, own, "ease") for n, own in targets.items()})


def test_faces_in_memory_and_at_addresses(rig: em.Rig, tmp_path: Path) -> None:
    """The same faces in a store of fsspec as in a folder."""
    here = em.make_faces(rig, f"file://{tmp_path}/faces.zarr", FACES)
    url = "memory://faces.zarr"
    there = em.make_faces(rig, url, FACES)
    assert (there[:] == here[:]).all()
    assert len(there.data.manifest.all_finished()) == there.data.manifest.units
    assert verify_faces(url).same
    assert len(em.open_faces(url)) == FACES
    with pytest.raises(FileError, match="cannot be reached"):
        em.open_faces("nowhere://faces.zarr")
    assert np.isfinite(here[:]).all()


def test_two_that_begin_at_once_are_one_or_refused(rig: em.Rig, tmp_path: Path) -> None:
    """Whichever is first, the other goes on with the same or is told; never a mixture."""
    place, gate = tmp_path / "faces.zarr", threading.Barrier(4)

    def make(seed: int) -> str:
        gate.wait()
        try:
            em.make_faces(rig, place, 200, seed=seed, unit=64)
        except FormatError as error:
            return str(error)
        return ""

    with ThreadPoolExecutor(4) as pool:
        told = list(pool.map(make, [1, 2, 1, 2]))
    assert sorted(map(bool, told)) == [False, False, True, True]
    assert told[0] == told[2]
    assert "begun with another recipe or seed" in "".join(told)
    assert verify_faces(place, 9).same
