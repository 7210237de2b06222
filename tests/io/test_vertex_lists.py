"""Curves round trip in both forms, and complaints name curve and vertex; regions of all kinds."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from elastomorph.curves import Curve, CurveNetwork
from elastomorph.errors import ElastomorphError, FileError, FormatError, ParameterError
from elastomorph.io.vertex_lists import read_curves, read_region, write_curves

patiently = settings(
    max_examples=150,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)


def written(folder: Path, content: object) -> Path:
    path = folder / "curves.json"
    if isinstance(content, bytes):
        path.write_bytes(content)
    else:
        path.write_text(
            content if isinstance(content, str) else json.dumps(content), encoding="utf-8"
        )
    return path


@st.composite
def networks(draw):
    lengths = draw(st.lists(st.integers(1, 6), min_size=1, max_size=5))
    count = sum(lengths) + draw(st.integers(0, 3))
    labels = draw(st.permutations(range(count)))
    curves, start = [], 0
    for length in lengths:
        closed = length >= 3 and draw(st.booleans())
        curves.append(Curve(labels[start : start + length], closed, draw(st.text(max_size=8))))
        start += length
    return CurveNetwork(curves, count)


@patiently
@given(networks())
def test_what_is_written_is_read_back(tmp_path, network):
    path = tmp_path / "curves.json"
    write_curves(path, network)
    assert read_curves(path, network.vertex_count) == network.curves


@patiently
@given(networks())
def test_a_written_file_is_plain_json(tmp_path, network):
    path = tmp_path / "curves.json"
    write_curves(path, network)
    content = json.loads(path.read_bytes())
    assert content["vertex_count"] == network.vertex_count
    assert [entry["vertices"] for entry in content["curves"]] == [
        curve.vertices.tolist() for curve in network
    ]


def test_bare_lists_are_closed_where_the_last_vertex_repeats_the_first(tmp_path):
    path = written(tmp_path, [[0, 1, 2, 0], [3, 4], [5]])
    assert read_curves(path, 6) == (
        Curve([0, 1, 2], closed=True),
        Curve([3, 4]),
        Curve([5]),
    )


def test_the_full_form_may_leave_out_what_it_does_not_need(tmp_path):
    path = written(tmp_path, {"curves": [{"vertices": [0, 1, 2, 0]}, {"vertices": [3, 4]}]})
    assert read_curves(path, 5) == (Curve([0, 1, 2], closed=True), Curve([3, 4]))


def test_vertices_may_be_named_where_markers_have_names(tmp_path):
    path = written(tmp_path, [["chin", "lip", 3], ["brow"]])
    names = ["lip", "brow", "chin", "nose"]
    assert read_curves(path, 4, names) == (Curve([2, 0, 3]), Curve([1]))


def test_a_byte_order_mark_is_no_obstacle(tmp_path):
    assert read_curves(written(tmp_path, b"\xef\xbb\xbf[[0, 1]]"), 2) == (Curve([0, 1]),)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "file is empty"),
        (" \n\n ", "file is empty"),
        ("[]", "holds no curves"),
        ({"curves": []}, "holds no curves"),
        ({"curve": [[0]]}, "no list of curves"),
        ("3", "no list of curves"),
        ('"chin"', "no list of curves"),
        ("[[0, 1],\n [2,, 3]]", "line 2: not JSON"),
        ("[[0, 1]] [[2]]", "line 1: not JSON"),
        (b"[[0, 1],\n\xff\xfe]", "line 2: not JSON: the text is not UTF-8"),
        ("[" * 100_000, "nested too deeply"),
        ("[[0, NaN]]", "found NaN"),
        ("[[0, -Infinity]]", "found -Infinity"),
        (f"[[{'9' * 5000}]]", "too many digits"),
        (f"[[{'9' * 4000}]]", "curve 0: vertex a number too large to show does not exist"),
        ([[0, 1], [2, 9]], "curve 1: vertex 9 does not exist; the mesh has 9 vertices"),
        ([[0, -1]], "curve 0: vertex -1 does not exist"),
        ([[0, 1.0]], "curve 0: vertex 1.0 is not a whole number"),
        ([[0, True]], "curve 0: vertex true is not a whole number"),
        ([[0, None]], "curve 0: vertex null is not a whole number"),
        ([[0, [1]]], "curve 0: vertex a list is not a whole number"),
        ([[0, "chin"]], 'curve 0: vertex "chin" is a name, but the vertices of this mesh'),
        ([[0, 1], []], "curve 1: it has no vertices"),
        ([[0, 1], 5], "curve 1: its vertices must be a list"),
        ([[0, 1, 2, 1]], "curve 0: it passes through vertex 1 twice"),
        ([[0, 1], [2, 1]], "curve 1: vertex 1 lies on curve 0 already"),
        ([[0, 1, 0]], "curve 0: it is closed but has 2 vertices"),
        ([[4, 4]], "curve 0: it is closed but has 1 vertices"),
        (
            [{"vertices": [0, 1], "closed": True, "name": "eye"}],
            r'curve 0 \("eye"\): it is closed but has 2',
        ),
        ([{"vertices": [0, 1], "closed": 1}], '"closed" must be true or false, found 1'),
        ([{"vertices": [0, 1], "close": True}], 'unknown key "close"'),
        ([{"vertices": [0, 1, 2, 0], "closed": True}], "passes through vertex 0 twice"),
        ([{"closed": True}], "its vertices must be a list of indices, found null"),
        ([{"vertices": "0 1 2"}], 'its vertices must be a list of indices, found "0 1 2"'),
        ([{"vertices": [0], "name": 7}], "its name must be text, found 7"),
        ({"vertex_count": 12, "curves": [[0]]}, "for a mesh of 12 vertices, this mesh has 9"),
        ({"vertex_count": "9", "curves": [[0]]}, 'for a mesh of "9" vertices'),
    ],
)
def test_what_is_no_curve_file_is_refused_with_the_reason(tmp_path, content, message):
    path = written(tmp_path, content)
    with pytest.raises(FormatError, match=message) as caught:
        read_curves(path, 9)
    assert str(caught.value).startswith(str(path))
    assert len(str(caught.value)) < len(str(path)) + 300


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ([["chin", "ear"]], 'curve 0: vertex "ear" does not exist among the names'),
        ([["chin", "lip", "chin", 3]], r'curve 0: it passes through vertex 2 \("chin"\) twice'),
        ([["chin"], [1, 2]], r'curve 1: vertex 2 \("chin"\) lies on curve 0 already'),
        ([["twin"]], 'vertex "twin" is the name of several vertices'),
    ],
)
def test_names_that_do_not_fit_are_refused(tmp_path, content, message):
    with pytest.raises(FormatError, match=message):
        read_curves(written(tmp_path, content), 5, ["lip", "brow", "chin", "twin", "twin"])


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(FileError, match=r"nothing\.json"):
        read_curves(tmp_path / "nothing.json", 9)


@patiently
@given(st.data())
def test_a_file_cut_off_anywhere_is_refused_or_read_whole(tmp_path, data):
    path = tmp_path / "curves.json"
    write_curves(path, CurveNetwork([Curve([0, 1, 2], True, "ä"), Curve([4, 3])], 6))
    whole = path.read_bytes()
    path.write_bytes(whole[: data.draw(st.integers(0, len(whole.rstrip()) - 1))])
    with pytest.raises(FormatError):
        read_curves(path, 6)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers(-2, 12) | st.floats() | st.text(max_size=4),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(st.sampled_from(["vertices", "closed", "name", "curves"]), inner)
    ),
    max_leaves=20,
)


@patiently
@given(JSON | st.binary(max_size=60))
def test_whatever_a_file_holds_it_is_read_or_refused(tmp_path, content):
    path = written(tmp_path, content)
    try:
        curves = read_curves(path, 9)
    except FormatError:
        return
    CurveNetwork(curves, 9)


def test_ranges_and_files_say_the_same(tmp_path: Path) -> None:
    plain, named = tmp_path / "a.json", tmp_path / "b.json"
    plain.write_text("[3, 4, 5, 9]")
    named.write_text('{"vertices": [3, 4, 5, 9]}')
    for region in ("3-5,9", plain, str(named)):
        assert read_region(region).tolist() == [3, 4, 5, 9]


@pytest.mark.parametrize("text", ["", "a", "3-", "5-3", "-2", "1,,2", "0-99999999999", "1.5"])
def test_ranges_that_are_none(text: str) -> None:
    with pytest.raises(ParameterError, match="range"):
        read_region(text)


@pytest.mark.parametrize("text", ["", "{}", "[1.5]", "[true]", "[-1]", "[" * 100_000, "7"])
def test_files_that_hold_no_region(text: str, tmp_path: Path) -> None:
    file = tmp_path / "region.json"
    file.write_text(text)
    with pytest.raises(FormatError, match=r"region\.json"):
        read_region(file)


def test_a_region_in_no_file(tmp_path: Path) -> None:
    with pytest.raises(ElastomorphError, match=r"no\.json"):
        read_region(tmp_path / "no.json")
