"""``elastomorph init``: a settings file for the character in a folder."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from elastomorph.cli.output import Say, print_facts
from elastomorph.cli.verb import Answer, verb


@verb
def init(
    folder: Annotated[
        Path, typer.Argument(help="The folder of a character: its neutral and targets, or a rig.")
    ],
    neutral: Annotated[
        str | None, typer.Option(help="File of the neutral, if its name does not tell.")
    ] = None,
    force: Annotated[
        bool, typer.Option("--force", help="Replace settings that are there.")
    ] = False,
    *,
    say: Say,
) -> Answer:
    """Look at a folder and write elastomorph.toml: what was found, and what could be set.

    Every verb that is given the folder as a rig then takes the settings from it.

    Examples:
      elastomorph init path/to/face
      elastomorph init path/to/face --force
    """
    from elastomorph.character.template import arkit_names, correctives, turning, write_settings

    file, found = write_settings(folder, neutral=neutral, force=force, say=say)
    corrected = correctives(found.shapes)
    facts = {
        "written": str(file),
        "neutral": None if found.neutral is None else found.neutral.name,
        "rig": None if found.rig is None else found.rig.name,
        "vertices": found.vertices,
        "targets": len(found.shapes),
        "ARKit names": len(arkit_names(found.shapes)),
        "turning": [name for name in turning(found.shapes) if name not in corrected],
        "correctives": list(corrected),
        "in-betweens": {
            name: [path.name for path in own.values()] for name, own in found.inbetweens.items()
        },
        "motions": found.sequences,
        "curves": [path.name for path in found.curves],
        "regions": [path.name for path in found.regions],
        "takes": [path.name for path in found.takes],
    }
    known = {name: value for name, value in facts.items() if value not in (None, [], {})}
    return Answer(facts, lambda: print_facts(known, 14))
