"""Data sets as PyTorch reads them: whole batches, in order and shuffled, by workers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import elastomorph as em
from elastomorph.errors import ParameterError
from needs import extra

torch = extra("torch", "torch")

FACES = 1000


@pytest.fixture(scope="module")
def faces(rig: em.Rig, tmp_path_factory: pytest.TempPathFactory) -> em.FaceSet:
    folder = tmp_path_factory.mktemp("torch") / "faces.zarr"
    return em.make_faces(rig, folder, FACES, landmarks={"nose": 4, "chin": 9})


@pytest.fixture(scope="module")
def pictures(rig: em.Rig, tmp_path_factory: pytest.TempPathFactory) -> em.FaceSet:
    folder = tmp_path_factory.mktemp("pictured") / "faces.zarr"
    return em.make_faces(rig, folder, 48, render=128, vertices="int16")


def test_a_face_and_a_batch_are_dicts_of_float32(faces: em.FaceSet) -> None:
    data = faces.as_torch("vertices", "landmarks", "weights", "codes")
    assert len(data) == FACES
    batch = data[[7, 3]]
    assert (batch["vertices"].numpy() == faces[[7, 3]]).all()
    assert batch["weights"].dtype == batch["landmarks"].dtype == torch.float32
    assert batch["codes"].dtype == torch.int32
    assert torch.equal(data[3]["landmarks"], batch["landmarks"][1])
    assert set(faces.as_torch()[0]) == {"vertices", "weights"}
    with pytest.raises(ParameterError, match="no array 'colour'"):
        faces.as_torch("colour")


def test_shuffled_batches_hold_each_face_once_in_another_order_each_time(
    faces: em.FaceSet,
) -> None:
    loader = faces.as_torch("codes").batches(96, seed=5, faces=slice(11, 990))
    orders = []
    for _ in range(2):
        batches = [batch["codes"].numpy() for batch in loader]
        assert [len(batch) for batch in batches] == [96] * 10 + [19]
        assert len(batches) == len(loader)
        orders.append(np.concatenate(batches))
    wanted = faces.codes[11:990].astype(np.int32)
    for order in orders:
        assert (np.sort(order, axis=0) == np.sort(wanted, axis=0)).all()
        assert not (order == wanted).all()
    assert not (orders[0] == orders[1]).all()
    again = faces.as_torch("codes").batches(96, seed=5, faces=slice(11, 990))
    assert (next(iter(again))["codes"].numpy() == orders[0][:96]).all()


def test_batches_in_order_are_the_slices(faces: em.FaceSet) -> None:
    loader = faces.as_torch("vertices").batches(300, shuffle=False)
    assert (torch.cat([batch["vertices"] for batch in loader]).numpy() == faces[:]).all()


def test_shuffled_products_are_full(faces: em.FaceSet) -> None:
    """Of each 32 faces that are made together, each is another row of a product."""
    order = faces.as_torch("vertices").batches(256).sampler
    numbers = np.concatenate(list(order))
    assert (numbers[:992].reshape(-1, 32) % 32 == np.arange(32)).all()
    assert len(np.unique(numbers[:32] // 32)) > 16  # and from everywhere


def test_what_is_stored_in_small_chunks_is_read_by_chunks(pictures: em.FaceSet) -> None:
    data = pictures.as_torch("images/colour", "vertices")
    chunk = pictures.data.array("images/colour").chunks[0]
    assert chunk == 16
    numbers = np.concatenate(list(data.batches(32).sampler))
    assert sorted(numbers) == [*range(48)]
    batch = data[numbers[:8]]
    assert batch["images/colour"].dtype == torch.uint8
    assert (batch["vertices"].numpy() == pictures[numbers[:8]]).all()
    assert data.block_and_grain()[1] == chunk
    assert (np.diff(numbers.reshape(-1, chunk)) == 1).all()


@pytest.mark.parametrize("start", ["fork", "spawn"])
def test_workers_give_the_same(faces: em.FaceSet, start: str) -> None:
    """After this process has read: its threads are not there in a fork."""
    faces.codes[:]
    data = faces.as_torch("vertices", "weights")
    alone = list(data.batches(256, seed=2))
    shared = data.batches(256, seed=2, workers=2, multiprocessing_context=start)
    for mine, theirs in zip(alone, shared, strict=True):
        assert all(torch.equal(mine[name], theirs[name]) for name in mine)


def test_a_loader_of_the_users_own_reads_whole_batches(
    faces: em.FaceSet, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = faces.as_torch("weights")
    read, one = [], type(data).__getitem__

    def get(own: object, rows: list[int]) -> dict[str, torch.Tensor]:
        read.append(len(rows))
        return one(own, rows)

    monkeypatch.setattr(type(data), "__getitem__", get)
    batches = list(torch.utils.data.DataLoader(data, batch_size=250))
    assert read == [250] * 4
    together = torch.cat([batch["weights"] for batch in batches]).numpy()
    assert (together == faces.weights[:].astype(np.float32)).all()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"size": 0}, "a batch has one face or more, found 0"),
        ({"faces": slice(0, 9, 2)}, "a slice without a step"),
        ({"faces": 7}, "a slice without a step"),
    ],
)
def test_batches_that_cannot_be_meant(faces: em.FaceSet, options: dict, said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        faces.as_torch().batches(**options)


def test_what_the_page_shows(rig: em.Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = (Path(__file__).parents[2] / "docs" / "farm.md").read_text(encoding="utf-8")
    program = page.split("<!-- needs PyTorch -->\n```python\n")[1].split("```")[0]
    em.make_faces(rig, tmp_path / "faces.zarr", 5000)
    monkeypatch.chdir(tmp_path)
    shown: dict[str, Any] = {}
    exec(program, shown)
    assert shown["vertices"].shape == (256, 90, 3)
    assert shown["test"]["weights"].shape == (100, 8)
