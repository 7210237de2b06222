"""The viewer inside a report: the methods beside the recording, to be turned and compared."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from elastomorph.errors import ElastomorphError, FileError
from elastomorph.evaluation import Evaluation, MethodResult
from elastomorph.model.morph import Morph
from elastomorph.report.faces import telling_frame
from elastomorph.report.markup import Markup, element, joined

__all__ = ["LARGEST", "live_viewer"]

LARGEST = 2_900_000
"""Bytes of faces in a report; beyond it fewer methods and frames are shown. Mails have limits."""
_MOST = 30_000_000
_FRAMES = (24, 12, 6)
# Bytes of a vertex in a file: once for the face with its polygons, and in each target it moves in.
_VERTEX = 40 * 4 / 3
_ROW = 16 * 4 / 3


def live_viewer(
    evaluation: Evaluation,
    title: str,
    unit: str = "",
    informed: Collection[str] = (),
    truth: str = "recorded",
) -> tuple[Markup, bool]:
    """The viewer in a frame of its own, or a sentence that says why there is none.

    Args:
        evaluation: Methods compared with a recorded motion.
        title: What the viewer's page is called.
        unit: Unit of the coordinates.
        informed: Methods that were given frames of the recording; the first to be left out.
        truth: What the viewer calls that motion.

    Returns:
        What stands in the report, and whether it is the viewer.
    """
    if not len(evaluation.truth.mesh.faces):
        return _sentence("It is left out: markers have no surface that could be shown."), False
    shown, frames = _fitting(evaluation, informed)
    if not shown:
        return _sentence(
            "It is left out: a face of this size does not fit into a page that is mailed around. "
            "Export a method as GLB and open that with 'elastomorph view'."
        ), False
    try:
        from elastomorph.viewer import evaluation_scene
        from elastomorph.viewer.page import viewer_page

        some = replace(evaluation, results=tuple(shown))
        scene = evaluation_scene(some, title=title, unit=unit, frames=frames, truth=truth)
        # Halfway, where all symmetric timings meet, says the least.
        moment = float(evaluation.truth.times[telling_frame(evaluation)])
        page = viewer_page(replace(scene, start={**scene.start, "t": moment}))
    except FileError:  # its message names folders of this machine
        return _sentence("It is left out: this installation came without the viewer's page."), False
    except ElastomorphError as error:  # a report without its viewer is better than none
        return _sentence(f"It is left out: {error}."), False
    frame = element(
        "iframe",
        title=f"Live viewer: the methods and what they are compared with ({truth})",
        # An origin of its own: nothing in the frame reaches the report or the disk around it.
        sandbox="allow-scripts allow-downloads",
        loading="lazy",
        srcdoc=page,
        class_="viewer",
    )
    left_out = [r.label for r in evaluation.results if r not in shown]
    words = "Drag to turn the faces, move t, and choose what is compared with what."
    if left_out:
        words += f" To keep this page small it does not hold {', '.join(left_out)}."
    script = element(
        "noscript",
        element(
            "p",
            "The viewer needs JavaScript, which is switched off. Everything else in this report "
            "can be read without it.",
        ),
    )
    return joined([element("p", words, class_="lead"), script, frame]), True


def _sentence(text: str) -> Markup:
    return element("p", text)


def _fitting(evaluation: Evaluation, informed: Collection[str]) -> tuple[list[MethodResult], int]:
    """The methods to show and the most recorded frames, so that the page stays small.

    No method, where even the least would be too much.
    """
    telling, others = _by_interest(evaluation.results, informed)
    truth = evaluation.truth
    face = len(truth.mesh.vertices) * _VERTEX
    moving = int((truth.frames != truth.frames[0]).any(axis=(0, 2)).sum())
    least = sum(face + _bytes(result.morph) for result in telling)
    for frames in _FRAMES:
        size = least + face + min(frames, len(truth)) * moving * _ROW
        if size <= LARGEST:
            break
    if size > _MOST:
        return [], 0
    chosen = list(telling)
    for result in others:
        size += face + _bytes(result.morph)
        if size > LARGEST:
            break
        chosen.append(result)
    return [result for result in evaluation.results if result in chosen], frames


def _by_interest(
    results: Sequence[MethodResult], informed: Collection[str]
) -> tuple[list[MethodResult], list[MethodResult]]:
    """What a report must show, and the rest.

    The straight line, the closest, the paper's choice, and what a rig gets unless asked otherwise.
    """
    judged = [r for r in results if r.label not in informed] or list(results)
    best = min(judged, key=lambda result: result.lme)
    telling = [r for r in results if r is best or r.label in ("linear", "beam R=2", "auto")]
    nearest = min(judged, key=lambda result: result.path_lme)
    # The ease shows what of the beam is timing alone, the nearest path what is none of it.
    rest = [r for r in results if r not in telling]
    rest.sort(key=lambda r: (r is not nearest, r.label != "ease R=2"))
    return telling, rest


def _bytes(morph: Morph) -> float:
    rows = sum(int(field.any(axis=1).sum()) for field in (morph.delta, *morph.bends))
    return rows * _ROW
