"""What a doctor can find, one thing found in one file, and all that an examination has to say."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sized
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, NamedTuple, cast, get_args

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.settings import ExaminationSettings
from elastomorph.errors import ElastomorphError, FileError, ParameterError
from elastomorph.model.mesh import Mesh

if TYPE_CHECKING:
    from elastomorph.doctor.checks.surface import SurfaceFacts

Severity = Literal["error", "warning", "note"]
SEVERITIES: tuple[Severity, ...] = get_args(Severity)
"""From the gravest: the files are no rig; animators will see it; worth knowing."""


class Kind(NamedTuple):
    """One kind of finding: how grave it is, what it is in a few words, what to do about it."""

    severity: Severity
    title: str
    remedy: str


_KINDS = """
# The files are not one rig.
unreadable | error | unreadable file
    mend the file, or export it again; the rest was examined
different-counts | error | other vertices or polygons than the neutral
    export the target again from the mesh of the neutral
different-polygons | error | other polygons than the neutral
    export the target again from the mesh of the neutral
triangulated | error | polygons were split into triangles
    '--repair FOLDER' puts the polygons of the neutral back; switch triangulation off on export
reversed-winding | error | polygons run the other way round
    '--repair FOLDER' winds them as in the neutral, positions stay as they are; switch off whatever
    flips normals on export
vertex-order | error | vertices in another order than in the neutral
    '--repair FOLDER' writes the file in the order of the neutral
polygon-order | error | polygons in another order than in the neutral
    '--repair FOLDER' writes the file in the order of the neutral
split-vertices | error | vertices split where texture or normals have seams
    '--repair FOLDER' joins them again; export without splitting vertices
welded-vertices | error | vertices of the neutral welded together
    '--repair FOLDER' takes them apart again where they lie at one position in the neutral; switch
    off merging by distance
saved-as-deltas | error | displacements in place of positions
    '--repair FOLDER' adds the neutral; export absolute positions
scrambled-vertices | error | positions of other vertices than the polygons say
    export positions and polygons together: nothing in the file tells their order
wrong-seed | error | pairs that cannot be
    leave the pair out of --seeds, or correct it
different-units | error | another unit of length than the neutral
    '--repair FOLDER' brings it back where the factor is that of two units; otherwise export it
    again at the scale of the neutral
different-axes | error | other axes than the neutral
    '--repair FOLDER' turns it back; set the same up axis for all exports
mirrored | error | mirrored against the neutral
    '--repair FOLDER' mirrors it back; look for a negative scale or a change of handedness on export
# The surface.
non-manifold-edges | warning | edges with more than two polygons
    delete the inner or doubled polygons: edge loops end here, so curves do too
non-manifold-vertices | warning | vertices that join fans of polygons at a point
    split the vertex, or weld the fans along an edge
inconsistent-winding | warning | polygons wound against their neighbours
    reverse these polygons in the neutral and in all targets: their normals point inwards
inside-out | warning | polygons that show their back
    '--repair FOLDER' winds them the other way round in all files; positions stay as they are
repeated-corners | warning | polygons that name a vertex twice
    delete the repeated corner, or the polygon
zero-area | warning | polygons without an area
    dissolve them in the neutral; in a target, keep the vertices a little apart: without an area
    there is no normal to shade with
isolated-vertices | warning | vertices on no polygon
    delete them in all files; nothing says how they move
unwelded-vertices | note | vertices at one position
    weld them in all files if the surface should hold together there; parts that only touch may stay
    apart
# What targets do.
does-nothing | warning | targets that do nothing
    export the shape that was meant, or delete the target
moves-the-head | warning | targets that move the whole head
    '--align auto --repair FOLDER' takes the motion out; '--align VERTICES' fits it to the vertices
    you name, such as those of the skull
duplicate-targets | warning | targets of the same shape
    keep one of them, or export the one meant
jumping-vertices | warning | vertices that jump away from their neighbours
    relax these vertices in the target
noise | warning | targets with noise
    smooth the target, or sculpt it again from the neutral: every vertex is a little off
baked-in-target | warning | targets that contain another target
    take the motion of the other target out, where it was sculpted: subtract it vertex by vertex
swapped-sides | warning | left and right swapped
    swap the names of the two targets
asymmetric-pair | note | left and right that are no mirror images
    mirror the better one if the face should be symmetric; real faces are not
missing-pair | note | a side without its other side
    mirror the target, or rename it
# How it will move.
resonant-material | error | a material at resonance
    change the damping as the message says, or the mass, the rigidity or the closure
overshooting-material | warning | a material that runs backwards or overshoots
    take the damping that it names, or choose another closure
in-between-pays | note | an in-between would pay here
    export with the method 'rotation', or sculpt an in-between at the time named
"""
KINDS: dict[str, Kind] = {}
for _block in re.split(r"\n(?=\S)", re.sub(r"\n#.*", "", _KINDS).strip()):
    _head, *_remedy = _block.split("\n")
    _name, _severity, _title = _head.split(" | ")
    KINDS[_name] = Kind(cast(Severity, _severity), _title, " ".join(map(str.strip, _remedy)))


@dataclass(frozen=True)
class Finding:
    """One thing found in one file.

    Attributes:
        name: A key of `KINDS`, which is also its place in the documentation.
        severity: ``error``, ``warning`` or ``note``.
        file: The file it was found in.
        message: What was found.
        remedy: What to do about it.
        line: Line of the file, counted from 1, where one is known.
        vertices: The vertices concerned, counted from 0, where there are any.
    """

    name: str
    severity: Severity
    file: str
    message: str
    remedy: str
    line: int | None = None
    vertices: tuple[int, ...] = ()

    @property
    def title(self) -> str:
        """The kind of finding in a few words."""
        return KINDS[self.name].title

    @property
    def link(self) -> str:
        """Where the documentation explains it."""
        return f"docs/findings.md#{self.name}"


def finding(
    name: str,
    file: str,
    message: str,
    *,
    line: int | None = None,
    vertices: Iterable[int] | NDArray[np.integer] = (),
    severity: Severity | None = None,
) -> Finding:
    """A finding with the severity, unless another is given, and the remedy of its kind."""
    kind = KINDS.get(name)
    if kind is None:
        raise ParameterError(f"unknown kind of finding {name!r}; one of {', '.join(KINDS)}")
    numbers = tuple(int(vertex) for vertex in vertices)
    return Finding(name, severity or kind.severity, file, message, kind.remedy, line, numbers)


def polygon_finding(
    name: str, mesh: Mesh, file: str, polygons: NDArray[np.integer], message: str
) -> Finding:
    """A finding about polygons, rising: with the line of the first, and the vertices of all."""
    lines = mesh.source.face_lines if mesh.source else None
    corners = np.isin(mesh.faces.corner_faces, polygons)
    return finding(
        name,
        file,
        message,
        line=None if lines is None else int(lines[polygons[0]]),
        vertices=np.unique(mesh.faces.indices[corners]),
    )


@dataclass(frozen=True, eq=False)
class Outcome:
    """What became of one mesh in a check that may put it right."""

    mesh: Mesh | None  # as it should be; None where that cannot be known
    findings: tuple[Finding, ...] = ()
    repair: str = ""  # in a few words; empty where nothing was wrong, or nothing helped
    # (F,) polygons of the neutral that it only runs the other way round; None where there are
    # none, or anything else was wrong.
    reversed: NDArray[np.bool_] | None = None


@dataclass(frozen=True, eq=False)
class Repaired:
    """A mesh in order, unit and axes of the rig, and what was done, in a few words each."""

    mesh: Mesh
    done: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Examination:
    """What was found.

    Attributes:
        neutral: File of the neutral, or of a rig that holds neutral and targets.
        targets: Files of the targets, or their names in the rig.
        facts: What the neutral is made of; None where it could not be read.
        symmetric: Whether the neutral has a plane of symmetry; None where nobody asked.
        findings: The gravest first, then by kind and file.
        repaired: Meshes that can be repaired, by file.
        beyond_repair: Files of meshes that do not fit and could not be repaired.
        settings: What was known beforehand.
        meshes: The meshes of a rig, by name as above; empty where each is a file of its own.
    """

    neutral: str
    targets: tuple[str, ...]
    facts: SurfaceFacts | None
    symmetric: bool | None
    findings: tuple[Finding, ...]
    repaired: Mapping[str, Repaired]
    beyond_repair: tuple[str, ...]
    settings: ExaminationSettings = field(default_factory=ExaminationSettings)
    meshes: Mapping[str, Mesh] = field(default_factory=dict)

    def count(self, severity: Severity) -> int:
        """How many findings are that grave."""
        return sum(found.severity == severity for found in self.findings)

    def worst_is(self, severity: Severity) -> bool:
        """Whether there is a finding that grave or graver."""
        grave = SEVERITIES[: SEVERITIES.index(severity) + 1]
        return any(found.severity in grave for found in self.findings)

    @property
    def unreadable(self) -> bool:
        """Whether a file could not be read."""
        return any(found.name == "unreadable" for found in self.findings)


def rank(found: Finding) -> tuple[int, int]:
    """To sort by: the gravest first, then by kind."""
    return SEVERITIES.index(found.severity), list(KINDS).index(found.name)


def unreadable(file: str, error: ElastomorphError) -> Finding:
    """The finding for a file that could not be read."""
    line = error.line if isinstance(error, FileError) else None
    message = str(error).removeprefix(f"{file}: ").removeprefix(f"{file}, line {line}: ")
    return finding("unreadable", file, message, line=line)


def counted(things: Sized | int, one: str, many: str) -> str:
    """A number and its noun: ``1 edge has``, ``2,000 edges have``."""
    count = things if isinstance(things, int) else len(things)
    return f"{count:,} {one if count == 1 else many}"


def listed(things: Iterable[object], most: int = 5) -> str:
    """The first few things, and dots if there are more."""
    names = [str(thing) for thing in things]
    return ", ".join(names[:most]) + (", …" if len(names) > most else "")


def percent(share: float) -> str:
    """A share in percent with as many digits as say something: ``0.67 %``, ``12 %``."""
    value = 100.0 * share
    if 0.0 < value < 0.0005:
        return "less than 0.001 %"
    digits = 0 if value >= 9.95 else 1 if value >= 0.995 else 2 if value >= 0.0995 else 3
    return f"{value:,.{digits}f} %"
