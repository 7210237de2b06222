"""A whole page from its sections, in one file that asks the network for nothing."""

from __future__ import annotations

import hashlib
import re
import tempfile
from base64 import b64encode
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from markupsafe import Markup

from elastomorph.curves import CurveNetwork
from elastomorph.draw.pictures import Image, imported
from elastomorph.errors import FileError, FormatError
from elastomorph.evaluation import Evaluation
from elastomorph.evaluation.words import counted, listed, significant
from elastomorph.io.atomic import replacing
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence
from elastomorph.numbers import first_few
from elastomorph.paths import Method
from elastomorph.templates import rendered


@dataclass(frozen=True)
class Section:
    """A part of a report.

    Attributes:
        name: Its id; its template is called like it.
        title: Its heading.
        content: What the template shows, called ``it`` there.
        appendix: Whether it stands behind what a reader came for.
    """

    name: str
    title: str
    content: Mapping[str, object] = field(default_factory=dict)
    appendix: bool = False

    @property
    def template(self) -> str:
        """The file of its template; headings in it begin at h3."""
        return f"{self.name}.html"


def document(
    title: str, subtitle: str, sections: Sequence[Section], *, viewer: bool = False
) -> str:
    """A whole page; ``viewer`` says whether a frame in it runs scripts."""
    script = _script()
    digest = b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")
    return rendered(
        "elastomorph.report",
        "page.html",
        title=title,
        subtitle=subtitle,
        sections=[each for each in sections if not each.appendix],
        appendix=[each for each in sections if each.appendix],
        viewer=viewer,
        script=Markup(script),
        digest=digest,
    )


@cache
def _script() -> str:
    """What copies tables, as the web source builds it."""
    return (files("elastomorph.report") / "templates" / "copy.js").read_text(encoding="utf-8")


def require_page_path(path: str | Path) -> None:
    """Refuse early what could not be written after a long computation."""
    if Path(path).suffix.lower() not in (".html", ".htm"):
        raise FormatError(path, "this is a web page; name it with the suffix .html")
    if not Path(path).resolve().parent.is_dir():
        raise FileError(
            path, f"the folder {Path(path).parent} does not exist; create it first or name another"
        )


def write_page(path: str | Path, page: str) -> None:
    """Write a finished page, the whole of it or nothing."""
    with replacing(path) as file:
        file.write(page.encode())


# Pictures of pixels and graphs of lines as they stand inside a page.

# Of WebP: at 82 no edge of a shaded face frays, at a tenth of the size of a PNG.
_QUALITY = 82
_REFERENCE = re.compile(r"url\(#([^)]+)\)")
_NUMBER = re.compile(r"-?\d+\.\d{3,}")
# Named last where a machine lacks the font that matplotlib measured: Verdana has its widths.
_FONT = "'DejaVu Sans'"
_FALLBACKS = f"{_FONT}, Verdana, sans-serif"


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture and the words that go with it.

    Attributes:
        title: Its heading.
        image: (H, W, 3) uint8.
        alt: What is seen, for those who do not see it.
        caption: What to look at.
        wide: Whether it is better scrolled than shrunk on a narrow screen.
        name: Of its file, without suffix, where it is one of those that are also written as files.
    """

    title: str
    image: Image
    alt: str
    caption: str
    wide: bool = True
    name: str = ""

    @property
    def source(self) -> str:
        """The picture itself as a ``data:`` address of WebP."""
        file = BytesIO()
        picture = imported("PIL.Image").fromarray(np.ascontiguousarray(self.image))
        picture.save(file, format="WEBP", quality=_QUALITY, method=4)
        return f"data:image/webp;base64,{b64encode(file.getvalue()).decode('ascii')}"


def picture_sections(faces: Sequence[Picture], more: Sequence[Picture]) -> list[Section]:
    """Pictures that show what was found, and in the appendix those that show more."""
    found = []
    if faces:
        found.append(Section("faces", "Faces", {"pictures": faces}))
    if more:
        found.append(Section("more", "More pictures", {"pictures": more}, appendix=True))
    return found


@dataclass(frozen=True, eq=False)
class Graph:
    """A graph of matplotlib and the words that go with it.

    Attributes:
        title: Its heading.
        svg: The graph, see `inline_svg`.
        caption: What to look at.
    """

    title: str
    svg: Markup
    caption: str

    @classmethod
    def drawn(
        cls, draw: Callable[[Path], None], name: str, title: str, alt: str, caption: str
    ) -> Graph:
        """Draw a graph; arguments and errors are those of `inline_svg`."""
        return cls(title, inline_svg(draw, name, alt), caption)


def inline_svg(draw: Callable[[Path], None], name: str, alt: str) -> Markup:
    """A graph as one ``svg`` element that may stand beside others in a page.

    Its ids begin with ``name``, its own on a page, its style touches nothing else, its words stay
    words, and it refers to nothing outside. ``draw`` draws it into a file ending in .svg.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "graph.svg"
        draw(file)
        root = ElementTree.fromstring(file.read_bytes())
    for parent in list(root.iter()):
        for child in list(parent):
            # The style speaks of every element of a page, the metadata to no reader of it.
            if _local(child.tag) in ("metadata", "style"):
                parent.remove(child)
    values = [value for node in root.iter() for value in node.attrib.values()]
    used = {reference for value in values for reference in _REFERENCE.findall(value)}
    used |= {value[1:] for value in values if value.startswith("#")}
    for node in root.iter():
        node.tag = _local(node.tag)
        pairs = [_kept(_local(key), value, used, name) for key, value in node.attrib.items()]
        node.attrib = dict(pair for pair in pairs if pair)
        node.text = node.text if (node.text or "").strip() else None
        node.tail = node.tail if (node.tail or "").strip() else None
    for key in ("width", "height", "version"):
        root.attrib.pop(key, None)
    root.attrib.update({"role": "img", "aria-label": alt, "class": "graph"})
    return Markup(ElementTree.tostring(root, encoding="unicode"))


def _kept(key: str, value: str, used: set[str], name: str) -> tuple[str, str] | None:
    """An attribute of a node as the page needs it, if it does."""
    if key == "id":
        return ("id", f"{name}-{value}") if value in used else None
    if key == "href":
        return "href", f"#{name}-{value.removeprefix('#')}"
    text = _REFERENCE.sub(rf"url(#{name}-\1)", value).replace(_FONT, _FALLBACKS)
    if key in ("d", "x", "y", "transform", "points"):
        text = " ".join(_NUMBER.sub(_rounded, text).split())
    return key, text


def _rounded(number: re.Match[str]) -> str:
    """Hundredths of a point are finer than any screen shows."""
    return f"{float(number[0]):.2f}".rstrip("0").rstrip(".")


def _local(name: str) -> str:
    """A name without its namespace: inside a page SVG needs none."""
    return name.rpartition("}")[2]


# What is compared: the first section of a report, and what only its caller knows.

_NAMED = 12


@dataclass(frozen=True, eq=False)
class About:
    """Where a recording came from and how it was compared.

    Attributes:
        name: What the report is about, such as ``built-in head`` or the name of a file.
        source: What the frames are, in a sentence.
        unit: Unit of the coordinates, such as ``cm``; an empty string where nobody knows it.
        call: The command or the call that makes this report again.
        curves: Where the curves come from, in a sentence.
        methods: The methods by their labels, with all settings; those left out are described by
            what their paths say of themselves.
        timing_known: Whether the frames were recorded at their times. Where a motion is only known
            as a way, such as that of a rigid part, errors at given times mean nothing.
        remarks: Further findings, in sentences.
    """

    name: str = "a recorded motion"
    source: str = ""
    unit: str = ""
    call: str = ""
    curves: str = "traced along the edges of the polygons, every vertex on one curve"
    methods: Mapping[str, Method | Morph] = field(default_factory=dict)
    timing_known: bool = True
    remarks: tuple[str, ...] = ()

    @property
    def truth(self) -> str:
        """What the methods are compared with, in a word or two."""
        return "recorded" if self.timing_known else "known way"


def compared(evaluation: Evaluation, about: About, informed: Sequence[str] = ()) -> Section:
    """The facts of one comparison."""
    truth = evaluation.truth
    facts = [
        ("Face" if evaluation.extent is None else "Parts", face_words(truth.mesh)),
        ("Size", _size_words(evaluation, about.unit)),
        ("Curves", curve_words(evaluation.curves)),
        ("Motion", _motion_words(truth, about)),
        ("Methods", method_labels(evaluation)),
    ]
    if evaluation.coverage:
        facts.insert(4, ("Confidence", evaluation.coverage))
    if truth.missing:
        facts.insert(4, ("Missing", _missing_words(truth)))
    more = f", {listed(informed)} frames between them too" if informed else ""
    how = (
        f"Every method was given the first and the last frame{more}. What it makes of the way "
        "between them is compared with the "
        f"{'recorded frames' if about.timing_known else 'known way'}."
    )
    content = {"source": about.source, "facts": facts, "how": how, "remarks": about.remarks}
    return Section("compared", "What was compared", content, appendix=True)


def method_labels(evaluation: Evaluation) -> str:
    """How many methods there are, and which."""
    labels = [result.label for result in evaluation.results]
    return f"{counted(len(labels), 'method')}: {', '.join(labels)}"


def face_words(mesh: Mesh) -> str:
    """Vertices and polygons, such as "8 vertices, 7 polygons (5 quads and 2 triangles)"."""
    words = counted(len(mesh.vertices), "vertex", "vertices")
    if not len(mesh.faces):
        return f"{counted(len(mesh.vertices), 'marker')}, without polygons"
    corners = np.diff(mesh.faces.offsets)
    kinds = [
        counted(int(np.count_nonzero(chosen)), name)
        for chosen, name in (
            (corners == 4, "quad"),
            (corners == 3, "triangle"),
            (corners > 4, "n-gon"),
        )
        if chosen.any()
    ]
    polygons = counted(len(mesh.faces), "polygon")
    return f"{words}, {polygons} ({listed(kinds)})" if len(kinds) > 1 else f"{words}, {kinds[0]}"


def curve_words(curves: CurveNetwork) -> str:
    """How many curves there are, and of which kind."""
    closed = sum(curve.closed for curve in curves)
    single = sum(len(curve) == 1 for curve in curves)
    words = f"{counted(len(curves), 'curve')}: {closed:,} closed, {len(curves) - closed:,} open"
    return f"{words} ({single:,} of a single vertex)" if single else words


def diameter_words(diameter: float, unit: str) -> str:
    """D with its unit, and what it is."""
    words = (
        f"D = {significant(diameter)} {unit or 'units'}, the distance of the two vertices that "
        "are farthest apart in the first frame"
    )
    return words if unit else f"{words}; the unit is that of the file, which does not name it"


def _size_words(evaluation: Evaluation, unit: str) -> str:
    """D; where only a part is compared, that of the whole face, and the size of the part."""
    own = evaluation.truth.mesh.diameter
    if evaluation.extent is None:
        return diameter_words(own, unit)
    return (
        f"D = {significant(evaluation.diameter)} {unit or 'units'}, the size of the whole face; "
        f"the parts compared here measure {significant(own)}"
    )


def _motion_words(truth: MeshSequence, about: About) -> str:
    times = truth.times
    steps = np.diff(times)
    even = bool(np.ptp(steps) <= 1e-6)
    words = f"{counted(len(truth), 'frame')} at t = 0 to 1"
    if len(times) <= _NAMED:
        words = f"{counted(len(truth), 'frame')} at t = {', '.join(f'{t:.3g}' for t in times)}"
    elif even:
        words += f", {steps[0]:.3g} apart"
    else:
        words += f", {steps.min():.3g} to {steps.max():.3g} apart"
    if not about.timing_known:
        words += "; only the way is known, the times are made up"
    return words


def _missing_words(truth: MeshSequence) -> str:
    return (
        f"the numbering leaves out {first_few(truth.missing, _NAMED)}; the frames there are keep "
        "the times of their numbers"
    )
