"""Comparisons as pages of HTML that ask the network for nothing."""

from elastomorph.report.capture import capture_page, write_capture_report
from elastomorph.report.comparison import report_page, write_report
from elastomorph.report.document import About, Picture
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
