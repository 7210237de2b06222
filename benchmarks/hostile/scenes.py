"""USD and FBX files made to harm."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Iterator
from random import Random

from hostile.byte_changes import MOST_BYTES
from hostile.case import Case, Entry, Link, Pipe

__all__ = ["fbx_texts", "usd_folders", "usd_texts", "usdz"]


def usdz(content: bytes, name: str = "face.usdc") -> bytes:
    """A package with one layer."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as packed:
        packed.writestr(zipfile.ZipInfo(name), content)
    return file.getvalue()


def usd_texts(whole: str) -> Iterator[tuple[str, str]]:
    """USD texts, each with what it is.

    Args:
        whole: A whole file of a rig.
    """
    head = "#usda 1.0\n"
    for depth in (100, 1000, 20_000):
        yield f"prims {depth} deep", head + 'def "a" {\n' * depth + "}\n" * depth
        yield f"brackets {depth} deep", head + 'def "a" {\ncustom int a = ' + "(" * depth + "\n}"
        yield f"arrays {depth} deep", head + 'def "a" {\ncustom int[] a = ' + "[" * depth + "\n}"
        deep = "dictionary a = {\n" * depth + "}\n" * depth
        yield f"dictionaries {depth} deep", head + f"(\ncustomLayerData = {{\n{deep}}}\n)"
    yield "many prims", head + "".join(f'def "a{i}" {{}}\n' for i in range(60_000))
    yield "many meshes", head + "".join(f'def Mesh "a{i}" {{}}\n' for i in range(40_000))
    yield "a bomb of references", head + _bomb(9, 10)
    yield "a small bomb of references", head + _bomb(4, 10)
    yield "a reference to itself", head + 'def "a" (references = </a>) { }'
    yield "a reference to its parent", head + 'def "a" {\ndef "b" (references = </a>) {}\n}'
    for attribute, values in (
        ("point3f[] points", ("[(nan, 0, 0)]", "[(inf, 0, 0)]", "[(1e999, 0, 0)]", "[]", "None")),
        ("int[] points", ("[1, 2]",)),
        ("string points", ('"a"',)),
        ("int[] faceVertexCounts", ("[2147483647]", "[-1, 5]", "[0]", "[]", "[99999999999]")),
        ("float[] faceVertexCounts", ("[3.5]",)),
        ("int[] faceVertexIndices", ("[-1]", "[2147483647]", "[]")),
    ):
        for value in values:
            kind, name = attribute.split(" ")
            own = _replaced(whole, name, f"{kind} {name} = {value}")
            yield f"{attribute} = {value}", own
    for kind, value in (("float[]", "[1, 2]"), ("string", '"a"'), ("texCoord2f", "(1, 2)")):
        extra = f'        {kind} primvars:st = {value} (interpolation = "faceVarying")\n'
        yield f"primvars:st {kind}", _into_mesh(whole, extra)
    for key in ("elastomorph:path", "elastomorph:sliders"):
        for text in (
            *('{"version": 1}', "[" * 900, '{"version": 1, "checksum": 1e999}', "null", "{}"),
            '{"version": 1, "method": "m", "bakeError": 1e999, "bendCurves": [], "limitLaw": '
            '{"breaks": [0, 1], "coefficients": [[0]]}, "checksum": 0}',
            '{"version": 1, "method": "m", "bakeError": 0, "bendCurves": [], "limitLaw": '
            '{"breaks": [0, 1], "coefficients": [[1' + "0" * 400 + ']]}, "checksum": 0}',
            '{"version": 1, "method": "m", "bakeError": 1' + "0" * 400 + "}",
            '{"version": 1, "correctives": {"a": [1]}, "groups": {"b": ["nothing"]}}',
            '{"version": 1, "correctives": 5, "groups": [], "materialLibrary": 5, "checksum": []}',
        ):
            yield f"{key} {text[:30]}", _json_replaced(whole, key, text)
    yield (
        "many numbers",
        head + 'def Mesh "a" { point3f[] points = [' + "(0,0,0)," * 120_000 + "] }",
    )
    yield "one time sample", _replaced(whole, "points", "point3f[] points.timeSamples = {0: []}")
    for arcs in ("clips", "inherits", "specializes", "payload"):
        yield f"{arcs} of nothing", head + f'def "a" ({arcs} = </b>) {{}}'


def usd_folders(whole: str) -> Iterator[Case]:
    """USD files that name others."""
    head = "#usda 1.0\n"
    outside: dict[str, Entry] = {"../outside.usda": whole.encode(), "part.usda": whole.encode()}
    outside |= {"link.usda": Link("../../outside.usda"), "loop.usda": Link("loop.usda")}
    outside |= {"pipe.usda": Pipe(), "up": Link("..")}
    for name, wanted in (
        ("./part.usda", "loaded"),
        *(
            (name, "refused")
            for name in ("../outside.usda", "/etc/passwd", "link.usda", "loop.usda")
        ),
        *((name, "refused") for name in ("file:///etc/passwd", "http://localhost:9/a.usda")),
        *((name, "refused") for name in ("up/outside.usda", "pipe.usda", "part.usda[a.usda]")),
        *(
            (name, "refused")
            for name in ("~/a.usda", "a" * 3000 + ".usda", "gone.usda", "face.usda")
        ),
    ):
        text = head + f'def "a" (references = @{name}@) {{}}'
        yield Case(
            f"refers to {name[:40]}", "face.usda", {"face.usda": text.encode(), **outside}, wanted
        )


def fbx_texts(whole: bytes) -> Iterator[tuple[str, bytes]]:
    """FBX texts, each with what it is."""
    head = b"; FBX 7.4.0 project file\n"
    for depth in (100, 10_000, 200_000):
        yield f"{depth} deep", head + b"A: {\n" * depth
    yield "numbers", head + b"Objects: {\nA: *9 {\na: " + b"1," * 450_000 + b"1\n}\n}\n"
    yield (
        "models",
        head
        + b"Objects: {\n"
        + b"".join(b'Model: %d, "Model::a", "Mesh" {\n}\n' % i for i in range(25_000))
        + b"}\n",
    )
    for count in (b"2147483647", b"-1", b"99999999999999999999", b"0"):
        yield f"arrays of {count.decode()}", whole.replace(b"*12 ", b"*" + count + b" ")
    for old, new in (
        (b"a: 0,1,2,-4", b"a: 0,1,2,-400"),
        (b"a: 0,1,2,-4", b"a: 0,1,2,3"),
        (b"a: 0,1,2,-4", b"a: -1,-1,-1,-1"),
        (b"a: 2\n", b"a: 99\n"),
        (b"a: 2\n", b"a: -5\n"),
        (b"0.25,0.5", b"1e999,0.5"),
        (b"0.25,0.5", b"1e308,1e308"),
        (b"0.0,0.0,0.5", b"nan,0.0,0.5"),
        (b'"Lcl Scaling", "", "A", 1.0', b'"Lcl Scaling", "", "A", 1e400'),
        (b'"Lcl Scaling", "", "A", 1.0', b'"Lcl Scaling", "", "A", 1e308'),
        (b'"Lcl Scaling", "", "A", 1.0', b'"Lcl Scaling", "", "A", 0.0'),
        (b'"Lcl Scaling", "", "A", 1.0', b'"Lcl Scaling", "", "A", 1e-300'),
        (b'"Lcl Translation", "", "A", 0.0', b'"Lcl Translation", "", "A", 1e308'),
        (b'"Lcl Rotation", "", "A", 0.0', b'"Lcl Rotation", "", "A", 1e308'),
        (b"FullWeights: *1 {\n\t\ta: 100.0", b"FullWeights: *1 {\n\t\ta: nan"),
        (b"FullWeights: *1 {\n\t\ta: 100.0", b"FullWeights: *1 {\n\t\ta: 1e999"),
        (b"FullWeights: *1 {\n\t\ta: 100.0", b"FullWeights: *1 {\n\t\ta: 0"),
        (b"FullWeights: *1 {\n\t\ta: 100.0", b"FullWeights: *1 {\n\t\ta: -1"),
    ):
        yield f"{new[:40]!a}", whole.replace(old, new)
    yield "one mesh of many nodes", _instances(whole, 3000)


def _instances(whole: bytes, count: int) -> bytes:
    """The mesh of the file below many more nodes."""
    models = b"".join(
        b'\tModel: %d, "Model::n%d", "Mesh" {\n\t}\n' % (9000 + i, i) for i in range(count)
    )
    mesh = whole.split(b"Geometry: ", 1)[1].split(b",", 1)[0]
    links = b"".join(
        b'\tC: "OO", %d, 0\n\tC: "OO", %s, %d\n' % (9000 + i, mesh, 9000 + i) for i in range(count)
    )
    return whole.replace(b"Objects:  {\n", b"Objects:  {\n" + models).replace(
        b"Connections:  {\n", b"Connections:  {\n" + links
    )[: MOST_BYTES - 1]


def _bomb(levels: int, width: int) -> str:
    """Prims that hold the level below many times, as references within the file."""
    parts = ['def "l0" {\ndef Mesh "m" {}\n}\n']
    for level in range(1, levels):
        children = "".join(
            f'def "c{i}" (references = </l{level - 1}>) {{}}\n' for i in range(width)
        )
        parts.append(f'def "l{level}" {{\n{children}}}\n')
    return "".join(parts)


def _replaced(whole: str, name: str, line: str) -> str:
    lines = whole.split("\n")
    for number, own in enumerate(lines):
        if f" {name} = " in own:
            lines[number] = line
            break
    return "\n".join(lines)


def _into_mesh(whole: str, extra: str) -> str:
    place = whole.index("point3f[] points")
    start = whole.rindex("\n", 0, place) + 1
    return whole[:start] + extra + whole[start:]


def _json_replaced(whole: str, key: str, text: str) -> str:
    lines = whole.split("\n")
    for number, own in enumerate(lines):
        if f"{key} = " in own:
            lines[number] = own[: own.index(" = ") + 3] + json.dumps(text)
    return "\n".join(lines)


def damaged_scene(random: Random, whole: str) -> tuple[str, str]:
    """The text with the values of two attributes exchanged or one repeated."""
    lines = [n for n, line in enumerate(whole.split("\n")) if " = " in line]
    one, other = random.choice(lines), random.choice(lines)
    changed = whole.split("\n")
    left, right = (changed[n].split(" = ", 1) for n in (one, other))
    changed[one] = f"{left[0]} = {right[1]}"
    return f"line {one} with the value of line {other}", "\n".join(changed)
