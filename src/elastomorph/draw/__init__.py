"""Pictures of faces and graphs of errors.

Needs vtk, matplotlib and Pillow (``pip install 'elastomorph[demo]'``), which are imported when the
first picture is drawn. Pictures are (H, W, 3) uint8 arrays, and files where a path is given.
"""

from elastomorph.draw.camera import VIEWS, Camera, camera_for
from elastomorph.draw.curves_picture import curves_picture, network_lines
from elastomorph.draw.graphs import (
    error_graphs,
    inbetween_graph,
    mode_law_graph,
    time_graphs,
    time_law_graph,
)
from elastomorph.draw.pictures import ColourScale, as_png, heat_colours, write_picture
from elastomorph.draw.posed import drag_picture
from elastomorph.draw.sheet import picture_grid
from elastomorph.draw.stage import Lines, Stage, render
from elastomorph.draw.strips import (
    closure_comparison,
    error_strip,
    expression_strip,
    face_strip,
    method_strip,
    side_by_side,
)

__all__ = [
    "VIEWS",
    "Camera",
    "ColourScale",
    "Lines",
    "Stage",
    "as_png",
    "camera_for",
    "closure_comparison",
    "curves_picture",
    "drag_picture",
    "error_graphs",
    "error_strip",
    "expression_strip",
    "face_strip",
    "heat_colours",
    "inbetween_graph",
    "method_strip",
    "mode_law_graph",
    "network_lines",
    "picture_grid",
    "render",
    "side_by_side",
    "time_graphs",
    "time_law_graph",
    "write_picture",
]
