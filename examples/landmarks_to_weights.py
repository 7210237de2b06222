"""Trains a small network that tells slider weights from landmarks, on bent and on linear faces.

    python examples/landmarks_to_weights.py [--faces 100000] [--rig head.glb] [--without-torch]

Two data sets are made, of the same weights: faces on the bent paths of a rig, and linear ones, of
the same targets. A network is trained on each and tested on other faces of both. Errors are
those of weights, and those of the faces that the rig makes of them, as parts of D.

Without PyTorch a network is trained with NumPy alone: a hidden layer of random weights, and a last
one by least squares.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from importlib.util import find_spec

import numpy as np
from numpy.typing import NDArray

import elastomorph as em
from elastomorph.rig.build import extent_of

Rows = NDArray[np.float32]
Network = Callable[[Rows], Rows]

LANDMARKS, TESTED = 68, 1000
EXPRESSIONS = ("sad", "angry", "confused", "grinning", "puff")  # of the built-in: sums of others


def landmarks_of(rig: em.Rig) -> dict[str, int]:
    """Vertices that move, as far from each other as can be."""
    moved = np.flatnonzero(rig.fields.matrix(np.float32)[1:].any(axis=0).reshape(-1, 3).any(axis=1))
    points = rig.neutral.vertices[moved]
    chosen, distance = [0], np.full(len(points), np.inf)
    while len(chosen) < min(LANDMARKS, len(points)):
        distance = np.minimum(distance, np.linalg.norm(points - points[chosen[-1]], axis=1))
        chosen.append(int(distance.argmax()))
    return {f"landmark {n}": int(moved[place]) for n, place in enumerate(chosen)}


def trained_by_torch(faces: em.FaceSet, count: int, mean: Rows, scale: Rows) -> Network:
    """Three layers, trained by Adam on shuffled batches."""
    import torch
    from torch import nn

    torch.manual_seed(0)
    torch.set_num_threads(1)  # Several wait for each other at layers as small as these
    network = nn.Sequential(
        *(nn.Linear(mean.size, 256), nn.ReLU()),
        *(nn.Linear(256, 256), nn.ReLU()),
        nn.Linear(256, len(faces.rig.names)),
    )
    batches = faces.as_torch("landmarks", "weights").batches(512, faces=slice(count))
    passes = 8
    optimizer = torch.optim.Adam(network.parameters())
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, 3e-3, passes * len(batches))
    for _ in range(passes):
        for batch in batches:
            shown = (batch["landmarks"].flatten(1) - torch.from_numpy(mean)) * float(1 / scale)
            loss = nn.functional.mse_loss(network(shown), batch["weights"])
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()

    def told(landmarks: Rows) -> Rows:
        with torch.no_grad():
            found: Rows = network(torch.from_numpy((landmarks - mean) / scale)).numpy()
        return found

    return told


def trained_by_numpy(faces: em.FaceSet, count: int, mean: Rows, scale: Rows) -> Network:
    """A hidden layer of random weights and the landmarks themselves, then least squares."""
    random, hidden = np.random.default_rng(0), min(1000, count // 4)
    first = random.normal(size=(mean.size, hidden)).astype(np.float32)
    offset = random.normal(size=hidden).astype(np.float32)

    def layer(landmarks: Rows) -> Rows:
        shown = (landmarks - mean) / scale
        return np.concatenate([np.maximum(shown @ first + offset, 0), shown], axis=1)

    gram, right = 0.0, 0.0
    for start in range(0, count, 4096):
        rows = slice(start, min(start + 4096, count))
        seen = layer(faces.labels["landmarks"][rows].reshape(-1, mean.size)).astype(np.float64)
        gram, right = gram + seen.T @ seen, right + seen.T @ faces.weights[rows]
    size = len(gram)
    last = np.linalg.solve(gram + 1e-7 * np.trace(gram) / size * np.eye(size), right)
    return lambda landmarks: np.asarray(layer(landmarks) @ last.astype(np.float32))


def errors(network: Network, faces: em.FaceSet) -> tuple[float, float]:
    """Mean errors, over the last faces, of weights and of moved vertices in units of D."""
    rows = slice(len(faces) - TESTED, None)
    landmarks, truth = faces.labels["landmarks"][rows], faces.weights[rows]
    found = network(landmarks.reshape(len(truth), -1)).clip(0, 1)
    apart = np.linalg.norm(faces.rig.batch(found) - faces[rows], axis=2)
    moved = np.linalg.norm(faces[rows] - faces.rig.neutral.vertices, axis=2).max(axis=0) > 0
    return float(np.abs(found - truth).mean()), float(apart[:, moved].mean() / extent_of(faces.rig))


def main(words: list[str] | None = None) -> dict[tuple[str, str], tuple[float, float]]:
    """Make both data sets, train on each, test on both, and print a table of errors."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--faces", type=int, default=100_000)
    parser.add_argument("--rig", default="built-in")
    parser.add_argument("--without-torch", action="store_true")
    given = parser.parse_args(words)
    by_torch = not given.without_torch and find_spec("torch") is not None
    train = trained_by_torch if by_torch else trained_by_numpy
    rigs = {"bent": em.read_rig(given.rig), "linear": em.read_rig(given.rig, method="linear")}
    names = [name for name in rigs["bent"].names if name not in EXPRESSIONS]
    rigs = {kind: rig.only(names) for kind, rig in rigs.items()}
    marks, table = landmarks_of(rigs["linear"]), {}
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        sets = {
            kind: em.make_faces(rig, f"{folder}/{kind}", given.faces + TESTED, landmarks=marks)
            for kind, rig in rigs.items()
        }
        print(f"{given.faces:,} faces of each kind in {time.perf_counter() - start:.0f} s")
        none = errors(lambda rows: np.zeros((len(rows), len(names)), np.float32), sets["bent"])
        table["none", "bent"] = none
        print(f"faces left at rest    weights {none[0]:.4f}  vertices {none[1]:.1e} D")
        for kind, faces in sets.items():
            start = time.perf_counter()
            some = faces.labels["landmarks"][: min(given.faces, 4096)].reshape(-1, 3 * len(marks))
            network = train(faces, given.faces, some.mean(axis=0), some.std())
            print(f"trained on {kind} faces in {time.perf_counter() - start:.0f} s")
            for other, tested in sets.items():
                weights, vertices = table[kind, other] = errors(network, tested)
                print(f"  tested on {other:6}  weights {weights:.4f}  vertices {vertices:.1e} D")
    return table


if __name__ == "__main__":
    main()
