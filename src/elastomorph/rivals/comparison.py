"""Rivals in the table of an evaluation: the same errors, and what each costs.

Each runs in a process of its own, for its faces, the processor time each took, and its memory; a
method of a rig is measured as they are. One thread, so that times add up; imports are done before
the clock starts. The peak is what the process held beyond what it held with its libraries and the
recording loaded.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, field, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.box import SIMPLE_HEAD
from rich.table import Table

from elastomorph.curves import CurveNetwork
from elastomorph.errors import ElastomorphError, ElastomorphWarning
from elastomorph.evaluation import Evaluation, MethodResult
from elastomorph.evaluation.evaluation import Yardstick
from elastomorph.io.atomic import temporary_folder
from elastomorph.io.isolated import own_process
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence
from elastomorph.paths import Method, interpolate
from elastomorph.paths.through import Through
from elastomorph.rivals.rival import Faces, Rival, require_surface

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
    own: Callable[[Path, Path], None] = import_module("elastomorph.rivals.comparison")._serve
    own(Path(sys.argv[1]), Path(sys.argv[2]))


@dataclass(frozen=True)
class OwnMethod(Rival):
    """Any method of `elastomorph.interpolate`, for its cost."""

    name = "method"
    source = "elastomorph"

    method: Method

    @property
    def label(self) -> str:
        """That of the method."""
        return self.method.label

    def require(self, mesh: Mesh) -> None:
        """As for every rival."""
        if self.method.on_surfaces:
            require_surface(mesh)

    def faces(
        self, recording: MeshSequence, curves: CurveNetwork, times: NDArray[np.float64]
    ) -> Faces:
        """The face at each time."""
        morph = interpolate(recording.mesh, recording.target, self.method, curves=curves)
        for moment in times:
            yield morph.at(float(moment))


OWN = ("linear", "beam:2", "arc", "auto")
"""The methods whose cost stands beside that of rivals."""


@dataclass(frozen=True)
class Cost:
    """What the faces of a rival cost, and how far it is from the shapes that it is given."""

    label: str
    source: str
    first: float  # Seconds of processor time until the first face, preparation included
    further: float  # Seconds for each further one
    peak: int | None  # Bytes beyond what was loaded; None where the system does not tell
    ends: float  # Largest distance from the known ends, as a fraction of D


@dataclass(frozen=True)
class Comparison:
    """An evaluation with rivals in it.

    Attributes:
        evaluation: The methods as before, and each rival that could be tried.
        costs: What each cost, and our methods beside them.
        left_out: Why, by the label of each rival that could not be tried.
    """

    evaluation: Evaluation
    costs: tuple[Cost, ...]
    left_out: Mapping[str, str] = field(default_factory=dict)

    def cost_table(self) -> Table:
        """The costs, to print with rich."""
        table = Table(box=SIMPLE_HEAD, padding=0, pad_edge=False, title_justify="left")
        table.title = (
            "Seconds of processor time, one thread; memory beyond the recording; ends in % of D"
        )
        for header in ("", "first face", "each further", "MiB", "ends"):
            table.add_column(header, justify="right" if header else "left", no_wrap=True)
        for cost in self.costs:
            table.add_row(cost.label, *cost_texts(cost))
        return table

    def sentences(self) -> list[str]:
        """Who is left out, and why."""
        return [f"{label} is left out: {why}." for label, why in self.left_out.items()]

    def facts(self) -> dict[str, Any]:
        """For machines."""
        return {"costs": [asdict(cost) for cost in self.costs], "left_out": dict(self.left_out)}


def cost_texts(cost: Cost) -> tuple[str, str, str, str]:
    """Times of the first and of each further face, MiB, and % of D, as tables show them."""
    peak = "unknown" if cost.peak is None else f"{cost.peak / 2**20:.0f}"
    return _duration(cost.first), _duration(cost.further), peak, f"{100 * cost.ends:.3f}"


def _duration(seconds: float) -> str:
    if seconds >= 1:
        return f"{seconds:.1f} s"
    return f"{1e3 * seconds:.{0 if seconds >= 0.01 else 1}f} ms"


def with_rivals(
    evaluation: Evaluation,
    rivals: Iterable[Rival],
    *,
    own: Iterable[str] = OWN,
    runner: Callable[[Rival, MeshSequence, CurveNetwork], Run] = run_apart,
    progress: Callable[[str], None] | None = None,
) -> Comparison:
    """Put rivals beside the methods of an evaluation, judged by the same frames.

    Each runs in a process of its own, unless `runner` is `run`. Between the times of the frames,
    which free timing looks at, its path is the natural cubic spline through its faces.
    """
    truth, say = evaluation.truth, progress or (lambda _: None)
    yardstick = Yardstick.of(truth, evaluation.curves, evaluation.extent, evaluation.confidence)
    costs: list[Cost] = []
    results: list[MethodResult] = []
    left_out: dict[str, str] = {}
    for rival in [*(OwnMethod(Method.parse(text)) for text in own), *rivals]:
        try:
            rival.require(truth.mesh)
            say(rival.label)
            made = runner(rival, truth, evaluation.curves)
        except ElastomorphError as error:
            left_out[rival.label] = str(error).rstrip(".")
            continue
        costs.append(cost_of(rival, made, truth, evaluation.diameter))
        if not isinstance(rival, OwnMethod):
            path = through_poses(truth.mesh, made.poses, truth.times, rival.label)
            path = replace(path, limit_law=rival.limit_law)
            found = yardstick.measure(rival.label, path)
            results.append(replace(found, informed=rival.informed))
    judged = replace(evaluation, results=(*evaluation.results, *results))
    return Comparison(judged, tuple(costs), left_out)


def through_poses(
    mesh: Mesh, poses: NDArray[np.float64], times: NDArray[np.float64], label: str
) -> Morph:
    """The natural cubic spline through (T, V, 3) faces, whose ends are the first and the last."""
    shapes = [mesh.with_vertices(pose) for pose in poses]
    inner = dict(zip(times[1:-1].tolist(), shapes[1:-1], strict=True))
    with warnings.catch_warnings():
        # A weight above 1 is no overshoot where every face is a sample of one path.
        warnings.simplefilter("ignore", ElastomorphWarning)
        morph = Through(inner, "spline").prepare(shapes[0])(shapes[-1])
    return replace(morph, method=label)


def cost_of(rival: Rival, made: Run, recording: MeshSequence, diameter: float) -> Cost:
    """What a run cost, and how far its first and last face are from those of a recording."""
    off = made.poses[[0, -1]] - recording.frames[[0, -1]]
    ends = float(np.linalg.norm(off, axis=2).max()) / diameter
    return Cost(rival.label, rival.source, made.first, made.further, made.peak, ends)
