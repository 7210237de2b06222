"""Where vertices are on the picture, found by clicking: the camera's own code is not asked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import least_squares
from visiting import state, update

from elastomorph.draw.head import neck_of
from elastomorph.rig import Rig
from elastomorph.rig.performance import HeadTurn

if TYPE_CHECKING:
    from playwright.sync_api import Page


@dataclass(frozen=True)
class FrontView:
    """A pinhole that looks along -Z.

    Attributes:
        centre: (2,) middle of the picture, in pixels.
        focal: Focal length in pixels.
        eye: (3,) where it is.
    """

    centre: NDArray[np.float64]
    focal: float
    eye: NDArray[np.float64]

    def project(self, points: ArrayLike) -> NDArray[np.float64]:
        """(n, 2) pixels of (n, 3) points, from the upper left corner of the page."""
        found = np.atleast_2d(np.asarray(points, float))
        aside = self.focal * (found - self.eye)[:, :2] / (self.eye[2] - found[:, 2])[:, None]
        return self.centre + aside * [1, -1]


def as_turned(points: NDArray[np.float64], rig: Rig, head: Sequence[float]) -> NDArray[np.float64]:
    """(n, 3) points as films of the command draw them where the head of a rig is turned."""
    neck = neck_of(rig.neutral, rig.morphs.values())
    return HeadTurn(neck, np.array([head])).of(points, 0)


def spots(page: Page, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 2) where the page says that points are, in pixels."""
    found = page.evaluate("points => points.map(p => elastomorph.spot(p))", points.tolist())
    return np.array([[one["x"], one["y"]] for one in found])


def front_view(
    page: Page, vertices: NDArray[np.float64], places: Sequence[tuple[float, float]]
) -> FrontView:
    """The camera of the picture, from clicks on the face.

    A click hits a vertex only to half an edge; the camera is the one for which the vertices that
    were picked come nearest to the clicks, in least squares over all of them.

    Args:
        page: A page that shows one face from the front.
        vertices: (V, 3) positions shown.
        places: Where to click, as fractions of the picture's width and height.
    """
    box = page.locator(".picture").bounding_box()
    assert box is not None
    centre = np.array([box["x"] + box["width"] / 2, box["y"] + box["height"] / 2])
    clicks, hit = [], []
    for x, y in places:
        update(page, picked=[], orbits=True)
        at = np.array([box["x"] + x * box["width"], box["y"] + y * box["height"]]).round()
        page.mouse.click(*at)
        picked = state(page)["picked"]
        assert len(picked) == 1, f"a click at {at} on the face picked {picked}"
        clicks.append(at)
        hit.append(vertices[picked[0]])
    update(page, picked=[])
    tall, middle = np.ptp(vertices[:, 1]), vertices.mean(axis=0)

    def view(numbers: NDArray[np.float64]) -> FrontView:
        log_scale, a, b, log_depth = numbers
        depth = tall * np.exp(log_depth)
        focal = np.exp(log_scale) * depth
        return FrontView(centre, focal, middle + [a, b, depth])

    def missed(numbers: NDArray[np.float64]) -> NDArray[np.float64]:
        return (view(numbers).project(hit) - clicks).ravel()

    start = [np.log(box["height"] / tall), 0, 0, np.log(4)]
    return view(least_squares(missed, start, loss="soft_l1").x)
