"""``elastomorph farm``: data sets of faces, from a recipe."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import options
from elastomorph.cli.output import Say, print_facts
from elastomorph.cli.verb import Answer, verb
from elastomorph.errors import ParameterError

if TYPE_CHECKING:
    from elastomorph.farm.faces import FaceSet

Output = Annotated[
    str, typer.Option("--output", "-o", help="A folder, or an address that fsspec knows.")
]
Count = Annotated[int | None, typer.Option(help="How many; may be left out for a finite recipe.")]
Recipe = Annotated[
    Path | None, typer.Option(help="What faces there are (TOML). Default: sparse mixtures of all.")
]
Seed = Annotated[int | None, typer.Option(help="Other faces of the same kind; 0 by default.")]
Stored = Annotated[
    str | None,
    typer.Option(help="Store vertices too: float32, float16 or int16. Default: the recipe alone."),
]
Tolerance = Annotated[
    float | None, typer.Option(help="Largest error of stored vertices, as a part of D.")
]
Normals = Annotated[bool, typer.Option("--normals", help="Store normals of the vertices.")]
Landmarks = Annotated[
    Path | None,
    typer.Option(
        help="Store positions of landmarks: vertices by name, of 'landmarks' writes them."
    ),
]


@verb
def farm(
    rig: options.RigName,
    output: Output,
    faces: Count = None,
    recipe: Recipe = None,
    seed: Seed = None,
    vertices: Stored = None,
    tolerance: Tolerance = None,
    normals: Normals = False,
    landmarks: Landmarks = None,
    method: options.MethodText = None,
    mesh: options.MeshNames = None,
    settings: options.SettingsFile = None,
    *,
    say: Say,
) -> Answer:
    """Make a data set of faces; given again, the same command goes on where it stood.

    Example: elastomorph farm rig.glb --faces 1000000 -o faces.zarr
    """
    from elastomorph.farm.run import make_faces

    face_rig = options.NamedRig.of(rig, settings, method, mesh).full(say)
    found = make_faces(
        face_rig,
        output,
        faces,
        recipe=recipe,
        seed=seed,
        vertices=vertices,
        tolerance=tolerance,
        normals=normals,
        landmarks=_landmarks(landmarks),
        progress=lambda state: say(str(state)),
    )
    return _answer(found)


def _landmarks(path: Path | None) -> dict[str, int] | None:
    if path is None:
        return None
    from elastomorph.capturing.landmarks.landmarks import read_landmarks

    found = dict(read_landmarks(path).vertices)
    if not found:
        raise ParameterError(f"{path} names no vertices of a rig; place them with 'landmarks'")
    return found


def _answer(found: FaceSet) -> Answer:
    facts: dict[str, Any] = {
        "faces": len(found),
        "vertices": found.shape[1],
        "stored": list(found.data.plan.arrays),
        "written": found.data.order.url,
    }
    return Answer(facts, lambda: print_facts(facts, 10))
