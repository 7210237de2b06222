"""Paint the head of ICT FaceKit: images in its own texture coordinates, all made by rules.

    python tools/paint_head.py generic_neutral_mesh.obj FOLDER

Colours are functions of where a point is on the neutral, so that no seam of the texture coordinates
is seen, and of a fixed seed: the same head gives the same bytes. Needs the extra ``capture``.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from PIL import ImageDraw
from scipy.ndimage import gaussian_filter
from scipy.spatial import cKDTree

import elastomorph as em
from elastomorph.model.geometry import component_of
from elastomorph.model.mesh import FaceLabels, Mesh
from elastomorph.samples.built_in_head import IMAGES, SKIN
from photographs.noise import Spots, ValueNoise
from texels import (
    Floats,
    chosen,
    corners_of,
    drawn,
    encoded,
    mix,
    openness,
    picture_of,
    places,
    rasterised,
    shrunk,
    spline,
    step,
    stroke,
    texture_coordinates,
)

__all__ = ["labels", "paint"]

Colour = tuple[float, float, float]

SEED = 20
# Pixels on a side: of the skin; of its shine, mouth and teeth; of eye and lashes; of shadows.
LARGE, SMALL, MIDDLE, LEAST = 1024, 256, 512, 64

NAMES = {
    "M_Face": "skin",
    "M_BackHead": "head",
    "M_GumsTongue": "gums",
    "M_Teeth": "teeth",
    "M_ScleraLeft": "sclera",
    "M_ScleraRight": "sclera",
    "M_IrisLeft": "iris",
    "M_IrisRight": "iris",
    "M_LacrimalFluid": "unseen",
    "M_EyeBlend": "unseen",
    "M_EyeOcclusion": "occlusion",
    "M_EyeLashes": "lashes",
}
THIN = ("unseen", "occlusion", "lashes")
# A point of the texture coordinates in each piece with a name of its own: the tongue, the bag of
# the mouth, the sockets of both eyes.
PIECES = (
    ((2.72, 0.30), "tongue"),
    ((1.13, 0.85), "mouth"),
    ((1.93, 0.91), "mouth"),
    ((1.78, 0.91), "mouth"),
)

# Vertices of face trackers' points: brows from the nose outwards, the border of the lips, and the
# line where they meet.
BROWS = ((1401, 2044, 1914, 493, 268), (3615, 4240, 4114, 2734, 2509))
LIPS = (5708, 5695, 2081, 0, 4275, 6200, 6213, 6346, 6461, 5518, 5957, 5841)
MEETING = (5702, 5711, 5533, 6216, 6207, 6470, 5517, 5966)
# Sheets of lashes that are seen, two of an upper lid and one of a lower: where, in the texture
# coordinates, roots and points are. Path tracers turn black behind many: three are left out.
STRIPS = ((0.988, 0.848), (0.822, 0.682), (0.486, 0.346))
LEFT, RIGHT, LENGTH = 0.510, 0.490, 0.478  # where they begin at the nose, and how long they are

# Where skin differs: a point in cm, left and right alike, how far it reaches, and what it leaves of
# red, green and blue in the middle.
ZONES: tuple[tuple[Colour, float, Colour], ...] = (
    ((0.0, 0.3, 12.9), 1.3, (1.00, 0.86, 0.85)),  # tip of the nose
    ((1.5, -0.3, 11.2), 0.9, (0.98, 0.85, 0.83)),  # its wings
    ((4.5, 0.6, 9.3), 2.6, (1.00, 0.91, 0.90)),  # cheeks
    ((8.4, 1.0, 0.8), 2.6, (1.00, 0.84, 0.82)),  # ears
    ((0.0, -6.6, 11.0), 1.5, (0.99, 0.92, 0.91)),  # chin
    ((2.2, 2.3, 9.6), 0.8, (0.93, 0.89, 0.92)),  # under the eyes
    ((3.6, 2.1, 9.5), 0.9, (0.95, 0.90, 0.93)),
    ((3.3, 4.5, 9.6), 0.9, (0.95, 0.90, 0.89)),  # upper lids
    ((1.6, 3.7, 9.6), 0.7, (0.94, 0.89, 0.89)),  # beside the bridge of the nose
    ((0.0, 8.8, 10.0), 3.2, (1.02, 1.03, 1.03)),  # forehead
    ((3.0, -3.6, 10.0), 0.7, (0.95, 0.91, 0.89)),  # corners of the mouth
    ((0.0, -5.1, 11.0), 0.7, (0.95, 0.91, 0.90)),  # under the lower lip
)
OILY: tuple[tuple[Colour, float], ...] = (
    ((0.0, 1.5, 12.2), 1.6),  # nose
    ((0.0, 8.5, 10.2), 2.8),  # forehead
    ((0.0, -6.6, 11.0), 1.2),  # chin
)
# All colours are those of screens.
LIP, LIP_LINE, LID = (172, 98, 92), (112, 50, 48), (150, 84, 74)
HAIR, LASH, SHADE = (48, 32, 24), (30, 20, 17), (58, 22, 18)
GUM, TONGUE, THROAT = (172, 90, 90), (166, 88, 86), (70, 26, 26)
TOOTH, ROOT = (226, 220, 205), (206, 184, 148)
WHITE, CORNER, VEIN = (218, 210, 202), (204, 170, 160), (184, 92, 80)
RIM, IRIS, HEART, PUPIL = (30, 35, 38), (84, 104, 108), (128, 112, 76), (8, 8, 9)
LIMBUS, OPENING = 0.157, 0.056  # radii of iris and pupil in the texture coordinates
# Waves of the iris round the pupil: how many, where they begin, how strong they are.
SPOKES = ((23, 5.0, 0.25), (37, 0.3, 0.3), (61, 2.0, 0.3), (97, 4.1, 0.25), (149, 1.1, 0.2))


def labels(neutral: Mesh) -> FaceLabels:
    """Name the part of each polygon: as ICT does, but for tongue, mouth and sockets.

    These are pieces of their own in the texture coordinates of larger materials. What is better not
    drawn, shells of wetness and half of the sheets of lashes, is "unseen".
    """
    faces, uv, given = neutral.faces, texture_coordinates(neutral), neutral.materials
    if given is None:
        raise ValueError("the mesh has no materials")
    own = np.array([NAMES[name] for name in given.names], dtype="<U16")[given.of_face]
    ends = np.stack([uv.corners, uv.corners[faces.next_corners]], axis=1)
    piece = component_of(len(uv.coordinates), ends)[uv.corners[faces.offsets[:-1]]]
    middles = np.add.reduceat(uv.coordinates[uv.corners, :2], faces.offsets[:-1])
    middles /= faces.sizes[:, None]
    for point, label in PIECES:
        nearest = np.argmin(np.linalg.norm(middles - point, axis=1))
        own[piece == piece[nearest]] = label
    seen = np.any([(low < middles[:, 1]) & (middles[:, 1] < high) for high, low in STRIPS], axis=0)
    own[(own == "lashes") & ~seen] = "unseen"
    names = tuple(dict.fromkeys(own.tolist()))
    numbers = [names.index(name) for name in own.tolist()]
    return FaceLabels(names, np.array(numbers, dtype=np.int32))


def paint(neutral: Mesh) -> dict[str, bytes]:
    """Paint all images of the head, by the names of files that its materials know.

    Args:
        neutral: ICT's generic neutral, all its vertices in their order.
    """
    part = labels(neutral)
    skin, shine = _skin(neutral, part)
    mouth, teeth = _mouth(neutral, part)
    images = {"skin": skin, "shine": shine, "eye": _eye(), "mouth": mouth, "teeth": teeth}
    images |= {"lashes": _lashes(), "shadow": _shadow()}
    return {name: encoded(images[Path(name).stem], name) for name in IMAGES}


def _skin(neutral: Mesh, part: FaceLabels) -> tuple[Floats, Floats]:
    """Colour, and smaller how it shines: openness to light in red and roughness in green."""
    own = chosen(part, "skin")
    border = np.intersect1d(corners_of(neutral, own), corners_of(neutral, chosen(part, "head")))
    inward = cKDTree(neutral.vertices[border]).query(neutral.vertices)[0]
    light = openness(neutral, own, ~chosen(part, *THIN), SEED)
    under = rasterised(neutral, own, np.column_stack([neutral.vertices, light, inward]), LARGE)
    points, light, inward = under[..., :3], under[..., 3], under[..., 4]
    flat = points.reshape(-1, 3).astype(np.float32)

    def noise(number: int, cell: float, stretch: Colour = (1, 1, 1)) -> Floats:
        scaled = (flat / np.array(stretch)).astype(np.float32)
        found = ValueNoise([SEED, number], cell)(scaled)
        return found.reshape(light.shape).astype(np.float64)

    colour = np.ones((*light.shape, 3))
    for middle, reach, tint in ZONES:
        for side in (1.0, -1.0) if middle[0] else (1.0,):
            near = _near(points, (side * middle[0], *middle[1:]), reach)
            colour *= 1 + near[..., None] * (np.array(tint) - 1)
    blood = 0.5 * noise(1, 2.6) + 0.45 * noise(2, 0.9) + 0.4 * noise(3, 0.3)
    colour *= 1 + blood[..., None] * [0.006, -0.032, -0.030]
    pores = Spots([SEED, 4], 0.13, 0.7)(flat).reshape(light.shape)
    freckles = Spots([SEED, 5], 0.55, 0.10)(flat).reshape(light.shape)
    grain = 1 + 0.018 * noise(6, 0.10) - 0.045 * pores
    colour *= grain[..., None] * (1 - freckles[..., None] * [0.05, 0.10, 0.12])
    # In a crease light goes from skin to skin, and is red when it leaves.
    colour *= np.clip(light, 0.05, 1)[..., None] ** [0.50, 0.72, 0.78]
    # The back of the head has one colour: toward it differences from that go.
    fade = step(inward, 0.1, 2.6)
    colour = np.array(SKIN) * (1 + fade[..., None] * (colour - 1))

    lips, line = _lips(neutral)
    furrows = 1 + 0.05 * noise(7, 0.09, (1, 6, 6)) + 0.05 * noise(8, 0.5)
    red = np.array(LIP) * furrows[..., None] * np.clip(light, 0.3, 1)[..., None] ** [0.3, 0.5, 0.5]
    colour = mix(mix(colour, red, 0.88 * lips), LIP_LINE, 0.8 * line)
    away = np.asarray(cKDTree(_lash_roots(neutral)).query(flat)[0]).reshape(light.shape)
    colour = mix(colour, LID, 0.40 * np.exp(-((away / 0.20) ** 2)))
    colour = mix(colour, LASH, 0.55 * np.exp(-((away / 0.07) ** 2)))
    hair = _brows(neutral)
    colour = mix(colour, HAIR, hair)

    oil = np.sum([_near(points, middle, reach) for middle, reach in OILY], axis=0)
    rough: Floats = 0.56 - 0.08 * oil + 0.05 * noise(9, 0.6) + 0.04 * noise(10, 0.2)
    rough = rough + (0.42 - rough) * lips + (0.75 - rough) * 0.8 * hair
    rough = 0.58 + (rough - 0.58) * fade
    shine = np.stack([step(light, 0.0, 0.45), rough, 0 * rough], axis=-1)
    times = LARGE // SMALL
    shine = shine.reshape(SMALL, times, SMALL, times, 3).mean(axis=(1, 3))
    return colour, 255 * shine


def _near(points: Floats, middle: Colour, reach: float) -> Floats:
    """1 at a point, less the farther from it."""
    away = np.linalg.norm(points - np.array(middle), axis=-1)
    return np.asarray(np.exp(-((away / reach) ** 2)))


def _lips(neutral: Mesh) -> tuple[Floats, Floats]:
    """How much each texel of the skin is lip, and how much it is inside of the line between."""
    masks = []
    for vertices, soft in ((LIPS, 0.0045), (MEETING, 0.006)):
        picture, pen = picture_of(LARGE)
        pen.polygon(drawn(spline(places(neutral, vertices), 240, closed=True), picture), fill=255)
        masks.append(gaussian_filter(shrunk(picture), soft * LARGE))
    return masks[0], masks[1]


def _brows(neutral: Mesh) -> Floats:
    """How much each texel of the skin is hair of the brows: single strokes on a soft ground."""
    random = np.random.default_rng([SEED, 11])
    hairs, ground = picture_of(LARGE)[0], picture_of(LARGE)[0]
    t = np.linspace(0, 1, 200)
    half = 0.015 * np.interp(t, [0, 0.12, 0.35, 0.7, 1], [0.50, 0.90, 1.0, 0.60, 0.15])
    for vertices in BROWS:
        along = spline(places(neutral, vertices), 200) - [0, 0.006]  # trackers' are rather high
        outward = np.gradient(along, axis=0)
        outward /= np.linalg.norm(outward, axis=1)[:, None]
        up = np.stack([-outward[:, 1], outward[:, 0]], axis=1)
        up *= np.sign(up[:, 1:])
        edges = along + up * half[:, None], along - up * half[:, None]
        outline = np.concatenate([edges[0], edges[1][::-1]])
        ImageDraw.Draw(ground).polygon(drawn(outline, ground), fill=255)
        for _ in range(520):
            at = int(199 * random.beta(1.15, 1.15))
            aside = random.triangular(-1.15, -0.05, 1.0)
            lean = np.interp(t[at], [0, 0.15, 0.4, 1], [80, 52, 26, 8])
            # Hairs of the upper and of the lower edge lean toward each other.
            turn = np.radians(lean - 20 * aside * min(1, 3 * t[at]) + random.normal(0, 7))
            length = 0.027 * np.interp(t[at], [0, 0.2, 0.7, 1], [0.75, 1.1, 1.0, 0.6])
            length *= random.uniform(0.7, 1.1)
            start = along[at] + up[at] * aside * half[at] * 0.95
            ahead = np.cos(turn) * outward[at] + np.sin(turn) * up[at]
            bend = 0.12 * length * (ahead - outward[at])
            stroke(hairs, start, length * ahead, bend, 4.6, int(random.uniform(120, 255)))
    soft = gaussian_filter(shrunk(ground), 0.006 * LARGE)
    return 1 - (1 - 0.90 * shrunk(hairs)) * (1 - 0.34 * soft)


def _lash_roots(neutral: Mesh) -> Floats:
    """(N, 3) points close together along the roots of the lashes of each lid."""
    uv = texture_coordinates(neutral)
    at, points = uv.coordinates[uv.corners, :2], []
    for left in (True, False):
        for root in (STRIPS[0][0], STRIPS[-1][0]):
            row = (abs(at[:, 1] - root) < 2e-3) & (at[:, 0] > 6) & ((at[:, 0] > 6.5) == left)
            along, first = np.unique(at[row, 0].round(4), return_index=True)
            known = neutral.vertices[neutral.faces.indices[row][first]]
            fine = np.linspace(along[0], along[-1], 300)
            points.append(np.column_stack([np.interp(fine, along, axis) for axis in known.T]))
    return np.concatenate(points)


def _eye() -> Floats:
    """Iris and white from in front; the middle of the image is that of the pupil."""
    random = np.random.default_rng([SEED, 12])
    across = (np.arange(MIDDLE) + 0.5) / MIDDLE - 0.5
    x, y = np.meshgrid(across, -across)
    out, turn = np.hypot(x, y), np.arctan2(y, x)
    veins, pen = picture_of(MIDDLE)
    for _ in range(70):
        radii = np.linspace(0.46, random.uniform(0.20, 0.30), 40)
        angles = random.uniform(-np.pi, np.pi) + np.cumsum(random.normal(0, 0.018, 40))
        path = 0.5 + radii[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        pen.line(drawn(path, veins), fill=int(random.uniform(40, 130)), width=4)
    colour = mix(np.broadcast_to(WHITE, (*out.shape, 3)), CORNER, 0.65 * step(out, 0.2, 0.42))
    colour = mix(colour, VEIN, 0.65 * shrunk(veins))

    spokes = np.zeros_like(out)
    for count, phase, weight in SPOKES:
        spokes += weight * np.sin(count * turn + phase + 1.2 * np.sin(out * 90 + phase))
    inward = (LIMBUS - out) / (LIMBUS - OPENING)
    iris = mix(np.broadcast_to(IRIS, colour.shape), RIM, 0.75 * step(-inward, -0.42, -0.02))
    iris = mix(iris, HEART, 0.7 * step(inward + 0.10 * spokes, 0.50, 0.85))
    iris *= (1 + 0.26 * spokes * step(inward, 0.02, 0.25))[..., None]
    iris *= (1 - 0.45 * step(inward, 0.90, 1.0))[..., None]
    iris = mix(iris, PUPIL, step(-out, -OPENING - 0.004, -OPENING + 0.003))
    return mix(colour, iris, step(-out, -LIMBUS - 0.009, -LIMBUS + 0.006))


def _mouth(neutral: Mesh, part: FaceLabels) -> tuple[Floats, Floats]:
    """Gums with the tongue, and teeth: darker the deeper they are, where light seldom gets."""
    own, tongue = chosen(part, "gums", "tongue"), chosen(part, "tongue")
    points = rasterised(neutral, own, neutral.vertices, SMALL)
    on_tongue = rasterised(neutral, tongue, neutral.vertices[:, :1], SMALL, filled=False)[..., 0]
    flat, tone = points.reshape(-1, 3).astype(np.float32), np.ones(points.shape[:2])
    for number, cell in enumerate((1.2, 0.3)):
        tone += 0.05 * ValueNoise([SEED, 13, number], cell)(flat).reshape(tone.shape)
    is_tongue = gaussian_filter(np.isfinite(on_tongue).astype(np.float64), 1.0)
    mouth = mix(np.broadcast_to(GUM, points.shape), TONGUE, is_tongue)
    mouth = mix(THROAT, mouth, 0.12 + 0.88 * step(points[..., 2], 3.0, 10.2))

    points = rasterised(neutral, chosen(part, "teeth"), neutral.vertices, SMALL)
    height = points[..., 1]
    root = np.maximum(step(height, -1.9, -1.2), step(-height, 4.7, 5.3))
    tooth = mix(np.broadcast_to(TOOTH, points.shape), ROOT, 0.35 * root)
    # Between parted lips of the neutral only edges are seen; shining ones would be a white line.
    edge = 1 - 0.16 * np.where(height > -3.6, step(-height, 3.05, 3.4), 0.0)
    deep = 0.78 + 0.22 * step(points[..., 2], 4.5, 10.0)
    return mouth * tone[..., None], tooth * (edge * deep)[..., None]


def _lashes() -> Floats:
    """Hairs with opacity on the sheets."""
    random = np.random.default_rng([SEED, 14])
    picture = picture_of(MIDDLE)[0]
    for begin, outwards in ((LEFT, 1), (RIGHT, -1)):
        for number, (root, end) in enumerate(STRIPS):
            count, width, fill, long = (60, 9.0, 255, 1.0) if number < 2 else (44, 6.0, 215, 0.7)
            for hair in range(count):
                along = (hair + random.uniform(0.1, 0.9)) / count
                length = np.interp(along, [0, 0.15, 0.7, 1], [0.45, 0.75, 1.0, 0.7])
                length *= (root - end) * long * random.uniform(0.55, 0.92)
                start = np.array([begin + outwards * LENGTH * along, root])
                lean = outwards * (0.35 * (along - 0.35) + random.normal(0, 0.12))
                bend = np.array([outwards * random.normal(0.0, 0.006), 0.0])
                stroke(picture, start, length * np.array([lean, -1.0]), bend, width, fill)
    return _with_opacity(LASH, 0.9 * shrunk(picture))


def _shadow() -> Floats:
    """What lids shade of the eyeball: from the lower lid, at the bottom, to the upper."""
    up = np.linspace(1, 0, LEAST)[:, None] * np.ones(LEAST)
    return _with_opacity(SHADE, 0.55 * step(up, 0.55, 1.0) + 0.28 * step(-up, -0.30, 0.0))


def _with_opacity(colour: Colour, alpha: Floats) -> Floats:
    plain = np.broadcast_to(colour, (*alpha.shape, 3))
    return np.concatenate([plain, 255 * alpha[..., None]], axis=-1)


if __name__ == "__main__":
    folder = Path(sys.argv[2])
    for name, content in paint(em.read(sys.argv[1])).items():
        (folder / name).write_bytes(content)
        print(f"{name}: {len(content):,} bytes")
