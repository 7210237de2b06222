"""A comparison as one page of HTML that asks the network for nothing."""

from elastomorph.report.page.about import About
from elastomorph.report.page.movements import movements_page, write_movements_report
from elastomorph.report.page.picture import Picture
from elastomorph.report.page.report import report_page, write_report

__all__ = [
    "About",
    "Picture",
    "movements_page",
    "report_page",
    "write_movements_report",
    "write_report",
]
