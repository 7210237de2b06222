"""What to do with each target of a rig: the answer that a report begins with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import tomlkit

from elastomorph.draw.framing import camera_for
from elastomorph.draw.pictures import heat_colours
from elastomorph.draw.stage import Stage
from elastomorph.evaluation.target_paths import TargetPath, TargetPaths
from elastomorph.evaluation.words import SPACE, Lengths, counted, listed, percent
from elastomorph.model.morph import Morph
from elastomorph.paths.auto import INBETWEEN_PAYS
from elastomorph.report.document import Section
from elastomorph.report.images import Picture
from elastomorph.report.subject import Subject

__all__ = ["TargetPictures", "advice", "targets_table"]

_SIDES = (168, 210)
_MOST_SHOWN = 24
"""Of a group; more of them are a click away."""


class TargetPictures:
    """Draws each target once its path is known, coloured by how far that is off the straight line.

    Use as a context manager.
    """

    def __init__(self, subject: Subject) -> None:
        neutral = subject.neutral
        self.drawn: dict[str, Picture] = {}
        self._extent = 0.0
        if len(neutral.faces):
            poses = np.stack([neutral.vertices, subject.targets[subject.jaw].vertices])
            camera = camera_for(neutral, poses=poses, head=subject.head, size=_SIDES)
            self._stage: Stage | None = Stage(neutral, camera, size=_SIDES)
        else:
            self._stage = None

    def draw(self, name: str, morph: Morph, extent: float) -> None:
        """Draw a target; ``extent`` is the D of its colours."""
        if self._stage is None:
            return
        colours, words = None, f"{name}, for which the straight line is enough."
        if len(morph.bends):
            middle = morph.neutral.vertices + 0.5 * morph.delta
            away = np.linalg.norm(morph.at(0.5) - middle, axis=1) / (extent or 1.0)
            colours = heat_colours(away, INBETWEEN_PAYS)
            most = percent(float(away.max()))
            words = f"{name}, darkest where halfway the bent path is {most} off the straight line."
        image = self._stage.picture(morph.target.vertices, colours=colours)
        self.drawn[name] = Picture(name, image, words, "")

    def __enter__(self) -> TargetPictures:
        if self._stage is not None:
            self._stage.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        if self._stage is not None:
            self._stage.__exit__(*error)


@dataclass(frozen=True)
class _Group:
    """Targets with one verdict."""

    title: str
    why: str
    targets: Sequence[TargetPath]
    folded: bool = False
    then: str = ""  # What to do next, below the pictures


def advice(paths: TargetPaths, pictures: Mapping[str, Picture], subject: Subject) -> Section:
    """The first section: in a sentence, then group by group with a picture of each target."""
    empty = [target for target in paths.targets if target.empty]
    pays = [target for target in paths.targets if target.inbetween_pays]
    bend = [t for t in paths.targets if not t.choice.straight and not t.inbetween_pays]
    keep = [t for t in paths.targets if t.choice.straight and not t.inbetween_pays and not t.empty]
    # A share tells more than a length in a unit that nobody knows.
    lengths = Lengths(paths.extent or None if subject.unit else None, subject.unit)
    groups = [
        _Group(
            f"Bend, and sculpt an in-between: {len(pays)}",
            f"Halfway the bent path is more than {lengths(INBETWEEN_PAYS)} off the straight line, "
            "or polygons turn over. Only a shape sculpted or scanned there can say which is right.",
            pays,
            then=_sculpted(pays),
        ),
        _Group(f"Bend: {len(bend)}", "The path turns what turns. Nothing to sculpt.", bend),
        _Group(f"Keep straight: {len(keep)}", "A bend would change nothing one sees.", keep, True),
        _Group(f"Empty: {len(empty)}", "They move nothing: sculpt or remove them.", empty, True),
    ]
    coloured = any(target.bends and target.name in pictures for target in paths.targets)
    content = {
        "headline": _headline(len(pays), len(bend), len(keep), len(empty)),
        "cost": _cost(paths),
        "command": subject.command if any(target.bends for target in paths.targets) else "",
        "groups": [_shown(group, pictures, lengths) for group in groups if group.targets],
        "scale": f"{lengths.plain(INBETWEEN_PAYS)} and more" if coloured else "",
        "colours": "How far at t = 0.5 the bent path is off the straight line; below each picture "
        "the most. D is the extent of all that the targets move.",
    }
    return Section("advice", "What to do with each target", content)


def _sculpted(pays: Sequence[TargetPath]) -> str:
    """How an in-between comes into the rig."""
    key = tomlkit.key(pays[0].name).as_string() if pays else ""
    return (
        f"Name what you sculpt in elastomorph.toml, under [inbetweens.{key}] and the like, and the "
        "paths go through it."
    )


def _headline(pays: int, bend: int, keep: int, empty: int) -> str:
    said = []
    if pays + bend:
        said.append(f"bend {counted(pays + bend, 'target')}")
    if pays:
        which = "it" if pays + bend == 1 else f"{pays} of them"
        said.append(f"sculpt an in-between for {which}")
    if keep:
        every = f"{'all ' if keep > 1 else ''}{counted(keep, 'target')}"
        said.append(f"keep {keep if said else every} straight")
    text = listed(said) if said else "" if empty else "there are no targets"
    if empty:
        moving = f"{counted(empty, 'target')} {'moves' if empty == 1 else 'move'} nothing"
        text = f"{text}; {moving}" if text else moving
    return f"{text[0].upper()}{text[1:]}."


def _cost(paths: TargetPaths) -> str:
    bends = sum(target.bends for target in paths.targets)
    if not bends:
        return "The rig stays as it is."
    size = sum(target.bytes for target in paths.targets) / 1e6
    return (
        f"All bends together cost {counted(bends, 'more morph target')}, {size:.2g}{SPACE}MB; end "
        "shapes and sliders stay what they are. This writes them:"
    )


def _shown(group: _Group, pictures: Mapping[str, Picture], lengths: Lengths) -> dict[str, Any]:
    cards = [
        {
            "name": target.name,
            "words": "" if group.folded else _words(target, lengths),
            "picture": pictures.get(target.name),
        }
        for target in group.targets
    ]
    first = 0 if group.folded else _MOST_SHOWN
    return {
        "title": group.title,
        "why": group.why,
        "then": group.then,
        "shown": cards[:first],
        "folded": cards[first:],
        "folded_words": "Show them" if group.folded else f"{len(cards) - first} more",
    }


def _words(target: TargetPath, lengths: Lengths) -> str:
    """Such as "0.13 cm, +2 targets"."""
    said = [lengths.plain(target.choice.distance)]
    if target.bends:
        said.append(f"+{counted(target.bends, 'target')}")
    if target.flips:
        said.append(f"{counted(target.flips, 'polygon')} turned over")
    return ", ".join(said)


def targets_table(paths: TargetPaths, unit: str) -> Section:
    """The numbers behind the advice, a row a target."""
    allowed = max((target.choice.allowed for target in paths.targets), default=0.0)
    content = {
        "allowed": f"{100 * allowed:g}",
        "pays": f"{100 * INBETWEEN_PAYS:g}",
        "extent": Lengths(paths.extent or None, unit).plain(1.0),
        "targets": paths.targets,
    }
    return Section("targets", "Each target in numbers", content, appendix=True)
