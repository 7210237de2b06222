"""How long it takes to load a rig: from a folder of meshes, from its cache, and from FBX.

Run:  python benchmarks/rig_loading.py [--data FOLDER]

Prints, measured in one run on this machine: reading the 58 files of a production rig and building
a beam for each target, the first time and from the cache; where that time goes; what threads or
processes would save; and a head of 52 shapes from FBX. Caches go to a temporary folder.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import tempfile
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import elastomorph as em
from elastomorph.io.fbx import read_fbx
from elastomorph.io.npz.rig import read_rig_npz, write_rig_npz
from elastomorph.io.rig_cache import content_digests
from elastomorph.io.rig_folder import find_rig_files, read_rig_folder
from measuring import best_seconds, data_folder


def vertices_in(path: Path) -> NDArray[np.float64]:
    return em.read(path).vertices


def load_folder(folder: Path, scratch: Path) -> None:
    files = find_rig_files(folder).all
    megabytes = sum(file.stat().st_size for file in files) / 1e6
    print(f"{folder.name}: {len(files)} files, {megabytes:.0f} MB, {os.cpu_count()} cores")

    def load() -> em.Mesh:
        return read_rig_folder(folder, method="beam:2", cache=scratch).neutral

    print(f"  rig of beams, first time       {best_seconds(load, 1):8.2f} s   (limit 6 s)")
    print(f"  … from the cache               {best_seconds(load, 5):8.2f} s   (limit 0.5 s)")
    print(
        f"    of which: contents hashed    {best_seconds(lambda: content_digests(files), 5):8.2f} s"
    )
    kept = next(iter(scratch.iterdir()))
    print(
        f"    and read                     {best_seconds(lambda: read_rig_npz(kept), 5):8.2f} s",
        end="",
    )
    print(f"   ({kept.stat().st_size / 1e6:.0f} MB)")
    rig = read_rig_npz(kept)
    archive = scratch / "rig.npz"
    written = best_seconds(lambda: write_rig_npz(archive, rig), 3)
    print(f"  written as an archive          {written:8.2f} s")

    one = best_seconds(lambda: [vertices_in(file) for file in files], 1)
    print(f"  meshes read one after another  {one:8.2f} s")

    def by_threads() -> None:
        with ThreadPoolExecutor(os.cpu_count()) as threads:
            list(threads.map(vertices_in, files))

    def by_processes() -> None:
        with ProcessPoolExecutor(mp_context=multiprocessing.get_context("spawn")) as processes:
            list(processes.map(vertices_in, files))

    print(f"  … by threads                   {best_seconds(by_threads, 1):8.2f} s")
    print(f"  … by processes, started first  {best_seconds(by_processes, 1):8.2f} s")


def load_fbx(path: Path) -> None:
    rig = read_fbx(path)
    print(f"{path.name}: {path.stat().st_size / 1e6:.1f} MB, {rig}")
    print(f"  read in a process of its own   {best_seconds(lambda: read_fbx(path), 5):8.2f} s")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=data_folder())
    data = parser.parse_args().data
    with tempfile.TemporaryDirectory() as scratch:
        if (data / "ict-facekit").is_dir():
            load_folder(data / "ict-facekit", Path(scratch))
        else:
            print(f"no folder {data / 'ict-facekit'}: nothing to load from a folder")
    head = data / "facecap" / "FaceCapHeadGeneric.fbx"
    if head.is_file():
        load_fbx(head)
    else:
        print(f"no file {head}: no FBX to load")


if __name__ == "__main__":
    main()
