"""Rigs and paths as they show themselves in a notebook: the viewer, a hand high."""

from __future__ import annotations

import html

from elastomorph.errors import ElastomorphError
from elastomorph.model.morph import Morph
from elastomorph.rig import Rig
from elastomorph.viewer.page import viewer_page
from elastomorph.viewer.rig_scenes import rig_scene

# A notebook keeps every output within its file; larger pages make it slow to open and to save.
LARGEST_PAGE = 40_000_000


def notebook_html(shown: Rig | Morph) -> str:
    """The viewer of a rig or path in a frame; in words where it cannot be shown."""
    words = repr(shown)
    try:
        if _least_size(shown) > LARGEST_PAGE:
            return _paragraph(words, _TOO_LARGE)
        page = viewer_page(rig_scene(shown, title=words))
    except ElastomorphError as error:  # a cell that shows a rig must not fail for the picture
        return _paragraph(words, f"It is not shown: {error}")
    if len(page) > LARGEST_PAGE:
        return _paragraph(words, _TOO_LARGE)
    # The frame has an origin of its own, so that nothing in it reaches the notebook around it.
    return (
        f'<iframe title="{html.escape(words)}" sandbox="allow-scripts allow-downloads" '
        'style="width: 100%; height: 480px; border: 0" '
        f'srcdoc="{html.escape(page)}"></iframe>'
    )


_TOO_LARGE = (
    "It is too large to be shown within a notebook. Write the rig with em.write('rig.glb', rig) "
    "and look at it with 'elastomorph view rig.glb', or show a part of it: rig.only(names)."
)


def _paragraph(words: str, why: str) -> str:
    return f"<p><code>{html.escape(words)}</code></p>\n<p>{html.escape(why)}</p>"


def _least_size(shown: Rig | Morph) -> float:
    """What the page takes at least, without making it: positions of all that moves, as text."""
    morphs = shown.morphs.values() if isinstance(shown, Rig) else (shown,)
    rows = 0
    for morph in morphs:
        for field in (morph.delta, *morph.bends):
            rows += int(field.any(axis=1).sum())
    return rows * 12 * 4 / 3
