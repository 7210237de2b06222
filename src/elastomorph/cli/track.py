"""``elastomorph track``: slider weights from a take of markers."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import options
from elastomorph.cli.output import Say
from elastomorph.cli.verb import Answer, verb
from elastomorph.errors import FormatError, ParameterError
from elastomorph.numbers import first_few

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import numpy as np
    from numpy.typing import NDArray

    from elastomorph.model.markers import Markers
    from elastomorph.rig.handles import Handle
    from elastomorph.rig.tracking import Tracked

_RATE = 60.0
_MOST = 1000  # vertices of meshes with those of the rig: more say nothing new
_SHOWN, _WORST = 12, 3

Take = Annotated[
    str,
    typer.Argument(
        metavar="MARKERS",
        help="A .c3d; a .npz with 'names' (M,), 'markers' (T, M, 3), NaN where missing, and "
        "perhaps 'times' (T,) in seconds and 'vertices' (M,) of the rig; or meshes of any "
        "topology, take.####.obj or a .npz with 'frames' (T, V, 3).",
    ),
]
Output = Annotated[
    Path, typer.Option("--output", "-o", help="Weights (.csv, .npz), as animate reads them.")
]
Vertices = Annotated[
    Path | None,
    typer.Option(
        "--landmarks",
        help="Vertices of the rig by names of markers, or by numbers of vertices of recorded "
        "meshes (.json), as 'landmarks' writes them.",
    ),
]
Recorded = Annotated[
    Path | None,
    typer.Option(
        "--mesh-landmarks",
        help="Vertices of the recorded meshes by the same names (.json), instead of numbers.",
    ),
]
Rest = Annotated[
    int | None,
    typer.Option(help="A frame with the face at rest: takes out how it differs from the rig's."),
]
Rate = Annotated[
    float | None, typer.Option(help="Frames a second of a file without times; 60 by default.")
]
Prior = Annotated[
    float,
    typer.Option(help="More keeps at rest what markers say little of: 1e-3 for another face."),
]
Smooth = Annotated[float, typer.Option(help="More for noise, less for quick movements.")]


@verb
def track(
    rig: options.RigName,
    markers: Take,
    output: Output,
    landmarks: Vertices = None,
    mesh_landmarks: Recorded = None,
    rest: Rest = None,
    rate: Rate = None,
    clip: options.ClipName = None,
    prior: Prior = 1e-4,
    smooth: Smooth = 3e-4,
    method: options.MethodText = None,
    mesh: options.MeshNames = None,
    settings: options.SettingsFile = None,
    *,
    say: Say,
) -> Answer:
    """Solve a rig to a take of markers, or of meshes of another topology, wherever the head is.

    Examples:
      elastomorph track rig.glb take.c3d --landmarks markers.json --rest 0 -o take.csv
      elastomorph track rig.glb arkit.####.obj --landmarks arkit.json -o take.csv
    """
    from elastomorph.io.sequences import read_markers
    from elastomorph.rig.tracking import track as tracked

    if output.suffix.lower() not in (".csv", ".npz"):
        raise ParameterError(f"weights are written as .csv or .npz, not as {output.name}")
    if rate is not None and not 0 < rate < float("inf"):
        raise ParameterError(f"--rate must be frames a second above 0, found {rate:g}")
    say(f"reading {markers}")
    taken = read_markers(markers, clip=clip)
    if rate is not None and taken.times is not None:
        raise FormatError(markers, "it has times of its own: leave --rate out")
    known = _known(markers, taken, landmarks, mesh_landmarks)
    face_rig = options.NamedRig.of(rig, settings, method, mesh).full(say)
    count = len(face_rig.neutral.vertices)
    columns, places = known or _same(markers, taken, count)
    _require_on(places, count, landmarks or markers)
    how: dict[str, Any] = {"rest": rest, "prior": prior, "smooth": smooth, "progress": say}
    found = tracked(face_rig, taken.frames[:, columns], places, **how)
    pace = _write(output, found, taken.times, rate or _RATE)
    left = {taken.names[i]: each for i, each in zip(columns, found.left.tolist(), strict=True)}
    left_out = sorted(set(taken.names) - set(left), key=taken.names.index)
    facts = {
        "frames": len(taken),
        "rate": pace,
        "markers": len(columns),
        "left_out": left_out,
        "left": {name: each for name, each in left.items() if each == each},
        "never_seen": [name for name, each in left.items() if each != each],
        "unseen": list(found.unseen),
        "frames_between": found.between.tolist(),
        "scale": found.scale,
        "unit": taken.unit,
        "written": str(output),
    }
    return Answer(facts, lambda: _tell(found, facts))


def _known(
    path: str, taken: Markers, landmarks: Path | None, recorded: Path | None
) -> tuple[list[int], list[Handle]] | None:
    """Columns of the markers whose place on the rig is said, and their places."""
    from elastomorph.capturing.landmarks import read_landmarks

    if landmarks is None:
        if recorded is not None:
            raise ParameterError(
                f"--mesh-landmarks {recorded} says where names are on the meshes; --landmarks must "
                "say where they are on the rig"
            )
        if taken.vertices is None:
            return None
        return list(range(len(taken.names))), list(taken.vertices)
    known = read_landmarks(landmarks).vertices
    if recorded is not None:
        own = read_landmarks(recorded).vertices
        beyond = [name for name in own if str(own[name]) not in taken.names]
        if beyond:
            raise FormatError(
                recorded,
                f"{beyond[0]} is vertex {own[beyond[0]]} of {path}, which has {taken.listed()}",
            )
        known = {str(own[name]): vertex for name, vertex in known.items() if name in own}
    # Systems of motion capture put the name of the subject before that of a marker.
    called = [name if name in known else name.rpartition(":")[2] for name in taken.names]
    columns = [i for i, name in enumerate(called) if name in known]
    names = [called[i] for i in columns]
    if not columns:
        raise FormatError(
            landmarks, f"none of its vertices has the name of a marker of {path}: {taken.listed()}"
        )
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise FormatError(path, f"{names.count(twice)} markers are called {twice}; rename them")
    return columns, [known[name] for name in names]


def _same(path: str, taken: Markers, count: int) -> tuple[list[int], list[Handle]]:
    """Some vertices of meshes that have those of the rig."""
    from elastomorph.rig.sliders import spread_rows

    if taken.names != tuple(map(str, range(count))):
        raise FormatError(
            path,
            "where its markers are on the rig is not said: name a file with --landmarks, or add an "
            "array 'vertices' to a .npz",
        )
    columns = spread_rows(count, _MOST).tolist()
    return columns, list(columns)


def _require_on(places: Sequence[Handle], count: int, named: str | Path) -> None:
    """Refuse places that the rig does not have, by the file that names them."""
    beyond = next((place for place in places if isinstance(place, int) and place >= count), None)
    if beyond is not None:
        raise FormatError(
            named,
            f"it has a marker on vertex {beyond} of the rig, which has {count:,} vertices, counted "
            "from 0",
        )


def _write(output: Path, found: Tracked, times: NDArray[np.float64] | None, rate: float) -> float:
    """Write the weights; the frames a second that they have."""
    import numpy as np

    from elastomorph.io.performance import write_performance
    from elastomorph.rig.performance import Performance

    if times is None:
        times = np.arange(len(found.weights)) / rate
    elif len(times) > 1:
        rate = 1.0 / float(np.median(np.diff(times)))
    write_performance(output, Performance(found.names, times, found.weights, rate))
    return rate


def _tell(found: Tracked, facts: Mapping[str, Any]) -> None:
    from rich.console import Console

    console = Console()
    how: dict[str, Any] = {"markup": False, "highlight": False, "soft_wrap": True}
    console.print(str(found), **how)
    far = sorted(facts["left"].items(), key=lambda each: -each[1])[:_WORST]
    told = {
        "farthest": ", ".join(f"{name} {each:.3g}" for name, each in far),
        "never seen": ", ".join(facts["never_seen"]),
        "without a place on the rig": first_few(facts["left_out"], _SHOWN),
        "sliders that no marker shows, left out": first_few(facts["unseen"], _SHOWN),
    }
    for what, names in told.items():
        if names:
            console.print(f"{what}: {names}", **how)
    console.print(f"written to {facts['written']}", **how)
