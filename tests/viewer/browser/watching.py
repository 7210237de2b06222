"""What a page asks for and complains about while a test looks at it."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import BrowserContext, ConsoleMessage

# The software renderer remarks on its own speed when positions are read back from it.
DRIVER_REMARK = "GPU stall due to ReadPixels"


class Watch:
    """Records requests, console messages and errors of all pages of a context."""

    def __init__(self, context: BrowserContext) -> None:
        self.requests: list[str] = []
        self.complaints: list[str] = []
        context.on("request", lambda request: self.requests.append(request.url))
        context.on("console", self._hear)
        context.on("weberror", lambda error: self.complaints.append(f"thrown: {error.error}"))

    def _hear(self, message: ConsoleMessage) -> None:
        if DRIVER_REMARK not in message.text:
            self.complaints.append(f"{message.type}: {message.text}")

    def forget(self) -> None:
        """Begins anew, for the next page."""
        self.requests.clear()
        self.complaints.clear()

    def outside(self, address: str) -> list[str]:
        """Requests that went elsewhere than to the page and what lies beside it."""
        address = address.partition("#")[0]
        # A file has nothing beside it; a server has its models below the same secret.
        served = address.startswith("http")
        own = address.rpartition("/")[0] + "/" if served else address
        return [
            url
            for url in self.requests
            if not (url.startswith(own) if served else url == own)
            and not url.startswith(("data:", "blob:", "about:"))
        ]
