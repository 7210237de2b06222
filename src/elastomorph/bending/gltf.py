"""A character goes in and comes out whole, with its paths bent; and back again.

Its clips play bent: a channel of weights gets a sampler of its own with all weights, for others may
use the one it had and its accessors too. Where KHR_animation_pointer moves one weight alone, the
weights of its bends get channels of their own.

What that made useless gives its place to what was added. A clip that plays bent has other keys, and
nothing uses those it had: a sampler, accessors of its keys, views of these, and a buffer that held
nothing else. Left where they are, every validator would remark on them. Their bytes stay, and the
record that undoes a bend gives them their places back.
"""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.bending.curves import write_curves
from elastomorph.bending.face import Face
from elastomorph.bending.files import (
    Character,
    name_beside,
    referred,
    require_output,
    write_character,
)
from elastomorph.bending.keys import Columns, Driven, Keys, bent_keys
from elastomorph.bending.meshes import (
    Additions,
    MeshEdit,
    NormalBends,
    Packing,
    data_uri,
    spaces_of,
)
from elastomorph.bending.plan import BentMorph, Plan, make_plan, not_bare, plan_as_is
from elastomorph.bending.report import BendReport, BentTarget
from elastomorph.bending.undo import record
from elastomorph.errors import FileError, FormatError, ParameterError
from elastomorph.io.atomic import size_of
from elastomorph.io.gltf.accessors import DTYPES, read_floats
from elastomorph.io.gltf.clips import POINTER, MovedWeights, moved_weights, read_channel
from elastomorph.io.gltf.container import GltfFile, open_gltf
from elastomorph.io.gltf.meshopt import EXTENSIONS, require_meshopt
from elastomorph.io.gltf.nodes import placed_meshes
from elastomorph.io.gltf.reader import read_meshes, rig_of
from elastomorph.io.gltf.vrm import overrides_note, overrides_of
from elastomorph.io.untrusted import naming_file
from elastomorph.numbers import as_number
from elastomorph.paths import Method
from elastomorph.rig import Rig
from elastomorph.rig.pairs import is_pair_bend

Places = Iterator[tuple[dict[str, Any], str]]
"""Each object and key whose value is a number of one kind."""


def fill_gaps(before: dict[str, Any], after: dict[str, Any]) -> None:
    """Move the last of what was added to where only something was that nothing uses any more."""
    clips = zip(_objects(before, "animations"), _objects(after, "animations"), strict=True)
    for was, now in clips:
        _fill(was, now, "samplers", _samplers(was), _samplers(now))
    _fill(before, after, "accessors", _accessor_places(before), _accessor_places(after))
    for key, place in (("bufferViews", "bufferView"), ("buffers", "buffer")):
        _fill(before, after, key, _places(before, place), _places(after, place))


def _fill(
    before: dict[str, Any], after: dict[str, Any], key: str, had: Places, has: Places
) -> None:
    was, now = before.get(key), after.get(key)
    if not isinstance(was, list) or not isinstance(now, list):
        return
    users: dict[int, list[tuple[dict[str, Any], str]]] = {}
    for holder, place in has:
        users.setdefault(holder[place], []).append((holder, place))
    gaps = {holder[place] for holder, place in had} - users.keys()
    for gap in sorted(gaps.intersection(range(len(was)))):
        if len(now) == len(was):
            return
        now[gap] = now.pop()
        for holder, place in users.pop(len(now), []):
            holder[place] = gap


def _samplers(animation: dict[str, Any]) -> Places:
    for channel in _objects(animation, "channels"):
        yield from _numbers(channel, "sampler")


def _accessor_places(document: dict[str, Any]) -> Places:
    """Where accessors are named; as attributes by extensions too."""
    for animation in _objects(document, "animations"):
        for sampler in _objects(animation, "samplers"):
            yield from _numbers(sampler, "input", "output")
    for skin in _objects(document, "skins"):
        yield from _numbers(skin, "inverseBindMatrices")
    for mesh in _objects(document, "meshes"):
        for primitive in _objects(mesh, "primitives"):
            yield from _numbers(primitive, "indices")
            for target in _objects(primitive, "targets"):
                yield from _numbers(target, *target)
    for holder in _everywhere(document):
        if isinstance(attributes := holder.get("attributes"), dict):
            yield from _numbers(attributes, *attributes)


def _places(document: dict[str, Any], key: str) -> Places:
    """Where buffer views or buffers are named, by extensions too."""
    for holder in _everywhere(document):
        yield from _numbers(holder, key)


def _numbers(holder: dict[str, Any], *keys: str) -> Places:
    return ((holder, key) for key in keys if type(holder.get(key)) is int)


def _objects(holder: dict[str, Any], key: str) -> list[dict[str, Any]]:
    own = holder.get(key)
    return [each for each in own if isinstance(each, dict)] if isinstance(own, list) else []


def _everywhere(value: Any) -> Iterator[dict[str, Any]]:
    """All objects of a document, but those in extras."""
    if isinstance(value, dict):
        yield value
        for key, own in value.items():
            if key != "extras":
                yield from _everywhere(own)
    elif isinstance(value, list):
        for own in value:
            yield from _everywhere(own)


class ClipEdit:
    """The animations of a document that weights of bends are added to.

    Args:
        file: The file.
        document: The document that is changed.
        additions: What is added to it.
        columns: How the weights of each mesh that got bends are extended.
        tolerance: How far a vertex may be from its path between keys, as a fraction of D.

    Attributes:
        clips: How many animations play bent.
        added_keys: How many keys were added to them.
        error: How far a vertex may be from its path between keys, as a fraction of D.
    """

    def __init__(
        self,
        file: GltfFile,
        document: dict[str, Any],
        additions: Additions,
        columns: Mapping[int, Columns],
        tolerance: float,
    ) -> None:
        self._file, self._document, self._additions = file, document, additions
        self._columns, self._tolerance = columns, tolerance
        self._inputs: dict[tuple[int, bytes], int] = {}
        self.clips = 0
        self.added_keys = 0
        self.error = 0.0

    def extend(self) -> None:
        """Extend every channel of weights."""
        for number in range(len(self._file.items("animations"))):
            self._file.item("animations", number, "the document")
            animation = self._document["animations"][number]
            of = f"animation {number}"
            made: dict[tuple[int, MovedWeights], list[int]] = {}
            single: dict[int, dict[int, dict[str, Any]]] = {}
            for channel in list(self._file.list_in(animation, "channels", of)):
                if not isinstance(channel, dict):
                    self._file.refuse(f"a channel of {of} is no object")
                moved = self._moved(channel, of)
                if moved is not None and moved.mesh in self._columns:
                    if moved.weight is not None:
                        own = single.setdefault(moved.mesh, {})
                        own.setdefault(moved.weight, copy.deepcopy(channel))
                    self._extend(animation, channel, moved, made, of)
            joined = [self._join(animation, mesh, own, of) for mesh, own in single.items()]
            self.clips += bool(made) or any(joined)

    def _moved(self, channel: dict[str, Any], of: str) -> MovedWeights | None:
        """The weights that a channel moves, None where it moves something else."""
        moved = moved_weights(self._file, channel, of)
        columns = None if moved is None else self._columns.get(moved.mesh)
        if moved is None or moved.weight is None or columns is None:
            return moved
        if moved.weight >= columns.count:
            self._file.refuse(
                f"{of} moves weight {moved.weight} of mesh {moved.mesh}, which has "
                f"{columns.count} morph targets; take out that channel, or export it again"
            )
        return moved

    def _extend(
        self,
        animation: dict[str, Any],
        channel: dict[str, Any],
        moved: MovedWeights,
        made: dict[tuple[int, MovedWeights], list[int]],
        of: str,
    ) -> None:
        samplers = self._file.list_in(animation, "samplers", of)
        number = channel.get("sampler")
        if type(number) is not int or number not in range(len(samplers)):
            self._file.refuse(f"a channel of {of} names a sampler that it does not have")
        columns = self._columns[moved.mesh]
        followers = list(range(columns.count, columns.count + len(columns.bends)))
        if moved.weight is not None:
            followers = [
                columns.count + k
                for k, (driver, _, _) in enumerate(columns.bends)
                if driver == moved.weight
            ]
            columns = _of_one(columns, moved.weight)
            if not columns.followers:
                return
        key = (number, moved)
        if key not in made:
            keys, times = self._keys(samplers[number], columns, of)
            parts = [keys.stored(keys.values)]
            if moved.weight is not None:  # its own first, which moves as before unless it is folded
                parts = np.split(parts[0], parts[0].shape[-1], axis=-1)
                parts = parts if columns.folds else parts[1:]
            made[key] = self._samplers(samplers, samplers[number], keys.times, times, parts)
        if moved.weight is None:
            channel["sampler"] = made[key][0]
            return
        if columns.folds:
            channel["sampler"] = made[key][0]
        for follower, sampler in zip(followers, made[key][bool(columns.folds) :], strict=True):
            added = copy.deepcopy(channel) | {"sampler": sampler}
            place = added["target"]["extensions"][POINTER]
            place["pointer"] = f"{place['pointer'].rpartition('/')[0]}/{follower}"
            animation["channels"].append(added)

    def _join(
        self, animation: dict[str, Any], mesh: int, single: dict[int, dict[str, Any]], of: str
    ) -> bool:
        """Add channels of what follows several sliders that channels move one by one."""
        samplers, columns = animation["samplers"], self._columns[mesh]
        found = False
        for place, (driver, curve, size) in enumerate(columns.bends, start=columns.count):
            if isinstance(driver, int) or single.keys().isdisjoint(driver.columns):
                continue
            moved = {
                column: read_channel(self._file, samplers, single[column], [str(column)], of)
                for column in driver.columns
                if column in single
            }
            first = single[next(iter(moved))]
            when = np.concatenate([own.moments() for own in moved.values()])
            times = np.unique(np.maximum(when, 0.0).astype(np.float32)).astype(np.float64)
            rest = self._at_rest(mesh, first, columns.count)
            given = np.tile(rest[list(driver.columns)], (len(times), 1))
            for number, column in enumerate(driver.columns):
                if column in moved:
                    given[:, number] = moved[column].at(times)[:, 0]
            law = Driven(tuple(range(len(driver.columns))), driver.law)
            alone = Columns(len(driver.columns), ((law, curve, size),), {})
            keys = bent_keys(times, given, "LINEAR", alone, self._tolerance)
            self.error = max(self.error, keys.error)
            self.added_keys += len(keys.times) - len(times)
            source = samplers[first["sampler"]]
            number = self._input(source["input"], keys.times.astype(np.float32))
            values = keys.stored(keys.values[:, -1])
            output = self._additions.keys(values, self._view(source["output"]))
            samplers.append({"input": number, "output": output, "interpolation": "LINEAR"})
            added = copy.deepcopy(first) | {"sampler": len(samplers) - 1}
            target = added["target"]["extensions"][POINTER]
            target["pointer"] = f"{target['pointer'].rpartition('/')[0]}/{place}"
            animation["channels"].append(added)
            found = True
        return found

    def _at_rest(self, mesh: int, channel: dict[str, Any], count: int) -> NDArray[np.float64]:
        """(count,) weights that a mesh has where no channel moves them."""
        _, kind, number, *_ = channel["target"]["extensions"][POINTER]["pointer"].split("/")
        holders = [self._file.item("meshes", mesh, "a channel")]
        if kind == "nodes":
            holders.insert(0, self._file.item("nodes", int(number), "a channel"))
        given = next((own["weights"] for own in holders if "weights" in own), None)
        return np.zeros(count) if given is None else np.array(given, dtype=np.float64)

    def _keys(self, sampler: Any, columns: Columns, of: str) -> tuple[Keys, NDArray[np.float64]]:
        """The keys of all weights, and the times of those of the source."""
        file, what = self._file, f"the keys of {of}"
        if not isinstance(sampler, dict):
            file.refuse(f"a sampler of {of} is no object")
        times = read_floats(file, sampler.get("input"), 1, what)[:, 0]
        kind = sampler.get("interpolation", "LINEAR")
        rows = 3 if kind == "CUBICSPLINE" else 1
        count = len(times) * rows * columns.count
        values = read_floats(file, sampler.get("output"), 1, what, count=count)
        shape = (len(times), *([3] if rows == 3 else []), columns.count)
        stored = DTYPES[file.item("accessors", sampler["output"], what)["componentType"]]
        given = values.reshape(shape)
        try:
            keys = bent_keys(times, given, kind, columns, self._tolerance, stored)
        except ParameterError as problem:
            file.refuse(f"{of} cannot be bent: {problem}")
        self.error = max(self.error, keys.error)
        self.added_keys += len(keys.times) - len(times)
        return keys, times

    def _samplers(
        self,
        samplers: list[Any],
        source: dict[str, Any],
        keys: NDArray[np.float64],
        times: NDArray[np.float64],
        parts: list[NDArray[Any]],
    ) -> list[int]:
        """The numbers of new samplers like that of the source, of key times and of values each."""
        number = source["input"]
        if not np.array_equal(times, keys):
            number = self._input(number, keys.astype(np.float32))
        for values in parts:
            view = self._view(source["output"])
            output = self._additions.keys(values.reshape(-1), view)
            samplers.append({**source, "input": number, "output": output})
        return list(range(len(samplers) - len(parts), len(samplers)))

    def _input(self, number: int, times: NDArray[np.float32]) -> int:
        """The accessor of key times in place of those of another accessor."""
        key = (number, times.tobytes())
        if key not in self._inputs:
            self._inputs[key] = self._additions.keys(times, self._view(number), bounds=True)
        return self._inputs[key]

    def _view(self, accessor: int) -> Any:
        return self._file.item("accessors", accessor, "a sampler").get("bufferView")


def _of_one(columns: Columns, weight: int) -> Columns:
    """The columns of one slider alone, without what follows several."""
    bends = tuple((0, curve, size) for driver, curve, size in columns.bends if driver == weight)
    folds = {0: columns.folds[weight]} if weight in columns.folds else {}
    return Columns(1, bends, folds, columns.sizes[weight : weight + 1])


FEWEST = 1e-5
KEYS_TOLERANCE = 1e-4

Methods = str | Method | Mapping[str, str | Method] | None


def bend_gltf(
    path: str | Path,
    output: str | Path | None,
    *,
    method: Methods = None,
    only: Collection[str] | None = None,
    tolerance: float | None = None,
    keys_tolerance: float | None = None,
    max_targets: int | None = None,
    fold: bool = False,
    compress: bool = False,
    curves: str | Path | None = None,
    say: Callable[[str], None] = lambda _: None,
) -> BendReport:
    """Bend a .glb, .vrm or .gltf file; without an output, only say what would come of it."""
    if compress:
        require_meshopt()
    file, character = _opened(path, output, say)
    face = Face.read(character.file)
    held = _whole_rig(file) if character.was_bent else face.rig
    shapes = [n for n, m in held.morphs.items() if n not in face.rig and not is_pair_bend(m)]
    if max_targets is not None and shapes:
        max_targets = max(0, max_targets - len(shapes))
    say("finding paths")
    # Half of an error is that of the path as it is baked, half what fewer bends leave of it.
    half = None if tolerance is None else as_number(tolerance, "the tolerance", above=0) / 2
    fewest = FEWEST if half is None else half
    plan = make_plan(
        face.moving(),
        method,
        only=only,
        tolerance=fewest,
        baked=half,
        max_targets=max_targets,
        fold=fold,
        meshes=_meshes(face),
        say=say,
    )
    if shapes:  # of a file that was held, which bends anew from its original
        plan = plan.with_correctives(_welded(face, held))
    with of_bounded_depth(path):
        edit = CharacterEdit(character, face, plan, fewest, compress=compress)
        edit.add_bends(say)
        edit.add_clips(KEYS_TOLERANCE if keys_tolerance is None else keys_tolerance, say)
        report = edit.written(output, say)
    if curves is not None and report.output is not None:
        write_curves(open_gltf(report.output), curves)
    return report


def hold_gltf(
    path: str | Path,
    output: str | Path | None,
    held: Callable[[Rig], Rig],
    *,
    say: Callable[[str], None] = lambda _: None,
) -> BendReport:
    """Add correctives to a .glb, .vrm or .gltf file, and to its clips; its paths stay.

    Args:
        path: The character, bent or not.
        output: The file to write, if anything is added; None: only say what would come of it.
        held: From its rig to that with correctives.
        say: Told what is being done.
    """
    file, character = _opened(path, output, say)
    face = Face.read(character.file, bent=True)
    rig = _whole_rig(file)
    more = held(rig)
    if len(more) == len(rig):
        output = None  # there is nothing to add
    # What its original has stays as it is; the bends that undoing took out are planned anew.
    plan = plan_as_is(face.rig, _welded(face, more), FEWEST)
    with of_bounded_depth(path):
        edit = CharacterEdit(character, face, plan, FEWEST)
        edit.add_bends(say)
        edit.add_clips(KEYS_TOLERANCE, say)
        return edit.written(output, say)


def _opened(
    path: str | Path, output: str | Path | None, say: Callable[[str], None]
) -> tuple[GltfFile, Character]:
    """A file and the character in it, which may be written to the output."""
    say(f"reading {path}")
    with of_bounded_depth(path):
        file = open_gltf(path)
        character = Character.of(file)
    if output is not None:
        require_output(character, output)
    return file, character


def _whole_rig(file: GltfFile) -> Rig:
    """The rig of a file, in which no path is bare."""
    with naming_file(file.path), np.errstate(all="ignore"):
        return not_bare(rig_of(file, read_meshes(file, placed_meshes(file))))


def _welded(face: Face, rig: Rig) -> Rig:
    """A rig of the face, as of the face that paths are made for."""
    with naming_file(face.file.path):
        welded = {name: face.welding.welded(morph) for name, morph in rig.morphs.items()}
    return Rig(face.welding.neutral, welded, correctives=rig.sliders.correctives)


def unbend_gltf(path: str | Path, output: str | Path) -> None:
    """Write the original of a bent .glb, .vrm or .gltf file."""
    with of_bounded_depth(path):
        bent = open_gltf(path)
        character = Character.of(bent)
    if not character.was_bent:
        raise FormatError(
            path, "it was not made by 'elastomorph bend', so there is nothing to undo"
        )
    require_output(character, output)
    for name in sorted({*referred(character.file)} - {*referred(bent)}):
        place = Path(path).parent / name
        if not place.is_file():
            raise FileError(
                place, f"there is no such file, which the original in {path} needs; put it back"
            )
    write_character(character, output, character.file.document, character.chunk, {})


@contextmanager
def of_bounded_depth(path: str | Path) -> Iterator[None]:
    """Refuse a document that is nested deeper than Python calls itself."""
    try:
        yield
    except RecursionError:
        raise FormatError(path, "its document is nested too deeply") from None


def _meshes(face: Face) -> list[tuple[int, Any]]:
    """How many targets each mesh has, and its vertices in the face that paths are made for."""
    place = face.welding.place
    found = []
    for mesh in face.meshes:
        own = place[np.unique(mesh.rig_vertices)]
        found.append((len(mesh.names), np.unique(own[own >= 0])))
    return found


def _accessors(file: GltfFile, face: Face) -> Iterator[Any]:
    """The accessors of the targets of a face."""
    for mesh in face.meshes:
        for primitive in file.item("meshes", mesh.number, "a node")["primitives"]:
            for target in primitive["targets"]:
                yield from (own for own in target.values() if type(own) is int)


class CharacterEdit:
    """A copy of a document on its way to being bent."""

    def __init__(
        self,
        character: Character,
        face: Face,
        plan: Plan,
        tolerance: float,
        *,
        compress: bool = False,
    ) -> None:
        self._character, self._face, self._plan = character, face, plan
        file = character.file
        self._document = copy.deepcopy(file.document)
        counts = (len(file.items("accessors")), len(file.items("bufferViews")))
        self._packing = Packing.of(file, _accessors(file, face))
        if self._packing is None and compress:
            self._packing = Packing(EXTENSIONS[0], len(file.items("buffers")), 0, asked=True)
        self._additions = Additions(*counts, self._packing)
        shared = (self._document, self._additions, plan.extent, tolerance)
        self._meshes = [MeshEdit(file, mesh, *shared) for mesh in face.meshes]
        self._bent: list[BentTarget] = []

    def add_bends(self, say: Callable[[str], None]) -> None:
        """The bends of all targets, in all meshes."""
        normals = self._normals()
        with naming_file(self._character.file.path):
            for number, bent in enumerate(self._plan.bent, start=1):
                say(f"the bends of {bent.name}, {number} of {len(self._plan.bent)}")
                shape = () if bent.shape is None else (bent.shape[None],)
                bends = self._face.welding.fields(np.concatenate([*shape, bent.morph.bends]))
                known = self._face.rig
                target = (known[bent.name].target if bent.name in known else known.neutral).vertices
                if bent.shape is not None:
                    target = target + bends[0]
                turned = None if normals is None else normals.bends(bent, target, bends)
                before = self._additions.size, sum(len(mesh.names) for mesh in self._meshes)
                for mesh in self._meshes:
                    mesh.add(bent, bends, turned)
                after = self._additions.size, sum(len(mesh.names) for mesh in self._meshes)
                self._bent.append(_described(bent, after[1] - before[1], after[0] - before[0]))

    def _normals(self) -> NormalBends | None:
        """The normals of the face, None where no target turns any."""
        turned = any(
            "NORMAL" in target
            for mesh in self._face.meshes
            for primitive in self._document["meshes"][mesh.number]["primitives"]
            for target in primitive["targets"]
        )
        if not turned:
            return None
        file, document = self._character.file, self._document
        spaces = [
            (mesh.rig_vertices, space)
            for mesh in self._face.meshes
            for space in spaces_of(file, mesh, document["meshes"][mesh.number]).values()
        ]
        return NormalBends.of(self._face, spaces)

    def add_clips(self, tolerance: float, say: Callable[[str], None]) -> None:
        """Names, default weights and curves of all meshes, and the animations of their weights."""
        columns = {}
        for mesh in self._meshes:
            own = mesh.finish(self._plan.rig.morphs)
            if own is not None:
                columns[mesh.number] = own
        say("bending clips")
        file = self._character.file
        self._clips = ClipEdit(file, self._document, self._additions, columns, tolerance)
        self._clips.extend()

    def written(self, output: str | Path | None, say: Callable[[str], None]) -> BendReport:
        """Write the file if anything in it bends, or only find out how large it would be."""
        if not self._bent:
            return self._report(None, self._character.file.size + self._others())
        chunk, beside = self._with_buffers(output)
        character = self._character
        length = None if character.chunk is None else len(character.chunk)
        document = record(character.file.document, self._document, length, chunk)
        text = len(json.dumps(document, separators=(",", ":"), ensure_ascii=False).encode())
        size = text + sum(map(len, beside.values())) + self._others()
        if character.is_glb:
            size = 20 + text + -text % 4 + (0 if chunk is None else 8 + len(chunk))
            size += len(character.rest)
        if output is not None:
            say(f"writing {output}")
            write_character(character, output, document, chunk, beside)
        return self._report(output, size)

    def glb(self) -> tuple[dict[str, Any], bytes | None]:
        """The document of the file itself, of which nothing undoes the bends, and its chunk."""
        chunk, _ = self._with_buffers(None)
        return self._document, chunk

    def _with_buffers(self, output: str | Path | None) -> tuple[bytes | None, dict[str, bytes]]:
        """The binary chunk, and files beside the output, with the bytes of bends behind theirs."""
        document, character = self._document, self._character
        additions = self._additions
        if not additions.accessors:
            return character.chunk, {}
        buffers = document.setdefault("buffers", [])
        if self._packing is not None and self._packing.fallback == len(buffers):  # it is ours
            name = self._packing.extension
            buffers.append({"byteLength": 0, "extensions": {name: {"fallback": True}}})
            for key in ("extensionsUsed", "extensionsRequired"):
                document[key] = [*dict.fromkeys([*document.get(key, []), name])]
        into_chunk = character.binary_is_buffer_0
        chunk, beside = character.chunk, {}
        if into_chunk:
            views, blob = additions.placed(0, len(chunk or b""))
            chunk = (chunk or b"") + blob
            if buffers:
                buffers[0]["byteLength"] = len(chunk)
            elif chunk:
                buffers.append({"byteLength": len(chunk)})
        else:
            views, blob = additions.placed(len(buffers), 0)
            own: dict[str, Any] = {"byteLength": len(blob)}
            if self._has_files:
                path = Path(character.file.path)
                usual = path.with_name(f"{path.stem}.bent{path.suffix}")
                name, own["uri"] = name_beside(character, usual if output is None else output)
                beside[name] = blob
            else:
                own["uri"] = data_uri(blob)
            if blob:
                buffers.append(own)
        if self._packing is not None:
            buffers[self._packing.fallback]["byteLength"] = additions.fallback_length
        document.setdefault("bufferViews", []).extend(views)
        document["accessors"] = [*document.get("accessors", []), *additions.accessors]
        if not document["bufferViews"]:
            del document["bufferViews"]
        if self._clips.clips:
            fill_gaps(character.file.document, document)
        return chunk, beside

    @property
    def _has_files(self) -> bool:
        """Whether a buffer of the source is a file of its own."""
        buffers = self._character.file.items("buffers")
        uris = (own.get("uri") for own in buffers if isinstance(own, dict))
        return any(isinstance(uri, str) and not uri.startswith("data:") for uri in uris)

    def _others(self) -> int:
        """Bytes of the files that the source refers to."""
        file = self._character.file
        return sum(size_of(Path(file.path).parent / name) for name in referred(file))

    def _report(self, output: str | Path | None, size: int) -> BendReport:
        file, plan = self._character.file, self._plan
        counts = [(len(own.names), own) for own in self._meshes]
        bent = {own.name for own in (*plan.bent, *plan.left_out)}
        before = max(len(mesh.names) for mesh in self._face.meshes)
        after = max(
            len(mesh.names) + len(own.names)
            for mesh, own in zip(self._face.meshes, self._meshes, strict=True)
        )
        return BendReport(
            path=Path(file.path),
            output=None if output is None else Path(output),
            extent=plan.extent,
            bent=tuple(self._bent),
            straight=tuple(
                name for name in plan.rig.morphs if name not in bent and name in self._face.rig
            ),
            left_out=tuple(_described(own, 0, 0) for own in plan.left_out),
            targets_before=before,
            targets=after,
            meshes=tuple(own.title for count, own in counts if count),
            clips=self._clips.clips,
            added_keys=self._clips.added_keys,
            bytes_before=file.size + self._others(),
            bytes=size,
            storage_error=max((own.error for own in self._meshes), default=0.0),
            key_error=self._clips.error,
            was_bent=self._character.was_bent,
            notes=(overrides_note(overrides),) if (overrides := overrides_of(file)) else (),
        )


def _described(bent: BentMorph, targets: int, size: int) -> BentTarget:
    choice = bent.morph.choice
    return BentTarget(
        name=bent.name,
        gain=bent.gain,
        error=bent.error,
        method=bent.morph.method if choice is None else choice.text,
        bends=len(bent.morph.bends),
        targets=targets,
        bytes=size,
        folded=bent.fold is not None,
    )
