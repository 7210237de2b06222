"""While something moves, shadows and soft edges wait; the picture at rest is the one as ever."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from faces import Faces
from pictures import Pixels, differing, picture, pixels_of, skin
from scipy.ndimage import maximum_filter, minimum_filter
from visiting import Visit, update

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from playwright.sync_api import Page

DRAWN = """([act, how, andThen]) => new Promise(done => {
    const canvas = document.querySelector('canvas');
    const gl = canvas.getContext('webgl2');
    const pictures = [];
    const keep = () => {
        delete gl.drawElements;
        pictures.push(canvas.toDataURL());
        if (pictures.length > andThen) done(pictures);
        else watch();
    };
    // What is drawn is kept once the whole of it is, and before anything else is drawn.
    const watch = () => {
        const drawn = gl.drawElements;
        let seen = false;
        gl.drawElements = function (...words) {
            drawn.apply(this, words);
            if (!seen) queueMicrotask(keep);
            seen = true;
        };
    };
    if (act === 'pose') elastomorph.update({ weights: how });
    else canvas.dispatchEvent(new WheelEvent('wheel', { deltaY: how, cancelable: true }));
    watch();
})"""


def moved(page: Page, weights: dict[str, float], and_then: int = 0) -> list[Pixels]:
    """The picture of the moment in which sliders move, and those that follow it unasked."""
    return drawn(page, "pose", weights, and_then)


def drawn(page: Page, act: str, how: object, and_then: int) -> list[Pixels]:
    return [pixels_of(one) for one in page.evaluate(DRAWN, [act, how, and_then])]


def test_the_picture_at_rest_is_whole(visit: Visit, faces: Faces) -> None:
    """A jaw that opens keeps its shadow for a moment, and has its own soon after, unasked."""
    page = visit(faces.alone)
    update(page, weights={}, light="studio")
    closed = picture(page)
    moving, by_itself = moved(page, {"jawOpen": 1}, 1)
    at_rest = picture(page)
    assert differing(moving, closed).any()
    waiting = differing(moving, at_rest)
    assert 0 < waiting.sum() < 0.2 * skin(at_rest).sum()
    assert not differing(by_itself, at_rest, 0).any()


def test_another_view_has_its_own_shadow(visit: Visit, faces: Faces) -> None:
    """The light goes with the camera: a shadow of another view would lie anywhere."""
    page = visit(faces.alone)
    update(page, weights={"jawOpen": 1}, light="studio")
    picture(page)
    page.evaluate("elastomorph.look('side')")
    (moving,) = moved(page, {"jawOpen": 0.999})
    at_rest = picture(page)
    assert differing(moving, at_rest, 24).sum() < 0.02 * skin(at_rest).sum()


def on_steps(pixels: Pixels) -> NDArray[np.bool_]:
    """(H, W) of the pixels that differ much from one beside them."""
    high, low = maximum_filter(pixels, (3, 3, 1)), minimum_filter(pixels, (3, 3, 1))
    found: NDArray[np.bool_] = (high - low).max(axis=-1) > 16
    return found


@pytest.mark.parametrize(("act", "how"), [("pose", {"jawOpen": 0.99999}), ("zoom", 1)])
def test_edges_wait_too(visit: Visit, faces: Faces, act: str, how: object) -> None:
    """In a light without shadow a picture at rest is another at its edges alone."""
    page = visit(faces.alone)
    update(page, weights={"jawOpen": 1}, light="matcap")
    picture(page)
    moving, at_rest = drawn(page, act, how, 1)
    softened = differing(moving, at_rest, 16)
    assert softened.sum() > 500
    assert not (softened & ~on_steps(moving) & ~on_steps(at_rest)).any()
    assert not differing(at_rest, picture(page), 0).any()


LOST = """async () => {
    const canvas = document.querySelector('canvas');
    const card = canvas.getContext('webgl2').getExtension('WEBGL_lose_context');
    const told = (event) => new Promise(done => canvas.addEventListener(event, done, {once: true}));
    const lost = told('webglcontextlost');
    card.loseContext();
    await lost;
    const restored = told('webglcontextrestored');
    // Not within the event, where the context cannot be asked for again.
    setTimeout(() => card.restoreContext());
    await restored;
}"""


def test_a_graphics_card_that_was_lost_draws_as_before(visit: Visit, faces: Faces) -> None:
    visit.forgiven = "THREE.WebGLRenderer: Context"
    page = visit(faces.alone)
    update(page, weights={"jawOpen": 1})
    before = picture(page)
    page.evaluate(LOST)
    assert not differing(picture(page), before, 0).any()
