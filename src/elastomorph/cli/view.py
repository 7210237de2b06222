"""``elastomorph view``: a face and its paths in the browser.

The faces that a page shows, as the command line names them.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from elastomorph.cli import completion, options
from elastomorph.cli.options import NamedRig
from elastomorph.cli.output import Say, print_json, progress
from elastomorph.cli.verb import AsJson, verb
from elastomorph.errors import ParameterError

if TYPE_CHECKING:
    from elastomorph.rig import Rig
    from elastomorph.viewer import Scene, ViewerServer
    from elastomorph.viewer.file_scenes import FaceFile
    from elastomorph.viewer.listening import Offer, Work


def face_file(named: NamedRig, name: str, say: Say) -> FaceFile:
    """A rig that was named, to be read when it is shown; ``name`` is how it was called."""
    from elastomorph.viewer.file_scenes import FaceFile, gltf_in

    def read(stored: Rig | None) -> Rig:
        return named.full(say, stored=stored)

    if named.settings is not None:
        return FaceFile.by_settings(name, named.followed or named.settings, read)
    character = None if named.place is None else gltf_in(named.place)
    settled = named.method is not None or bool(named.mesh)
    return FaceFile(name, read, character, tuple(named.mesh), settled)


_PAGES = (".html", ".htm")

Files = Annotated[
    list[str],
    typer.Argument(
        metavar="RIG|FOLDER|REPORT|GLB…",
        help="Rigs (.glb, .vrm, .usd, .fbx, .npz, a folder of meshes, 'built-in'), several to "
        "compare them; or a report (.html).",
    ),
]
Methods = Annotated[
    list[str] | None,
    typer.Option(
        help="auto, linear, rotation, beam:R[:closure], …: paths made anew from the targets; "
        "may be repeated to compare. Default: those of the file, auto where it has none.",
        autocompletion=completion.methods,
    ),
]
Page = Annotated[
    Path | None,
    typer.Option("--output", "-o", help="Write the page (.html) instead of serving it."),
]
Unit = Annotated[str, typer.Option(help="Unit of the coordinates, for legends.")]
Port = Annotated[
    int | None,
    typer.Option(
        help="Port of 127.0.0.1; a free one for 0. Default: always the same one, by which the "
        "browser finds poses again, or a free one where it is taken.",
    ),
]
Open = Annotated[bool, typer.Option("--open/--no-open", help="Open the address in the browser.")]


@verb
def view(
    files: Files,
    method: Methods = None,
    mesh: options.MeshNames = None,
    output: Page = None,
    unit: Unit = "",
    port: Port = None,
    open_browser: Open = True,
    settings: options.SettingsFile = None,
    as_json: AsJson = False,
) -> None:
    """Look at a rig, or compare several, in the browser; Ctrl-C ends it.

    The page is served to this machine only, under an address with a secret in it.

    Examples:
      elastomorph view rig.glb
      elastomorph view path/to/rig --method linear --method beam:2
      elastomorph view built-in -o head.html
    """
    if output is not None and port is not None:
        raise ParameterError("give --output or --port, not both: a written page is not served")
    reports = [file for file in files if Path(file).suffix.lower() in _PAGES]
    if reports:
        if len(files) > 1 or method or output is not None or unit or mesh or settings:
            raise ParameterError(
                f"{reports[0]} is a finished page: view it by itself, without further options"
            )
        from elastomorph.io.atomic import read_bytes
        from elastomorph.viewer.server import serve_page

        shown(serve_page(read_bytes(Path(reports[0])), port or 0), open_browser, as_json)
        return
    with progress(as_json) as say:
        methods = method or []
        scene = _scene(files, methods, unit, settings, mesh, say)
        if output is not None:
            from elastomorph.viewer import write_viewer

            say(f"writing {output}")
            write_viewer(output, scene)
    if output is None:
        from elastomorph.viewer import serve

        shelf: dict[str, Offer] = {}
        services = _services(files, methods, unit, settings, mesh, shelf)
        shown(serve(scene, port, services, shelf), open_browser, as_json)
    elif as_json:
        print_json({"written": str(output), "bytes": output.stat().st_size})
    else:
        typer.echo(f"{scene.title} → {output} ({output.stat().st_size / 1e6:.1f} MB)")


def _scene(
    files: list[str],
    methods: list[str],
    unit: str,
    settings: Path | None,
    mesh: list[str] | None,
    say: Say,
) -> Scene:
    from elastomorph.viewer.file_scenes import read_scene

    for what in (files, methods):
        twice = [one for one in what if what.count(one) > 1]
        if twice:
            raise ParameterError(f"{twice[0]} was given twice")

    # The targets are what counts if methods are named: the straight lines cost nothing.
    method = "linear" if methods else None
    named = [options.NamedRig.of(file, settings, method, mesh) for file in files]
    followed = named[0].settings
    unit = unit or (followed.character.unit if followed else None) or ""
    faces = [face_file(own, file, say) for own, file in zip(named, files, strict=True)]
    return read_scene(faces, methods, unit=unit, say=say)


def _services(
    files: list[str],
    methods: list[str],
    unit: str,
    settings: Path | None,
    mesh: list[str] | None,
    shelf: dict[str, Offer],
) -> dict[str, Work]:
    """What the page may ask this command for: to open files, and paths by other methods."""
    from elastomorph.io.rig_folder import rig_as_stored
    from elastomorph.viewer.file_scenes import read_scene
    from elastomorph.viewer.methods import MethodBench, Subject
    from elastomorph.viewer.uploads import Uploads

    services = {"open": Uploads(shelf).service()}
    if len(files) > 1 or methods:
        return services
    named = options.NamedRig.of(files[0], settings, mesh=mesh)
    followed = named.followed

    def stored(say: Say) -> Rig:
        rig = None if followed is None else followed.character.rig
        if followed is None or rig is None:
            return named.stored(say)
        return rig_as_stored(followed.file(rig), mesh=followed.character.mesh or None)

    def scene(rig: Rig) -> Scene:
        face = face_file(named, files[0], lambda _: None)
        return read_scene([replace(face, read=lambda _: rig, settled=True)], unit=unit)

    bench = MethodBench(Subject(named.full, stored, scene, followed), shelf)
    return {**services, **bench.services()}


def shown(server: ViewerServer, open_browser: bool, as_json: bool) -> None:
    """Say where a page is, send the browser there, and wait until it has ended."""
    import webbrowser

    # Ctrl-C is how one leaves, also in the moment before the server waits for it.
    with server, suppress(KeyboardInterrupt):
        if as_json:
            print_json({"address": server.address})
        else:
            typer.echo(server.words)
        if open_browser:
            webbrowser.open(server.address)
        server.wait()
