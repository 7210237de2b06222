"""``elastomorph export``: a rig into the formats that play morph targets."""

from __future__ import annotations

from dataclasses import asdict, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import completion, options
from elastomorph.cli.output import Say, print_facts
from elastomorph.cli.verb import Answer, verb
from elastomorph.errors import ParameterError

if TYPE_CHECKING:
    from elastomorph.character import Settings


@verb
def export(
    rig: options.RigName,
    output: Annotated[
        Path, typer.Option("--output", "-o", help=".glb, .usd, .usda, .usdc, .usdz, .npz")
    ],
    method: options.MethodText = None,
    mesh: options.MeshNames = None,
    settings: options.SettingsFile = None,
    only: Annotated[
        str | None,
        typer.Option(
            help="Names separated by commas; all by default.", autocompletion=completion.sliders
        ),
    ] = None,
    normals: Annotated[
        str | None, typer.Option(help=".glb: delta (normals of every target) or none.")
    ] = None,
    tolerance: Annotated[
        float | None, typer.Option(help="Largest error allowed, as a fraction of D.")
    ] = None,
    clips: Annotated[
        bool,
        typer.Option("--clips", help=".glb: an animation a slider, of its name, of one second."),
    ] = False,
    timing: options.TimingText = None,
    compress: Annotated[
        bool,
        typer.Option("--compress", help=".glb: a fifth of the size, within 1e-4 of D of the rig."),
    ] = False,
    *,
    say: Say,
) -> Answer:
    """Write a rig for other programs: its paths as morph targets, which any player can play.

    Example: elastomorph export path/to/rig -o rig.glb
    """
    from elastomorph.io import write

    given = {"normals": normals, "tolerance": tolerance, "timing": options.timing(timing)}
    given["compress"] = compress or None
    given["clips"] = clips or None
    said: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    _require_format(output, list(said))
    source = options.NamedRig.of(rig, settings, method, mesh)
    face_rig = source.full(say, only)
    say(f"writing {output}")
    if source.settings is not None:
        said = _overriding(source.settings, output, said, timing, only)
    if timing is not None:  # that of clips
        said["clips"] = True
    report = write(output, face_rig, **said)
    size = output.stat().st_size
    facts: dict[str, Any] = {"morphs": len(face_rig.morphs), "bytes": size, "written": str(output)}
    if is_dataclass(report) and not isinstance(report, type):
        facts |= {k: str(v) if isinstance(v, Path) else v for k, v in asdict(report).items()}
    texts = {
        name.replace("_", " "): _text(name, value)
        for name, value in facts.items()
        if not isinstance(value, dict | list | tuple)
    }
    return Answer(facts, lambda: print_facts(texts, 20))


def _require_format(output: Path, names: list[str]) -> None:
    """Refuse a format that is not written, and options it does not have, before all else."""
    from elastomorph.io.registry import RIG_FORMATS, writer_of

    writer_of(output, RIG_FORMATS)
    suffix = output.suffix.lower()
    known: dict[str, list[str]] = {
        ".glb": ["normals", "tolerance", "timing", "compress", "clips"],
        ".npz": [],
    }
    known |= {usd: ["tolerance"] for usd in (".usd", ".usda", ".usdc", ".usdz")}
    for name in names:
        if name not in known.get(suffix, names):
            formats = ", ".join(own for own, options in known.items() if name in options)
            raise ParameterError(f"--{name} is for {formats}; {output} has no such option")


def _overriding(
    settings: Settings, output: Path, said: dict[str, Any], timing: str | None, only: str | None
) -> dict[str, Any]:
    """Options of the writer: those of settings, and in their place those of the command line."""
    from elastomorph.character.schema import export_options

    plain = {name: value for name, value in said.items() if name != "timing"}
    names = [*said, *(["only"] if only is not None else [])]
    settings = settings.with_options(
        *names,
        timing=settings.timing if timing is None else timing,
        **{
            own: {**getattr(settings, own), **(plain if own in output.suffix.lower() else {})}
            for own in ("glb", "usd")
        },
    )
    return export_options(settings, output)


def _text(name: str, value: object) -> object:
    if name == "bytes" and isinstance(value, int):
        return f"{value:,} ({value / 2**20:.1f} MiB)"
    if isinstance(value, float):
        return f"{100 * value:.2g} % of D" if "error" in name else f"{value:g}"
    return value
