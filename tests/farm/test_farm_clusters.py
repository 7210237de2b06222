"""Data sets made by workers of Dask, real processes, compared with those of one process."""

from __future__ import annotations

import gc
import os
import pickle
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import elastomorph as em
from children import started
from elastomorph.farm.making import cluster, schedulers
from elastomorph.farm.making.queues import read_queue
from elastomorph.farm.storage import beginning
from needs import extra
from streams import wait

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
    before = dict(os.environ)

    def kill(state: object) -> None:
        if not killed and (workers := workers_below(os.getpid())):
            workers[0].kill()
            killed.append(workers[0].pid)

    folder = tmp_path / "faces.zarr"
    em.make_faces(rig, folder, FACES, vertices="int16", scheduler="local", progress=kill)
    assert killed
    assert contents(folder) == alone
    assert workers_below(os.getpid()) == []
    assert dict(os.environ) == before


def test_a_scheduler_elsewhere_whose_end_is_said_and_gone_on_from(
    rig: em.Rig, alone: dict[str, bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with separate() as machines:
        with monkeypatch.context() as patch:
            patch.setattr(cluster, "_version", lambda name: "0.0.1")
            with pytest.raises(
                em.ClusterError, match=r"has elastomorph .* this machine has 0\.0\.1"
            ):
                em.make_faces(rig, tmp_path / "none", 9, scheduler=machines.address)
        assert not (tmp_path / "none").exists()
        with pytest.raises(em.ClusterError, match="does not find the data set memory://"):
            em.make_faces(rig, "memory://here-alone", 9, scheduler=machines.address)

        monkeypatch.chdir(tmp_path)
        em.make_faces(rig, "faces.zarr", FACES, vertices="int16", scheduler=machines.address)
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


def test_workers_come_from_jobs_of_a_queue(
    rig: em.Rig, alone: dict[str, bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """SLURM itself is not there: a job that is handed in runs at once, beside us."""
    jobs = tmp_path / "jobs"
    commands = {
        "sbatch": f'cp "$1" {jobs}.sh; setsid sh {jobs}.sh >{jobs}.log 2>&1 &\n'
        f'echo $! >>{jobs}; echo "Submitted batch job $!"',
        "scancel": 'kill -KILL -- "-$1"',
    }
    for name, command in commands.items():
        (tmp_path / name).write_text(f"#!/bin/sh\n{command}\n")
        (tmp_path / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    file = tmp_path / "cluster.toml"
    file.write_text(QUEUE)
    folder = tmp_path / "faces.zarr"
    em.make_faces(rig, folder, FACES, vertices="int16", scheduler=str(file))
    assert contents(folder) == alone
    assert "export MALLOC_MMAP_THRESHOLD_=" in (tmp_path / "jobs.sh").read_text()
    numbers = [int(line) for line in jobs.read_text().split()]
    assert numbers
    wait(lambda: not any(workers_below(number) for number in numbers))


QUEUE = """\
class = "SLURMCluster"
jobs = 1
patience = 100

[arguments]
cores = 1
memory = "1 GB"
walltime = "00:10:00"
scheduler_options = { host = "127.0.0.1" }
"""


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('class = "SLURM"', r"cluster.toml, line 1: 'class' .* did you mean 'SLURMCluster'"),
        ("jobs = 3", "'class' is a cluster of dask-jobqueue, found None: there are"),
        (QUEUE.replace("jobs = 1", "jobs = 0"), "line 2: 'jobs' must be at least 1"),
        (QUEUE.replace("jobs", "job"), "line 2: unknown table or key 'job': did you mean 'jobs'"),
        (QUEUE.replace("cores", "core"), "SLURMCluster refuses this: .*core"),
        (QUEUE, "there is no command 'sbatch' on this machine"),
    ],
)
@pytest.mark.filterwarnings("ignore:unclosed cluster:ResourceWarning")  # Begun by halves
def test_files_of_queues_that_are_refused(
    text: str, message: str, rig: em.Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    file = tmp_path / "cluster.toml"
    file.write_text(text)
    with pytest.raises(em.ElastomorphError, match=message) as caught:
        em.make_faces(rig, tmp_path / "faces.zarr", 9, scheduler=str(file))
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "faces.zarr").exists()
    del caught
    gc.collect()


def test_every_queue_of_dask_jobqueue_has_a_name(tmp_path: Path) -> None:
    file = tmp_path / "cluster.toml"
    for name in ("SLURM", "PBS", "SGE", "LSF", "OAR", "HTCondor", "Moab", "Local"):
        file.write_text(f'class = "{name}Cluster"')
        assert read_queue(file).kind.__name__ == f"{name}Cluster"


def test_what_is_no_scheduler_is_refused(
    rig: em.Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(schedulers, "_ANSWER", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"127.0.0.1:{silent.getsockname()[1]}"
        for scheduler, message in {
            "slurm": "a scheduler is none, local, an address such as .* found 'slurm'",
            "host:door": "found 'host:door'",
            address: f"no Dask scheduler answers at {address} within",
            f"tcp://{address}": "no Dask scheduler answers at tcp",
            str(tmp_path / "scheduler.json"): "no file of a running scheduler",
            str(tmp_path / "cluster.toml"): "there is no such file",
        }.items():
            with pytest.raises(em.ElastomorphError, match=message) as caught:
                em.make_faces(rig, tmp_path / "faces.zarr", 9, scheduler=scheduler)
            assert "\n" not in str(caught.value)
    with pytest.raises(em.ParameterError, match="a scheduler is named by a text, found 8786"):
        em.make_faces(rig, tmp_path / "faces.zarr", 9, scheduler=8786)  # type: ignore[arg-type]
    assert not (tmp_path / "faces.zarr").exists()


def test_a_script_that_would_start_itself_again_is_refused(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    call = "from elastomorph.farm.making.main_guard import require_guarded_main as f\n\n"
    call += "def main():\n    f()\n"
    for guard, fine in (("if True:", False), ("if __name__ == '__main__':", True)):
        script.write_text(f"{call}\n{guard}\n    main()\n")
        found = subprocess.run([sys.executable, script], capture_output=True, text=True)
        assert (found.returncode == 0) is fine
        said = found.stderr.strip().rpartition("\n")[2]
        assert fine or f"{script}, line 7: put what stands here below" in said


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
