"""Opens pages in a browser, each in a tab of its own that is watched."""

from __future__ import annotations

import base64
import os
import time
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from tabs import NOWHERE, Tab, Tabs

from elastomorph.viewer import Scene, write_viewer

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Frame, Page

DESK = (1280, 720)
PHONE = (390, 844)
FRAME = (800, 500)
# Where text enlarged fourfold leaves no more of a desk's window (WCAG 2.2, 1.4.10).
NARROW = (320, 640)
# Like a desk's, with half of the picture: drawing in software takes time by the pixel.
WINDOW = (1010, 640)
# Where only numbers are read.
SMALL = (420, 320)
_LOOKED_AT = bool(os.environ.get("ELASTOMORPH_SCREENSHOTS"))
# Options where nobody looks at the picture: a sixteenth of its pixels, everything else in place;
# and where pictures are only compared with each other.
COARSE: dict[str, Any] = {} if _LOOKED_AT else {"device_scale_factor": 0.25}
HALVED: dict[str, Any] = {} if _LOOKED_AT else {"device_scale_factor": 0.5}


class Visit:
    """Opens pages; at the end says what was wrong with any of them."""

    def __init__(self, tabs: Tabs, folder: Path) -> None:
        self._tabs, self.folder = tabs, folder
        # What a page may well complain of, where a test takes something from it.
        self.forgiven = "nothing"
        self._open: list[tuple[Tab, str]] = []

    @property
    def browser(self) -> Browser:
        return self._tabs.browser

    def __call__(
        self, subject: Scene | str, *, size: tuple[int, int] = WINDOW, **options: Any
    ) -> Page:
        """A page that has drawn its scene.

        Args:
            subject: A scene, which is opened as a file, or the address of a page.
            size: Width and height of the window.
            **options: Of the browser's context, such as ``color_scheme`` or ``reduced_motion``.
        """
        page = self.blank(subject, size=size, **options)
        page.evaluate("elastomorph.ready")
        settled(page)  # before its first frame the picture has no size
        return page

    def blank(
        self, subject: Scene | str, *, size: tuple[int, int] = WINDOW, **options: Any
    ) -> Page:
        """A page that was opened, whether or not it is the viewer."""
        address = subject if isinstance(subject, str) else self._written(subject)
        # Nothing moves by itself, so that pictures can be compared; tests of motion say otherwise.
        media = {
            "reduced_motion": options.pop("reduced_motion", "reduce"),
            "color_scheme": options.pop("color_scheme", "light"),
        }
        tab = self._tabs.take(size, media, options)
        self._open.append((tab, address))
        page = tab.page
        page.goto(address)
        return page

    def close(self) -> list[str]:
        """Leaves everything; complaints of the pages and requests to elsewhere."""
        problems = []
        for tab, address in self._open:
            # As the page goes its last words are heard.
            tab.page.goto(NOWHERE)
            problems += [words for words in tab.watch.complaints if self.forgiven not in words]
            problems += [f"asked for {url}" for url in tab.watch.outside(address)]
            self._tabs.leave(tab)
        self._open.clear()
        return problems

    def _written(self, scene: Scene) -> str:
        file = self.folder / f"viewer-{len(self._open)}.html"
        write_viewer(file, scene)
        return file.as_uri()


def empty_page() -> str:
    """Address of the page without a scene: the one under test, as it was built."""
    named = os.environ.get("ELASTOMORPH_VIEWER_PAGE")
    place = Path(named or str(files("elastomorph.viewer") / "page" / "index.html"))
    return place.resolve().as_uri()


def state(page: Page) -> dict[str, Any]:
    """Everything the picture depends on."""
    found: dict[str, Any] = page.evaluate("elastomorph.state()")
    return found


def update(page: Page, **patch: Any) -> None:
    page.evaluate("patch => elastomorph.update(patch)", patch)


def settled(page: Page | Frame) -> None:
    """Waits until the interface agrees with the state: it does so at the next frame."""
    page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")


def again(page: Page) -> None:
    """Loads a page anew."""
    page.reload()
    page.evaluate("elastomorph.ready")
    settled(page)


def beside(page: Page, script: str = "") -> Page:
    """The same page in another tab of the browser, which a script hinders."""
    other = page.context.new_page()
    if script:
        other.add_init_script(script)
    other.goto(page.url)
    other.evaluate("elastomorph.ready")
    settled(other)
    return other


def wait(page: Page | Frame, condition: str, seconds: float = 240) -> None:
    """Waits for an expression of the page to hold; Playwright's own wait needs eval."""
    until = time.monotonic() + seconds
    while not page.evaluate(f"Boolean({condition})"):
        assert time.monotonic() < until, f"after {seconds} s still not: {condition}"
        time.sleep(0.03)


def positions(page: Page, model: int, count: int) -> NDArray[np.float64]:
    """(count, 3) positions of the author's vertices, read back from the graphics card."""
    # As text: a list of numbers takes the driver many times as long.
    text = page.evaluate(
        """number => {
            const bytes = new Uint8Array(elastomorph.positions(number).slice().buffer);
            let text = '';
            for (let i = 0; i < bytes.length; i += 8192)
                text += String.fromCharCode(...bytes.subarray(i, i + 8192));
            return btoa(text);
        }""",
        model,
    )
    found = np.frombuffer(base64.b64decode(text), "<f4").reshape(-1, 3)
    return found[:count].astype(np.float64)
