"""What a page may do: run its own scripts and use what it brought along, nothing else."""

from __future__ import annotations

import base64
import hashlib
from html.parser import HTMLParser

__all__ = ["alone_policy", "report_policy", "served_policy"]

# Pictures and workers that the page makes itself have addresses of blob: and data:.
_WITHIN = (
    "style-src 'unsafe-inline'; img-src data: blob:; media-src data: blob:; font-src data:; "
    "worker-src blob:; frame-src blob: data:; base-uri 'none'; form-action 'none'"
)
# Browsers take this from a server only, and complain about it within a page.
_NOT_FRAMED = "frame-ancestors 'none'"


def alone_policy(page: str) -> str:
    """The policy of a page that is one file: its own scripts run, and nothing is fetched."""
    return f"{_own_scripts(page)}; {_WITHIN}; connect-src data: blob:"


def served_policy(page: str) -> str:
    """The policy of a page beside its models: these are fetched too, from where it came from."""
    return f"{_own_scripts(page)}; {_WITHIN}; connect-src 'self' data: blob:; {_NOT_FRAMED}"


def report_policy() -> str:
    """The policy of a finished page: whatever is within it may run, and nothing is fetched."""
    scripts = "script-src 'unsafe-inline' blob:"
    return f"default-src 'none'; {scripts}; {_WITHIN}; connect-src data: blob:; {_NOT_FRAMED}"


def _own_scripts(page: str) -> str:
    """Scripts of a page by their hashes: none that got into it by other ways would run."""
    found = _Scripts()
    found.feed(page)
    found.close()
    allowed = [f"'sha256-{_digest(script)}'" for script in found.scripts] or ["'none'"]
    return f"default-src 'none'; script-src {' '.join(allowed)}"


def _digest(script: str) -> str:
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")


class _Scripts(HTMLParser):
    """Collects what stands in the script elements that a browser would run."""

    def __init__(self) -> None:
        super().__init__(convert_charrefs=False)
        self.scripts: list[str] = []
        self._parts: list[str] | None = None

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        runs = dict(attrs).get("type") in (None, "", "module", "text/javascript")
        self._parts = [] if tag == "script" and runs else None

    def handle_data(self, data: str) -> None:
        if self._parts is not None:
            self._parts.append(data)

    def handle_endtag(self, tag: str) -> None:
        if tag == "script" and self._parts is not None:
            self.scripts.append("".join(self._parts))
            self._parts = None
