"""Paths of a rig by other methods, for a page to choose from, and settings that keep the choice.

For people who choose a method: what paths cost, and how far they are from the straight line.
"""

from __future__ import annotations

import json
import threading
from collections import OrderedDict
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any
from warnings import catch_warnings, simplefilter

import numpy as np
from numpy.typing import NDArray

from elastomorph.character import PathMaker, Settings
from elastomorph.character.document import parse_document
from elastomorph.character.editing import said_of, save_methods, with_methods
from elastomorph.character.read import settings_of
from elastomorph.character.template import ways_by_name
from elastomorph.errors import FormatError, ParameterError
from elastomorph.evaluation.target_paths import ROW
from elastomorph.io.atomic import is_file, read_bytes
from elastomorph.io.registry import read
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths import Method
from elastomorph.paths.through import LAWS
from elastomorph.rig import Rig
from elastomorph.rig.build import extent_of, with_paths
from elastomorph.viewer.listening import Offer, Sent, Work, model_file
from elastomorph.viewer.rig_scenes import rig_model
from elastomorph.viewer.scene import Scene

_TIMES = np.linspace(0.0, 1.0, 11)


@dataclass(frozen=True)
class PathFigures:
    """One path, in the unit of the vertices.

    Attributes:
        method: How it was made, with what ``auto`` chose.
        extra: Morph targets that it needs besides the target itself.
        bytes: What they add to a file that stores an index and three 32-bit numbers a moved vertex.
        largest: Largest distance from the straight line at the same time, over eleven times.
        mean: Mean distance from it, over the times and the vertices that the target moves.
        between: Largest and mean distance from the shapes on the way, where there are any.
    """

    method: str
    extra: int
    bytes: int
    largest: float
    mean: float
    between: tuple[float, float] | None


def path_figures(morph: Morph, shapes: Mapping[float, Mesh] | None = None) -> PathFigures:
    """Measure a path; shapes are in-betweens that were made for its target, by time."""
    moved: NDArray[np.bool_] = np.any(morph.delta, axis=1) | np.any(morph.bends, axis=(0, 2))
    off = _offsets(morph, moved)
    between = None
    if shapes:
        gaps = [
            np.linalg.norm(morph.at(time) - shape.vertices, axis=1)
            for time, shape in shapes.items()
        ]
        between = _largest(*gaps), _mean(np.array(gaps)[:, moved])
    text = morph.method if morph.choice is None else morph.choice.text
    rows = sum(int(bend.any(axis=1).sum()) for bend in morph.bends)
    return PathFigures(text, len(morph.bends), ROW * rows, _largest(off), _mean(off), between)


def _offsets(morph: Morph, moved: NDArray[np.bool_]) -> NDArray[np.float64]:
    """(T, M) distances of the moved vertices from the straight line."""
    found = np.zeros((len(_TIMES), int(moved.sum())))
    weights = np.array([curve(_TIMES) for curve in morph.bend_curves]).reshape(-1, len(_TIMES))
    bends = morph.bends[:, moved]
    for row, weight in zip(found, weights.T, strict=True):
        row[:] = np.linalg.norm(np.einsum("k,kvc->vc", weight, bends), axis=1)
    return found


def _largest(*distances: NDArray[np.float64]) -> float:
    return max((float(each.max(initial=0.0)) for each in distances), default=0.0)


def _mean(distances: NDArray[np.float64]) -> float:
    return float(distances.mean()) if distances.size else 0.0


Say = Callable[[str], None]
_MOST_KEPT = 24
_MOST_CHOICES = 10_000


@dataclass(frozen=True)
class Subject:
    """The rig that methods are chosen for, read when somebody looks.

    Attributes:
        rig: Reads it with its paths.
        stored: Reads it with the paths of its file alone, whatever settings say.
        scene: What the page shows of a rig.
        settings: What its paths follow, and where choices are kept; None for a file by itself.
    """

    rig: Callable[[Say], Rig]
    stored: Callable[[Say], Rig]
    scene: Callable[[Rig], Scene]
    settings: Settings | None


class MethodBench:
    """Makes the paths that a page asks for, one at a time, and writes what it chose.

    Args:
        subject: The rig.
        shelf: Where the page finds models.
    """

    def __init__(self, subject: Subject, shelf: dict[str, Offer]) -> None:
        self._subject, self._shelf = subject, shelf
        self._settings = subject.settings
        self._lock = threading.Lock()
        self._rig: Rig | None = None
        self._stored: Rig | None = None
        self._maker: PathMaker | None = None
        self._shapes: dict[str, dict[float, Mesh]] = {}  # in-betweens of the settings
        self._named: dict[str, dict[float, Mesh]] = {}  # targets that are some by their names
        self._made: OrderedDict[tuple[str, str, str], Morph] = OrderedDict()
        self._number = 0

    def services(self) -> dict[str, Work]:
        """What the page may ask for."""
        methods = {"methods": Work(self._answer)}
        return methods if self._settings is None else {**methods, "save": Work(self._save)}

    def _answer(self, sent: Sent, say: Say) -> Mapping[str, Any]:
        asked = _object(sent)
        with self._lock:
            rig = self._whole(say)
            if "target" not in asked:
                return {"rows": self._rows(rig, rig.targets, say), "methods": Method.texts()}
            target, method = _text(asked, "target"), _text(asked, "method")
            rig.sliders.require(target, tuple(rig.targets))
            say(f"{target}: {method or 'as without a choice'}")
            with catch_warnings(record=True) as warned:
                simplefilter("always")
                morph = self._path(rig, target, method, say)
            say(f"{target}: {morph.method}, packing it")
            # The page shows it with the looks of the face that it has already.
            bare = replace(rig.neutral, appearance=None)
            model = rig_model(Rig(bare, {target: replace(morph, neutral=bare)}), method, "method")
            told = list(dict.fromkeys(str(each.message) for each in warned))
            row = self._row(target, morph)
            return {"row": row, "glb": self._shelved(model.glb), "warnings": told}

    def _save(self, sent: Sent, say: Say) -> Mapping[str, Any]:
        asked = _object(sent)
        choices, known = _texts(asked, "choices"), _texts(asked, "known")
        with self._lock:
            rig, before = self._whole(say), self._settings
            if before is None:
                raise ParameterError("there are no settings to keep a choice in")
            for name in choices:
                rig.sliders.require(name, tuple(rig.targets))
            say(f"writing {before.path.name}")
            after = self._own(save_methods(before.path, choices, known))
            changed = _changed(before, after, rig.targets)
            if (before.regions, before.character.curves) != (after.regions, after.character.curves):
                self._maker = None
            self._settings = after
            morphs = {
                name: self._kept(rig, name, after, say) if name in changed else rig[name]
                for name in rig.targets
            }
            sliders, maker = rig.sliders, self._made_by(rig, after)
            self._rig = maker.rig(rig, morphs, sliders.correctives, sliders.groups, say)
            say("packing the face")
            scene = self._subject.scene(self._rig)
            self._shelf["model-0.glb"] = model_file(scene.models[0].glb)
            rows = self._rows(self._rig, {*changed, *choices}, say)
            return {"rows": rows, "glb": "model-0.glb", "file": str(after.path)}

    def _whole(self, say: Say) -> Rig:
        if self._rig is None:
            self._rig = self._subject.rig(say)
            self._named = ways_by_name(self._rig.targets)
        return self._rig

    def _rows(self, rig: Rig, names: Iterable[str], say: Say) -> list[dict[str, Any]]:
        wanted = set(names)
        found: list[dict[str, Any]] = []
        for name, morph in rig.morphs.items():
            if name in wanted:
                say(f"measuring {name}, {len(found) + 1} of {len(wanted)}")
                found.append(self._row(name, morph))
        return found

    def _row(self, target: str, morph: Morph) -> dict[str, Any]:
        settings = self._settings
        said = "" if settings is None else said_of(settings, target)
        between = None if settings is None else settings.inbetweens.get(target)
        if settings is not None and between is not None and target not in self._shapes:
            own = between.files.items()
            self._shapes[target] = {time: read(settings.file(file)) for time, file in own}
        on_the_way = self._shapes.get(target, self._named.get(target))
        figures = path_figures(morph, on_the_way)
        laws = [] if between is None else list(LAWS)
        return {"name": target, "said": said, "laws": laws, **asdict(figures)}

    def _path(self, rig: Rig, target: str, method: str, say: Say) -> Morph:
        """The path by another method, exactly as it would be once the choice is saved."""
        settings = self._settings
        if settings is None:
            if not method and not (own := self._as_stored(say).morphs[target]).bare:
                return own
            chosen = Method.of(method) if method else Method()
            extent = extent_of(rig) if "extent" in chosen.inputs() else None
            return with_paths(rig, chosen, names=[target], extent=extent).morphs[target]
        path = settings.path
        raw = read_bytes(path) if is_file(path) else b""
        if target in settings.inbetweens and method and method not in LAWS:
            raise FormatError(
                path,
                f"{target} has in-betweens, which its path passes through: choose "
                f"{', '.join(LAWS)}, or take [inbetweens.{target}] out of the file first",
            )
        edited = with_methods(path, raw, {target: method})
        return self._kept(rig, target, self._own(settings_of(parse_document(path, edited))), say)

    def _kept(self, rig: Rig, target: str, settings: Settings, say: Say) -> Morph:
        """The path that settings give to a target, made at most once."""
        choice = repr((settings.choice_for(target), settings.inbetweens.get(target)))
        key = (target, choice, repr((settings.regions, settings.character)))
        if key not in self._made:
            own = self._as_stored(say).morphs[target] if settings.character.rig else None
            maker = self._made_by(rig, settings)
            self._made[key] = maker.path(target, rig.morphs[target].target, own=own)
            if len(self._made) > _MOST_KEPT:
                self._made.popitem(last=False)
        self._made.move_to_end(key)
        return self._made[key]

    def _made_by(self, rig: Rig, settings: Settings) -> PathMaker:
        if self._maker is None:
            self._maker = PathMaker(settings, rig.neutral, rig)
        return self._maker.with_settings(settings)

    def _as_stored(self, say: Say) -> Rig:
        if self._stored is None:
            self._stored = self._subject.stored(say)
        return self._stored

    def _own(self, settings: Settings) -> Settings:
        """Settings as they are now on the disk, of the files that this command was given."""
        character = self._subject.settings.character if self._subject.settings else None
        return replace(settings, character=character or settings.character)

    def _shelved(self, glb: bytes) -> str:
        """The address of a model; the oldest of many is forgotten."""
        self._number += 1
        self._shelf.pop(f"method-{self._number - _MOST_KEPT}.glb", None)
        name = f"method-{self._number}.glb"
        self._shelf[name] = model_file(glb)
        return name


def _changed(before: Settings, after: Settings, names: Iterable[str]) -> list[str]:
    """The targets whose paths differ between two settings."""
    if before.regions != after.regions or before.character != after.character:
        return list(names)
    return [
        name
        for name in names
        if before.choice_for(name) != after.choice_for(name)
        or before.inbetweens.get(name) != after.inbetweens.get(name)
    ]


def _object(sent: Sent) -> dict[str, Any]:
    try:
        asked = json.loads(sent.read())
    except (ValueError, RecursionError):
        asked = None
    if not isinstance(asked, dict):
        raise ParameterError("what the page asked for is no JSON object; reload the page")
    return asked


def _text(asked: Mapping[str, Any], name: str) -> str:
    value = asked.get(name)
    if not isinstance(value, str):
        raise ParameterError(f"what the page asked for has no text {name!r}; reload the page")
    return value


def _texts(asked: Mapping[str, Any], name: str) -> dict[str, str]:
    value = asked.get(name)
    texts = isinstance(value, dict) and all(isinstance(each, str) for each in value.values())
    if not isinstance(value, dict) or not texts or len(value) > _MOST_CHOICES:
        raise ParameterError(f"what the page asked for has no texts {name!r}; reload the page")
    return value
