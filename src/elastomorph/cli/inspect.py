"""``elastomorph inspect``: what is in a file, how it was made, how far targets are from neutral."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import options
from elastomorph.cli.output import Say, print_facts
from elastomorph.cli.verb import Answer, verb
from elastomorph.errors import ParameterError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from elastomorph.model.inspection import Displacement, MeshFacts
    from elastomorph.model.morph import Morph
    from elastomorph.rig.laws import Corrective


@verb
def inspect(
    files: Annotated[
        list[Path],
        typer.Argument(
            help="A mesh and further ones as its targets; a rig (.glb, …, a folder, 'built-in', "
            "settings); an evaluation (.json)."
        ),
    ],
    mesh: options.MeshNames = None,
    *,
    say: Say,
) -> Answer:
    """Say what a file holds and how it was made; compare further meshes with the first.

    A rig shows the path of each target, for what reason where ``auto`` chose it, and, like an
    evaluation, the settings it was made with.

    Examples:
      elastomorph inspect neutral.obj jawOpen.obj smile.obj
      elastomorph inspect head.glb
    """
    from elastomorph.cli.render_words import holds_mesh
    from elastomorph.io import read
    from elastomorph.io.gltf.container import open_gltf
    from elastomorph.io.gltf.vrm import overrides_note, overrides_of
    from elastomorph.io.registry import settings_used
    from elastomorph.model.inspection import displacement, mesh_facts

    first = files[0]
    changes: dict[str, Displacement] = {}
    rig = facts = None
    say(f"reading {first}")
    used = settings_used(first)
    gltf = first.suffix.lower() in (".glb", ".gltf", ".vrm") and not first.is_dir()
    overrides = overrides_of(open_gltf(first)) if gltf else {}
    if first.suffix.lower() != ".json" or first.is_dir():
        if not holds_mesh(first):
            named = options.NamedRig.of(str(first), mesh=mesh)
            rig = named.full(say, stored=None if named.settings else named.stored(say))
        neutral = read(first) if rig is None else rig.neutral
        facts = mesh_facts(neutral)
        if rig is not None:
            changes = {n: displacement(neutral, target) for n, target in rig.targets.items()}
    if mesh and (rig is None or len(files) > 1):
        raise ParameterError("--mesh is for a rig file by itself")
    if len(files) > 1 and (changes or facts is None):
        why = "has its own targets" if changes else "is no mesh"
        raise ParameterError(f"{first} {why}: inspect it by itself, without {files[1]}")
    for file in files[1:]:
        say(f"reading {file}")
        changes[str(file)] = displacement(neutral, read(file))
    morphs = {} if rig is None else rig.morphs
    correctives = {} if rig is None else rig.sliders.correctives

    def tell() -> None:
        typer.echo(str(first))
        if facts is not None:
            print_facts(_lines(facts), 20)
        for line in _made_with(used, first):
            typer.echo(line)
        _tell(changes, morphs, correctives)
        if overrides:
            typer.echo(f"\n  {overrides_note(overrides)}")

    made = {} if used is None else {"settings": used}
    made |= {"overrides": overrides} if overrides else {}
    known = {} if facts is None else {**asdict(facts), "targets": _targets(changes, morphs)}
    if correctives:
        paths = {name: _path(morphs[name]) for name in correctives if name not in changes}
        known["correctives"] = {
            name: own.entry() | paths.get(name, {}) for name, own in correctives.items()
        }
    return Answer({"file": str(first), **known, **made}, tell)


def _tell(
    changes: Mapping[str, Displacement],
    morphs: Mapping[str, Morph],
    correctives: Mapping[str, Corrective],
) -> None:
    if changes:
        typer.echo("\n  moved vertices   largest   mean of moved   target  (% of D)")
    for name, change in changes.items():
        way = ""
        if name in morphs:
            way = f"  ({_words(morphs[name])})"
        typer.echo(
            f"{change.moved:>16,} {change.largest:>9.3%} {change.mean_of_moved:>15.3%}   "
            f"{name}{way}"
        )
    if correctives:
        typer.echo("\n  correctives, and the sliders that drive them")
    for name, own in correctives.items():
        shape = "" if name in changes else f"  ({_words(morphs[name])})"
        typer.echo(f"    {name}: {own.law} of {', '.join(own.drivers)}{shape}")


def _words(morph: Morph) -> str:
    return morph.method if morph.choice is None else morph.choice.text


def _targets(
    changes: Mapping[str, Displacement], morphs: Mapping[str, Morph]
) -> dict[str, dict[str, Any]]:
    return {
        name: asdict(change) | (_path(morphs[name]) if name in morphs else {})
        for name, change in changes.items()
    }


def _path(morph: Morph) -> dict[str, Any]:
    from elastomorph.io.choices import choice_to_json

    choice = choice_to_json(morph.choice)
    return {"method": morph.method, "bends": len(morph.bends), "choice": choice}


def _made_with(used: dict[str, Any] | None, file: Path) -> list[str]:
    """The settings, one line a key, as a settings file would name it."""
    if used is None:
        return [] if file.suffix.lower() != ".json" else ["  no settings are kept in it"]
    lines = ["  made with the settings"]
    waiting: list[tuple[str, Any]] = list(used.items())
    while waiting:
        name, value = waiting.pop(0)
        if isinstance(value, dict):
            waiting = [(f"{name}.{key}", own) for key, own in value.items()] + waiting
        else:
            text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
            lines.append(f"{name:>30}  {text}")
    return lines


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
