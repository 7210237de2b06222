"""Turn a mesh into curves that hold every vertex exactly once (Sec. 4.2 of the paper)."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from elastomorph.curves.chains import ordered_chains
from elastomorph.curves.connectivity import edge_ends
from elastomorph.curves.loops import trace_loops
from elastomorph.curves.network import Curve, CurveNetwork
from elastomorph.curves.scraps import mend_scraps
from elastomorph.curves.selection import choose_runs
from elastomorph.model.mesh import Mesh, require_mesh

__all__ = ["extract_curves"]


def extract_curves(mesh: Mesh, keep: Iterable[Curve] = ()) -> CurveNetwork:
    """Curves along the edges of a mesh, with every vertex on exactly one.

    The curves are edge loops and parts of them: closed loops first, then the longest runs that are
    left. Vertices that no loop is left for are taken into the curves beside them. Length is
    counted in vertices.

    Args:
        mesh: Polygons of any size, in any number of components, or none at all.
        keep: Curves an artist has drawn. They are taken as they are, whether they follow edges or
            not; the rest of the mesh is covered around them.

    Returns:
        The kept curves, then the others, longest first. Consecutive vertices of those share an
        edge. A curve of one or two vertices is left only where no curve beside it could take it,
        such as a vertex without edges.

    Raises:
        MeshError: It is no mesh.
        CurveError: A kept curve names a vertex that the mesh does not have, or two share one.
    """
    require_mesh(mesh, "what curves are found on")
    vertex_count = len(mesh.vertices)
    kept = CurveNetwork(keep, vertex_count)
    fixed = kept.curve_of >= 0
    ends = edge_ends(mesh.faces, vertex_count)
    threads = choose_runs(trace_loops(ends), fixed.copy())
    mend_scraps(threads, fixed, ends.edges, mesh.vertices)
    chains = ordered_chains(threads.links)
    order = np.argsort(-chains.lengths, kind="stable")
    order = order[~fixed[chains.items[chains.offsets[:-1][order]]]]
    arrays, closed = chains.arrays(), chains.closed.tolist()
    found = (Curve(arrays[chain], closed[chain]) for chain in order.tolist())
    return CurveNetwork((*kept, *found), vertex_count)
