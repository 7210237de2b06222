"""The report of a capture: what photographs gave, and how far it is to be trusted."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from colorsys import hsv_to_rgb
from pathlib import Path

import numpy as np

from elastomorph.capturing.geometry.camera import Camera
from elastomorph.capturing.work.captured import Captured
from elastomorph.capturing.work.registered import FLAGGED, Registered
from elastomorph.errors import FileError
from elastomorph.evaluation.words import SPACE, counted
from elastomorph.model.mesh import Mesh
from elastomorph.report.capture_pictures import (
    Shown,
    beside,
    camera_picture,
    front_picture,
    frontal,
    pose_picture,
)
from elastomorph.report.capture_tables import (
    agreement,
    photographs_section,
    size_words,
    times,
)
from elastomorph.report.capture_trust import Trust, findings, headline, trust_section
from elastomorph.report.document import Section, document, require_page_path, write_page
from elastomorph.report.facts import face_words

__all__ = ["capture_page", "write_capture_report", "write_register_report"]

_MOST = 12
"""Pictures of poses from scans; of a take of hundreds some, evenly chosen."""
_LARGE_DOUBT = 0.25
"""Of the place of a head, in % of D, that is told."""
_FIRST, _LAST = 0.60, 0.05
"""Hues of the first pose and of the last."""


def write_capture_report(
    captured: Captured,
    path: str | Path,
    *,
    name: str = "capture",
    unit: str = "",
    call: str = "",
    say: Callable[[str], None] = lambda _: None,
) -> None:
    """Write one self-contained HTML page about a capture, the whole of it or nothing.

    Args:
        captured: Poses, cameras and figures. Photographs are opened, one of each pose.
        path: The page, ``.html``; its folder must exist.
        name: What was captured, for the title.
        unit: Of the coordinates, such as ``cm``; an empty string where nobody knows it.
        call: The command or the call that makes this again.
        say: Told what is being done.

    Raises:
        FormatError: The suffix is not .html.
        FileError: The page cannot be written.
        MissingExtraError: The extra ``capture`` is not installed.
    """
    require_page_path(path)
    write_page(path, capture_page(captured, name=name, unit=unit, call=call, say=say))


def write_register_report(
    poses: Mapping[str, Registered], path: str | Path, *, name: str = "register", call: str = ""
) -> None:
    """Write one self-contained HTML page about registered scans, the whole of it or nothing.

    Args:
        poses: As `register_all` gives them.
        path: The page, ``.html``; its folder must exist.
        name: What was scanned, for the title.
        call: The command or the call that makes this again.

    Raises:
        FormatError: The suffix is not .html.
        FileError: The page cannot be written.
        MissingExtraError: The extra ``capture`` is not installed.
    """
    require_page_path(path)
    first = next(iter(poses.values()))
    doubted = {own: pose for own, pose in poses.items() if _doubt(pose) > _LARGE_DOUBT}
    share = np.mean([pose.flagged.mean() for pose in poses.values()])
    remarks = [
        f"{own}: the head may be turned by {pose.figures['head']['doubt_degrees']:.1f}° otherwise."
        for own, pose in sorted(doubted.items(), key=lambda each: -_doubt(each[1]))[:_MOST]
    ]
    if len(doubted) > _MOST:
        remarks.append(f"So may those of {len(doubted) - _MOST:,} more; see the table.")
    facts = [
        ("Poses", f"{len(poses):,}"),
        ("Template", face_words(first)),
        ("Correspondence", ", ".join({pose.figures["correspondence"] for pose in poses.values()})),
    ]
    words = f"{counted(len(poses), 'pose')}, {100 * share:.0f}{SPACE}% of vertices flagged."
    shown = [list(poses)[round(k)] for k in np.linspace(0, len(poses) - 1, min(_MOST, len(poses)))]
    pictures = [
        Shown(
            own,
            front_picture(poses[own]),
            f"{own} from the front and from the side, painted with its confidence.",
            f"{own}: {100 * poses[own].flagged.mean():.0f}{SPACE}% of vertices flagged.",
        )
        for own in dict.fromkeys(shown)
    ]
    rows = [
        (
            own,
            [
                pose.figures["correspondence"],
                f"{pose.figures['surface_mean']:.3f}",
                f"{100 * pose.figures['shown']:.0f}",
                f"{100 * pose.figures['flagged']:.1f}",
                f"{_doubt(pose):.2f}",
            ],
        )
        for own, pose in poses.items()
    ]
    content = {"headline": words, "remarks": remarks, "facts": facts, "call": call}
    table = {"pictures": pictures, "rows": rows, "least": f"{FLAGGED:g}"}
    sections = [
        Section("captured", "What was registered", content),
        Section("registered", "Pose by pose", table),
    ]
    write_page(path, document(name, f"{counted(len(poses), 'pose')} from scans", sections))


def _doubt(pose: Registered) -> float:
    """About the place of a pose's head, in % of D on average."""
    return float(pose.figures.get("head", {}).get("doubt_mean", 0.0))


def capture_page(
    captured: Captured,
    *,
    name: str = "capture",
    unit: str = "",
    call: str = "",
    say: Callable[[str], None] = lambda _: None,
) -> str:
    """The page that `write_capture_report` writes; arguments and errors are the same."""
    trust = {
        pose: Trust.of(mesh, captured.cameras.get(pose, ()))
        for pose, mesh in captured.poses.items()
    }
    sections = [_captured(captured, trust, unit, call)]
    neutral = captured.poses.get(captured.neutral)
    if any(captured.cameras.values()):
        say("drawing cameras")
        sections.append(_cameras(captured, neutral))
    sections += [photographs_section(captured.figures), agreement(captured.figures)]
    if captured.poses:
        sections.append(_poses(captured, trust, say))
        sections.append(trust_section(captured.poses, trust))
    sections.append(times(captured.figures))
    taken = sum(map(len, captured.cameras.values()))
    found = counted(len(captured.poses), "pose") if captured.poses else "cameras alone"
    return document(name, f"{found} from {counted(taken, 'photograph')}", sections)


def _captured(captured: Captured, trust: Mapping[str, Trust], unit: str, call: str) -> Section:
    """What there is, and in one sentence how much of it is to be trusted."""
    figures = captured.figures.get("poses", {})
    given = sum(own.get("photographs", 0) for own in figures.values())
    used = sum(map(len, captured.cameras.values()))
    facts = [("Photographs", f"{used:,} used of {given:,}")]
    first, remarks = f"{counted(used, 'camera')} found; no poses were asked for.", []
    if captured.poses:
        neutral = captured.poses[captured.neutral]
        first, remarks = headline(trust), findings(trust)
        facts += [
            ("Poses", f"{', '.join(captured.poses)}; the neutral is {captured.neutral}"),
            ("Template", face_words(neutral)),
            ("Size", size_words(neutral.diameter, unit)),
        ]
    remarks += [
        f"{pose}: {remark}" for pose, own in figures.items() for remark in own.get("remarks", [])
    ]
    content = {"headline": first, "remarks": remarks, "facts": facts, "call": call}
    return Section("captured", "What was captured", content)


def _cameras(captured: Captured, head: Mesh | None) -> Section:
    """Where the cameras stood, in three views."""
    every = {pose: own for pose, own in captured.cameras.items() if own}
    colours = {}
    for place, pose in enumerate(every):
        share = place / max(len(every) - 1, 1)
        hue = _FIRST + (_LAST - _FIRST) * share
        red, green, blue = (round(255 * own) for own in hsv_to_rgb(hue, 0.85, 0.78))
        colours[pose] = (red, green, blue)
    words = {
        pose: f"{counted(len(own), 'camera')}, focal length "
        f"{_range(sorted({round(camera.focal) for camera in own}))}{SPACE}px"
        for pose, own in every.items()
    }
    alike = len(set(words.values())) == 1 < len(words)
    common = f" Every pose: {next(iter(words.values()))}." if alike else ""
    what = "the head of the neutral" if head is not None else "what they look at"
    picture = Shown(
        "Cameras around the head",
        camera_picture(every, colours, head),
        f"Three views of {counted(sum(map(len, every.values())), 'camera')} around {what}: from "
        "the front, from the side and from above.",
        "From the front, from the side and from above. Each pyramid is a photograph; its tip is "
        "where it was taken. What no pyramid looks at, such as the skin under the chin where none "
        f"is low enough, cannot be trusted.{common}",
    )
    poses = [
        {
            "name": pose,
            "colour": "#{:02x}{:02x}{:02x}".format(*colours[pose]),
            "words": "" if alike else words[pose],
        }
        for pose in every
    ]
    return Section("cameras", "Cameras", {"picture": picture, "poses": poses})


def _range(values: list[int]) -> str:
    low, high = values[0], values[-1]
    return f"{low:,}" if low == high else f"{low:,} to {high:,}"


def _one_of_each(captured: Captured) -> dict[str, Camera]:
    """A camera of each pose, all from about the same side, so that poses can be compared."""
    seen = {pose: captured.cameras.get(pose, ()) for pose in captured.poses}
    seen = {pose: cameras for pose, cameras in seen.items() if cameras}
    if not seen:
        return {}
    first = captured.neutral if captured.neutral in seen else next(iter(seen))
    front = frontal(seen[first], captured.poses[first])
    return {pose: beside(front, own, captured.poses[pose]) for pose, own in seen.items()}


def _poses(captured: Captured, trust: Mapping[str, Trust], say: Callable[[str], None]) -> Section:
    """Each pose through one of its cameras, with the template over it and its confidence."""
    pictures, left_out = [], []
    for pose, camera in _one_of_each(captured).items():
        say(f"drawing {pose}")
        try:
            image = pose_picture(
                captured.poses[pose], camera, captured.photographs[pose][camera.name]
            )
        except FileError as error:  # a report without one of its pictures is better than none
            left_out.append(f"{pose} is not shown: its photograph cannot be opened any more")
            say(str(error))
            continue
        own = trust[pose]
        counts = (
            f"{own.trusted:,} vertices are trusted, {own.doubtful:,} doubtful although cameras saw "
            f"them, {own.unseen:,} seen by no camera."
        )
        pictures.append(
            Shown(
                pose,
                image,
                f"{pose} in the photograph {camera.name}: as it was taken, with the edges of the "
                f"template over it, and the mesh painted with its confidence. {counts}",
                f"Photograph {camera.name}. {counts}",
            )
        )
    content = {"pictures": pictures, "left_out": left_out, "least": f"{FLAGGED:g}"}
    return Section("poses", "Pose by pose", content)
