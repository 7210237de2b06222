"""While something moves, shadows and soft edges wait; the picture at rest is the one as ever."""

from __future__ import annotations

from typing import TYPE_CHECKING

from faces import Faces
from pictures import Pixels, differing, picture, pixels_of, skin
from visiting import Visit, update

if TYPE_CHECKING:
    from playwright.sync_api import Page

DRAWN = """weights => new Promise(done => {
    elastomorph.update({ weights });
    // Asked for after the stage has asked, so it comes right after the drawing.
    requestAnimationFrame(() => done(document.querySelector('canvas').toDataURL()));
})"""
NEXT = """() => new Promise(done => {
    const gl = document.querySelector('canvas').getContext('webgl2');
    const drawn = gl.drawElements;
    gl.drawElements = function (...words) {
        drawn.apply(this, words);
        delete gl.drawElements;
        queueMicrotask(() => done(document.querySelector('canvas').toDataURL()));
    };
})"""


def moved(page: Page, weights: dict[str, float]) -> Pixels:
    """The picture of the moment in which sliders move."""
    return pixels_of(page.evaluate(DRAWN, weights))


def test_the_picture_at_rest_is_whole(visit: Visit, faces: Faces) -> None:
    """A jaw that opens keeps its shadow for a moment, and has its own soon after, unasked."""
    page = visit(faces.alone)
    update(page, weights={}, light="studio")
    closed = picture(page)
    moving = moved(page, {"jawOpen": 1})
    by_itself = pixels_of(page.evaluate(NEXT))
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
    moving = moved(page, {"jawOpen": 0.999})
    at_rest = picture(page)
    assert differing(moving, at_rest, 24).sum() < 0.02 * skin(at_rest).sum()
