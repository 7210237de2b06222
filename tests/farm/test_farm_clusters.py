"""Data sets made by workers of Dask, real processes, compared with those of one process."""

from __future__ import annotations

import os
import pickle
import shutil
import signal
import socket
import subprocess
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import elastomorph as em
from children import started
from elastomorph.farm.making import executors
from elastomorph.farm.making import run as beginning
from needs import extra

extra("distributed", "farm")

from distributed import Client  # noqa: E402

from dask_processes import kill_all, separate, workers_below  # noqa: E402
from farm_kills import contents  # noqa: E402

pytestmark = pytest.mark.cluster

FACES = 1200


@pytest.fixture(autouse=True)
def _small_units(monkeypatch: pytest.MonkeyPatch) -> None:
    """About forty units; workers know their size from the data set."""
    monkeypatch.setattr(beginning, "_MOST_UNIT", 32)


@pytest.fixture
def alone(rig: em.Rig, tmp_path: Path) -> dict[str, bytes]:
    """The files that one process makes."""
    em.make_faces(rig, tmp_path / "alone.zarr", FACES, vertices="int16")
    found = contents(tmp_path / "alone.zarr")
    assert len(found) >= 3 * 38  # units, of weights, vertices and the manifest
    return found


def test_processes_of_which_one_is_killed_make_what_one_process_makes(
    rig: em.Rig, alone: dict[str, bytes], tmp_path: Path
) -> None:
    killed: list[int] = []

    def kill(state: object) -> None:
        if not killed and (workers := workers_below(os.getpid())):
            workers[0].kill()
            killed.append(workers[0].pid)

    folder = tmp_path / "faces.zarr"
    em.make_faces(rig, folder, FACES, vertices="int16", scheduler="local", progress=kill)
    assert killed
    assert contents(folder) == alone
    assert workers_below(os.getpid()) == []


def test_a_scheduler_elsewhere_whose_end_is_said_and_gone_on_from(
    rig: em.Rig, alone: dict[str, bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with separate() as machines:
        with monkeypatch.context() as patch:
            patch.setattr(executors, "version", lambda name: "0.0.1")
            with pytest.raises(
                em.ClusterError, match=r"has elastomorph .* this machine has 0\.0\.1"
            ):
                em.make_faces(rig, tmp_path / "none", 9, scheduler=machines.address)
        assert not (tmp_path / "none").exists()
        with pytest.raises(em.ClusterError, match="does not find the data set memory://"):
            em.make_faces(rig, "memory://here-alone", 9, scheduler=machines.address)

        monkeypatch.chdir(tmp_path)
        with Client(machines.address, set_as_default=False) as client:
            em.make_faces(rig, "faces.zarr", FACES, vertices="int16", scheduler=client)
            assert client.status == "running"  # It is the caller's
        assert contents(tmp_path / "faces.zarr") == alone

        def kill(state: object) -> None:
            kill_all(machines.scheduler)

        cut = tmp_path / "cut.zarr"
        with pytest.raises(em.ClusterError, match=r"the scheduler is gone.* the same command"):
            em.make_faces(
                rig, cut, FACES, vertices="int16", scheduler=machines.address, progress=kill
            )
    em.make_faces(rig, cut, FACES, vertices="int16")
    assert contents(cut) == alone


def test_standing_workers_make_what_is_there_now(rig: em.Rig, tmp_path: Path) -> None:
    """A place at which one data set follows another, while workers and reader processes stay."""
    place = tmp_path / "faces.zarr"
    wanted: list[tuple[int, dict[str, Any]]] = [
        (200, {"seed": 1}),
        (200, {"seed": 2}),
        (200, {"seed": 2, "vertices": "int16"}),
        (500, {"seed": 2, "vertices": "int16"}),  # The one before, grown
    ]
    with separate() as machines:
        for number, (faces, options) in enumerate(wanted):
            if number < 3:
                shutil.rmtree(place, ignore_errors=True)
            found = em.make_faces(rig, place, faces, scheduler=machines.address, **options)
            alone = tmp_path / f"alone{number}.zarr"
            expected = em.make_faces(rig, alone, faces, **options)
            assert contents(place) == contents(alone)
            with Client(machines.address, set_as_default=False) as client:
                lazy = client.compute(found.as_dask("vertices")).result()
            assert np.array_equal(lazy, expected[:])


def test_what_is_no_scheduler_is_refused(
    rig: em.Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(executors, "_ANSWER", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"127.0.0.1:{silent.getsockname()[1]}"
        for scheduler, message in {
            "slurm": "a scheduler is none .* local .* or the address of .* found 'slurm'",
            "host:door": "found 'host:door'",
            address: f"no Dask scheduler answers at {address} within",
            f"tcp://{address}": "no Dask scheduler answers at tcp",
            "cluster.toml": "that you started, by dask-jobqueue or Kubernetes .* 'cluster.toml'",
        }.items():
            with pytest.raises(em.ElastomorphError, match=message) as caught:
                em.make_faces(rig, tmp_path / "faces.zarr", 9, scheduler=scheduler)
            assert "\n" not in str(caught.value)
    with pytest.raises(em.ParameterError, match=r"a scheduler is none .* found 8786"):
        em.make_faces(rig, tmp_path / "faces.zarr", 9, scheduler=8786)  # type: ignore[arg-type]
    assert not (tmp_path / "faces.zarr").exists()


def test_ctrl_c_is_one_sentence_and_leaves_no_process(rig: em.Rig, tmp_path: Path) -> None:
    rig.save(tmp_path / "rig.npz")
    words = ("-m", "elastomorph", "farm", "rig.npz", "--faces", "100000000", "-o", "faces.zarr")
    with started(
        *words, "--scheduler", "local", cwd=tmp_path, stderr=subprocess.PIPE, start_new_session=True
    ) as process:
        while not list(tmp_path.glob("faces.zarr/manifest/c.*")):
            assert process.poll() is None
            time.sleep(0.05)
        workers = workers_below(process.pid)
        assert workers
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does
        said = process.communicate(timeout=120)[1]
    assert process.returncode == 130
    assert said.startswith("interrupted after ")
    assert said.strip().endswith("the same command goes on")
    assert said.count("\n") == 1
    assert not any(worker.is_running() for worker in workers)


def test_errors_come_whole_from_other_processes() -> None:
    for error in (
        em.FormatError("faces.zarr", "this is a file", line=3),
        em.ResonanceError("rings", mode=1, stiffness=2.0, safe_damping=3.0),
        em.MissingExtraError("zarr", "farm"),
    ):
        found = pickle.loads(pickle.dumps(error))
        assert type(found) is type(error)
        assert (str(found), vars(found)) == (str(error), vars(error))
