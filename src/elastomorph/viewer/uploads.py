"""Files that a page was given, opened by the command that shows it: read as any others, then gone.

They arrive as one stream: a line of JSON with their names and sizes, then their bytes one after
another. They are written into a folder of their own, under names of their own making: nothing of
what is sent decides what else is written or read on this machine.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import threading
from collections.abc import Callable, Mapping
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import Any

from elastomorph.character import find_settings, read_settings, rig_from_settings
from elastomorph.character.build import find_sources
from elastomorph.errors import ElastomorphError, FileError, FormatError, ParameterError
from elastomorph.io.registry import MESH_FORMATS, RIG_FORMATS, known_suffixes
from elastomorph.rig import Rig
from elastomorph.viewer.file_scenes import FaceFile, read_scene
from elastomorph.viewer.listening import Offer, Sent, Work, model_file
from elastomorph.viewer.methods import MethodBench, Subject
from elastomorph.viewer.scene import Scene

Say = Callable[[str], None]
MOST_BYTES = 2 << 30
MOST_FILES = 2_000
_MOST_HEAD = 1 << 20
_MOST_NAME = 150
_DEEPEST = 6
_BLOCK = 1 << 20
_MOST_SCENES = 3
_SPARE = 256 << 20  # bytes of the disk that are left free
_NOT_IN_NAMES = re.compile(r'[\x00-\x1f\x7f<>:"|?*\\]')
_RIGS = tuple(s for s in known_suffixes(RIG_FORMATS) if s not in known_suffixes(MESH_FORMATS))


class Uploads:
    """Opens what pages send; the models that they are shown are put on a shelf."""

    def __init__(self, shelf: dict[str, Offer]) -> None:
        self._shelf = shelf
        self._lock = threading.Lock()
        self._number = 0

    def service(self) -> Work:
        """What takes the files; the page gets the scene as one it begins with."""
        return Work(self._open, MOST_BYTES + _MOST_HEAD)

    def _open(self, sent: Sent, say: Say) -> Mapping[str, Any]:
        with self._lock, TemporaryDirectory(prefix="elastomorph-") as folder:
            root = Path(folder).resolve() / "face"  # what a face of loose files is called
            root.mkdir()
            try:
                files = _listed(sent)
                _store(sent, files, root, say)
                scene, services = self._scene(_meant(root, list(files)), root, say)
            except ElastomorphError as error:
                # Where the files lay for a moment is nobody's business.
                words = str(error).replace(f"{root}{os.sep}", "")
                words = words.replace(str(root), "what was opened")
                raise ParameterError(words) from None
            return {"scene": self._shelved(scene, services)}

    def _scene(self, path: Path, root: Path, say: Say) -> tuple[Scene, Mapping[str, Work]]:
        face = _face(path, root, say)
        scene = read_scene([face], say=say)
        if face.shown_as_it_is() is not None:
            return scene, {}
        rig = face.rig
        subject = Subject(lambda _: rig, lambda _: rig, lambda _: scene, None)
        return scene, MethodBench(subject, self._shelf).services()

    def _shelved(self, scene: Scene, services: Mapping[str, Work]) -> dict[str, Any]:
        self._number += 1
        forgotten = f"opened-{self._number - _MOST_SCENES}/"
        for name in [name for name in list(self._shelf) if name.startswith(forgotten)]:
            del self._shelf[name]
        place = f"opened-{self._number}/"
        addresses = [f"{place}model-{number}.glb" for number in range(len(scene.models))]
        for address, model in zip(addresses, scene.models, strict=True):
            self._shelf[address] = model_file(model.glb)
        self._shelf |= {place + name: service for name, service in services.items()}
        own = {"open": "open", **{name: place + name for name in services}}
        found: dict[str, Any] = json.loads(scene.to_json(addresses, own))
        return found


def _face(path: Path, root: Path, say: Say) -> FaceFile:
    """The face in what was sent; nothing of it is kept, for its place will be another's."""
    settings = find_settings(path) if path.is_dir() else None
    if settings is None:
        return FaceFile.of(str(path), say, **({"cache": None} if path.is_dir() else {}))
    found = read_settings(settings)
    for file in find_sources(found).all:
        if not file.resolve().is_relative_to(root):
            raise FormatError(
                settings,
                f"it names {file.name}, which is not among the files that were opened; open the "
                "folder that holds them all, or run 'elastomorph view' with it",
            )

    def follow(stored: Rig | None) -> Rig:
        return rig_from_settings(found, cache=None, say=say, stored=stored)

    return FaceFile.by_settings(str(path), found, follow)


def _listed(sent: Sent) -> dict[PurePosixPath, int]:
    """The sizes of the files that are sent, under names that are safe here."""
    head = sent.line(_MOST_HEAD)
    try:
        stated = [(str(name), int(size)) for name, size in json.loads(head)["files"]]
    except (ValueError, TypeError, LookupError, RecursionError):
        stated = []
    sizes = {_safe(name): size for name, size in stated}
    whole = head.endswith(b"\n") and len(sizes) == len(stated)
    if not sizes or not whole or min(sizes.values()) < 0:
        raise ParameterError(
            "what was sent does not begin with a list of files, each name once; reload the page"
        )
    if len(sizes) > MOST_FILES:
        raise ParameterError(
            f"{len(sizes):,} files are more than the {MOST_FILES:,} that a page may send; open the "
            "folder of one character, or run 'elastomorph view' with it"
        )
    if sum(sizes.values()) != sent.left:
        raise ParameterError("the files that were sent are of other sizes than they say; try again")
    return sizes


def _safe(name: str) -> PurePosixPath:
    """A name within a folder of ours; one that leads out of it is refused."""
    parts = name.split("/")
    if any(part in ("", ".", "..") for part in parts) or len(parts) > _DEEPEST:
        raise ParameterError(f"{name[:_MOST_NAME]!r} is no name of a file in a folder; rename it")
    made = [_NOT_IN_NAMES.sub("_", part) for part in parts]
    if any(len(part.encode(errors="replace")) > _MOST_NAME for part in made):
        raise ParameterError(f"{name[:_MOST_NAME]!r}… is too long a name for a file; rename it")
    return PurePosixPath(*made)


def _store(sent: Sent, files: Mapping[PurePosixPath, int], root: Path, say: Say) -> None:
    total = sum(files.values())
    free = shutil.disk_usage(root).free
    if total + _SPARE > free:
        raise ParameterError(
            f"the files are {total / 1e6:,.0f} MB, and where temporary files go only "
            f"{free / 1e6:,.0f} MB are free; make room, or run 'elastomorph view' with them"
        )
    taken: set[str] = set()
    for number, (name, size) in enumerate(files.items(), start=1):
        if str(name).casefold() in taken:
            raise ParameterError(f"two files are called {name}; rename one of them")
        taken.add(str(name).casefold())
        say(f"receiving {name.name}, {number} of {len(files)}")
        try:
            place = root / name
            place.parent.mkdir(parents=True, exist_ok=True)
            with place.open("xb") as file:
                for start in range(0, size, _BLOCK):
                    block = sent.block(min(_BLOCK, size - start))
                    if not block:
                        raise ParameterError("the files that were sent ended early; try again")
                    file.write(block)
        except OSError as error:
            raise FileError(place, f"cannot be stored: {error.strerror}") from None


def _meant(root: Path, names: list[PurePosixPath]) -> Path:
    """The file or folder to open: a rig file, else the folder that all meshes are in."""
    tops = {name.parts[0] for name in names}
    place = root / tops.pop() if len(tops) == 1 else root
    if place.is_file():
        return place
    files = [file for file in sorted(place.iterdir()) if file.is_file()]
    meshes = [file for file in files if file.suffix.lower() in known_suffixes(MESH_FORMATS)]
    rigs = [file for file in files if file.suffix.lower() in _RIGS]
    if not meshes and len(rigs) > 1:
        raise ParameterError(
            f"there are several rigs: {', '.join(file.name for file in rigs[:5])}; open one of "
            "them, with the files that it needs"
        )
    return rigs[0] if rigs and not meshes else place
