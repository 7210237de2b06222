"""``elastomorph inspect``: what is in a mesh file, and how far targets are from their neutral."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from elastomorph.cli import options

if TYPE_CHECKING:
    from elastomorph.inspection import MeshFacts

__all__ = ["add_to"]


def add_to(app: typer.Typer) -> None:
    """Add the verb to the command line."""
    app.command()(inspect)


def inspect(
    files: Annotated[
        list[Path], typer.Argument(help="A mesh file; further ones are taken as its targets.")
    ],
    as_json: options.AsJson = False,
) -> None:
    """Say what a mesh file holds; with several files, compare the others with the first.

    Example: elastomorph inspect neutral.obj jawOpen.obj smile.obj
    """
    from elastomorph.inspection import displacement, mesh_facts
    from elastomorph.io import read

    with options.progress(as_json) as say:
        say(f"reading {files[0]}")
        neutral = read(files[0])
        facts = mesh_facts(neutral)
        changes = {}
        for file in files[1:]:
            say(f"reading {file}")
            changes[str(file)] = displacement(neutral, read(file))
    if as_json:
        targets = {name: asdict(change) for name, change in changes.items()}
        options.print_json({"file": str(files[0]), **asdict(facts), "targets": targets})
        return
    typer.echo(str(files[0]))
    for name, value in _lines(facts).items():
        typer.echo(f"{name:>20}  {value}")
    if changes:
        typer.echo("\n  moved vertices   largest   mean of moved   target  (% of D)")
    for name, change in changes.items():
        typer.echo(
            f"{change.moved:>16,} {change.largest:>9.3%} {change.mean_of_moved:>15.3%}   {name}"
        )


def _lines(facts: MeshFacts) -> dict[str, str]:
    names = {3: "triangles", 4: "quads", 5: "pentagons", 6: "hexagons"}
    polygons = [f"{n:,} {names.get(size, f'{size}-gons')}" for size, n in facts.polygons.items()]
    size = [high - low for low, high in zip(facts.lowest, facts.highest, strict=True)]
    return {
        "vertices": f"{facts.vertices:,}",
        "polygons": ", ".join(polygons) or "none",
        "edges": f"{facts.edges:,}",
        "border edges": f"{facts.border_edges:,}",
        "non-manifold edges": f"{facts.non_manifold_edges:,}",
        "components": f"{facts.components:,}",
        "isolated vertices": f"{facts.isolated_vertices:,}",
        "poles": f"{facts.poles:,}  (inside the surface, valence other than 4)",
        "D": f"{facts.diameter:.6g}",
        "size": " × ".join(f"{s:.6g}" for s in size),
        "materials": ", ".join(facts.materials) or "none",
        "groups": ", ".join(facts.groups) or "none",
    }
