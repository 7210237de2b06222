"""The viewer inside a report: the methods beside the recording, to be turned and compared."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from elastomorph.errors import ElastomorphError, FileError, MeshError
from elastomorph.evaluation import Evaluation, MethodResult
from elastomorph.model.morph import Morph
from elastomorph.report.document import Section
from elastomorph.report.faces import telling_frame

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
) -> Section:
    """The viewer in a frame of its own, or a sentence that says why there is none.

    ``informed`` methods are the first to be left out. The section's ``page`` is empty where the
    viewer is.
    """
    page, left_out = "", []
    try:
        shown, frames = _fitting(evaluation, informed)
        page = _page(evaluation, shown, frames, title, unit, truth)
        left_out = [each.label for each in evaluation.results if each not in shown]
        reason = ""
    except FileError:  # its message names folders of this machine
        reason = "this installation came without the viewer's page"
    except ElastomorphError as error:  # a report without its viewer is better than none
        reason = str(error)
    content = {"page": page, "left_out": left_out, "reason": reason, "truth": truth}
    return Section("viewer", "Live viewer", content)


def _page(
    evaluation: Evaluation,
    shown: Sequence[MethodResult],
    frames: int,
    title: str,
    unit: str,
    truth: str,
) -> str:
    from elastomorph.viewer import evaluation_scene
    from elastomorph.viewer.page import viewer_page

    some = replace(evaluation, results=tuple(shown))
    scene = evaluation_scene(some, title=title, unit=unit, frames=frames, truth=truth)
    # Halfway, where all symmetric timings meet, says the least.
    moment = float(evaluation.truth.times[telling_frame(evaluation)])
    return viewer_page(replace(scene, start={**scene.start, "t": moment}))


def _fitting(evaluation: Evaluation, informed: Collection[str]) -> tuple[list[MethodResult], int]:
    """The methods to show and the most recorded frames, so that the page stays small."""
    if not len(evaluation.truth.mesh.faces):
        raise MeshError("markers have no surface that could be shown")
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
        raise MeshError(
            "a face of this size does not fit into a page that is mailed around. Export a method "
            "as GLB and open that with 'elastomorph view'"
        )
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
