"""An examination as text for people and as a document for machines."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from itertools import groupby
from pathlib import Path
from typing import Any

from elastomorph.doctor.checks.surface import SurfaceFacts
from elastomorph.doctor.findings import SEVERITIES, Examination, counted, percent
from elastomorph.doctor.repair import Repair
from elastomorph.holding.damage import Meeting

_FILES_SHOWN = 12
_MEETINGS_SHOWN = 30
_ENTRY = ("name", "severity", "file", "line", "vertices", "message", "remedy", "link")


def as_text(
    examination: Examination,
    repair: Repair | None = None,
    meetings: Sequence[Meeting] | None = None,
) -> str:
    """What a rigger reads: the gravest first, each kind once, one line a file.

    Below that, sliders that meet, if they were ranked.
    """
    targets = examination.targets
    and_targets = f" and {counted(targets, 'target', 'targets')}" if targets else ""
    lines = [f"{examination.neutral}{and_targets}"]
    if examination.facts is not None:
        lines += _fact_lines(examination.facts)
    if examination.symmetric is False:
        lines.append("  no plane of symmetry, so left and right targets were not compared")
    short = _short_names(examination)
    for (severity, _), group in groupby(examination.findings, key=lambda f: (f.severity, f.name)):
        found = list(group)
        lines += ["", f"{severity.upper()}  {found[0].title}  [{found[0].name}]"]
        width = min(28, max(len(short[f.file]) for f in found))
        for one in found[:_FILES_SHOWN]:
            place = f", line {one.line:,}" if one.line is not None else ""
            lines.append(f"  {short[one.file]:<{width}}  {one.message}{place}")
        lines += _more(len(found))
        lines.append(f"  → {found[0].remedy}  ({found[0].link})")
    counts = ((severity, examination.count(severity)) for severity in SEVERITIES)
    verdict = ", ".join(counted(count, one, f"{one}s") for one, count in counts if count)
    lines += ["", verdict or "nothing found: these files are one rig"]
    if repair is not None:
        lines += ["", *_repair_lines(repair)]
    if meetings is not None:
        lines += ["", *_meeting_lines(meetings)]
    return "\n".join(lines)


def as_document(
    examination: Examination,
    repair: Repair | None = None,
    meetings: Sequence[Meeting] | None = None,
) -> dict[str, Any]:
    """The same for machines; every vertex is listed."""
    facts = examination.facts
    return {
        "neutral": examination.neutral,
        "targets": list(examination.targets),
        "facts": facts
        and {
            **asdict(facts.counts),
            "borders": facts.borders,
            "poles_by_valence": facts.poles_by_valence,
        },
        "symmetric": examination.symmetric,
        "counts": {severity: examination.count(severity) for severity in SEVERITIES},
        "findings": [
            {name: getattr(found, name) for name in _ENTRY} | {"vertices": list(found.vertices)}
            for found in examination.findings
        ],
        "repair": repair
        and {
            "folder": repair.folder,
            "repaired": [{"file": file, "done": list(done)} for file, done in repair.repaired],
            "copied": list(repair.copied),
            "left_out": list(repair.left_out),
            "refused": [{"file": file, "why": why} for file, why in repair.refused],
        },
        "meetings": None if meetings is None else [asdict(meeting) for meeting in meetings],
    }


def _fact_lines(facts: SurfaceFacts) -> Iterator[str]:
    counts = facts.counts
    polygons = sum(counts.polygons.values())
    yield (
        f"  {counts.vertices:,} vertices, {polygons:,} polygons, "
        f"{counted(counts.components, 'piece', 'pieces')}, D = {counts.diameter:.6g}"
    )
    if not polygons:
        return
    valences = sorted(facts.poles_by_valence.items())
    usual = [f"{number:,} of valence {valence}" for valence, number in valences if valence <= 6]
    many = sum(number for valence, number in valences if valence > 6)
    if many:
        usual.append(f"{many:,} of 7 to {valences[-1][0]}")
    poles = f"poles: {', '.join(usual)}" if usual else "no poles"
    yield (
        f"  {counted(counts.border_edges, 'border edge', 'border edges')} in "
        f"{counted(facts.borders, 'border', 'borders')}; {poles}"
    )


def _repair_lines(repair: Repair) -> Iterator[str]:
    yield (
        f"{repair.folder}: {counted(repair.repaired, 'file', 'files')} repaired and read back, "
        f"{len(repair.copied):,} copied as they were"
    )
    for file, done in repair.repaired[:_FILES_SHOWN]:
        yield f"  {Path(file).name}: {', '.join(done)}"
    yield from _more(len(repair.repaired))
    for file, why in repair.refused:
        yield f"  {Path(file).name} was not written: {why}"
    if repair.left_out:
        names = ", ".join(Path(file).name for file in repair.left_out)
        yield f"  left out, as they could not be repaired: {names}"


def _meeting_lines(meetings: Sequence[Meeting]) -> Iterator[str]:
    if not meetings:
        yield "sliders that meet do no damage that is seen"
        return
    yield "sliders that meet, by the damage that is seen, the worst first"
    shown = meetings[:_MEETINGS_SHOWN]
    width = max(len(" + ".join(meeting.sliders)) for meeting in shown)
    for meeting in shown:
        line = f"  {' + '.join(meeting.sliders):<{width}}  at "
        line += ", ".join(f"{weight:.2g}" for weight in meeting.weights)
        line += f": {counted(meeting.folds, 'triangle folds', 'triangles fold')}"
        if meeting.depth:
            line += f", surfaces pass by {meeting.depth:.3g} ({percent(meeting.share)} of D)"
        if meeting.frames is not None:
            line += f"; {counted(meeting.frames, 'frame', 'frames')}"
            line += f", {meeting.per_frame:.2g} folded a frame"
        elif meeting.opposite:
            line += "; opposites"
        yield line
    yield from _more(len(meetings), _MEETINGS_SHOWN)


def _more(count: int, shown: int = _FILES_SHOWN) -> list[str]:
    left = count - shown
    return [f"  and {left} more; --json lists all"] if left > 0 else []


def _short_names(examination: Examination) -> dict[str, str]:
    """Names without folders, where that is clear."""
    files = [examination.neutral, *examination.targets]
    names = [Path(file).name for file in files]
    clear = len(set(names)) == len(names)
    return dict(zip(files, names if clear else files, strict=True))
