"""A session of photographs: poses of a movement, photographed and written with the truth beside.

::

    FOLDER/p00/00.jpg …     a folder a pose, p00 the neutral
    FOLDER/template.obj     the face of somebody else, of the topology of this face
    FOLDER/landmarks.json   landmarks on the template and clicks in photographs of the neutral
    FOLDER/truth.npz        cameras, vertices and motion of the head (`Truth`)
    FOLDER/poses_true/      the true poses with the topology of the template
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import elastomorph as em
from elastomorph.capturing.landmarks import Landmarks, write_landmarks
from photographs.backdrop import Backdrop
from photographs.cameras import RINGS, Lens, Shot, Spread, around
from photographs.clicks import clicked
from photographs.film import Film, developed
from photographs.rendering import Scene
from photographs.skin import Skin
from photographs.subjects import Subject, subject
from photographs.truth import Truth

__all__ = ["SMALL", "Session", "on_template", "photograph"]


@dataclass(frozen=True)
class Session:
    """What is photographed, and how.

    Attributes:
        subject: `ict` or `small`.
        movement: Which of the subject's.
        poses: How many, evenly from t = 0, the neutral, to 1.
        count: Photographs of each pose.
        size: Width and height in pixels.
        rings: Elevations of the rings of cameras in degrees.
        azimuth: How far rings go to either side, in degrees.
        rig: ``walking``: cameras are placed anew for each pose; ``fixed``: they stay.
        motion: Standard deviation of the head's turn between poses in degrees, and four times that
            of its shift in cm.
        sway: As ``motion``, from photograph to photograph of one pose.
        drift: How far the face is along its movement, from photograph to photograph of one pose:
            standard deviation of t.
        jitter: Of cameras: 1 by hand, 0 exact.
        texture: Strength of grain and freckles.
        radial: k1 of the lens.
        film: Blur, noise, JPEG and EXIF.
        backdrop: ``studio`` or ``room``.
        seed: Of everything.
    """

    subject: str = "small"
    movement: str = "smile"
    poses: int = 2
    count: int = 30
    size: tuple[int, int] = (1500, 2000)
    rings: tuple[float, ...] = RINGS
    azimuth: float = 90.0
    rig: str = "walking"
    motion: float = 2.0
    sway: float = 0.0
    drift: float = 0.0
    jitter: float = 1.0
    texture: float = 1.0
    radial: float = -0.04
    film: Film = field(default_factory=Film)
    backdrop: str = "studio"
    seed: int = 0

    @property
    def times(self) -> NDArray[np.float64]:
        """(poses,) from 0 to 1; of two poses the neutral and the end."""
        return np.linspace(0, 1, self.poses)

    @property
    def names(self) -> list[str]:
        """The poses: ``p00``, ``p01`` and so on."""
        return [f"p{number:02d}" for number in range(self.poses)]

    def shots(self, pose: int, person: Subject) -> tuple[Shot, ...]:
        """The cameras of a pose."""
        lens = Lens.of_size(*self.size, radial=self.radial)
        spread = Spread(self.rings, self.azimuth, self.jitter, person.distance, person.aim)
        return around(lens, self.count, spread, [self.seed, 10, 0 if self.rig == "fixed" else pose])

    def head(self, pose: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Turn (3, 3) and shift (3,) of the head in a pose; none in the neutral."""
        if pose == 0:
            return np.eye(3), np.zeros(3)
        return _moved(np.random.default_rng([self.seed, 11, pose]), self.motion)

    def still(self, pose: int, shot: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Turn (3, 3) and shift (3,) of the head beside `head` in one photograph."""
        return _moved(np.random.default_rng([self.seed, 14, pose, shot]), self.sway)

    def time(self, pose: int, shot: int) -> float:
        """Where on its movement, from 0 to 1, a face is in one photograph."""
        random = np.random.default_rng([self.seed, 15, pose, shot])
        return float(np.clip(self.times[pose] + self.drift * random.normal(), 0, 1))


def _moved(
    random: np.random.Generator, degrees: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A small turn and shift."""
    turn = Rotation.from_rotvec(np.radians(degrees * random.normal(size=3)))
    return turn.as_matrix(), degrees / 4 * random.normal(size=3)


# Two poses that are matched in seconds: from the front, where twelve photographs overlap enough.
SMALL = Session(count=12, size=(750, 1000), rings=(-8.0, 16.0), azimuth=50.0)


def photograph(
    session: Session, folder: str | Path, told: Callable[[str], None] = lambda line: None
) -> Truth:
    """Write the photographs of a session into a folder, and the truth beside them.

    Args:
        session: What to photograph.
        folder: Made if it is not there.
        told: Called with a line as each pose is done.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    person = subject(session.subject, session.seed)
    truth = Truth.of(session, person)
    truth.save(folder / "truth.npz")
    em.write(folder / "template.obj", person.template)
    (folder / "poses_true").mkdir(exist_ok=True)
    for number, name in enumerate(session.names):
        start = time.process_time()
        true = person.template.with_vertices(truth.vertices[name][person.of_template])
        em.write(folder / "poses_true" / f"{name}.obj", true)
        _pose(session, number, person, truth, folder / name)
        told(f"{name}: {session.count} photographs, {time.process_time() - start:.0f} s")
    return truth


def _pose(session: Session, number: int, person: Subject, truth: Truth, folder: Path) -> None:
    """The photographs of one pose."""
    folder.mkdir(exist_ok=True)
    name = session.names[number]
    vertices = truth.vertices[name]
    scene = _scene(session, person, truth.in_world(name, vertices))
    if number == 0:
        _landmarks(session, person, truth, scene, folder.parent / "landmarks.json")
    # Where a pixel is wider than the finest grain it averages over what it covers.
    samples = 2 if session.size[1] <= 1400 else 1
    for shot, (file, camera) in enumerate(
        zip(truth.files, session.shots(number, person), strict=True)
    ):
        random = np.random.default_rng([session.seed, 12, number, shot])
        own = scene
        if session.drift or session.sway:
            turn, shift = session.still(number, shot)
            times = np.array([session.time(number, shot)])
            face = person.poses(session.movement, times)[0] if session.drift else vertices
            own = _scene(session, person, truth.in_world(name, face) @ turn.T + shift)
        light = own.photograph(camera, samples)
        (folder / file).write_bytes(developed(light, camera.lens, session.film, random))


def _scene(session: Session, person: Subject, vertices: NDArray[np.float64]) -> Scene:
    """The head as it is in the world, ready to be photographed."""
    skin = Skin(session.seed, session.texture)
    return Scene(person.surface, vertices, skin, Backdrop(session.backdrop, session.seed))


def _landmarks(session: Session, person: Subject, truth: Truth, scene: Scene, path: Path) -> None:
    """The file of landmarks on the template and of clicks in photographs of the neutral."""
    name = session.names[0]
    random = np.random.default_rng([session.seed, 13])
    clicks = clicked(scene, truth.cameras[name], truth.files, person.landmarks, random)
    write_landmarks(path, Landmarks(on_template(person), {name: clicks}))


def on_template(person: Subject) -> dict[str, int]:
    """Vertices of the template, by name of the landmark."""
    order = np.argsort(person.of_template)
    own = list(person.landmarks.values())
    places = np.searchsorted(person.of_template, own, sorter=order)
    return {name: int(order[place]) for name, place in zip(person.landmarks, places, strict=True)}
