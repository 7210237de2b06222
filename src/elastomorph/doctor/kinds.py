"""What a doctor can find: the name of every finding, how grave it is, and what to do about it."""

from __future__ import annotations

from typing import Literal, NamedTuple, get_args

__all__ = ["KINDS", "SEVERITIES", "Kind", "Severity"]

Severity = Literal["error", "warning", "note"]
SEVERITIES: tuple[Severity, ...] = get_args(Severity)
"""From the gravest: the files are no rig; animators will see it; worth knowing."""


class Kind(NamedTuple):
    """One kind of finding: how grave it is, what it is in a few words, what to do about it."""

    severity: Severity
    title: str
    remedy: str


_REPAIR = "'--repair FOLDER' writes the file in the order of the neutral"
_AGAIN = "export the target again from the mesh of the neutral"

KINDS: dict[str, Kind] = {
    # The files are not one rig.
    "unreadable": Kind(
        "error", "unreadable file", "mend the file, or export it again; the rest was examined"
    ),
    "different-counts": Kind("error", "other vertices or polygons than the neutral", _AGAIN),
    "different-polygons": Kind("error", "other polygons than the neutral", _AGAIN),
    "triangulated": Kind(
        "error",
        "polygons were split into triangles",
        "'--repair FOLDER' puts the polygons of the neutral back; switch triangulation off on "
        "export",
    ),
    "reversed-winding": Kind(
        "error",
        "polygons run the other way round",
        "'--repair FOLDER' winds them as in the neutral, positions stay as they are; switch off "
        "whatever flips normals on export",
    ),
    "vertex-order": Kind("error", "vertices in another order than in the neutral", _REPAIR),
    "polygon-order": Kind("error", "polygons in another order than in the neutral", _REPAIR),
    "split-vertices": Kind(
        "error",
        "vertices split where texture or normals have seams",
        "'--repair FOLDER' joins them again; export without splitting vertices",
    ),
    "welded-vertices": Kind(
        "error",
        "vertices of the neutral welded together",
        "'--repair FOLDER' takes them apart again where they lie at one position in the neutral; "
        "switch off merging by distance",
    ),
    "saved-as-deltas": Kind(
        "error",
        "displacements in place of positions",
        "'--repair FOLDER' adds the neutral; export absolute positions",
    ),
    "scrambled-vertices": Kind(
        "error",
        "positions of other vertices than the polygons say",
        "export positions and polygons together: nothing in the file tells their order",
    ),
    "wrong-seed": Kind(
        "error", "pairs that cannot be", "leave the pair out of --seeds, or correct it"
    ),
    "different-units": Kind(
        "error",
        "another unit of length than the neutral",
        "'--repair FOLDER' brings it back where the factor is that of two units; otherwise export "
        "it again at the scale of the neutral",
    ),
    "different-axes": Kind(
        "error",
        "other axes than the neutral",
        "'--repair FOLDER' turns it back; set the same up axis for all exports",
    ),
    "mirrored": Kind(
        "error",
        "mirrored against the neutral",
        "'--repair FOLDER' mirrors it back; look for a negative scale or a change of handedness "
        "on export",
    ),
    # The surface.
    "non-manifold-edges": Kind(
        "warning",
        "edges with more than two polygons",
        "delete the inner or doubled polygons: edge loops end here, so curves do too",
    ),
    "non-manifold-vertices": Kind(
        "warning",
        "vertices that join fans of polygons at a point",
        "split the vertex, or weld the fans along an edge",
    ),
    "inconsistent-winding": Kind(
        "warning",
        "polygons wound against their neighbours",
        "reverse these polygons in the neutral and in all targets: their normals point inwards",
    ),
    "inside-out": Kind(
        "warning",
        "polygons that show their back",
        "'--repair FOLDER' winds them the other way round in all files; positions stay as they are",
    ),
    "repeated-corners": Kind(
        "warning",
        "polygons that name a vertex twice",
        "delete the repeated corner, or the polygon",
    ),
    "zero-area": Kind(
        "warning",
        "polygons without an area",
        "dissolve them in the neutral; in a target, keep the vertices a little apart: without an "
        "area there is no normal to shade with",
    ),
    "isolated-vertices": Kind(
        "warning",
        "vertices on no polygon",
        "delete them in all files; nothing says how they move",
    ),
    "unwelded-vertices": Kind(
        "note",
        "vertices at one position",
        "weld them in all files if the surface should hold together there; parts that only touch "
        "may stay apart",
    ),
    # What targets do.
    "does-nothing": Kind(
        "warning",
        "targets that do nothing",
        "export the shape that was meant, or delete the target",
    ),
    "moves-the-head": Kind(
        "warning",
        "targets that move the whole head",
        "'--align auto --repair FOLDER' takes the motion out; '--align VERTICES' fits it to the "
        "vertices you name, such as those of the skull",
    ),
    "duplicate-targets": Kind(
        "warning", "targets of the same shape", "keep one of them, or export the one meant"
    ),
    "jumping-vertices": Kind(
        "warning",
        "vertices that jump away from their neighbours",
        "relax these vertices in the target",
    ),
    "noise": Kind(
        "warning",
        "targets with noise",
        "smooth the target, or sculpt it again from the neutral: every vertex is a little off",
    ),
    "baked-in-target": Kind(
        "warning",
        "targets that contain another target",
        "take the motion of the other target out, where it was sculpted: subtract it vertex by "
        "vertex",
    ),
    "swapped-sides": Kind("warning", "left and right swapped", "swap the names of the two targets"),
    "asymmetric-pair": Kind(
        "note",
        "left and right that are no mirror images",
        "mirror the better one if the face should be symmetric; real faces are not",
    ),
    "missing-pair": Kind(
        "note", "a side without its other side", "mirror the target, or rename it"
    ),
    # How it will move.
    "resonant-material": Kind(
        "error",
        "a material at resonance",
        "change the damping as the message says, or the mass, the rigidity or the closure",
    ),
    "overshooting-material": Kind(
        "warning",
        "a material that runs backwards or overshoots",
        "take the damping that it names, or choose another closure",
    ),
    "in-between-pays": Kind(
        "note",
        "an in-between would pay here",
        "export with the method 'rotation', or sculpt an in-between at the time named",
    ),
}
