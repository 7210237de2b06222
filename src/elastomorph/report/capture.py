"""The report of a capture: what photographs gave, and how far it is to be trusted.

Tables of photographs, agreement and time; trust in a sentence, in tables, and as a list of
vertices.

Pictures for the report of a capture: cameras around the head, and poses through their cameras.

Drawn by the rays and the pixels that a capture works with anyway, so that its report needs nothing
that is not installed for it.
"""

from __future__ import annotations

import json
import math
from base64 import b64encode
from collections.abc import Callable, Collection, Mapping, Sequence
from colorsys import hsv_to_rgb
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.cameras.coverage import times_seen
from elastomorph.capturing.geometry import Camera, Surface, open_colours
from elastomorph.capturing.work.captured import Captured
from elastomorph.capturing.work.registered import FLAGGED, Registered
from elastomorph.draw.camera import Camera as Looking
from elastomorph.draw.over_photographs import box_of, over_photograph
from elastomorph.errors import FileError
from elastomorph.evaluation.words import SPACE, counted, significant
from elastomorph.model.mesh import Mesh
from elastomorph.report.document import (
    Picture,
    Section,
    document,
    face_words,
    require_page_path,
    write_page,
)

Points = NDArray[np.float64]
Pixels = NDArray[np.uint8]

_CLAY = np.array([0.86, 0.87, 0.88])
_DOUBT = np.array([0.98, 0.80, 0.30])
_FLAG = np.array([0.93, 0.42, 0.28]), np.array([0.66, 0.07, 0.12])
_PAPER = 255
_QUALITY = 82
_HEIGHT = 560  # of a pose in pixels
_GAP = 8
# White: a packed picture keeps colours in coarse blocks, and coloured lines would tint the skin.
_LINE, _FLAGGED_LINE = (1.0, 1.0, 1.0), (1.0, 0.2, 0.15)
_PYRAMID = 0.09  # height of that of a camera, of its distance from the head
_SIDES = {"front": (0.0, 0.0), "side": (90.0, 0.0), "above": (0.0, 89.0)}


@dataclass(frozen=True, eq=False)
class Shown(Picture):
    """A picture that is packed by the library that opened the photographs."""

    @property
    def source(self) -> str:
        """The picture itself as a ``data:`` address of WebP."""
        from base64 import b64encode

        import cv2

        own = np.ascontiguousarray(self.image[..., ::-1])
        _, packed = cv2.imencode(".webp", own, [cv2.IMWRITE_WEBP_QUALITY, _QUALITY])
        return f"data:image/webp;base64,{b64encode(packed.tobytes()).decode('ascii')}"


def confidence_colours(confidence: NDArray[np.floating]) -> Points:
    """(V, 3) red, green, blue of (V,) confidences: clay, yellow where in doubt, red where flagged.

    The step at the confidence from which on a vertex is flagged is one of colour, too.
    """
    share = np.asarray(confidence, dtype=np.float64)[:, None]
    sure = np.clip((share - FLAGGED) / (1 - FLAGGED), 0, 1)
    kept = _DOUBT + (_CLAY - _DOUBT) * sure
    lost = _FLAG[1] + (_FLAG[0] - _FLAG[1]) * np.clip(share / FLAGGED, 0, 1)
    found: Points = np.where(share >= FLAGGED, kept, lost)
    return found


def frontal(cameras: Sequence[Camera], mesh: Registered) -> Camera:
    """The camera that most of what is to be trusted faces."""
    normals = Surface(mesh.vertices, mesh.faces.triangles()).normals

    def faced(camera: Camera) -> float:
        towards = camera.position - mesh.vertices
        towards /= np.linalg.norm(towards, axis=1, keepdims=True)
        cosines = np.einsum("vi,vi->v", normals, towards)
        return float((np.maximum(cosines, 0) * mesh.confidence).sum())

    return max(cameras, key=faced)


def beside(front: Camera, cameras: Sequence[Camera], mesh: Registered) -> Camera:
    """The camera that sees the mesh most nearly from where another one did."""
    middle = mesh.vertices.mean(axis=0)

    def direction(camera: Camera) -> Points:
        away = camera.position - middle
        found: Points = away / np.linalg.norm(away)
        return found

    return max(cameras, key=lambda camera: float(direction(camera) @ direction(front)))


def pose_picture(mesh: Registered, camera: Camera, photograph: Path) -> Pixels:
    """Through one camera: the photograph, the template drawn over it, and the confidence.

    Args:
        mesh: The pose, in the frame of the camera.
        camera: That took the photograph.
        photograph: Its file.

    Returns:
        (H, W, 3) uint8.

    Raises:
        FileError: The photograph cannot be read.
    """
    surface = Surface(mesh.vertices, mesh.faces.triangles())
    own, picture = _around(surface, camera, photograph)
    lines = np.where(mesh.flagged[:, None], _FLAGGED_LINE, _LINE)
    over = over_photograph(picture, own, mesh, colours=lines)
    painted = _rendered(surface, own, confidence_colours(mesh.confidence))
    gap = np.full((len(painted), _GAP, 3), _PAPER, dtype=np.uint8)
    return np.concatenate([picture, gap, over, gap, painted], axis=1)


def front_picture(mesh: Registered, size: tuple[int, int] = (420, 420)) -> Pixels:
    """(H, W, 3) uint8 a pose from the front and from the side, painted with its confidence."""
    surface = Surface(mesh.vertices, mesh.faces.triangles())
    colours = confidence_colours(mesh.confidence)
    views = [
        _rendered(surface, _looking(Looking.framing(mesh.vertices, side, size=size), size), colours)
        for side in (_SIDES["front"], _SIDES["side"])
    ]
    return np.concatenate(views, axis=1)


def _around(surface: Surface, camera: Camera, photograph: Path) -> tuple[Camera, Pixels]:
    """The part of a photograph that shows a pose, made as small as it is shown."""
    _, top, _, bottom = box_of(camera, surface.vertices)
    scale = min(1.0, _HEIGHT / (bottom - top))
    own, picture = open_colours(camera, photograph, scale=scale)
    left, top, right, bottom = box_of(own, surface.vertices)
    part = replace(own, size=(right - left, bottom - top), centre=own.centre - [left, top])
    return part, np.ascontiguousarray(picture[top:bottom, left:right])


def _rendered(surface: Surface, camera: Camera, colours: Points) -> Pixels:
    """(H, W, 3) uint8 the surface in the colours (V, 3) of its vertices, on paper."""
    hits = surface.seen(camera)
    towards = -camera.directions()
    towards /= np.linalg.norm(towards, axis=-1, keepdims=True)
    facing = np.abs(np.einsum("hwi,hwi->hw", surface.at(hits, surface.normals), towards))
    lit = surface.at(hits, colours) * (0.35 + 0.65 * np.clip(facing, 0, 1))[..., None]
    found = np.where(hits.met[..., None], lit, _PAPER / 255)
    return np.asarray(np.rint(255 * np.clip(found, 0, 1)), dtype=np.uint8)


def camera_picture(
    cameras: Mapping[str, Sequence[Camera]],
    colours: Mapping[str, tuple[int, int, int]],
    mesh: Mesh | None,
    size: tuple[int, int] = (420, 420),
) -> Pixels:
    """Where the cameras of all poses stood, from the front, the side and above.

    Args:
        cameras: Of each pose, in one frame.
        colours: Red, green and blue of each pose, from 0 to 255.
        mesh: The neutral; without one the cameras are turned so that up is up.
        size: Of one of the three views in pixels.
    """
    every = [camera for own in cameras.values() for camera in own]
    turn, head = np.eye(3), None
    if mesh is not None:
        middle = mesh.vertices.mean(axis=0)
        head = Surface(mesh.vertices - middle, mesh.faces.triangles())
    else:
        middle = np.mean([_ahead(camera, every) for camera in every], axis=0)
        turn = _upright(every, middle)
    reach = float(np.median([np.linalg.norm(c.position - middle) for c in every]))
    frusta = {
        pose: np.array([(_frustum(c, _PYRAMID * reach) - middle) @ turn.T for c in own])
        for pose, own in cameras.items()
        if own
    }
    cloud = np.concatenate([own.reshape(-1, 3) for own in frusta.values()])
    if head is not None:
        cloud = np.concatenate([cloud, head.vertices])
    views = []
    for side in _SIDES.values():
        looking = _looking(Looking.framing(cloud, side, size=size, margin=0.03), size)
        image = _blank(size)
        if head is not None:
            image = _rendered(head, looking, np.tile(_CLAY, (len(head.vertices), 1)))
        for pose, own in frusta.items():
            _draw_frusta(image, looking, own, colours[pose])
        views += [image, np.full((size[1], _GAP, 3), _PAPER, dtype=np.uint8)]
    picture = np.concatenate(views[:-1], axis=1)
    drawn = np.flatnonzero((picture < _PAPER).any(axis=(1, 2)))
    return picture[max(0, drawn[0] - _GAP) : drawn[-1] + _GAP]


def _blank(size: tuple[int, int]) -> Pixels:
    return np.full((size[1], size[0], 3), _PAPER, dtype=np.uint8)


def _frustum(camera: Camera, depth: float) -> Points:
    """(5, 3) where a camera stands, and the corners of what it sees at a depth."""
    width, height = camera.size
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height]], dtype=np.float64)
    rays = camera.through(corners)
    return np.concatenate([camera.position[None], camera.position + depth * rays])


def _draw_frusta(image: Pixels, camera: Camera, frusta: Points, colour: Any) -> None:
    import cv2

    pixels = np.rint(camera.project(frusta)[0] * 16).astype(np.int32)
    around = pixels[:, [1, 2, 3, 4, 1]]
    rays = np.stack([pixels[:, [0, k]] for k in range(1, 5)], axis=1).reshape(-1, 2, 2)
    lines = [np.ascontiguousarray(line) for line in (*around, *rays)]
    cv2.polylines(image, lines, False, colour, 1, cv2.LINE_AA, 4)


def _looking(eye: Looking, size: tuple[int, int]) -> Camera:
    """The camera of pictures as one of photographs."""
    position = np.array(eye.position)
    ahead = np.array(eye.focus) - position
    ahead /= np.linalg.norm(ahead)
    down = -np.array(eye.up)
    down = down - (down @ ahead) * ahead
    down /= np.linalg.norm(down)
    rotation = np.stack([np.cross(down, ahead), down, ahead])
    focal = size[1] / 2 / float(np.tan(np.radians(eye.angle) / 2))
    centre = (np.array(size) - 1) / 2
    return Camera("", size, focal, centre, 0.0, rotation, -rotation @ position)


def _ahead(camera: Camera, every: Sequence[Camera]) -> Points:
    """What a camera looks at, as far away as the others are."""
    reach = np.linalg.norm(camera.position - np.mean([c.position for c in every], axis=0))
    found: Points = camera.position + camera.rotation[2] * reach
    return found


def _upright(cameras: Sequence[Camera], middle: Points) -> Points:
    """(3, 3) a turn after which up in most photographs is +Y, and the cameras stand before +Z."""
    up = -np.mean([camera.rotation[1] for camera in cameras], axis=0)
    back = np.mean([camera.position for camera in cameras], axis=0) - middle
    up /= max(float(np.linalg.norm(up)), 1e-12)
    back = back - (back @ up) * up
    if not np.linalg.norm(back) > 1e-9:
        back = -cameras[0].rotation[2]
        back = back - (back @ up) * up
    back /= max(float(np.linalg.norm(back)), 1e-12)
    return np.stack([np.cross(up, back), up, back])


_BEFORE = 0.005  # of D: part of the head that may stand before a vertex without hiding it


@dataclass(frozen=True, eq=False)
class Trust:
    """What is known of the vertices of a pose.

    Attributes:
        flagged: (V,) which are not to be trusted.
        seen: (V,) which some camera saw well enough to measure them.
    """

    flagged: NDArray[np.bool_]
    seen: NDArray[np.bool_]

    @classmethod
    def of(cls, mesh: Registered, cameras: Sequence[Camera]) -> Trust:
        """Of a pose and the cameras of its photographs, both in one frame."""
        surface = Surface(mesh.vertices, mesh.faces.triangles())
        return cls(mesh.flagged, times_seen(surface, cameras, _BEFORE * mesh.diameter) > 0)

    @property
    def unseen(self) -> int:
        """Flagged vertices that no camera saw."""
        return int((self.flagged & ~self.seen).sum())

    @property
    def doubtful(self) -> int:
        """Vertices that are flagged although cameras saw them."""
        return int((self.flagged & self.seen).sum())

    @property
    def trusted(self) -> int:
        """All others."""
        return int((~self.flagged).sum())

    @property
    def share(self) -> float:
        """Of what cameras saw, how much is to be trusted."""
        return self.trusted / max(self.trusted + self.doubtful, 1)


def headline(trust: Mapping[str, Trust]) -> str:
    """How many poses there are, and how much of what was seen is to be trusted."""
    shares = {pose: own.share for pose, own in trust.items()}
    worst = min(shares, key=lambda pose: shares[pose])
    vertices = f"{len(trust[worst].seen):,} vertices"
    poses = f"{counted(len(trust), 'pose')} of {vertices}{' each' if len(trust) > 1 else ''}"
    least = f", least in {worst}" if len({_percent(share) for share in shares.values()}) > 1 else ""
    return f"{poses}. Of what the cameras saw, {_span(shares.values())} can be trusted{least}."


def findings(trust: Mapping[str, Trust]) -> list[str]:
    """What is not to be trusted, and for which of two reasons."""
    unseen = {pose: own.unseen / len(own.seen) for pose, own in trust.items()}
    doubtful = {pose: own.doubtful / len(own.seen) for pose, own in trust.items()}
    found = []
    if any(unseen.values()):
        found.append(
            f"No camera saw {_span(unseen.values())} of the vertices, as on the back of a head or "
            "within the mouth. They were placed by what is around them."
        )
    if any(doubtful.values()):
        most = max(doubtful, key=lambda pose: doubtful[pose])
        found.append(
            f"{_span(doubtful.values())} of the vertices are doubtful although cameras saw them"
            f"{f', most in {most}' if len(trust) > 1 else ''}. The pictures pose by pose show "
            "where."
        )
    return found


def trust_section(poses: Mapping[str, Registered], trust: Mapping[str, Trust]) -> Section:
    """How many vertices of each pose are to be trusted, where the others are, and their list."""
    rows = [
        (
            pose,
            [
                f"{own.trusted:,}",
                f"{own.doubtful:,}",
                f"{own.unseen:,}",
                f"{_percent(own.share)}{SPACE}%",
            ],
        )
        for pose, own in trust.items()
    ]
    unseen, doubtful = (
        {
            pose: np.flatnonzero(own.flagged & (own.seen == seen)).tolist()
            for pose, own in trust.items()
        }
        for seen in (False, True)
    )
    listed = {"version": 1, "below": FLAGGED, "doubtful": doubtful, "unseen": unseen}
    text = json.dumps(listed, separators=(",", ":"), ensure_ascii=False)
    first = next(iter(poses.values()))
    content = {
        "rows": rows,
        "groups": _by_group(first, trust),
        "heads": ["Material" if first.groups is None else "Group", "Vertices", *poses],
        "least": f"{FLAGGED:g}",
        "link": f"data:application/json;base64,{b64encode(text.encode()).decode('ascii')}",
        "words": counted(
            sum(own.unseen + own.doubtful for own in trust.values()), "entry", "entries"
        ),
    }
    return Section("trust", "What can be trusted", content)


def _by_group(mesh: Mesh, trust: Mapping[str, Trust]) -> list[tuple[str, list[str]]]:
    """Doubtful vertices of each group in each pose, the worst group first; none of one group."""
    groups = vertex_groups(mesh)
    if len(groups) < 2:
        return []
    counts = {
        name: [int((own.flagged & own.seen & chosen).sum()) for own in trust.values()]
        for name, chosen in groups.items()
    }
    return [
        (name, [f"{groups[name].sum():,}", *(f"{count:,}" for count in counts[name])])
        for name in sorted(groups, key=lambda name: -max(counts[name]))
    ]


def vertex_groups(mesh: Mesh) -> dict[str, NDArray[np.bool_]]:
    """(V,) which vertices each group of a mesh has, or each material where there are no groups.

    A vertex of several is of the first; those of none are unnamed.
    """
    labels = mesh.groups if mesh.groups is not None else mesh.materials
    if labels is None:
        return {"whole mesh": np.ones(len(mesh.vertices), dtype=bool)}
    group = np.full(len(mesh.vertices), len(labels.names))
    of_corner = labels.of_face[mesh.faces.corner_faces]
    named = of_corner >= 0
    np.minimum.at(group, mesh.faces.indices[named], of_corner[named])
    names = [*labels.names, "unnamed"]
    return {name: group == k for k, name in enumerate(names) if (group == k).any()}


def _percent(share: float) -> str:
    """In whole per cent, or tenths of little; never rounded to all of it."""
    parts = 10 if share < 0.1 else 1
    return f"{math.floor(100 * parts * share) / parts:g}"


def _span(shares: Collection[float]) -> str:
    low, high = _percent(min(shares)), _percent(max(shares))
    return f"{low}{SPACE}%" if low == high else f"{low} to {high}{SPACE}%"


Figures = Mapping[str, Any]

_HEADS = {
    "points": "Points",
    "matches": "Matches",
    "median": "Median",
    "mean": "Mean",
    "p95": "95 % below",
    "max": "Largest",
    "views": "Photographs a vertex, median",
    "seen": "Vertices in 4 photographs or more",
}
_SHARES = ("seen",)


def photographs_section(figures: Figures) -> Section:
    """Reprojection error of each photograph, and why some are not used."""
    poses = figures.get("poses", {})
    rejected = [
        (name, [pose, why])
        for pose, own in poses.items()
        for name, why in own.get("rejected", {}).items()
    ]
    rows, bars = [], []
    highest = max(
        (error for own in poses.values() for error in own.get("reprojection", {}).values()),
        default=1.0,
    )
    for pose, own in poses.items():
        errors = own.get("reprojection", {})
        worst = max(errors, key=lambda name: errors[name], default="")
        cells = [
            f"{own.get('cameras', len(errors))} of {own.get('photographs', len(errors))}",
            f"{own.get('points', 0):,}",
            f"{np.mean(list(errors.values())):.3f}" if errors else "",
            f"{errors[worst]:.3f} ({worst})" if worst else "",
        ]
        rows.append((pose, cells))
        bars.append(
            {
                "pose": pose,
                "errors": [
                    {"name": name, "text": f"{error:.3f}", "share": error / (highest or 1.0)}
                    for name, error in errors.items()
                ],
            }
        )
    content = {
        "heads": ["Pose", "Photographs used", "Points", "Reprojection, mean, px", "Worst, px"],
        "rows": rows,
        "bars": bars,
        "highest": f"{highest:.2f}{SPACE}px",
        "rejected": rejected,
    }
    return Section("photographs", "Photograph by photograph", content)


def agreement(figures: Figures) -> Section:
    """How well surfaces fit, and apart from it how well skin is where it was."""
    poses = figures.get("poses", {})
    content = {
        "surface": _measured(poses, "surface"),
        "correspondence": _measured(poses, "correspondence"),
        "landmarks": [
            (name, [f"{error:.1f}"]) for name, error in figures.get("landmarks", {}).items()
        ],
        "frames": [
            (pose, [f"{100 * own['frame']['rms_of_extent']:.3f}", f"{own['frame']['agreeing']:,}"])
            for pose, own in poses.items()
            if "frame" in own
        ],
    }
    return Section("agreement", "Surface and correspondence", content)


def _measured(poses: Mapping[str, Any], kind: str) -> dict[str, Any] | None:
    """One row a pose of what was measured of one kind; None where nothing was."""
    found = {pose: own[kind] for pose, own in poses.items() if own.get(kind)}
    names = list(dict.fromkeys(name for own in found.values() for name in own))
    if not names:
        return None
    rows = [(pose, [_cell(name, own.get(name)) for name in names]) for pose, own in found.items()]
    return {"heads": ["Pose", *(_HEADS.get(name, name) for name in names)], "rows": rows}


def _cell(name: str, value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, int):
        return f"{value:,}"
    return f"{100 * value:.1f}{SPACE}%" if name in _SHARES else f"{100 * value:.3f}"


def times(figures: Figures) -> Section:
    """How long each stage took, whenever it was made."""
    seconds: Mapping[str, float] = figures.get("seconds", {})
    total = sum(seconds.values())
    rows = [
        {
            "name": name,
            "text": duration(own),
            "share": own / max(max(seconds.values()), 1e-9),
        }
        for name, own in seconds.items()
    ]
    return Section("times", "How long it took", {"rows": rows, "total": duration(total)})


def duration(seconds: float) -> str:
    """Such as "0.4 s", "38 s", "4 min 10 s" or "1 h 5 min"."""
    if seconds < 9.95:
        return f"{seconds:.1f}{SPACE}s"
    whole = round(seconds)
    if whole < 60:
        return f"{whole}{SPACE}s"
    minutes, rest = divmod(whole, 60)
    if minutes < 60:
        return f"{minutes}{SPACE}min {rest}{SPACE}s"
    return f"{minutes // 60}{SPACE}h {minutes % 60}{SPACE}min"


def size_words(diameter: float, unit: str) -> str:
    """D, the size of the neutral."""
    return (
        f"D = {significant(diameter)} {unit or 'units'}, the distance of the two vertices of the "
        "neutral that are farthest apart"
    )


_MOST = 12
"""Pictures of poses from scans; of a take of hundreds some, evenly chosen."""
_LARGE_DOUBT = 0.25
"""Of the place of a head, in % of D, that is told."""
_FIRST, _LAST = 0.60, 0.05
"""Hues of the first pose and of the last."""


def write_capture_report(
    captured: Captured,
    path: str | Path,
    *,
    name: str = "capture",
    unit: str = "",
    call: str = "",
    say: Callable[[str], None] = lambda _: None,
) -> None:
    """Write one self-contained HTML page about a capture, the whole of it or nothing.

    Args:
        captured: Poses, cameras and figures. Photographs are opened, one of each pose.
        path: The page, ``.html``; its folder must exist.
        name: What was captured, for the title.
        unit: Of the coordinates, such as ``cm``; an empty string where nobody knows it.
        call: The command or the call that makes this again.
        say: Told what is being done.

    Raises:
        FormatError: The suffix is not .html.
        FileError: The page cannot be written.
        MissingExtraError: The extra ``capture`` is not installed.
    """
    require_page_path(path)
    write_page(path, capture_page(captured, name=name, unit=unit, call=call, say=say))


def write_register_report(
    poses: Mapping[str, Registered], path: str | Path, *, name: str = "register", call: str = ""
) -> None:
    """Write one self-contained HTML page about registered scans, the whole of it or nothing.

    Args:
        poses: As `register_all` gives them.
        path: The page, ``.html``; its folder must exist.
        name: What was scanned, for the title.
        call: The command or the call that makes this again.

    Raises:
        FormatError: The suffix is not .html.
        FileError: The page cannot be written.
        MissingExtraError: The extra ``capture`` is not installed.
    """
    require_page_path(path)
    first = next(iter(poses.values()))
    doubted = {own: pose for own, pose in poses.items() if _doubt(pose) > _LARGE_DOUBT}
    share = np.mean([pose.flagged.mean() for pose in poses.values()])
    remarks = [
        f"{own}: the head may be turned by {pose.figures['head']['doubt_degrees']:.1f}° otherwise."
        for own, pose in sorted(doubted.items(), key=lambda each: -_doubt(each[1]))[:_MOST]
    ]
    if len(doubted) > _MOST:
        remarks.append(f"So may those of {len(doubted) - _MOST:,} more; see the table.")
    facts = [
        ("Poses", f"{len(poses):,}"),
        ("Template", face_words(first)),
        ("Correspondence", ", ".join({pose.figures["correspondence"] for pose in poses.values()})),
    ]
    words = f"{counted(len(poses), 'pose')}, {100 * share:.0f}{SPACE}% of vertices flagged."
    shown = [list(poses)[round(k)] for k in np.linspace(0, len(poses) - 1, min(_MOST, len(poses)))]
    pictures = [
        Shown(
            own,
            front_picture(poses[own]),
            f"{own} from the front and from the side, painted with its confidence.",
            f"{own}: {100 * poses[own].flagged.mean():.0f}{SPACE}% of vertices flagged.",
        )
        for own in dict.fromkeys(shown)
    ]
    rows = [
        (
            own,
            [
                pose.figures["correspondence"],
                f"{pose.figures['surface_mean']:.3f}",
                f"{100 * pose.figures['shown']:.0f}",
                f"{100 * pose.figures['flagged']:.1f}",
                f"{_doubt(pose):.2f}",
            ],
        )
        for own, pose in poses.items()
    ]
    content = {"headline": words, "remarks": remarks, "facts": facts, "call": call}
    table = {"pictures": pictures, "rows": rows, "least": f"{FLAGGED:g}"}
    sections = [
        Section("captured", "What was registered", content),
        Section("registered", "Pose by pose", table),
    ]
    write_page(path, document(name, f"{counted(len(poses), 'pose')} from scans", sections))


def _doubt(pose: Registered) -> float:
    """About the place of a pose's head, in % of D on average."""
    return float(pose.figures.get("head", {}).get("doubt_mean", 0.0))


def capture_page(
    captured: Captured,
    *,
    name: str = "capture",
    unit: str = "",
    call: str = "",
    say: Callable[[str], None] = lambda _: None,
) -> str:
    """The page that `write_capture_report` writes; arguments and errors are the same."""
    trust = {
        pose: Trust.of(mesh, captured.cameras.get(pose, ()))
        for pose, mesh in captured.poses.items()
    }
    sections = [_captured(captured, trust, unit, call)]
    neutral = captured.poses.get(captured.neutral)
    if any(captured.cameras.values()):
        say("drawing cameras")
        sections.append(_cameras(captured, neutral))
    sections += [photographs_section(captured.figures), agreement(captured.figures)]
    if captured.poses:
        sections.append(_poses(captured, trust, say))
        sections.append(trust_section(captured.poses, trust))
    sections.append(times(captured.figures))
    taken = sum(map(len, captured.cameras.values()))
    found = counted(len(captured.poses), "pose") if captured.poses else "cameras alone"
    return document(name, f"{found} from {counted(taken, 'photograph')}", sections)


def _captured(captured: Captured, trust: Mapping[str, Trust], unit: str, call: str) -> Section:
    """What there is, and in one sentence how much of it is to be trusted."""
    figures = captured.figures.get("poses", {})
    given = sum(own.get("photographs", 0) for own in figures.values())
    used = sum(map(len, captured.cameras.values()))
    facts = [("Photographs", f"{used:,} used of {given:,}")]
    first, remarks = f"{counted(used, 'camera')} found; no poses were asked for.", []
    if captured.poses:
        neutral = captured.poses[captured.neutral]
        first, remarks = headline(trust), findings(trust)
        facts += [
            ("Poses", f"{', '.join(captured.poses)}; the neutral is {captured.neutral}"),
            ("Template", face_words(neutral)),
            ("Size", size_words(neutral.diameter, unit)),
        ]
    remarks += [
        f"{pose}: {remark}" for pose, own in figures.items() for remark in own.get("remarks", [])
    ]
    content = {"headline": first, "remarks": remarks, "facts": facts, "call": call}
    return Section("captured", "What was captured", content)


def _cameras(captured: Captured, head: Mesh | None) -> Section:
    """Where the cameras stood, in three views."""
    every = {pose: own for pose, own in captured.cameras.items() if own}
    colours = {}
    for place, pose in enumerate(every):
        share = place / max(len(every) - 1, 1)
        hue = _FIRST + (_LAST - _FIRST) * share
        red, green, blue = (round(255 * own) for own in hsv_to_rgb(hue, 0.85, 0.78))
        colours[pose] = (red, green, blue)
    words = {
        pose: f"{counted(len(own), 'camera')}, focal length "
        f"{_range(sorted({round(camera.focal) for camera in own}))}{SPACE}px"
        for pose, own in every.items()
    }
    alike = len(set(words.values())) == 1 < len(words)
    common = f" Every pose: {next(iter(words.values()))}." if alike else ""
    what = "the head of the neutral" if head is not None else "what they look at"
    picture = Shown(
        "Cameras around the head",
        camera_picture(every, colours, head),
        f"Three views of {counted(sum(map(len, every.values())), 'camera')} around {what}: from "
        "the front, from the side and from above.",
        "From the front, from the side and from above. Each pyramid is a photograph; its tip is "
        "where it was taken. What no pyramid looks at, such as the skin under the chin where none "
        f"is low enough, cannot be trusted.{common}",
    )
    poses = [
        {
            "name": pose,
            "colour": "#{:02x}{:02x}{:02x}".format(*colours[pose]),
            "words": "" if alike else words[pose],
        }
        for pose in every
    ]
    return Section("cameras", "Cameras", {"picture": picture, "poses": poses})


def _range(values: list[int]) -> str:
    low, high = values[0], values[-1]
    return f"{low:,}" if low == high else f"{low:,} to {high:,}"


def _one_of_each(captured: Captured) -> dict[str, Camera]:
    """A camera of each pose, all from about the same side, so that poses can be compared."""
    seen = {pose: captured.cameras.get(pose, ()) for pose in captured.poses}
    seen = {pose: cameras for pose, cameras in seen.items() if cameras}
    if not seen:
        return {}
    first = captured.neutral if captured.neutral in seen else next(iter(seen))
    front = frontal(seen[first], captured.poses[first])
    return {pose: beside(front, own, captured.poses[pose]) for pose, own in seen.items()}


def _poses(captured: Captured, trust: Mapping[str, Trust], say: Callable[[str], None]) -> Section:
    """Each pose through one of its cameras, with the template over it and its confidence."""
    pictures, left_out = [], []
    for pose, camera in _one_of_each(captured).items():
        say(f"drawing {pose}")
        try:
            image = pose_picture(
                captured.poses[pose], camera, captured.photographs[pose][camera.name]
            )
        except FileError as error:  # a report without one of its pictures is better than none
            left_out.append(f"{pose} is not shown: its photograph cannot be opened any more")
            say(str(error))
            continue
        own = trust[pose]
        counts = (
            f"{own.trusted:,} vertices are trusted, {own.doubtful:,} doubtful although cameras saw "
            f"them, {own.unseen:,} seen by no camera."
        )
        pictures.append(
            Shown(
                pose,
                image,
                f"{pose} in the photograph {camera.name}: as it was taken, with the edges of the "
                f"template over it, and the mesh painted with its confidence. {counts}",
                f"Photograph {camera.name}. {counts}",
            )
        )
    content = {"pictures": pictures, "left_out": left_out, "least": f"{FLAGGED:g}"}
    return Section("poses", "Pose by pose", content)
