"""``elastomorph export``: a rig into the formats that play morph targets."""

from __future__ import annotations

from dataclasses import asdict, is_dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from elastomorph.cli import options

__all__ = ["add_to"]


def add_to(app: typer.Typer) -> None:
    """Add the verb to the command line."""
    app.command()(export)


def export(
    rig: Annotated[
        str, typer.Argument(help="A rig: .glb, .usd, .fbx, .npz, a folder; 'built-in' for ours.")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help=".glb, .usd, .usda, .usdc, .npz")],
    method: options.MethodText = "beam:2",
    only: Annotated[
        str | None, typer.Option(help="Names separated by commas; all by default.")
    ] = None,
    normals: Annotated[
        str | None, typer.Option(help=".glb: delta (normals of every target) or none.")
    ] = None,
    tolerance: Annotated[
        float | None, typer.Option(help="Largest error allowed, as a fraction of D.")
    ] = None,
    timing: options.TimingText = None,
    as_json: options.AsJson = False,
) -> None:
    """Write a rig with its paths as morph targets that any player of linear ones can play.

    Example: elastomorph export path/to/rig -o rig.glb --method beam:2
    """
    from elastomorph.io import write

    settings: dict[str, Any] = {
        "normals": normals,
        "tolerance": tolerance,
        "timing": options.timing(timing),
    }
    with options.progress(as_json) as say:
        face_rig = options.full_rig(None if rig == "built-in" else Path(rig), method, say)
        if only is not None:
            face_rig = face_rig.only([name.strip() for name in only.split(",")])
        say(f"writing {output}")
        report = write(output, face_rig, **{k: v for k, v in settings.items() if v is not None})
    facts: dict[str, Any] = {
        "morphs": len(face_rig.morphs),
        "bytes": output.stat().st_size,
        "written": str(output),
    }
    if is_dataclass(report) and not isinstance(report, type):
        facts |= asdict(report)
    if as_json:
        options.print_json(facts)
        return
    for name, value in facts.items():
        if isinstance(value, dict | list | tuple):
            continue
        typer.echo(f"{name.replace('_', ' '):>20}  {_text(name, value)}")


def _text(name: str, value: object) -> str:
    if name == "bytes" and isinstance(value, int):
        return f"{value:,} ({value / 2**20:.1f} MiB)"
    if isinstance(value, float):
        return f"{100 * value:.2g} % of D" if "error" in name else f"{value:g}"
    return f"{value:,}" if isinstance(value, int) else f"{value}"
