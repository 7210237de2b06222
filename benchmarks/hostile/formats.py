"""The formats under test: seeds, readers, what is done to them, and what must come back.

A format joins by one entry in `FORMATS`.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterable, Iterator
from functools import cache, partial
from pathlib import Path
from random import Random
from typing import Any

from elastomorph.character import read_settings
from elastomorph.io import read_rig, read_sequence
from elastomorph.io.gltf import read_glb, write_glb
from elastomorph.io.npz import read_npz, read_npz_sequence, write_npz, write_npz_sequence
from elastomorph.io.npz.rig import read_rig_npz, write_rig_npz
from elastomorph.io.obj import read_obj, write_obj
from elastomorph.io.performance import read_performance, write_performance, write_performance_csv
from elastomorph.io.ply import read_ply, write_ply
from elastomorph.io.poses import read_poses, write_poses
from elastomorph.io.sequences import read_mdd, read_pc2, read_recording, write_mdd, write_pc2
from elastomorph.io.vertex_lists import read_curves, read_region
from elastomorph.rig.performance import Performance
from hostile import archives, documents, scenes, texts
from hostile.format import Format
from hostile.frames import NumberedFrames, sequence_folders
from hostile.judge import require, same
from hostile.seeds import face, motion, rig, written

__all__ = ["FORMATS", "Format"]

_ROOT = Path(__file__).resolve().parents[2]


def _encoded(made: Iterable[tuple[str, str]]) -> Iterator[tuple[str, bytes]]:
    for label, text in made:
        yield label, text.encode("utf-8", "replace")


def _ply_bytes() -> Iterator[tuple[str, bytes]]:
    # Binary rows are written as characters below 256.
    for label, text in texts.ply_files():
        yield label, text.encode("latin-1", "replace")


def _again(write: Callable[..., Any], read: Callable[..., Any], name: str, tolerance: float = 0.0):
    def check(thing: Any, folder: Path) -> None:
        path = folder / name
        write(path, thing)
        require(
            same(thing, read(path), tolerance=tolerance), "what is written again must be the same"
        )

    return check


def _write_cache(write: Callable[..., Any], path: Path, cache: Any) -> None:
    write(path, cache.frames)


# Seeds.


def _meshes(write: Callable[..., Any], name: str, **options: Any) -> list[bytes]:
    return [written(name, write, face(), **options)]


@cache
def _performance() -> Performance:
    return Performance(
        ["jawOpen", "browInnerUp"], [0.0, 1 / 30, 2 / 30], [[0, 0.25], [0.1, 0.5], [1, 0]], 30.0
    )


_POSES = (
    b'{"format": "elastomorph poses", "version": 1, "poses": ['
    b'{"name": "Smile", "weights": {"smile": 0.7, "jawOpen": 0.25}}, '
    b'{"name": "Rest", "weights": {}}]}',
    b'{"Smile": {"smile": 0.7}, "Rest": {}}',
)
_LIVELINK = (
    b"Timecode,BlendShapeCount,EyeBlinkLeft,JawOpen,HeadYaw\n"
    b"13:04:31:58.500,3,0.1,0.2,-0.3\n13:04:31:59.500,3,0.2,0.3,-0.2\n13:04:32:00.500,0,,,\n"
    b"13:04:32:01.500,3,0.3,0.1,0.0\n13:04:32:01.500,3,0.3,0.1,0.0\n13:04:32:04.500,3,0.5,0,0\n"
)
_CURVES = (
    b'{"vertex_count": 100, "curves": [\n{"vertices": [4, 8, 15], "closed": true, "name": "upper '
    b'lip"},\n{"vertices": [16, 23]}]}\n',
    b"[[0, 1, 2, 0], [42, 43]]",
)
_SETTINGS = (
    b'[character]\nunit = "cm"\n[method]\ndefault = "beam:3"\nclosure = "rest"\n'
    b'[method.material]\ndamping = 0.5\n[timing]\ndefault = "linear"\n'
    b'[methods]\njawOpen = "rotation"\n[regions.mouth]\nvertices = "0-99,120"\nfalloff = 2.5\n'
    b'method = "linear"\n[groups]\njaw = ["jawOpen", "jaw*"]\n[export.glb]\nfps = 30\n'
)
_REGION = (b"[3, 4, 5]", b'{"vertices": [0, 2147483647]}')


def _markers() -> dict[str, Any]:
    import numpy as np

    return {
        "positions": np.arange(24, dtype=float).reshape(2, 4, 3),
        "names": np.array(["chin", "lip", "brow.L", "brow.R"]),
    }


@cache
def _arrays(kind: str) -> dict[str, Any]:
    if kind == "markers":
        return _markers()
    write, thing = {
        "mesh": (write_npz, face()),
        "motion": (write_npz_sequence, motion()),
        "rig": (write_rig_npz, rig()),
    }[kind]
    return archives.arrays_of(written("a.npz", write, thing))


def _archive_seeds(kind: str) -> list[bytes]:
    import zipfile

    return [archives.archive(_arrays(kind), m) for m in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)]


def _archives(kind: str, main: str) -> Iterator[tuple[str, bytes]]:
    return archives.archive_files(_arrays(kind), main)


def _archive_damage(kind: str, random: Random) -> tuple[str, bytes]:
    return archives.damaged_arrays(random, _arrays(kind))


@cache
def _glb() -> bytes:
    return written("face.glb", write_glb, rig())


def _glb_damage(random: Random) -> tuple[str, bytes]:
    document, blob = documents.chunks(_glb())
    label, document = documents.damaged_document(random, document)
    return label, documents.glb(documents.text_of(document), blob)


def _gltf_seeds() -> list[bytes]:
    """With its bytes in itself, so that it stands alone."""
    import base64

    document, blob = documents.chunks(_glb())
    uri = "data:application/octet-stream;base64," + base64.b64encode(blob).decode()
    document["buffers"] = [{"byteLength": len(blob), "uri": uri}]
    return [json.dumps(document, indent=1).encode()]


def _gltf_damage(random: Random) -> tuple[str, bytes]:
    label, document = documents.damaged_document(random, json.loads(_gltf_seeds()[0]))
    return label, documents.text_of(document)


def _json_damage(seeds: tuple[bytes, ...], random: Random) -> tuple[str, bytes]:
    label, document = documents.damaged_document(random, json.loads(random.choice(seeds)))
    return label, documents.text_of(document)


@cache
def _usd(suffix: str) -> bytes:
    from elastomorph.io.usd import write_usd

    return written(f"face.{suffix}", write_usd, rig())


def _usd_text() -> str:
    return _usd("usda").decode()


def _usd_damage(random: Random) -> tuple[str, bytes]:
    label, text = scenes.damaged_scene(random, _usd_text())
    return label, text.encode()


def _usdz_seeds() -> list[bytes]:
    return [scenes.usdz(_usd("usdc"))]


@cache
def _fbx(binary: bool) -> bytes:
    sys.path.append(str(_ROOT / "tests" / "io" / "fbx"))
    from fbx_samples import Shape, as_binary, as_text, quad, scene

    between = [
        Shape([1], [[0, 0, 0.5]], 40.0, "half"),
        Shape([1, 3], [[0, 0, 1], [0.5, 0, 0]], 100.0, "full"),
    ]
    channels = {**quad().channels, "blendShape1.both": between}
    model = quad(
        channels=channels,
        uv=([[0, 0], [1, 0], [1, 1]], [0, 1, 2, 2]),
        materials=(["skin"], [0]),
    )
    content: bytes = (as_binary if binary else as_text)(scene(model))
    return content


def _sound_curves(curves: Any) -> None:
    seen: set[int] = set()
    for curve in curves:
        own = curve.vertices.tolist()
        require(own and all(0 <= vertex < 100 for vertex in own), "vertices of the mesh")
        require(not seen & set(own) and len(set(own)) == len(own), "a vertex on one curve only")
        seen.update(own)


def _sound_poses(poses: dict[str, dict[str, float]]) -> None:
    require(poses and all(isinstance(name, str) and name for name in poses), "poses with names")
    numbers = [weight for weights in poses.values() for weight in weights.values()]
    require(all(map(math.isfinite, numbers)), "finite weights")


def _poses_again(poses: dict[str, dict[str, float]], folder: Path) -> None:
    write_poses(folder / "again.json", poses)
    require(read_poses(folder / "again.json") == poses, "what is written again must be the same")


def _sound_region(region: Any) -> None:
    require(region.dtype.kind == "i" and region.ndim == 1, "whole numbers")
    require(not region.size or (region.min() >= 0 and region.max() < 2**31), "from 0")


def _sound_settings(settings: Any) -> None:
    require(settings.path.name.lower() == "elastomorph.toml" or settings.path.exists(), "its file")
    for region in settings.regions.values():
        require(0 <= region.falloff < float("inf"), "a falloff from 0")
    for own in settings.inbetweens.values():
        require(all(0 < time < 1 for time in own.files), "times between 0 and 1")


def _cache_seeds(write: Callable[..., Any], name: str) -> list[bytes]:
    return [written(name, write, motion().frames)]


FORMATS: tuple[Format, ...] = (
    Format(
        "OBJ",
        "face.obj",
        partial(_meshes, write_obj, "face.obj"),
        read_obj,
        again=_again(write_obj, read_obj, "again.obj"),
        crafted=lambda: _encoded(texts.obj_files()),
    ),
    *(
        Format(
            f"PLY {label}",
            "face.ply",
            partial(_meshes, write_ply, "face.ply", encoding=encoding),
            read_ply,
            again=_again(partial(write_ply, encoding=encoding), read_ply, "again.ply"),
            crafted=_ply_bytes if label == "ascii" else tuple,
        )
        for label, encoding in (
            ("ascii", "ascii"),
            ("binary LE", "binary_little_endian"),
            ("binary BE", "binary_big_endian"),
        )
    ),
    Format(
        "NPZ mesh",
        "face.npz",
        partial(_archive_seeds, "mesh"),
        read_npz,
        again=_again(write_npz, read_npz, "again.npz"),
        crafted=partial(_archives, "mesh", "vertices"),
        damage=partial(_archive_damage, "mesh"),
    ),
    Format(
        "NPZ rig",
        "face.npz",
        partial(_archive_seeds, "rig"),
        read_rig_npz,
        again=_again(write_rig_npz, read_rig_npz, "again.npz"),
        crafted=partial(_archives, "rig", "neutral"),
        damage=partial(_archive_damage, "rig"),
    ),
    Format(
        "NPZ take",
        "face.npz",
        partial(_archive_seeds, "motion"),
        read_npz_sequence,
        again=_again(write_npz_sequence, read_npz_sequence, "again.npz"),
        crafted=partial(_archives, "motion", "frames"),
        damage=partial(_archive_damage, "motion"),
    ),
    Format(
        "NPZ markers",
        "face.npz",
        partial(_archive_seeds, "markers"),
        read_recording,
        crafted=partial(_archives, "markers", "positions"),
        damage=partial(_archive_damage, "markers"),
    ),
    Format(
        "GLB",
        "face.glb",
        lambda: [_glb()],
        read_glb,
        again=_again(write_glb, read_glb, "again.glb", 1e-6),
        crafted=lambda: documents.glb_files(_glb()),
        damage=_glb_damage,
    ),
    Format(
        "glTF + .bin",
        "face.gltf",
        _gltf_seeds,
        read_glb,
        folders=lambda: documents.gltf_folders(_glb()),
        damage=_gltf_damage,
    ),
    Format(
        "USD text",
        "face.usda",
        lambda: [_usd("usda")],
        read_rig,
        crafted=lambda: _encoded(scenes.usd_texts(_usd_text())),
        folders=lambda: scenes.usd_folders(_usd_text()),
        damage=_usd_damage,
        isolated=True,
    ),
    Format("USD binary", "face.usdc", lambda: [_usd("usdc")], read_rig, isolated=True),
    Format("USD package", "face.usdz", _usdz_seeds, read_rig, isolated=True),
    Format(
        "FBX text",
        "face.fbx",
        lambda: [_fbx(False)],
        read_rig,
        crafted=lambda: scenes.fbx_texts(_fbx(False)),
        isolated=True,
    ),
    Format("FBX binary", "face.fbx", lambda: [_fbx(True)], read_rig, isolated=True),
    Format(
        "CSV performance",
        "take.csv",
        lambda: [written("take.csv", write_performance_csv, _performance())],
        read_performance,
        again=_again(write_performance_csv, read_performance, "again.csv"),
        crafted=lambda: _encoded(texts.csv_files()),
    ),
    Format(
        "CSV Live Link",
        "take.csv",
        lambda: [_LIVELINK],
        read_performance,
        crafted=lambda: _encoded(texts.livelink_files()),
    ),
    Format(
        "NPZ performance",
        "take.npz",
        lambda: [written("take.npz", write_performance, _performance())],
        read_performance,
        again=_again(write_performance, read_performance, "again.npz"),
    ),
    Format(
        "JSON poses",
        "poses.json",
        lambda: list(_POSES),
        read_poses,
        _sound_poses,
        again=_poses_again,
        damage=partial(_json_damage, _POSES),
    ),
    Format(
        "CSV poses",
        "poses.csv",
        lambda: [b"pose,jawOpen,smile\nWide,1,\nSmile,0.25,0.7\n"],
        read_poses,
        _sound_poses,
        again=_poses_again,
    ),
    Format(
        "JSON curves",
        "curves.json",
        lambda: list(_CURVES),
        partial(read_curves, vertex_count=100),
        _sound_curves,
        crafted=lambda: _encoded(texts.curve_files()),
        damage=partial(_json_damage, _CURVES),
    ),
    Format(
        "JSON region",
        "region.json",
        lambda: list(_REGION),
        read_region,
        _sound_region,
        crafted=lambda: _encoded(texts.region_files()),
        damage=partial(_json_damage, _REGION),
    ),
    Format(
        "TOML settings",
        "elastomorph.toml",
        lambda: [_SETTINGS],
        read_settings,
        _sound_settings,
        crafted=lambda: _encoded(texts.settings_files()),
    ),
    NumberedFrames(
        "numbered frames",
        "scan.#.obj",
        partial(_meshes, write_obj, "face.obj"),
        read_sequence,
        folders=sequence_folders,
    ),
    Format(
        "MDD cache",
        "face.mdd",
        partial(_cache_seeds, write_mdd, "face.mdd"),
        read_mdd,
        again=_again(partial(_write_cache, write_mdd), read_mdd, "again.mdd"),
    ),
    Format(
        "PC2 cache",
        "face.pc2",
        partial(_cache_seeds, write_pc2, "face.pc2"),
        read_pc2,
        again=_again(partial(_write_cache, write_pc2), read_pc2, "again.pc2"),
    ),
)
