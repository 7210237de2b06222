"""Text files made to harm: numbers, counts and lines that no program would write."""

from __future__ import annotations

from collections.abc import Iterator

from hostile.byte_changes import MOST_BYTES

__all__ = [
    "csv_files",
    "curve_files",
    "livelink_files",
    "obj_files",
    "ply_files",
    "region_files",
    "settings_files",
]

_TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
_HUGE = ("9" * 5000, "0" * 5000 + "1", "1e999", "1" * 400, "-" + "9" * 30, "1e18", "-1e18")


def _filled(line: str, head: str = "", tail: str = "") -> str:
    """The line as often as a megabyte holds it."""
    return head + line * ((MOST_BYTES - 1 - len(head) - len(tail)) // len(line)) + tail


def _counted(template: str, head: str = "", tail: str = "") -> str:
    """The template with 0, 1, 2 … in place of # as often as a megabyte holds it."""
    parts, size = [head], len(head) + len(tail)
    while size < MOST_BYTES - 40:
        parts.append(template.replace("#", str(len(parts))))
        size += len(parts[-1])
    return "".join(parts) + tail


def obj_files() -> Iterator[tuple[str, str]]:
    """OBJ texts, each with what it is."""
    for number in (*_HUGE, "nan", "inf", "1_0", "1e-999", "\u0661", "+", ".", "1e", "0x1"):
        yield f"coordinate {number[:8]}", f"v {number} 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
        yield f"index {number[:8]}", f"{_TRIANGLE}f 1 2 {number}\n"
        yield f"vt index {number[:8]}", f"{_TRIANGLE}vt 0 0\nf 1/1 2/1 3/{number}\n"
        yield f"normal {number[:8]}", f"{_TRIANGLE}f 1//1 2//1 3//{number}\n"
        yield f"relative index {number[:8]}", f"{_TRIANGLE}f -1 -2 -{number}\n"
    yield "a long number that is none", f"v {'1' * (MOST_BYTES - 20)}x 0 0\n"
    yield "a long fraction that is none", f"v 0.{'1' * (MOST_BYTES - 20)}x 0 0\n"
    yield "a long exponent", f"v 1e{'1' * (MOST_BYTES - 20)} 0 0\n"
    yield "a long index", f"{_TRIANGLE}f 1 2 {'0' * (MOST_BYTES - 60)}3\n"
    yield "a long corner", f"{_TRIANGLE}f 1 2 {'/' * (MOST_BYTES - 60)}\n"
    yield "a long name", f"{_TRIANGLE}usemtl {'n' * (MOST_BYTES - 60)}\nf 1 2 3\n"
    yield "a long keyword", "k" * (MOST_BYTES - 1)
    yield "one polygon of all", _TRIANGLE + "f" + " 1" * 450_000 + "\n"
    yield "relative indices", _filled("f -1 -2 -3\n", _TRIANGLE)
    yield "vertices only", _filled("v 0 0 0\n")
    yield "vertices of the strict reader", _filled("v 0 0 0\n", "v 0 0 0 # a\n")
    yield "small polygons", _filled("f 1 2 3\n", _TRIANGLE)
    yield "polygons of the strict reader", _filled("f 1 2 3\n", _TRIANGLE + "\\\n\n")
    yield "a group a polygon", _counted("g g#\nf 1 2 3\n", _TRIANGLE)
    yield "groups", _counted("g #\n", _TRIANGLE, "f 1 2 3\n")
    yield "libraries", _counted("mtllib #\n", _TRIANGLE, "f 1 2 3\n")
    yield "continued lines", _filled("\\\n", "v 0 0 0 ")
    yield "continued words", _filled("1 \\\n", _TRIANGLE + "f ")
    yield "empty texture coordinates", _filled("vt 0\n", _TRIANGLE)
    yield "comments", _filled("#\n", _TRIANGLE)
    yield "a wrong line at the end", _filled("v 0 0 0\n", "", "oops\n")
    yield "names that are not UTF-8 escapes", f"{_TRIANGLE}g \\ud800\nf 1 2 3\n"


def ply_files() -> Iterator[tuple[str, str]]:
    """PLY texts, each with what it is."""
    vertex = "property float x\nproperty float y\nproperty float z\n"
    face = "property list uchar int vertex_indices\n"
    body = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"

    def ply(header: str, rows: str, encoding: str = "ascii") -> str:
        return f"ply\nformat {encoding} 1.0\n{header}end_header\n{rows}"

    for count in ("0", "-1", "999999999999999999", "9" * 5000, "3.0", "1e9", "\u0663", "4"):
        for encoding in ("ascii", "binary_little_endian"):
            label = f"count {count[:8]} {encoding}"
            faces = f"element face 1\n{face}"
            yield label, ply(f"element vertex {count}\n{vertex}{faces}", body, encoding)
            yield label, ply(f"element vertex 3\n{vertex}element face {count}\n{face}", body)
            empty = f"element nothing {count}\nelement vertex 3\n{vertex}"
            yield label + " of nothing", ply(empty, body, encoding)
    for number in (*_HUGE, "nan", "inf", "1_0", "\u0661", "x", "3.5", ""):
        whole = f"element vertex 3\n{vertex}element face 1\n{face}"
        yield f"coordinate {number[:8]}", ply(whole, body.replace("0 1 0", f"0 1 {number}"))
        yield f"corner {number[:8]}", ply(whole, body.replace("3 0 1 2", f"3 0 1 {number}"))
        yield f"length {number[:8]}", ply(whole, body.replace("3 0 1 2", f"{number} 0 1 2"))
    twice = vertex.replace("float x", "list uchar float x") + "property float x\n"
    yield "x twice, first a list", ply(f"element vertex 1\n{twice}", "2 1 1 0 0 0\n")
    lists = f"property float vertex_indices\n{face}"
    yield (
        "corners twice, first numbers",
        ply(
            f"element vertex 3\n{vertex}element face 1\n{lists}",
            "0 0 0\n1 0 0\n0 1 0\nnan 3 0 1 2\n",
        ),
    )
    yield (
        "corners that are numbers",
        ply(f"element vertex 3\n{vertex}element face 1\nproperty int vertex_indices\n", body),
    )
    for kind in ("char", "uint", "double"):
        own = face.replace("uchar int", f"uchar {kind}")
        yield f"corners {kind}", ply(f"element vertex 3\n{vertex}element face 1\n{own}", body)
        own = face.replace("uchar int", f"{kind} int")
        yield f"lengths {kind}", ply(f"element vertex 3\n{vertex}element face 1\n{own}", body)
    yield "strips", ply(f"element vertex 3\n{vertex}element tristrips 1\n{face}", body)
    yield (
        "two elements of one name",
        ply(f"element vertex 1\n{vertex}element vertex 2\n{vertex}element face 1\n{face}", body),
    )
    yield "encodings twice", ply(f"format binary_big_endian 1.0\nelement vertex 3\n{vertex}", body)
    yield "properties", _counted("property int p#\n", "ply\nformat ascii 1.0\nelement vertex 1\n")
    for encoding in ("ascii", "binary_little_endian"):
        for properties in (2_000, 20_000):
            own = "".join(f"property int p{i}\n" for i in range(properties))
            own = f"element vertex 1\n{vertex}{own}"
            yield f"{properties} properties", ply(own, "0 " * (properties + 3) + "\n", encoding)
            yield f"{properties} properties cut", ply(own, "0 " * properties + "\n", encoding)
    yield "elements", ply(_counted("element e# 0\n")[: MOST_BYTES - 200_000] + "\n", "")
    yield (
        "empty lists",
        ply(
            f"element list 900000\n{face}element vertex 1\n{vertex}",
            "\0" * 900_012,
            "binary_little_endian",
        ),
    )
    yield (
        "lists of one and none",
        ply(
            f"element vertex 1\n{vertex}element other 300000\nproperty list uchar char a\n",
            "\0" * 12 + "\x01\x01\0" * 200_000 + "\0" * 100_000,
            "binary_little_endian",
        ),
    )
    yield (
        "polygons of mixed lengths",
        ply(
            f"element vertex 3\n{vertex}element face 110000\n{face.replace('int v', 'uchar v')}",
            "\0" * 36 + "\x03\0\0\0\x04\0\0\0\0" * 55_000,
            "binary_little_endian",
        ),
    )
    yield (
        "vertices only",
        _filled("0 0 0\n", f"ply\nformat ascii 1.0\nelement vertex 166640\n{vertex}end_header\n"),
    )
    yield "a long line", ply(f"element vertex 1\n{vertex}", "0 " * 490_000)
    yield "a long number", ply(f"element vertex 1\n{vertex}", "1" * 990_000 + " 0 0\n")


def csv_files() -> Iterator[tuple[str, str]]:
    """Tables of times and weights, each with what it is."""
    for number in (*_HUGE, "nan", "inf", "1_0", "\u0661", "", " ", '"1"', "'1", "1;5", "1e-320"):
        yield f"weight {number[:8]}", f"time,jawOpen\n0,0\n1,{number}\n"
        yield f"time {number[:8]}", f"time,jawOpen\n0,0\n{number},1\n"
    yield "times far apart", "time,jawOpen\n-1e308,0\n1e308,1\n"
    yield "times close together", "time,jawOpen\n0,0\n5e-324,1\n"
    yield "times far and close", "time,jawOpen\n-1.7e308,0\n0,0\n5e-324,1\n1.7e308,1\n"
    yield "columns", "time," + _counted("c#,")[:400_000].rstrip(",") + "\n" + "0," * 150_000 + "0\n"
    yield "the last column twice", "time," + _counted("c#,")[:900_000] + "c1\n"
    yield "rows of nothing", _filled(",\n", "time,a\n")
    yield "rows", _counted("#,0\n", "time,a\n")
    yield "a wrong cell at the end", _counted("#,0\n", "time,a\n", "x,x\n")
    yield "a wide row", "time,a\n" + "0," * 490_000 + "\n"
    yield "empty lines", _filled("\n", "time,a\n0,0\n")
    yield "a quote that never ends", _filled("a,b\n", 'time,a\n0,"')
    yield "a long cell", "time,a\n0," + "1" * 131_000 + "\n"
    yield "a longer cell", "time,a\n0," + "1" * 140_000 + "\n"
    yield "a long name", "time," + "n" * 130_000 + "\n0,x\n"
    yield "semicolons", "time;a\n0;0\n"
    yield "a name twice", "time,a,a\n0,0,0\n"
    yield "a name of nothing", "time,a,\n0,0,0\n"
    yield "no time", "a,b\n0,0\n"
    yield "two times", "time,seconds,a\n0,0,0\n"
    yield "only time", "time\n0\n"
    yield "no rows", "time,a\n"


def livelink_files() -> Iterator[tuple[str, str]]:
    """Takes of Live Link Face, each with what it is."""
    head = "Timecode,BlendShapeCount,EyeBlinkLeft\n"
    codes = (
        *("13:04:31:12.500", "24:00:00:00", "00:60:00:00", "00:00:00:999", "00:00:00;00", ""),
        *("00:00:00:00." + "9" * 1000, "1:2:3:4", "\u0661\u0662:00:00:00", "-1:00:00:00", ":::"),
    )
    for code in codes:
        yield f"timecode {code[:12]!a}", f"{head}{code},1,0\n"
        yield f"then timecode {code[:12]!a}", f"{head}12:00:00:00,1,0\n{code},1,0\n"
    for count in ("0", "-1", "2", "9" * 5000, "1.0", "\u0661", "", "x", "00000000001"):
        yield f"count {count[:8]}", f"{head}12:00:00:00,{count},0\n12:00:00:01,1,0\n"
    yield "a gap of hours", f"{head}00:00:00:00,1,0\n00:00:00:01,1,0\n00:27:00:00,1,0\n"
    yield "midnight again and again", _filled("23:59:59:59,1,0\n00:00:00:00,1,0\n", head)
    yield "one timecode", _filled("00:00:00:00,1,0\n", head)
    yield "sub-frames", _filled("00:00:00:00.1,1,0\n00:00:00:00.2,1,0\n", head)
    yield "no face", _filled("00:00:00:00,0,\n", head)
    yield "short rows", _filled("0\n", head)
    yield "columns", f"Timecode,BlendShapeCount,{_counted('c#,')[:900_000]}x\n00:00:00:00,1,0\n"
    steps = "".join(
        f"{i // 3600:02d}:{i // 60 % 60:02d}:{i % 60:02d}:{i % 30:02d},1,0\n" for i in range(50_000)
    )
    yield "a frame a second", head + steps


def curve_files() -> Iterator[tuple[str, str]]:
    """JSON that is or is not curves of a mesh of a hundred vertices, each with what it is."""
    deep = MOST_BYTES - 1
    yield "100,000 brackets", "[" * 100_000
    yield "100,000 pairs of brackets", "[" * 100_000 + "]" * 100_000
    for depth in range(930, 1001, 10):
        yield f"{depth} pairs of brackets", "[" * depth + "]" * depth
        yield f"{depth} objects", '{"curves":' * depth + "1" + "}" * depth
        yield f"a name {depth} deep", '{"curves": [{"name": ' + "[" * depth + "]" * depth + "}]}"
    yield "objects", '{"a":' * (deep // 5)
    for number in (*_HUGE, "NaN", "Infinity", "-1", "1.0", "true", "null", '"a"', "100", "1e2"):
        yield f"vertex {number[:8]}", f"[[0, 1, {number}]]"
        yield f"count {number[:8]}", f'{{"vertex_count": {number}, "curves": [[0, 1, 2]]}}'
        yield f"closed {number[:8]}", f'{{"curves": [{{"vertices": [0, 1], "closed": {number}}}]}}'
        yield f"name {number[:8]}", f'{{"curves": [{{"vertices": [0, 1], "name": {number}}}]}}'
        yield f"curves {number[:8]}", f'{{"curves": {number}}}'
    yield "half a character", '{"curves": [{"vertices": [0, 1], "name": "\\ud800"}]}'
    yield "a long name", '{"curves": [{"vertices": [0, 0], "name": "' + "n" * 900_000 + '"}]}'
    yield "a long key", '{"curves": [{"vertices": [0, 1], "' + "n" * 900_000 + '": 1}]}'
    yield "keys", '{"curves": [{' + _counted('"k#": 0,')[:900_000] + '"vertices": 0}]}'
    yield "one key again and again", '{"curves": [[0, 1]]' + ', "curves": [[0, 1]]' * 40_000 + "}"
    yield "empty curves", "[" + "[]," * 300_000 + "[]]"
    yield "one vertex again", "[[0" + ",0" * 450_000 + "]]"
    yield "numbers", "[[" + _counted("#,")[:900_000] + "0]]"
    yield "a long text", '"' + "\\u0041" * 160_000 + '"'


def region_files() -> Iterator[tuple[str, str]]:
    """JSON that is or is not a list of vertices, each with what it is."""
    yield "100,000 brackets", "[" * 100_000
    for depth in (900, 950, 990, 1000):
        yield f"{depth} pairs of brackets", "[" * depth + "]" * depth
        yield f"vertices {depth} deep", '{"vertices":' * depth + "1" + "}" * depth
    for number in (*_HUGE, "NaN", "Infinity", "-1", "1.0", "true", "null", '"a"', "2147483648"):
        yield f"vertex {number[:8]}", f"[0, 1, {number}]"
        yield f"vertices {number[:8]}", f'{{"vertices": {number}}}'
    yield "one vertex again", "[0" + ",0" * 450_000 + "]"
    yield "nothing", "[]"


def settings_files() -> Iterator[tuple[str, str]]:
    """TOML that is or is not settings, each with what it is."""
    for depth in (30, 100, 1000, 20_000, 100_000):
        yield f"arrays {depth} deep", "a = " + "[" * depth + "]" * depth
        yield f"tables {depth} deep", "a = " + "{b = " * depth + "1" + "}" * depth
        yield f"keys {depth} deep", "a" + ".a" * depth + " = 1"
        yield f"a header {depth} deep", "[a" + ".a" * depth + "]"
        yield f"quoted keys {depth} deep", 'a."b' + '"."b' * depth + '" = 1'
    for number in (*_HUGE, "nan", "inf", "-1", "0", "1e-320", "true", "[]", "{}", "1979-05-27"):
        yield f"falloff {number[:8]}", f'[regions.a]\nvertices = "0"\nfalloff = {number}'
        yield f"vertices {number[:8]}", f"[regions.a]\nvertices = {number}"
        yield f"range {number[:8]}", f'[regions.a]\nvertices = "0-{number}"'
        yield f"fps {number[:8]}", f"[export.glb]\nfps = {number}"
        yield f"method {number[:8]}", f"[method]\ndefault = {number}"
        yield f"inbetween {number[:8]}", f'[inbetweens.a]\n"{number}" = "a.obj"'
    for name in ("../a.obj", "/etc/passwd", "~/a", "a" * 5000, "\\u0000", "", "gone.obj"):
        yield f"neutral {name[:12]}", f'[character]\nneutral = "{name}"'
        yield f"targets {name[:12]}", f'[character]\ntargets = ["{name}"]'
    yield "keys", "[methods]\n" + _counted('a# = "beam"\n')[:250_000]
    yield "groups", "[groups]\n" + _counted('a# = ["b"]\n')[:250_000].rsplit("\n", 1)[0]
    yield "a long unknown key", "k" * 200_000 + " = 1"
    yield "a long text", '[method]\ndefault = "' + "b" * 200_000 + '"'
    yield "too large", _filled("# a comment\n")
    yield "half a character", '[methods]\n"\\ud800" = "beam"'
    yield "a key twice", "[method]\ndefault = 'beam'\ndefault = 'beam'"
