"""Lids of the built-in head held together, measured by pictures: no code of `em.hold` measures.

    python benchmarks/held_lids.py --take rom.csv

Correctives are fitted to the first half of the take, and every figure is of the second half. Skin
above and below the line between the corners of the eye is drawn each by itself, from the front and
without perspective: where both cover a pixel, lids lie over each other. What a picture shows of the
eyeball, lids do not cover. D is that of the skin of ICT-FaceKit's head.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import elastomorph as em
from elastomorph.rig.performance.performance import slider_weights
from elastomorph.samples import landmarks

CORNERS = {"Left": (42, 45), "Right": (36, 39)}  # among the 68 landmarks of trackers
WIDE, SIZE = 4.2, (336, 240)  # centimetres and pixels: an eighth of a millimetre each
PIXEL = WIDE / SIZE[0]
DIAMETER = 29.03
VIEWS = {"front": (0, 0, 1), "below": (0, -0.4, 1), "above": (0, 0.4, 1)}

Points = NDArray[np.float64]


class Eye:
    """Flat pictures of one eye: of the skin above, below, and of all."""

    def __init__(self, mesh: em.Mesh, side: str) -> None:
        import vtk
        from vtk.util.numpy_support import numpy_to_vtkIdTypeArray

        inner, outer = (mesh.vertices[landmarks()[i]] for i in CORNERS[side])
        self.middle = (inner + outer) / 2
        names, of_face = mesh.groups.names, mesh.groups.of_face
        corners = mesh.vertices[mesh.faces.indices]
        centres = np.add.reduceat(corners, mesh.faces.offsets[:-1])
        centres /= mesh.faces.sizes[:, None]
        near = np.linalg.norm((centres - self.middle)[:, :2], axis=1) < WIDE / 2
        near &= np.isin(of_face, [names.index("skin"), names.index("head")]) & (centres[:, 2] > 6)
        slope = (outer - inner)[1] / (outer - inner)[0]
        above = centres[:, 1] > inner[1] + slope * (centres[:, 0] - inner[0])
        ball = np.isin(of_face, [names.index("eye_L"), names.index("eye_R")])
        skin = np.isin(of_face, [names.index(n) for n in ("skin", "lips", "head")])
        self.points = vtk.vtkPoints()
        self.scenes = {}
        for name, layers in {
            "above": [(near & above, (1, 1, 1))],
            "below": [(near & ~above, (1, 1, 1))],
            "ball": [(skin, (0.2, 0.2, 0.2)), (ball, (1, 1, 1))],
        }.items():
            renderer, window = vtk.vtkRenderer(), vtk.vtkRenderWindow()
            for chosen, colour in layers:
                rows = [
                    np.r_[len(face), face].astype(np.int64)
                    for face in (mesh.faces[i] for i in np.flatnonzero(chosen))
                ]
                cells = vtk.vtkCellArray()
                cells.ImportLegacyFormat(numpy_to_vtkIdTypeArray(np.concatenate(rows), deep=1))
                surface, mapper, actor = vtk.vtkPolyData(), vtk.vtkPolyDataMapper(), vtk.vtkActor()
                surface.SetPoints(self.points)
                surface.SetPolys(cells)
                mapper.SetInputData(surface)
                actor.SetMapper(mapper)
                actor.GetProperty().SetColor(*colour)
                actor.GetProperty().LightingOff()
                renderer.AddActor(actor)
            window.SetOffScreenRendering(1)
            window.SetMultiSamples(0)
            window.SetSize(*SIZE)
            window.AddRenderer(renderer)
            self.scenes[name] = (renderer, window)

    def drawn(self, scene: str, positions: Points, view: str = "front") -> NDArray[np.uint8]:
        """(height, width) brightness."""
        import vtk
        from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

        self.points.SetData(numpy_to_vtk(np.ascontiguousarray(positions), deep=1))
        self.points.Modified()
        renderer, window = self.scenes[scene]
        camera = renderer.GetActiveCamera()
        camera.ParallelProjectionOn()
        camera.SetFocalPoint(*self.middle)
        camera.SetPosition(*(self.middle + 30 * np.array(VIEWS[view])))
        camera.SetParallelScale(WIDE / 2 * SIZE[1] / SIZE[0])
        camera.SetClippingRange(1, 90)
        window.Render()
        grab = vtk.vtkWindowToImageFilter()
        grab.SetInput(window)
        grab.ReadFrontBufferOff()
        grab.ShouldRerenderOff()
        grab.Update()
        image = grab.GetOutput()
        flat = vtk_to_numpy(image.GetPointData().GetScalars())
        return flat.reshape(SIZE[1], SIZE[0], -1)[..., 0]

    def over(self, positions: Points) -> Points:
        """(width,) height by which both lids cover a column."""
        both = (self.drawn("above", positions) > 127) & (self.drawn("below", positions) > 127)
        return np.asarray(both.sum(axis=0) * PIXEL)

    def shown(self, positions: Points) -> int:
        """Pixels of the eyeball, over three views."""
        return sum(int((self.drawn("ball", positions, view) > 220).sum()) for view in VIEWS)


def main() -> None:
    """Print one row an eye."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--take", type=Path, required=True)
    take = em.read_performance(parser.parse_args().take)
    half = len(take) // 2
    rig = em.read_rig("built-in")
    held = em.hold(rig, take.part(stop=float(take.times[half - 1])))
    weights = slider_weights(rig, take)[half:]
    driven = held.rig.sliders.drive(weights)
    places = list(held.rig.sliders.morphs)
    print(f"frames {half} to {len(take) - 1}; correctives from those before; D = {DIAMETER} cm")
    for side in CORNERS:
        eye = Eye(rig.neutral, side)
        alone = np.max([eye.over(rig.pose({name: 1.0})) for name in rig.names], axis=0)
        own = [places.index(row.name) for row in held.corrections if side in row.name and row.law]
        hinges = driven[:, own]
        faces = [(rig.pose(w), held.rig.pose(w)) for w in weights[hinges.any(axis=1)]]
        shut = hinges[hinges.any(axis=1)].min(axis=1) > 0
        over = (
            100
            / DIAMETER
            * np.array([[(eye.over(f) - alone).max() for f in pair] for pair in faces])
        )
        shown = np.array([[eye.shown(f) for f in pair] for pair in faces])[shut]
        print(
            f"{side:5}: {len(faces)} frames, {shut.sum()} of them shut all along; over each other, "
            f"beyond what a slider does alone, at most {over[:, 0].max():.2f} -> "
            f"{over[:, 1].max():.2f} % of D; frames with an eyeball between shut lids, from the "
            f"front, 22° above and below: {np.count_nonzero(shown[:, 0])} -> "
            f"{np.count_nonzero(shown[:, 1])}"
        )


if __name__ == "__main__":
    main()
