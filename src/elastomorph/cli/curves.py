"""``elastomorph curves``: turn a face into curves."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from elastomorph.cli import options
from elastomorph.cli.output import Say, print_facts
from elastomorph.cli.verb import Answer, verb


@verb
def curves(
    face: Annotated[Path, typer.Argument(help="A mesh file (OBJ, PLY, NPZ), or 'built-in'.")],
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Curve file, JSON.")] = None,
    picture: Annotated[
        Path | None, typer.Option(help="A picture (PNG) of the curves, one colour each.")
    ] = None,
    keep: options.CurveFile = None,
    settings: options.SettingsFile = None,
    *,
    say: Say,
) -> Answer:
    """Find curves along edge loops: they cover every vertex of a face once.

    Example: elastomorph curves face.obj -o curves.json --picture curves.png
    """
    from elastomorph.io import read
    from elastomorph.io.registry import BUILT_IN
    from elastomorph.io.vertex_lists import write_curves
    from elastomorph.samples import head

    say(f"reading {face}")
    mesh = head() if str(face) == BUILT_IN else read(face)
    say("tracing edge loops")
    network = options.network(mesh, options.curve_file(keep, settings))
    if output is not None:
        write_curves(output, network)
    if picture is not None:
        from elastomorph.draw.curves_picture import curves_picture

        say("drawing")
        curves_picture(mesh, network, picture)
    sizes = sorted((len(curve.vertices) for curve in network), reverse=True)
    facts = {
        "file": str(face),
        "vertices": len(mesh.vertices),
        "curves": len(network),
        "closed": sum(curve.closed for curve in network),
        "longest": sizes[0],
        "median": sizes[len(sizes) // 2],
        "of one or two vertices": sum(size <= 2 for size in sizes),
    }

    def tell() -> None:
        print_facts(facts, 22)
        for path in (output, picture):
            if path is not None:
                print_facts({"written": path}, 22)

    return Answer(facts, tell)
