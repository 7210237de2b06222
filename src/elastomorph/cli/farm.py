"""``elastomorph farm``: data sets of faces, from a recipe."""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import options
from elastomorph.cli.output import Say, given_parameters, print_facts
from elastomorph.cli.verb import Answer, verb
from elastomorph.errors import ParameterError

if TYPE_CHECKING:
    from elastomorph.farm.sampling.recipe import Recipe as RecipeTables
    from elastomorph.farm.sampling.sampler import FaceSampler
    from elastomorph.farm.storage.wanted import Wanted
    from elastomorph.rig import Rig

_Rig = Annotated[
    str | None,
    typer.Argument(
        metavar="[RIG]",
        help="A rig: .glb, .vrm, .usd, .fbx, .npz, a folder, settings (.toml); 'built-in' for "
        "ours. For --to, a data set. Not for --verify.",
    ),
]
_Output = Annotated[
    str, typer.Option("--output", "-o", help="A folder, or an address that fsspec knows.")
]
_Count = Annotated[int | None, typer.Option(help="How many; may be left out for a finite recipe.")]
_Recipe = Annotated[
    Path | None, typer.Option(help="What faces there are (TOML). Default: sparse mixtures of all.")
]
_Seed = Annotated[
    int | None, typer.Option(help="Other faces of the same kind; that of the recipe, or 0.")
]
_Stored = Annotated[
    str | None,
    typer.Option(help="Store vertices too: float32, float16 or int16. Default: the recipe alone."),
]
_Tolerance = Annotated[
    float | None, typer.Option(help="Largest error of stored vertices, as a part of D.")
]
_Normals = Annotated[bool, typer.Option("--normals", help="Store normals of the vertices.")]
_Landmarks = Annotated[
    str | None,
    typer.Option(
        help="Store where landmarks are: vertices by name, as 'landmarks' writes them, or clicks, "
        "68 or mediapipe of a rig whose points are known."
    ),
]
_Render = Annotated[
    int | None,
    typer.Option(help="Store pictures of so many pixels a side, with depth, parts and the like."),
]
_Codec = Annotated[str, typer.Option(help="How it is compressed: lz4, zstd or none.")]
_Unit = Annotated[
    int | None,
    typer.Option(help="Faces made and written together, a power of two; about 32 MiB by default."),
]
_Sheet = Annotated[
    Path | None,
    typer.Option(help="Picture of some faces with their labels; alone, of a data set there is."),
]
_To = Annotated[
    str | None,
    typer.Option(help="Write a data set with pictures as webdataset, coco or folder."),
]
_Verify = Annotated[
    bool,
    typer.Option(
        "--verify", help="Check all checksums, and make a random sample again to compare."
    ),
]
_Sample = Annotated[int, typer.Option(help="Units that --verify makes again.")]
_DryRun = Annotated[
    bool, typer.Option("--dry-run", help="Say what it would take, from a second's trial here.")
]
_Storage = Annotated[
    list[str] | None,
    typer.Option(
        "--storage-option",
        metavar="KEY=VALUE",
        help="What reaches the store at an address, as endpoint_url=http://host:9000; again for "
        "more.",
    ),
]
_Scheduler = Annotated[
    str,
    typer.Option(
        help="Executor: none (threads of this process), local (processes), or the address of a "
        "Dask scheduler."
    ),
]


@verb
def farm(
    context: typer.Context,
    rig: _Rig = None,
    output: _Output = "",
    faces: _Count = None,
    recipe: _Recipe = None,
    seed: _Seed = None,
    vertices: _Stored = None,
    tolerance: _Tolerance = None,
    normals: _Normals = False,
    landmarks: _Landmarks = None,
    render: _Render = None,
    codec: _Codec = "lz4",
    unit: _Unit = None,
    sheet: _Sheet = None,
    to: _To = None,
    storage_option: _Storage = None,
    scheduler: _Scheduler = "none",
    verify: _Verify = False,
    sample: _Sample = 4,
    dry_run: _DryRun = False,
    method: options.MethodText = None,
    mesh: options.MeshNames = None,
    settings: options.SettingsFile = None,
    *,
    say: Say,
) -> Answer:
    """Make a data set of faces; given again, the same command goes on where it stood.

    Example: elastomorph farm rig.glb --faces 1000000 -o faces.zarr
    """
    shown = rig is None and sheet is not None
    _require_use(context, output, verify, shown, dry_run)
    storage = _storage_options(storage_option or [])
    # Sessions with a store that failed are told of by aiohttp when they are thrown away.
    logging.getLogger("asyncio").setLevel(logging.CRITICAL)
    if verify or shown:
        return (
            _verified(output, sample, storage, say) if verify else _answer(output, sheet, storage)
        )
    if to is not None:
        return _exported(rig, output, to, storage, say)
    if rig is None:
        raise ParameterError("name the rig whose faces are made, or 'built-in' for ours")
    from elastomorph.farm.making.run import make_faces
    from elastomorph.farm.sampling.sampler import FaceSampler
    from elastomorph.farm.storage.wanted import Wanted, pictured

    own = pictured(recipe, render)
    face_rig = options.NamedRig.of(rig, settings, method, mesh).full(say)
    marks = _landmarks(landmarks, own, rig, face_rig)
    wanted = Wanted(vertices, tolerance, normals, marks, codec, unit)
    if dry_run:
        sampler = FaceSampler(face_rig, own, seed=seed)
        return _estimated(face_rig, sampler, faces, wanted, say)
    make_faces(
        face_rig,
        output,
        faces,
        recipe=own,
        seed=seed,
        progress=lambda state: say(str(state)),
        storage_options=storage,
        scheduler=scheduler,
        **vars(wanted),
    )
    return _answer(output, sheet, storage)


def _require_use(
    context: typer.Context, output: str, verify: bool, shown: bool, dry_run: bool
) -> None:
    """Refuse what is missing, and what is given beside the others and would have no effect."""
    if not output and not dry_run:
        raise ParameterError("name where the data set is, as -o faces.zarr")
    if (sheet := context.params["sheet"]) is not None:
        from elastomorph.draw.pictures import picture_suffix

        picture_suffix(sheet)  # before the faces are made
    always = {"output", "as_json", "overwrite", "storage_option"}
    for own in given_parameters(context):
        name = own.name or ""
        said = own.opts[-1] if name != "rig" else "the name of a rig"
        if verify and name not in always | {"verify", "sample"}:
            raise ParameterError(f"--verify makes nothing, so {said} has no meaning beside it")
        if not verify and shown and name not in always | {"sheet"}:
            raise ParameterError(f"--sheet shows what is there: for {said}, name a rig too")
        if context.params["to"] is not None and name not in always | {"to", "rig"}:
            raise ParameterError(f"--to writes a data set there is, so {said} has no meaning here")
        if name == "sample" and not verify:
            raise ParameterError("--sample is how many units --verify makes again: add --verify")


def _answer(output: str, sheet: Path | None, storage: Mapping[str, Any]) -> Answer:
    """What is there now, and a picture of it."""
    from elastomorph.farm.reading.faces import open_faces

    found = open_faces(output, storage_options=storage)
    if sheet is not None:
        from elastomorph.farm.reading.sheets import sheet_of

        sheet_of(found, sheet)
    facts = {
        "faces": len(found),
        "vertices": found.shape[1],
        "stored": list(found.data.plan.arrays),
        "written": output,
    }
    return Answer(facts, lambda: print_facts(facts, 10))


def _exported(
    source: str | None, output: str, to: str, storage: Mapping[str, Any], say: Say
) -> Answer:
    from elastomorph.farm.reading.export import export_faces
    from elastomorph.farm.reading.faces import open_faces

    if source is None:
        raise ParameterError("name the data set, as 'farm faces.zarr --to coco -o faces'")
    faces = open_faces(source, storage_options=storage)
    written = export_faces(faces, output, to, progress=say)
    facts = {"faces": len(faces), "files": [str(file) for file in written], "written": output}
    shown = {"faces": len(faces), "format": to, "written": output}
    return Answer(facts | shown, lambda: print_facts(shown, 10))


def _verified(output: str, sample: int, storage: Mapping[str, Any], say: Say) -> Answer:
    from elastomorph.farm.making.verify import verify_faces

    found = verify_faces(output, sample, storage_options=storage, progress=say)
    facts = {
        "finished": found.finished,
        "units": found.units,
        "faces": found.faces,
        "same": found.same,
    }
    return Answer(facts, lambda: typer.echo(str(found)))


def _estimated(
    rig: Rig,
    sampler: FaceSampler,
    faces: int | None,
    wanted: Wanted,
    say: Say,
) -> Answer:
    from dataclasses import asdict

    from elastomorph.farm.making.trial import estimate

    say("trying for a second")
    found = estimate(rig, sampler, faces, wanted)

    def tell() -> None:
        typer.echo(sampler.describe())
        print_facts(found.told(), 8)

    return Answer(asdict(found) | {"recipe": sampler.describe()}, tell)


def _landmarks(
    path: str | None, recipe: RecipeTables, place: str, rig: Rig
) -> Mapping[str, int] | str | None:
    """Those of the file or set named; for pictures without any, those that come with the rig."""
    from elastomorph.capturing.landmarks import (
        POINT_SETS,
        known_landmarks,
        read_landmarks,
    )

    if path is None:
        known = recipe.pictures is not None and not recipe.landmarks
        return (known_landmarks(place, rig.neutral) or None) if known else None
    if path in POINT_SETS:
        return path
    found = read_landmarks(path).vertices
    if not found:
        raise ParameterError(f"{path} names no vertices of a rig; place them with 'landmarks'")
    return found


def _storage_options(words: list[str]) -> dict[str, Any]:
    """Options by name; values are JSON where they can be, such as true, and text elsewhere."""
    found: dict[str, Any] = {}
    for word in words:
        name, equals, value = word.partition("=")
        if not name or not equals:
            raise ParameterError(
                f"--storage-option is a name and a value, as anon=true, not {word!r}"
            )
        try:
            found[name] = json.loads(value)
        except ValueError:
            found[name] = value
    return found
