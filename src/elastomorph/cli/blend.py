"""``elastomorph blend``: one face from weights, or all combinations of weights at once."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from elastomorph.cli import completion, options
from elastomorph.cli.output import Say, print_facts
from elastomorph.cli.verb import Answer, verb
from elastomorph.errors import ParameterError

if TYPE_CHECKING:
    from elastomorph.rig import Rig

Output = Annotated[
    str | None,
    typer.Option(
        "--output", "-o", help="Faces: .npy, .npz (with weights), or face.####.obj; one: .obj."
    ),
]
Weights = Annotated[
    list[str] | None,
    typer.Option(
        "--weight",
        "-w",
        help="name=0.4, repeated: one face instead of all.",
        autocompletion=completion.poses,
    ),
]
Time = Annotated[float, typer.Option("--time", "-t", help="Common time of all paths.")]
Levels = Annotated[
    int | None, typer.Option(help="Values from 0 to 1 in combinations; 6 by default.", min=2)
]
Normalize = Annotated[
    bool | None,
    typer.Option(
        help="Divide the weights of a face by their sum, as the paper does, or not; all "
        "combinations do by default."
    ),
]
Sheet = Annotated[Path | None, typer.Option(help="A contact sheet of 50 faces (PNG).")]
Grid = Annotated[Path | None, typer.Option(help="Neutral to expression, one row each (PNG).")]


@verb
def blend(
    rig: options.OptionalRig = None,
    output: Output = None,
    weight: Weights = None,
    t: Time = 1.0,
    levels: Levels = None,
    expressions: completion.Expressions = None,
    normalize: Normalize = None,
    method: options.MethodText = None,
    mesh: options.MeshNames = None,
    settings: options.SettingsFile = None,
    sheet: Sheet = None,
    grid: Grid = None,
    *,
    say: Say,
) -> Answer:
    """Blend expressions: 7775 faces from five of them, or one face from weights.

    Examples:
      elastomorph blend -o faces.npy --sheet sheet.png
      elastomorph blend rig.glb -w jawOpen=0.4 -w mouthSmileLeft=1 -o face.obj
    """
    if weight:
        _refuse_for_one(levels=levels, expressions=expressions, normalize=normalize, sheet=sheet)
    source = options.NamedRig.of(rig, settings, method, mesh)
    if weight:
        face_rig = source.full(say)
        found = _one(face_rig, weight, t, output)
    else:
        face_rig = source.expressions(say, expressions)
        found = _all(face_rig, levels or 6, t, normalize is not False, output, sheet, say)
    if grid is not None:
        from elastomorph.draw import expression_strip

        say("drawing expressions")
        expression_strip({name: face_rig[name] for name in face_rig.targets}, grid)
        found["grid"] = str(grid)
    return Answer(found, lambda: print_facts(found, 12))


def _refuse_for_one(**given: object) -> None:
    """Refuse what is for all combinations where weights ask for one face."""
    for name, value in given.items():
        if value is not None:
            raise ParameterError(
                f"--{name} is for all combinations: leave it out, or --weight, which asks for one "
                "face"
            )


def _one(rig: Rig, weight: list[str], t: float, output: str | None) -> dict[str, object]:
    from elastomorph.io import write

    weights = options.named_numbers(weight, "--weight")
    positions = rig.blend(weights, t)
    if output is None:
        raise ParameterError("say where to write the face: -o face.obj")
    write(output, rig.neutral.with_vertices(positions))
    return {"faces": 1, "written": output}


def _all(
    rig: Rig,
    levels: int,
    t: float,
    normalize: bool,
    output: str | None,
    sheet: Path | None,
    say: Say,
) -> dict[str, object]:
    from elastomorph.io.npz.mesh import write_face_array
    from elastomorph.io.sequences import write_face_files
    from elastomorph.rig.sliders import spread_rows, weight_combinations

    rows = weight_combinations(len(rig.names), levels)
    found: dict[str, object] = {
        "faces": len(rows),
        "expressions": ", ".join(rig.names),
        "vertices": len(rig.neutral.vertices),
    }
    if output is not None:
        say(f"blending {len(rows):,} faces")
        blocks = rig.stream(rows, t, normalize=normalize)
        if "#" in Path(output).name:
            write_face_files(output, rig.neutral, blocks, count=len(rows))
        else:
            shape = (len(rows), len(rig.neutral.vertices), 3)
            write_face_array(output, blocks, shape, beside={"weights": rows})
        found["written"] = output
    if sheet is not None:
        from elastomorph.draw.strips import contact_sheet

        say("drawing the contact sheet")
        chosen = rows[spread_rows(len(rows), 50)]
        contact_sheet(rig, chosen, t, sheet, normalize=normalize, title=", ".join(rig.names))
        found["sheet"] = str(sheet)
    return found
