"""Tabs of a browser that are used again: opening one costs more than the page it shows.

Every page is a new document, so nothing of the one before is left in it; what belongs to the tab,
its size and its media, is set each time. What pages store is forgotten before the next one, but
in tabs with ``keeps``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from watching import Watch

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

NOWHERE = "about:blank"
FORGET = "try { localStorage.clear(); indexedDB.deleteDatabase('elastomorph') } catch {}"


@dataclass(frozen=True)
class Tab:
    """A page in a context of its own, and what is heard of it."""

    page: Page
    watch: Watch
    options: str


class Tabs:
    """Those that nobody uses at the moment, by the options that cannot be changed later."""

    def __init__(self, browser: Browser) -> None:
        self.browser = browser
        self._idle: dict[str, list[Tab]] = {}

    def take(self, size: tuple[int, int], media: dict[str, Any], options: dict[str, Any]) -> Tab:
        """An empty tab of a size."""
        viewport = {"width": size[0], "height": size[1]}
        idle = self._idle.get(repr(options))
        if not idle:
            known = {name: value for name, value in options.items() if name != "keeps"}
            context = self.browser.new_context(viewport=viewport, **media, **known)
            if not options.get("keeps"):
                context.add_init_script(FORGET)
            context.set_default_timeout(240_000)
            return Tab(context.new_page(), Watch(context), repr(options))
        tab = idle.pop()
        tab.page.set_viewport_size(viewport)
        tab.page.emulate_media(**media)
        return tab

    def leave(self, tab: Tab) -> None:
        """Whoever used it needs it no more, and has left its page."""
        tab.page.mouse.move(0, 0)
        tab.watch.forget()
        self._idle.setdefault(tab.options, []).append(tab)

    def close(self) -> None:
        for idle in self._idle.values():
            for tab in idle:
                tab.page.context.close()
