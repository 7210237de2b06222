"""``elastomorph live``: the face of a phone on a rig."""

from __future__ import annotations

import time
from contextlib import nullcontext, suppress
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import options
from elastomorph.cli.output import Say, print_json, progress
from elastomorph.cli.verb import AsJson, verb
from elastomorph.cli.view import face_file

if TYPE_CHECKING:
    from elastomorph.live import LivePage

_BETWEEN = 0.5  # seconds from one line on the terminal to the next

Port = Annotated[int, typer.Option(help="UDP port that Live Link Face sends to.")]
Listen = Annotated[
    str,
    typer.Option(
        help="Address of this machine to receive packets on. Another than the default is reached "
        "by all who are on that network: 0.0.0.0 for all its networks.",
    ),
]
Subject = Annotated[
    str | None, typer.Option(help="The phone to show, by its subject name. Default: the first.")
]
Record = Annotated[
    Path | None,
    typer.Option(
        help="Record to a take (take.csv), from the first packet on; no file is replaced, the next "
        "is take-2.csv.",
    ),
]
ReplayFile = Annotated[
    Path | None,
    typer.Option(help="Send a recorded take (.csv) instead of a phone, over and over."),
]
PagePort = Annotated[
    int | None,
    typer.Option(
        help="Port of 127.0.0.1 for the page; a free one for 0. Default: that of 'view', or a free "
        "one.",
    ),
]
Open = Annotated[bool, typer.Option("--open/--no-open", help="Open the address in the browser.")]


@verb
def live(
    rig: options.RigName,
    port: Port = 11111,
    listen: Listen = "127.0.0.1",
    subject: Subject = None,
    record: Record = None,
    replay: ReplayFile = None,
    page_port: PagePort = None,
    open_browser: Open = True,
    method: options.MethodText = None,
    mesh: options.MeshNames = None,
    settings: options.SettingsFile = None,
    as_json: AsJson = False,
) -> None:
    """Show the face of a phone on a rig, as it moves, in the browser; Ctrl-C ends it.

    The phone runs Live Link Face in the mode "Live Link (ARKit)", with the address of this machine
    as its target. The page is served to this machine only.

    Examples:
      elastomorph live rig.glb --listen 0.0.0.0 --record take.csv
      elastomorph live rig.glb --replay take.csv
    """
    from elastomorph.io.performance import read_performance
    from elastomorph.live import Replay, require_possible

    require_possible(listen, port, record)
    with progress(as_json) as say:
        take = None if replay is None else read_performance(replay)
        where = {"host": listen, "port": port, "page_port": page_port}
        named = options.NamedRig.of(rig, settings, method, mesh)
        page = _page(named, rig, say, subject=subject, record=record, **where)
    sender = nullcontext() if take is None else Replay(take, page.port)
    try:
        # Ctrl-C is how one leaves, and a recording must end well then.
        with suppress(KeyboardInterrupt), page, sender:
            _say_where(page, open_browser, as_json)
            with progress(as_json) as say:
                while True:
                    say(page.session.status().text())
                    time.sleep(_BETWEEN)
    finally:
        outcome = page.session.outcome()
        if as_json:
            print_json(asdict(outcome))
        else:
            typer.echo(outcome.text())


def _page(named: options.NamedRig, name: str, say: Say, **how: Any) -> LivePage:
    """The page of a rig; what was read of it is given back but for what the page needs."""
    from elastomorph.live import LivePage
    from elastomorph.viewer.file_scenes import read_scene

    face = face_file(named, name, say)
    shown = read_scene([face], say=say)
    return LivePage(face.rig, name=face.title, scene=shown, **how)


def _say_where(page: LivePage, open_browser: bool, as_json: bool) -> None:
    import webbrowser

    if as_json:
        print_json({"address": page.address, "port": page.port})
    else:
        typer.echo(f"{page.server.words}\n{page.meaning}\n{page.session.match.text()}")
    if open_browser:
        webbrowser.open(page.address)
