"""Pictures of faces, graphs of errors, and reports.

Needs vtk, matplotlib and Pillow (``pip install 'elastomorph[demo]'``), which are imported when the
first picture is drawn. Pictures are (H, W, 3) uint8 arrays, and files where a path is given.
"""

from elastomorph.report.camera import VIEWS, Camera
from elastomorph.report.closures import closure_comparison
from elastomorph.report.curves_picture import curves_picture, network_lines
from elastomorph.report.face_strip import face_strip
from elastomorph.report.framing import camera_for
from elastomorph.report.graphs import error_graphs, time_graphs
from elastomorph.report.grid import ColourScale, picture_grid
from elastomorph.report.heat import heat_colours
from elastomorph.report.inbetween_graph import inbetween_graph
from elastomorph.report.page import About, write_movements_report, write_report
from elastomorph.report.pictures import as_png, write_picture
from elastomorph.report.render import render
from elastomorph.report.stage import Lines, Stage
from elastomorph.report.strips import error_strip, expression_strip, method_strip, side_by_side
from elastomorph.report.time_laws import time_law_graph

__all__ = [
    "VIEWS",
    "About",
    "Camera",
    "ColourScale",
    "Lines",
    "Stage",
    "as_png",
    "camera_for",
    "closure_comparison",
    "curves_picture",
    "error_graphs",
    "error_strip",
    "expression_strip",
    "face_strip",
    "heat_colours",
    "inbetween_graph",
    "method_strip",
    "network_lines",
    "picture_grid",
    "render",
    "side_by_side",
    "time_graphs",
    "time_law_graph",
    "write_movements_report",
    "write_picture",
    "write_report",
]
