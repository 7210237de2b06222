"""A rival in a process of its own: its faces, the processor time each took, and its memory.

One thread, so that times add up; imports are done before the clock starts. The peak is what the
process held beyond what it held with its libraries and the recording loaded.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork
from elastomorph.errors import ElastomorphError
from elastomorph.io.isolated import own_process
from elastomorph.io.temporaries import temporary_folder
from elastomorph.model.sequence import MeshSequence
from elastomorph.rivals.rival import Rival

_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
_LIBRARIES = (
    "scipy.interpolate",
    "scipy.sparse.csgraph",
    "scipy.sparse.linalg",
    "scipy.spatial.transform",
)
LONGEST = 900.0
"""Seconds after which a rival is given up."""


@dataclass(frozen=True, eq=False)
class Run:
    """What a rival made of a recording, and what that cost."""

    poses: NDArray[np.float64]  # (T, V, 3)
    first: float  # Seconds of processor time until the first face, preparation included
    further: float  # Seconds for each further one, their mean
    peak: int | None  # Bytes beyond what was loaded; None where the system does not tell


class TooLongError(ElastomorphError):
    """A rival did not finish in time."""


def run_apart(
    rival: Rival,
    recording: MeshSequence,
    curves: CurveNetwork,
    times: NDArray[np.float64] | None = None,
    *,
    longest: float = LONGEST,
) -> Run:
    """Run a rival at some times, by default those of the recording.

    Raises:
        ElastomorphError: What the rival raised, or it took too long or broke.
    """
    with temporary_folder() as folder:
        asked, answered = folder / "asked", folder / "answered"
        asked.write_bytes(pickle.dumps((rival, recording, curves, times)))
        command, environment = own_process(__name__)
        try:
            done = subprocess.run(
                [*command, str(asked), str(answered)],
                env=environment | _ONE_THREAD,
                stdin=subprocess.DEVNULL,
                capture_output=True,
                timeout=longest,
                check=False,
            )
        except subprocess.TimeoutExpired:
            raise TooLongError(f"it took longer than {longest:.0f} s") from None
        if not answered.is_file():
            said = done.stderr.decode("utf-8", "backslashreplace").strip().splitlines()
            raise ElastomorphError(
                f"its process broke: {(said or [f'exit {done.returncode}'])[-1]}"
            )
        found = pickle.loads(answered.read_bytes())
    if isinstance(found, ElastomorphError):
        raise found
    assert isinstance(found, Run)
    return found


def run(
    rival: Rival,
    recording: MeshSequence,
    curves: CurveNetwork,
    times: NDArray[np.float64] | None = None,
) -> Run:
    """Run a rival in this process, each face against the clock."""
    for library in (*_LIBRARIES, *filter(None, [rival.package])):
        import_module(library)
    before = _memory("VmRSS")
    moments = recording.times if times is None else times
    faces = rival.told(recording, moments, curves)
    poses = np.empty((len(moments), *recording.mesh.vertices.shape))
    seconds = np.empty(len(moments))
    for i in range(len(moments)):
        start = time.process_time()
        poses[i] = next(faces)
        seconds[i] = time.process_time() - start
    after = _memory("VmHWM")
    peak = None if before is None or after is None else max(0, after - before)
    return Run(poses, float(seconds[0]), float(seconds[1:].mean()), peak)


def _memory(what: str) -> int | None:
    """Bytes of this process as Linux counts them: held now, or at most."""
    try:
        lines = Path("/proc/self/status").read_text().splitlines()
    except OSError:
        return None
    return next((int(line.split()[1]) << 10 for line in lines if line.startswith(what)), None)


def _serve(asked: Path, answered: Path) -> None:
    task: Any = pickle.loads(asked.read_bytes())
    found: Run | ElastomorphError
    try:
        found = run(*task)
    except ElastomorphError as error:
        found = error
    answered.write_bytes(pickle.dumps(found))


if __name__ == "__main__":
    # Pickled under the name that the other process knows.
    own: Callable[[Path, Path], None] = import_module("elastomorph.rivals.process")._serve
    own(Path(sys.argv[1]), Path(sys.argv[2]))
