"""What cannot be meant is one error of ours that says what was expected, in every public call."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import elastomorph as em
from elastomorph import timing

MESH: Any = em.Mesh(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0]], [[0, 1, 2, 3], [1, 4, 5, 2]]
)
TARGET = MESH.with_vertices(MESH.vertices + [[0, 0, 0], [0, 0, 1], [0, 0, 1]] * 2)
MORPH: Any = em.interpolate(MESH, TARGET, "linear")
RIG: Any = em.Rig(MESH, {"jawOpen": MORPH, "smile": MORPH})
MOTION: Any = em.MeshSequence(MESH, MORPH.at([0, 0.5, 1]))
MARKERS: Any = em.Markers(("chin", "lip", "lip"), np.zeros((2, 3, 3)))
CURVE: Any = em.BendCurve.power(2)
NETWORK: Any = em.extract_curves(MESH)
EM: Any = em
ONE = {"mixture": [{"kind": "sparse", "active": 1}]}

CALLS: list[tuple[str, Callable[[], object], str]] = [
    ("Mesh of texts", lambda: EM.Mesh([["a", "b", "c"]]), "vertices must be numbers"),
    ("Mesh of digits", lambda: EM.Mesh([["0", "1", "2"]]), "vertices must be numbers"),
    ("Mesh of a file", lambda: EM.Mesh("face.obj"), "vertices must be numbers"),
    ("Mesh of None", lambda: EM.Mesh(None), "vertices must be numbers"),
    ("Mesh of flags", lambda: EM.Mesh(np.ones((3, 3), bool)), "vertices must be numbers"),
    ("Mesh with faces of texts", lambda: EM.Mesh(np.eye(3), [["a", "b", "c"]]), "polygon"),
    ("Mesh with a number for faces", lambda: EM.Mesh(np.eye(3), 3), "polygon"),
    ("with_vertices", lambda: MESH.with_vertices("moved"), "vertices must be numbers"),
    ("interpolate files", lambda: EM.interpolate("a.obj", "b.obj"), r"em\.read\('a\.obj'\)"),
    ("interpolate to a file", lambda: EM.interpolate(MESH, "b.obj"), r"em\.read\('b\.obj'\)"),
    ("interpolate None", lambda: EM.interpolate(MESH, None), "target must be a Mesh, found None"),
    ("interpolate by number", lambda: EM.interpolate(MESH, TARGET, 2), "a method is a text such"),
    ("interpolate by None", lambda: EM.interpolate(MESH, TARGET, None), "a method is a text such"),
    ("curves", lambda: EM.interpolate(MESH, TARGET, curves=[0, 1]), "must be a CurveNetwork"),
    ("extent", lambda: EM.interpolate(MESH, TARGET, "auto", extent="D"), "extent must be a number"),
    ("falloff", lambda: EM.interpolate(MESH, TARGET, region=[0], falloff="3"), "falloff must be"),
    (
        "falloff of nothing",
        lambda: EM.interpolate(MESH, TARGET, falloff=2),
        "falloff without a region",
    ),
    ("rest of nothing", lambda: EM.prepare(MESH, rest="neutral"), "rest without a region"),
    ("extent of a line", lambda: EM.prepare(MESH, "linear", extent=1), "only auto takes extent"),
    ("region", lambda: EM.interpolate(MESH, TARGET, region={"a": 1}), "a region must be"),
    ("rigidity", lambda: EM.interpolate(MESH, TARGET, "plate", rigidity="a"), "rigidity must be"),
    ("pinned", lambda: EM.interpolate(MESH, TARGET, "plate", pinned="a"), "pinned must be"),
    ("prepare a file", lambda: EM.prepare("a.obj"), r"em\.read\('a\.obj'\)"),
    ("prepared of a file", lambda: EM.prepare(MESH, "linear")("b.obj"), r"em\.read\('b\.obj'\)"),
    ("through a file", lambda: EM.through(MESH, TARGET, {0.5: "c.obj"}), r"em\.read\('c\.obj'\)"),
    ("through a list", lambda: EM.through(MESH, TARGET, [MESH]), "mapping from times"),
    ("through from a file", lambda: EM.through("a.obj", TARGET, {}), r"em\.read\('a\.obj'\)"),
    ("through None", lambda: EM.through(MESH, None, {}), "target must be a Mesh"),
    ("at None", lambda: MORPH.at(None), "times must be numbers"),
    ("at a text", lambda: MORPH.at("half"), "times must be numbers"),
    ("Morph of files", lambda: EM.Morph("a.obj", "b.obj", [], ()), r"em\.read\('a\.obj'\)"),
    ("Morph of bends", lambda: EM.Morph(MESH, TARGET, "bends", ()), "bends must"),
    ("Morph of curves", lambda: EM.Morph(MESH, TARGET, [MORPH.delta], ["t"]), "bend_curves must"),
    ("Morph of a number", lambda: EM.Morph(MESH, TARGET, [], 3), "bend_curves must"),
    ("BendCurve", lambda: EM.BendCurve("a", "b"), "must be numbers"),
    ("power", lambda: EM.BendCurve.power("two"), "exponent"),
    ("polynomial", lambda: EM.BendCurve.polynomial("t"), "must be numbers"),
    ("curve at", lambda: CURVE("half"), "times must be numbers"),
    ("bake no path", lambda: EM.bake(3, MESH, TARGET), "path must be a function"),
    ("bake to a file", lambda: EM.bake(MORPH.at, MESH, "b.obj"), r"em\.read\('b\.obj'\)"),
    ("bake to words", lambda: EM.bake(lambda _: "x", MESH, TARGET), "path must"),
    ("bake within", lambda: EM.bake(MORPH.at, MESH, TARGET, tolerance="1"), "tolerance must be"),
    ("extract_curves of a file", lambda: EM.extract_curves("a.obj"), r"em\.read\('a\.obj'\)"),
    ("extract_curves keeping", lambda: EM.extract_curves(MESH, [3]), "Curve"),
    ("edge_loops of None", lambda: EM.edge_loops(None), "must be a Mesh"),
    ("Curve of a text", lambda: EM.Curve("a", False), "whole numbers"),
    ("CurveNetwork of numbers", lambda: EM.CurveNetwork([3], 6), "Curve"),
    ("CurveNetwork of a count", lambda: EM.CurveNetwork([], "6"), "must be whole"),
    ("restricted", lambda: NETWORK.restricted("lips"), "a region must be"),
    ("relabelled", lambda: NETWORK.relabelled("lips"), "renumbering"),
    ("Load of a text", lambda: EM.Load("x"), "a load needs numbers"),
    ("Load of a number", lambda: EM.Load(3), "a load needs numbers"),
    ("Load.power", lambda: EM.Load.power("2"), "order R"),
    ("Material", lambda: EM.Material("1"), "mass must be"),
    ("Method", lambda: EM.Method(3), "method must be one of"),
    ("Method with a load", lambda: EM.Method("beam", load=[1, 2]), "load must be a Load"),
    ("Method.parse", lambda: EM.Method.parse(None), "a method is a text such"),
    ("Rig of a text", lambda: EM.Rig("x", {}), "neutral of a rig must be a Mesh"),
    ("Rig of a list", lambda: EM.Rig(MESH, [MORPH]), "mapping from names"),
    ("Rig of a file", lambda: EM.Rig(MESH, {"jawOpen": "jaw.obj"}), r"em\.read\('jaw\.obj'\)"),
    ("Rig of numbers", lambda: EM.Rig(MESH, {3: MORPH}), "names of a rig are texts"),
    ("Rig with correctives", lambda: EM.Rig(MESH, {}, correctives=["a"]), "correctives are a map"),
    ("Rig with a driver", lambda: EM.Rig(MESH, {}, correctives={"a": "b"}), "lists of names"),
    ("Rig with groups", lambda: EM.Rig(MESH, {}, groups={"a": 3}), "groups are a mapping"),
    ("FaceSampler of a file", lambda: EM.FaceSampler("rig.glb"), r"em\.read_rig\('rig\.glb'\)"),
    ("FaceSampler with a number", lambda: EM.FaceSampler(RIG, 3), "a recipe is a .toml file"),
    ("FaceSampler with a seed", lambda: EM.FaceSampler(RIG, seed="7"), "a seed is a whole number"),
    ("codes to None", lambda: EM.FaceSampler(RIG).codes(0, None), "numbered from 0"),
    ("values backwards", lambda: EM.FaceSampler(RIG).values(5, 3), "numbered from 0"),
    ("pose by name", lambda: RIG.pose("jawOpen"), "weights must be numbers"),
    ("pose None", lambda: RIG.pose(None), "weights must be numbers"),
    ("pose to words", lambda: RIG.pose({"jawOpen": "half"}), "not a number"),
    ("blend at words", lambda: RIG.blend({"jawOpen": 1}, "half"), "the time must be a number"),
    ("blend at None", lambda: RIG.blend({"jawOpen": 1}, None), "the time must be a number"),
    ("velocity", lambda: RIG.velocity({"jawOpen": 1}, "fast"), "weights must be numbers"),
    ("batch by name", lambda: RIG.batch("jawOpen"), "weights must be numbers"),
    ("batch of None", lambda: RIG.batch(None), "weights must be numbers"),
    ("batch at words", lambda: RIG.batch([[1, 0]], "half"), "times must be numbers"),
    ("batch into a list", lambda: RIG.batch([[1, 0]], out=[1]), "out must be"),
    ("batch of words", lambda: RIG.batch([[1, 0]], dtype="words"), "float32 or float64"),
    ("batch elsewhere", lambda: RIG.batch([[1, 0]], backend=3), "backend must be one of"),
    ("stream by name", lambda: list(RIG.stream("jawOpen")), "weights must be numbers"),
    ("stream block", lambda: list(RIG.stream([[1, 0]], block="a")), "a block must hold"),
    ("only one text", lambda: RIG.only("jawOpen"), "names are a list"),
    ("only a number", lambda: RIG.only(3), "names are a list"),
    ("rig by number", lambda: RIG[0], "no slider"),
    ("MeshSequence", lambda: EM.MeshSequence("a.obj", []), r"em\.read\('a\.obj'\)"),
    ("MeshSequence of words", lambda: EM.MeshSequence(MESH, "frames"), "frames must"),
    ("MeshSequence at words", lambda: EM.MeshSequence(MESH, MOTION.frames, "now"), "times must"),
    ("evaluate None", lambda: EM.evaluate(None), "motion must be a MeshSequence"),
    ("evaluate a mesh", lambda: EM.evaluate(MESH), "motion must be a MeshSequence"),
    ("evaluate a name", lambda: EM.evaluate("nowhere.####.obj"), r"nowhere\.####\.obj"),
    ("evaluate by number", lambda: EM.evaluate(MOTION, 3), "methods are texts"),
    ("evaluate by numbers", lambda: EM.evaluate(MOTION, [3]), "a method is a text"),
    ("evaluate along", lambda: EM.evaluate(MOTION, curves="all"), "must be a CurveNetwork"),
    ("evaluate of", lambda: EM.evaluate(MOTION, material="steel"), "material must be a Material"),
    ("suggest None", lambda: EM.suggest_inbetweens(None, 1), "motion must be a MeshSequence"),
    ("suggest words", lambda: EM.suggest_inbetweens(MOTION, "one"), "has room for"),
    ("suggest along", lambda: EM.suggest_inbetweens(MOTION, 1, curves=3), "be a CurveNetwork"),
    ("suggest effort", lambda: EM.suggest_inbetweens(MOTION, 1, effort="a"), "effort must be"),
    ("FaceSampler of a file", lambda: EM.FaceSampler("rig.glb"), "faces are of a Rig"),
    ("faces of a file", lambda: EM.make_faces("rig.glb", "f", 9), r"em\.read_rig\('rig\.glb'\)"),
    ("faces nowhere", lambda: EM.make_faces(RIG, None, 9), "named by a folder or an address"),
    ("faces of none", lambda: EM.make_faces(RIG, "f", 0, recipe=ONE), "one face or more"),
    ("faces in vain", lambda: EM.make_faces(RIG, "f", recipe=ONE), "say how many faces"),
    ("faces as", lambda: EM.make_faces(RIG, "f", 9, recipe=ONE, vertices="i8"), "vertices are"),
    ("faces within", lambda: EM.make_faces(RIG, "f", 9, recipe=ONE, tolerance=1), "a tolerance is"),
    ("faces at", lambda: EM.make_faces(RIG, "f", 9, recipe=ONE, landmarks={"a": 9}), "vertex 9"),
    ("faces by", lambda: EM.make_faces(RIG, "f", 9, scheduler=8786), "a scheduler is none"),
    ("open no faces", lambda: EM.open_faces(3), "named by a folder or an address"),
    ("open faces with", lambda: EM.open_faces("f", storage_options=3), "options are a mapping"),
    ("learn None", lambda: EM.learn(None), "motion must be a MeshSequence"),
    ("learn a name", lambda: EM.learn("nowhere.####.obj"), r"nowhere\.####\.obj"),
    ("learn bends", lambda: EM.learn(MOTION, "two"), "bends must be a whole number"),
    ("learn too many", lambda: EM.learn(MOTION, 2), "2 bends need a frame each"),
    ("learn nothing", lambda: EM.learn([]), "nothing to learn from"),
    ("learn shapes", lambda: EM.learn(MOTION, shapes=3), "shapes must be free or scanned"),
    ("learn timing", lambda: EM.learn(MOTION, timing="x"), "timing must be recorded or even"),
    ("learn knots", lambda: EM.learn(MOTION, knots=-1), "knots must be a whole number"),
    ("learn along", lambda: EM.learn(MOTION, curves="all"), "must be a CurveNetwork"),
    ("learn trusting", lambda: EM.learn(MOTION, confidence=[1]), "confidence of a motion needs"),
    ("read None", lambda: EM.read(None), "a file is named by a text"),
    ("read a mesh", lambda: EM.read(MESH), "a file is named by a text"),
    ("read a rig", lambda: EM.read("head.glb"), "there is no such file"),
    ("bend None", lambda: EM.bend(None, "b.glb"), "a file is named by a text"),
    ("bend into a number", lambda: EM.bend("a.glb", 5), "a file is named by a text"),
    ("bend a mesh", lambda: EM.bend("face.obj", None), "a character is a file of .glb"),
    ("unbend into None", lambda: EM.unbend("a.glb", None), "a file is named by a text"),
    ("read_rig None", lambda: EM.read_rig(None), "a file is named by a text"),
    ("read_rig a mesh", lambda: EM.read_rig("face.obj"), "hold one mesh"),
    ("read_sequence None", lambda: EM.read_sequence(None), "a file is named by a text"),
    ("write None", lambda: EM.write("x.glb", None), "expected a Mesh or a Rig"),
    ("write turned about", lambda: EM.write(MESH, "x.obj"), "a file is named by a text"),
    ("write_sequence None", lambda: EM.write_sequence("x.npz", None), "MeshSequence"),
    ("write_sequence about", lambda: EM.write_sequence(MOTION, "x.npz"), "MeshSequence"),
    ("write_sequence to None", lambda: EM.write_sequence(None, MOTION), "named by a text"),
    ("bend no file", lambda: EM.bend("built-in", "x.glb"), "in no file to bend; export it first"),
    ("bend FBX", lambda: EM.bend("head.fbx", "x.glb"), "FBX is only read"),
    ("register None", lambda: EM.register(None, MESH), "a file is named by a text"),
    ("register onto None", lambda: EM.register(MESH, None), "a file is named by a text"),
    ("register by a list", lambda: EM.register(MESH, MESH, landmarks=[0]), "landmarks are a file"),
    ("register from no file", lambda: EM.register(MESH, MESH, neutral="n.obj"), "no such file"),
    ("register nothing", lambda: EM.register_all([], MESH), "there is no scan"),
    ("register one", lambda: EM.register_all("scan.obj", MESH), "expected scans"),
    ("unbend None", lambda: EM.unbend(None, "x.glb"), "a file is named by a text"),
    ("unbend OBJ", lambda: EM.unbend("head.obj", "x.obj"), "unknown suffix '.obj'"),
    ("Registered", lambda: EM.Registered(np.eye(3), confidence=[0, 1, 2]), "between 0 and 1"),
    ("Registered as", lambda: EM.Registered(np.eye(3), confidence="all"), "must be numbers"),
    ("Registered by few", lambda: EM.Registered.of(MESH, TARGET.vertices, [1]), r"shape \(6,\)"),
    ("Registered of a file", lambda: EM.Registered.of("a.obj", 1, 1), r"em\.read\('a\.obj'\)"),
    ("capture None", lambda: EM.capture(None, MESH, output="x"), "photos must be a folder"),
    ("capture nothing", lambda: EM.capture({}, MESH, output="x"), "there are no poses"),
    ("capture up to", lambda: EM.capture("x", MESH, output="x", to="end"), "to must be cameras"),
    ("capture by", lambda: EM.capture("x", MESH, output="x", rig=3), "rig must be walking or"),
    ("solve None", lambda: RIG.solve(None), "handles are a mapping from vertices"),
    ("solve nothing", lambda: RIG.solve({}), "at least one in it"),
    ("solve a vertex too far", lambda: RIG.solve({6: [0, 0, 1]}), "vertex 6, but the mesh has 6"),
    ("solve a vertex below", lambda: RIG.solve({-1: [0, 0, 1]}), "vertex -1, but the mesh"),
    ("solve half a vertex", lambda: RIG.solve({0.5: [0, 0, 1]}), "a handle is a vertex"),
    ("solve a switch", lambda: RIG.solve({True: [0, 0, 1]}), "a handle is a vertex"),
    ("solve shares", lambda: RIG.solve({((0, 1), (1,)): [0, 0, 1]}), "a handle is a vertex"),
    ("solve a sum", lambda: RIG.solve({((0, 1), (1, 1)): [0, 0, 1]}), "must sum to 1"),
    ("solve NaN shares", lambda: RIG.solve({((0,), (np.nan,)): [0, 0, 1]}), "must sum to 1"),
    ("solve a name", lambda: RIG.solve({"chin": [0, 0, 1]}), "landmark 'chin' is not known"),
    (
        "solve a landmark",
        lambda: RIG.solve({"chin": [0, 0, 1]}, landmarks={"chin": "1"}),
        "a handle is a vertex",
    ),
    ("solve landmarks", lambda: RIG.solve({1: [0, 0, 1]}, landmarks=[1]), "landmarks are a map"),
    ("solve to NaN", lambda: RIG.solve({1: [0, np.nan, 1]}), "position of 1 must be three finite"),
    ("solve to two", lambda: RIG.solve({1: [0, 1]}), "must be three finite numbers"),
    ("solve to a text", lambda: RIG.solve({1: "up"}), "position of 1 must be numbers"),
    ("solve from", lambda: RIG.solve({1: [0, 0, 1]}, {"smiel": 1}), "did you mean 'smile'"),
    ("solve from NaN", lambda: RIG.solve({1: [0, 0, 1]}, {"smile": np.nan}), "must be finite"),
    ("solve within", lambda: RIG.solve({1: [0, 0, 1]}, bounds=(1, 0)), "bounds must be two finite"),
    ("solve within 3", lambda: RIG.solve({1: [0, 0, 1]}, bounds=(0, 1, 2)), "bounds must be two"),
    ("solve bounds", lambda: RIG.solve({1: [0, 0, 1]}, bounds={"a": (0, 1)}), "no slider 'a'"),
    ("solve a prior", lambda: RIG.solve({1: [0, 0, 1]}, prior=-1), "the prior must be a number"),
    ("track a text", lambda: RIG.track("take.npz", [0, 1, 2, 3]), r"em\.read_markers"),
    ("track switches", lambda: RIG.track([[[True] * 3] * 4], [0, 1, 2, 3]), "must be numbers"),
    ("read_markers None", lambda: EM.read_markers(None), "a file is named by a text"),
    ("read_markers a mesh", lambda: EM.read_markers(MESH), "a file is named by a text"),
    ("read_markers of no take", lambda: EM.read_markers("take.csv"), "no files called 'take.csv'"),
    ("hold a file", lambda: EM.hold("a.glb"), "what is held is a Rig, found str"),
    ("hold with a file", lambda: EM.hold(RIG, "take.csv"), "takes are performances, found str"),
    ("hold folds", lambda: EM.hold(RIG, folds="many"), "the number of folds must be"),
    ("Corrective of a text", lambda: EM.Corrective("ab"), "drivers are a list of names"),
    ("Corrective law", lambda: EM.Corrective(("a",), "max"), "the law must be one of"),
    ("read_correctives None", lambda: EM.read_correctives(None, []), "a file is named by a text"),
    ("read_correctives file", lambda: EM.read_correctives("a.json", []), "no such file"),
    ("read_performance None", lambda: EM.read_performance(None), "a file is named by a text"),
    ("read_performance rate", lambda: EM.read_performance("a.csv", "x"), "no such file"),
    ("Performance name", lambda: EM.Performance("jaw", [0], [[1]], 30), "a list of texts"),
    ("Performance rate", lambda: EM.Performance(["jaw"], [0], [[1]], "30"), "must be a number"),
    ("Performance times", lambda: EM.Performance(["a"], [1, 0], [[1], [1]], 30), "must rise"),
    ("Performance text", lambda: EM.Performance(["a"], [0], [["1"]], 30), "must be numbers"),
    ("write a turn", lambda: EM.write("a.glb", RIG, turn=[0, 0, 0]), "turned with an animation"),
    ("Markers of none", lambda: MARKERS.of(["nose"]), "no marker is called 'nose'; there are chi"),
    ("Markers of two", lambda: MARKERS.of(["lip"]), "2 markers are called 'lip'"),
    ("Markers of a text", lambda: MARKERS.of("chin"), "a list of texts, found 'chin'"),
    ("track nowhere", lambda: RIG.track(np.zeros((2, 4, 3)), None), "places are a list"),
    ("track too far", lambda: RIG.track(np.zeros((2, 1, 3)), [6]), "but the mesh has 6"),
    ("read_poses of a number", lambda: EM.read_poses(3), "a file is named by a text"),
    ("read_poses of a mesh", lambda: EM.read_poses("a.obj"), r"in \.json or \.csv, found \.obj"),
    ("write_poses of a list", lambda: EM.write_poses("a.json", [{"a": 1}]), "a mapping from names"),
    ("write_poses of words", lambda: EM.write_poses("a.csv", {"A": {"b": "1"}}), "finite number"),
    ("write_poses of none", lambda: EM.write_poses("a.csv", {}), "no poses to write"),
    ("write_poses as", lambda: EM.write_poses("a.txt", {"A": {}}), r"found \.txt"),
    ("write no performance", lambda: EM.write_performance("a.csv", [1]), "expected a Performance"),
    ("a clip of a table", lambda: EM.read_performance("a.csv", clip="b"), "leave the name of a"),
    ("save to None", lambda: RIG.save(None), "a file is named by a text"),
]


@pytest.mark.parametrize(("call", "message"), [c[1:] for c in CALLS], ids=[c[0] for c in CALLS])
def test_is_an_error_of_ours(call: Callable[[], object], message: str) -> None:
    with pytest.raises(em.ElastomorphError, match=message) as caught:
        call()
    assert "\n" not in str(caught.value)


def test_every_public_call_is_in_the_table() -> None:
    """All but those that only results and errors are made with."""
    made_elsewhere = {
        "BendReport",
        "Captured",
        "FaceSet",
        "Evaluation",
        "Suggestion",
        "Fit",
        "Learned",
        "Correction",
        "Held",
        "Markers",
    }
    words = " ".join(
        call.__code__.co_names[1] for _, call, _ in CALLS if len(call.__code__.co_names) > 1
    )
    for name in em.__all__:
        value = getattr(em, name)
        if isinstance(value, type) and issubclass(value, Exception):
            continue
        assert name in made_elsewhere or name in words.split(), name


def test_timing_is_public() -> None:
    assert em.timing is timing
