"""What is true of rendered photographs: cameras, vertices, and how the head moved."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from photographs.cameras import Lens, Shot

if TYPE_CHECKING:
    from photographs.sessions import Session
    from photographs.subjects import Subject

__all__ = ["Truth"]


@dataclass(frozen=True, eq=False)
class Truth:
    """The truth of a session of photographs.

    Attributes:
        triangles: (T, 3) of the photographed surface.
        materials: (T,) of them; 0 is skin.
        of_template: (N,) the vertex of the surface at each vertex of the template.
        landmarks: Vertices of the surface, by name.
        lip_line: (S, 2) vertices of the surface at the ends of pieces of where the lips meet.
        vertices: (V, 3) of the surface in each pose, in the frame of the neutral.
        turns: (3, 3) of the head in each pose.
        shifts: (3,) of the head in each pose: what is at X is photographed at turn X + shift.
        cameras: Of each pose, in the world where the head has turned; where it sways, they do.
        files: Names of photographs, the same in each pose.
    """

    triangles: NDArray[np.int32]
    materials: NDArray[np.int8]
    of_template: NDArray[np.int64]
    landmarks: dict[str, int]
    lip_line: NDArray[np.int64]
    vertices: dict[str, NDArray[np.float64]]
    turns: dict[str, NDArray[np.float64]]
    shifts: dict[str, NDArray[np.float64]]
    cameras: dict[str, tuple[Shot, ...]]
    files: tuple[str, ...]

    @classmethod
    def of(cls, session: Session, person: Subject) -> Truth:
        """What a session will photograph."""
        poses = person.poses(session.movement, session.times)
        heads = [session.head(number) for number in range(session.poses)]
        names = session.names
        return cls(
            triangles=person.surface.triangles,
            materials=person.surface.materials,
            of_template=person.of_template,
            landmarks=person.landmarks,
            lip_line=person.lip_line,
            vertices=dict(zip(names, poses, strict=True)),
            turns={name: turn for name, (turn, _) in zip(names, heads, strict=True)},
            shifts={name: shift for name, (_, shift) in zip(names, heads, strict=True)},
            cameras={
                name: tuple(
                    shot.beside(*session.still(pose, number))
                    for number, shot in enumerate(session.shots(pose, person))
                )
                for pose, name in enumerate(names)
            },
            files=tuple(f"{shot:02d}.jpg" for shot in range(session.count)),
        )

    def in_world(self, pose: str, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Where points (..., 3) of the frame of the neutral are photographed in a pose."""
        return points @ self.turns[pose].T + self.shifts[pose]

    def in_neutral(self, pose: str, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """The inverse of `in_world`."""
        back: NDArray[np.float64] = (points - self.shifts[pose]) @ self.turns[pose]
        return back

    def save(self, path: Path) -> None:
        """Write an .npz.

        It holds ``triangles``, ``materials``, ``of_template``, ``landmarks`` and
        ``landmark_names``, ``lip_line``, ``names``, ``files``, ``size``, ``focal``, ``centre``,
        ``radial``, and of each pose ``p00_vertices``, ``p00_turn``,
        ``p00_shift``, ``p00_rotations`` and ``p00_positions``.
        """
        lens = next(iter(self.cameras.values()))[0].lens
        own: dict[str, NDArray[np.generic]] = {k: np.asarray(v) for k, v in asdict(lens).items()}
        for name, shots in self.cameras.items():
            own[f"{name}_vertices"] = self.vertices[name]
            own[f"{name}_turn"], own[f"{name}_shift"] = self.turns[name], self.shifts[name]
            own[f"{name}_rotations"] = np.array([shot.rotation for shot in shots])
            own[f"{name}_positions"] = np.array([shot.position for shot in shots])
        np.savez_compressed(
            path,
            triangles=self.triangles,
            materials=self.materials,
            of_template=self.of_template,
            landmarks=np.array(list(self.landmarks.values())),
            landmark_names=np.array(list(self.landmarks)),
            lip_line=self.lip_line,
            names=np.array(list(self.vertices)),
            files=np.array(self.files),
            **own,
        )

    @classmethod
    def load(cls, path: str | Path) -> Truth:
        """Read what `save` wrote."""
        with np.load(path) as file:
            own = {key: file[key] for key in file.files}
        width, height = (int(side) for side in own["size"])
        x, y = (float(part) for part in own["centre"])
        lens = Lens((width, height), float(own["focal"]), (x, y), float(own["radial"]))
        names = [str(name) for name in own["names"]]
        shots = {
            name: tuple(
                Shot(lens, rotation, position)
                for rotation, position in zip(
                    own[f"{name}_rotations"], own[f"{name}_positions"], strict=True
                )
            )
            for name in names
        }
        return cls(
            own["triangles"],
            own["materials"],
            own["of_template"],
            {
                str(name): int(vertex)
                for name, vertex in zip(own["landmark_names"], own["landmarks"], strict=True)
            },
            own["lip_line"],
            {name: own[f"{name}_vertices"] for name in names},
            {name: own[f"{name}_turn"] for name in names},
            {name: own[f"{name}_shift"] for name in names},
            shots,
            tuple(str(file) for file in own["files"]),
        )
