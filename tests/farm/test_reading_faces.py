"""Data sets read as Dask arrays and as pictures, in any process, and again from what is kept."""

from __future__ import annotations

import pickle
import shutil
from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.errors import FormatError, ParameterError
from elastomorph.farm.reading import faces as rows_module

FACES = 2100  # More than one chunk of 2,048


@pytest.fixture(scope="module")
def faces(rig: em.Rig, tmp_path_factory: pytest.TempPathFactory) -> em.FaceSet:
    """Recipe only."""
    return em.make_faces(rig, tmp_path_factory.mktemp("reading") / "faces é.zarr", FACES, unit=1024)


@pytest.fixture(scope="module")
def pictures(rig: em.Rig, tmp_path_factory: pytest.TempPathFactory) -> em.FaceSet:
    folder = tmp_path_factory.mktemp("pictured") / "faces.zarr"
    return em.make_faces(rig, folder, 9, render=16, landmarks={"nose": 44})


@pytest.mark.parametrize("scheduler", ["threads", "processes"])
def test_dask_arrays_are_what_slices_are(faces: em.FaceSet, scheduler: str) -> None:
    lazy = faces.as_dask()
    assert (lazy.shape, lazy.dtype) == (faces.shape, faces.dtype)
    assert lazy.chunks[0] == (1024, 1024, 52)
    assert len(pickle.dumps(lazy)) < 10_000
    some = lazy[1000:2099:3, 5:, 1].compute(scheduler=scheduler)
    assert (some == faces[1000:2099:3, 5:, 1]).all()


def test_every_array_is_had_by_its_name(faces: em.FaceSet) -> None:
    mean = faces.as_dask("weights").mean(axis=0).compute(scheduler="threads")
    assert np.allclose(mean, faces.weights[:].mean(axis=0), rtol=1e-12)
    assert (faces.array("codes")[7] == faces.codes[7]).all()
    again = em.open_faces(faces.data.order.url)
    assert faces.as_dask("values").name == again.as_dask("values").name
    with pytest.raises(ParameterError, match="no array 'colour'; there are vertices, weights, "):
        faces.as_dask("colour")


def test_chunks_that_are_kept_change_nothing(
    faces: em.FaceSet, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever is asked for, and with room for one chunk only."""
    whole = faces.data.sampler.codes(0, FACES)
    random = np.random.default_rng(1)
    for most in (rows_module._KEPT_BYTES, 1):
        monkeypatch.setattr(rows_module, "_KEPT_BYTES", most)
        own = em.open_faces(faces.data.order.url)
        for rows in (
            *(slice(1020, 1030), slice(0, 0), slice(5, 2), slice(0, FACES), slice(-3, None)),
            *(slice(2099, 0, -13), random.integers(-FACES, FACES, 77), [], whole[:, 0] > 3000),
        ):
            assert (own.codes[rows] == whole[rows]).all()
    own.codes[3:9][:] = 0  # What was handed out is the reader's own
    assert (own.codes[3:9] == whole[3:9]).all()


def test_a_data_set_goes_to_another_process_as_its_place(
    rig: em.Rig, faces: em.FaceSet, tmp_path: Path
) -> None:
    assert len(pickle.dumps(faces)) < 5000
    other = pickle.loads(pickle.dumps(faces))
    assert (other[2050:2060] == faces[2050:2060]).all()
    assert pickle.loads(pickle.dumps(faces)) is other
    own = em.make_faces(rig, tmp_path / "faces.zarr", 5)
    kept = pickle.dumps(own)
    shutil.rmtree(tmp_path / "faces.zarr")
    em.make_faces(rig, tmp_path / "faces.zarr", 5, seed=1)
    with pytest.raises(FormatError, match="not the data set that it was"):
        pickle.loads(kept)


def test_what_is_open_is_not_read_from_another_that_takes_its_place(
    rig: em.Rig, tmp_path: Path
) -> None:
    """Not even from the same made anew: it may not be finished."""
    place, recipe = tmp_path / "faces.zarr", {"mixture": [{"kind": "sparse", "active": 2}]}
    for seed in (1, 0):
        own = em.make_faces(rig, place, 64, recipe=recipe, unit=32, codec="none")
        before = own.codes[:4]
        kept = pickle.dumps(own)
        shutil.rmtree(place)
        em.make_faces(rig, place, 64, recipe=recipe, seed=seed, unit=32, codec="none")
        assert (own.codes[:4] == before).all()  # Kept since it was read
        with pytest.raises(FormatError, match="not the data set that it was"):
            own.codes[:]
        with pytest.raises(FormatError, match="not the data set that it was"):
            own.codes[40]
        with pytest.raises(FormatError, match="not the data set that it was"):
            pickle.loads(kept)
        shutil.rmtree(place)
        with pytest.raises(FormatError):
            own.codes[40]


def test_a_data_set_that_grows_is_read_as_it_was(rig: em.Rig, tmp_path: Path) -> None:
    """Its last unit was not a whole one; the rows that were read keep their values."""
    first = em.make_faces(rig, tmp_path / "faces.zarr", 30)
    before = first[:]
    grown = em.make_faces(rig, tmp_path / "faces.zarr", 60)
    assert (first[:] == before).all()
    assert (grown[:30] == before).all()
    assert grown.as_dask().name != first.as_dask().name
    assert grown.as_dask().sum().compute() == pytest.approx(grown[:].sum(dtype=float), rel=1e-5)


def test_pictures_come_with_their_labels(pictures: em.FaceSet) -> None:
    images = pictures.as_images()
    assert len(images) == 9
    some = images[2:5]
    assert some["colour"].shape == (3, 16, 16, 3)
    assert set(some) == {"weights"} | {
        name.removeprefix("images/") for name in pictures.labels if name.startswith("images/")
    }
    for number, image in enumerate(images):
        for name, values in image.items():
            assert (values == images.arrays[name][number]).all()
    assert (some["weights"] == pictures.weights[2:5]).all()
    assert images.arrays["landmarks"].attributes["names"] == ["nose"]


def test_without_pictures_it_says_how_they_are_had(faces: em.FaceSet) -> None:
    with pytest.raises(ParameterError, match="holds no pictures; data sets made with  --render"):
        faces.as_images()


def test_a_file_is_no_data_set(tmp_path: Path) -> None:
    place = tmp_path / "faces.zarr"
    place.write_text("")
    with pytest.raises(FormatError, match="there is no data set"):
        em.open_faces(place)


def test_a_number_out_of_range_is_told(faces: em.FaceSet) -> None:
    """Plain Python says IndexError too, which ends loops over a sequence."""
    for number in (FACES, -FACES - 1):
        with pytest.raises(IndexError, match=f"there are 2,100 faces, found {number}"):
            faces[number]
