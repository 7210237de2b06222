"""Comparisons as pages of HTML that ask the network for nothing."""

from typing import Any

from elastomorph import draw
from elastomorph.errors import warn
from elastomorph.report.capture import capture_page, write_capture_report
from elastomorph.report.comparison import report_page, write_report
from elastomorph.report.facts import About
from elastomorph.report.images import Picture
from elastomorph.report.movements import movements_page, write_movements_report

__all__ = [
    "About",
    "Picture",
    "capture_page",
    "movements_page",
    "report_page",
    "write_capture_report",
    "write_movements_report",
    "write_report",
]


def __getattr__(name: str) -> Any:
    """What is drawn has moved to `elastomorph.draw`; found here too until 0.3."""
    if name not in draw.__all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    message = f"{__name__}.{name} is now elastomorph.draw.{name}; this works until elastomorph 0.3."
    warn(message, DeprecationWarning)
    return getattr(draw, name)
