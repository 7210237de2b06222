"""The rig that settings describe, target by target and part by part."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import elastomorph as em
from characters import LEFT, TABLES, changed, sheet, write_character, write_settings_file
from elastomorph.character import Settings, read_settings, rig_from_settings
from elastomorph.character.schema import MethodChoice
from elastomorph.curves import extract_curves, region_weights
from elastomorph.errors import ElastomorphWarning, FileError, FormatError, TopologyError
from elastomorph.io.rig_folder import read_rig_folder
from elastomorph.io.vertex_lists import read_curves
from elastomorph.rig import Rig

TIMES = [0.25, 0.5, 1.2]

pytestmark = pytest.mark.filterwarnings("ignore::elastomorph.errors.TimeLawWarning")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_character(tmp_path)
    return tmp_path


def read(folder: Path, tables: dict[str, Any]) -> Settings:
    return read_settings(write_settings_file(folder, tables))


def rig_of(folder: Path, tables: dict[str, Any]) -> Rig:
    return rig_from_settings(read(folder, tables), cache=None)


def assert_same_path(one: em.Morph, other: em.Morph) -> None:
    np.testing.assert_array_equal(one.at(TIMES), other.at(TIMES))


def target(folder: Path, name: str) -> em.Mesh:
    return em.read(folder / "shapes" / f"{name}.obj")


def test_an_empty_file_makes_the_rig_of_the_folder(folder: Path) -> None:
    """With the default method of every door; the order of the targets is the same too."""
    for file in folder.glob("brow_*.obj"):
        file.rename(folder / "shapes" / file.name)
    (folder / "head.npz").unlink()
    (folder / "other_rest.obj").unlink()
    for file in (folder / "shapes").iterdir():
        file.rename(folder / file.name)
    expected = read_rig_folder(folder, cache=None)
    found = rig_of(folder, {})
    assert {morph.choice is not None for morph in expected.morphs.values()} == {True}
    assert found.names == expected.names
    for name in found.names:
        assert_same_path(found.morphs[name], expected.morphs[name])
        assert found.morphs[name].method == expected.morphs[name].method


def test_each_target_has_the_most_specific_method(folder: Path) -> None:
    """An exact name before a pattern, more letters before fewer, then the later."""
    methods = {"*": "cosine", "s*": "ease:2", "?mile": "ease:3", "smi*": "arc", "brow": "beam:3"}
    rig = rig_of(folder, changed(TABLES, methods=methods))
    chosen = {"jawOpen": "cosine", "smile": "ease:3", "brow": "beam:3"}
    for name, method in chosen.items():
        expected = em.interpolate(rig.neutral, target(folder, name), method)
        assert_same_path(rig.morphs[name], expected)
    later = rig_of(folder, changed(TABLES, methods={"smil*": "arc", "?mile": "ease:2"}))
    assert later.morphs["smile"].method == "ease R=2"


def test_a_target_keeps_what_it_does_not_say(folder: Path) -> None:
    """Material and closure of the whole character hold for a target with a method of its own."""
    tables = changed(
        TABLES,
        method={"default": "beam:3", "closure": "compatible", "material": {"rigidity": 0.1}},
        methods={"smile": {"method": "plate:2", "material": {"damping": 0.5}}},
    )
    settings = read(folder, tables)
    method = settings.choice_for("smile").method()
    assert (method.name, method.order, method.closure) == ("plate", 2, "compatible")
    assert method.material == em.Material(1.0, 0.5, 0.1)
    assert settings.choice_for("brow").method() == em.Method(
        "beam", order=3, material=em.Material(rigidity=0.1), closure="compatible"
    )


def test_a_name_brings_its_order_or_load() -> None:
    general = MethodChoice.of("beam", load=(0.2, 0.8), closure="rest")
    assert MethodChoice.of("ease").over(general).method() == em.Method("ease")
    assert MethodChoice.of(damping=2.0).over(general).method().load == em.Load([0.2, 0.8])
    assert MethodChoice.of(load=(1.0,)).over(MethodChoice.of("beam:3")).method().order == 2
    assert MethodChoice.of(order=3).over(general).method() == em.Method(
        "beam", order=3, closure="rest"
    )
    assert not MethodChoice()
    assert MethodChoice.of(mass=1.0)


def test_artists_curves_are_followed(folder: Path) -> None:
    rig = rig_of(folder, changed(TABLES, character__curves="curves.json"))
    curves = extract_curves(sheet(), read_curves(folder / "curves.json", len(sheet().vertices)))
    expected = em.interpolate(rig.neutral, target(folder, "smile"), "beam:3", curves=curves)
    assert_same_path(rig.morphs["smile"], expected)


def test_a_region_follows_its_own_method_inside_and_the_target_outside(folder: Path) -> None:
    """In between it is the mean of both by the weights of the region."""
    region = {"vertices": "left.json", "falloff": 2, "method": "rotation"}
    rig = rig_of(folder, changed(TABLES, regions__left=region))
    neutral, end = rig.neutral, target(folder, "jawOpen")
    share = region_weights(neutral.edges, len(neutral.vertices), LEFT, 2)[:, None]
    assert ((share > 0) & (share < 1)).any()
    assert (share == 1).any()
    inside, outside = (em.interpolate(neutral, end, method) for method in ("rotation", "beam:3"))
    expected = share * inside.at(TIMES) + (1 - share) * outside.at(TIMES)
    found = rig.morphs["jawOpen"]
    np.testing.assert_allclose(found.at(TIMES), expected, atol=1e-13)
    assert found.method == "beam R=3, left: rotation"
    np.testing.assert_array_equal(found.at(1.0), end.vertices)


def test_a_beam_in_a_region_runs_on_the_curves_inside(folder: Path) -> None:
    """As `interpolate` has it, whose path outside a region is straight."""
    region = {"vertices": LEFT, "falloff": 2, "method": "beam:3", "material": {"rigidity": 0.01}}
    rig = rig_of(folder, changed(TABLES, method__default="linear", regions__left=region))
    expected = em.interpolate(
        rig.neutral,
        target(folder, "smile"),
        "beam:3",
        region=LEFT,
        falloff=2,
        material=em.Material(rigidity=0.01),
    )
    np.testing.assert_allclose(rig.morphs["smile"].at(TIMES), expected.at(TIMES), atol=1e-13)


def test_the_later_region_lies_on_top(folder: Path) -> None:
    """Where both are whole, only the later counts, even if it has the method of the target."""
    everything = f"0-{len(sheet().vertices) - 1}"
    first = {"vertices": everything, "method": "rotation"}
    on_top = {"vertices": everything, "method": "beam:3"}
    rig = rig_of(folder, changed(TABLES, regions={"a": first, "b": on_top}))
    expected = em.interpolate(rig.neutral, target(folder, "jawOpen"), "beam:3")
    np.testing.assert_allclose(rig.morphs["jawOpen"].at(TIMES), expected.at(TIMES), atol=1e-13)


def test_a_region_that_changes_nothing_costs_nothing(folder: Path) -> None:
    """A material means nothing to a rotation, which is said."""
    region = {"vertices": "left.json", "material": {"rigidity": 0.01}}
    tables = changed(TABLES, method__default="rotation")
    plain = rig_of(folder, tables)
    with pytest.warns(ElastomorphWarning, match="line .*'rigidity' has no effect: .* is rotation"):
        rig = rig_of(folder, changed(tables, regions__left=region))
    assert rig.morphs["jawOpen"].method == "rotation"
    assert len(rig.morphs["jawOpen"].bends) == len(plain.morphs["jawOpen"].bends)
    assert_same_path(rig.morphs["jawOpen"], plain.morphs["jawOpen"])


def test_a_path_passes_through_its_inbetweens(folder: Path) -> None:
    """And a region does not take it off them."""
    tables = changed(
        TABLES,
        inbetweens__brow={"0.3": "brow_30.obj", "0.6": "brow_60.obj"},
        regions__left={"vertices": "left.json", "method": "cosine"},
    )
    morph = rig_of(folder, tables).morphs["brow"]
    for share, file in ((0.3, "brow_30.obj"), (0.6, "brow_60.obj")):
        np.testing.assert_allclose(morph.at(share), em.read(folder / file).vertices, atol=1e-12)


@pytest.mark.parametrize("law", ["smooth", "spline", "piecewise", "linear"])
def test_each_law_between_inbetweens_can_be_asked_for(folder: Path, law: str) -> None:
    files = {"0.3": "brow_30.obj", "0.6": "brow_60.obj"}
    brow = rig_of(folder, changed(TABLES, inbetweens__brow=files | {"method": law})).morphs["brow"]
    shapes = {float(time): em.read(folder / file) for time, file in files.items()}
    expected = em.through(brow.neutral, brow.target, shapes, method=law)
    assert_same_path(brow, expected)
    assert brow.method == expected.method


def test_one_inbetween_is_passed_through_smoothly(folder: Path) -> None:
    """Unless told, by the same default as in Python."""
    brow = rig_of(folder, changed(TABLES, inbetweens__brow={"0.3": "brow_30.obj"})).morphs["brow"]
    shapes = {0.3: em.read(folder / "brow_30.obj")}
    assert_same_path(brow, em.through(brow.neutral, brow.target, shapes, method="smooth"))


def test_inbetweens_are_no_targets(folder: Path) -> None:
    """Though a pattern, or the folder itself, has them among the others."""
    tables = changed(
        TABLES,
        character__targets=["shapes/*.obj", "*.obj"],
        inbetweens__brow={"0.3": "brow_30.obj"},
    )
    assert rig_of(folder, tables).names == ("brow", "brow_60", "jawOpen", "other_rest", "smile")
    shutil.copy(folder / "shapes" / "brow.obj", folder)
    (folder / "head.npz").unlink()
    names = rig_of(folder, changed(tables, character={"neutral": "neutral.obj"})).names
    assert "brow" in names
    assert "brow_30" not in names


def test_groups_and_correctives_reach_the_rig(folder: Path) -> None:
    tables = changed(
        TABLES,
        groups={"mouth": ["s*", "jawOpen", "*w*"], "brows": "brow"},
        correctives={"smile": ["jawOpen", "brow"]},
    )
    rig = rig_of(folder, tables)
    assert rig.sliders.groups == {"mouth": ("smile", "jawOpen", "brow"), "brows": ("brow",)}
    assert rig.sliders.correctives == {"smile": em.Corrective(("jawOpen", "brow"))}


def test_correctives_follow_their_law(folder: Path) -> None:
    table = {"drivers": ["jawOpen", "brow"], "law": "hinge", "gains": [0.5, 1.25]}
    rig = rig_of(folder, changed(TABLES, correctives={"smile": table}))
    assert rig.sliders.correctives == {
        "smile": em.Corrective(("jawOpen", "brow"), "hinge", (0.5, 1.25))
    }
    posed = rig.pose({"jawOpen": 1.0, "brow": 1.0})
    parts = [rig.morphs[n].at(t) for n, t in (("jawOpen", 1.0), ("brow", 1.0), ("smile", 0.75))]
    np.testing.assert_allclose(posed, sum(parts) - 2 * rig.neutral.vertices, atol=1e-12)


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ('smile = { drivers = ["brow"], law = "mean" }', 5, "the law must be one of product, min"),
        ('smile = { law = "min" }', 5, "has no drivers"),
        ('smile = { drivers = ["brow"], law = "hinge", gains = [1, 2] }', 5, "one gain a driver"),
        ('smile = { drivers = ["brow"], law = "min", gains = [1] }', 5, "takes no gains"),
        ('smile = { drivers = ["brow"], law = "softmin", sharpness = 0 }', 5, "sharpness"),
        ('smile = { drivers = ["brow"], lwa = "min" }', 5, "unknown key 'lwa'"),
        ('smile = { drivers = ["brow"], gains = "1" }', 5, "must be a list of finite numbers"),
        ("smile = 3", 5, "must be text or a list of texts"),
        ('brow = ["smile"]\nsmile = ["jawOpen"]', 5, "driven by 'smile', which is a corrective"),
    ],
)
def test_correctives_that_cannot_be_are_refused_with_their_line(
    folder: Path, text: str, line: int, message: str
) -> None:
    path = folder / "elastomorph.toml"
    path.write_text(f'[method]\ndefault = "linear"\n\n[correctives]\n{text}\n')
    with pytest.raises(
        FormatError, match=rf"elastomorph\.toml, line {line}: .*{re.escape(message)}"
    ):
        read_settings(folder)


def test_a_file_of_simplex_says_what_drives_targets(folder: Path) -> None:
    """Correctives of the settings go before it, and targets that it lacks are left out."""
    with_file = changed(TABLES, character__correctives="simplex.json")
    both = em.Corrective(("jawOpen", "smile"), "extMul")
    assert rig_of(folder, with_file).sliders.correctives == {"brow": both}
    own = changed(with_file, correctives={"brow": ["smile"]})
    assert rig_of(folder, own).sliders.correctives == {"brow": em.Corrective(("smile",))}


def closing(folder: Path) -> None:
    """Add mouthClose, which takes back most of what jawOpen moves."""
    neutral, jaw = sheet(), target(folder, "jawOpen")
    ends = neutral.vertices - 0.9 * (jaw.vertices - neutral.vertices)
    em.write(folder / "shapes" / "mouthClose.obj", neutral.with_vertices(ends))


AUTO = changed(TABLES, method__default="auto")
PAIR = "jawOpen_mouthClose"


def test_paths_that_meet_have_the_pair_bends_of_any_rig(folder: Path) -> None:
    closing(folder)
    rig = rig_of(folder, AUTO)
    names = ("brow", "jawOpen", "mouthClose", "smile")
    expected = Rig(rig.neutral, {name: target(folder, name) for name in names})
    assert rig.sliders.correctives == {PAIR: em.Corrective(("jawOpen", "mouthClose"), "min")}
    assert dict(rig.sliders.correctives) == dict(expected.sliders.correctives)
    for weights in ([0, 0.5, 0.5, 0], [0.3, 0.8, 0.4, 0.1]):
        np.testing.assert_allclose(rig.pose(weights), expected.pose(weights), atol=1e-12)
    read_settings(folder)
    kept = [rig_from_settings(read_settings(folder), cache=folder / "cache") for _ in range(2)]
    assert [dict(own.sliders.correctives) for own in kept] == [dict(rig.sliders.correctives)] * 2


@pytest.mark.parametrize("method", ["auto", "rotation", "arc"])
def test_a_pair_is_bent_by_the_method_of_both(folder: Path, method: str) -> None:
    """On the diagonal it is on the path to the sum of both, made by that method."""
    closing(folder)
    methods = dict.fromkeys(("jawOpen", "mouthClose"), method)
    rig = rig_of(folder, changed(TABLES, methods=methods))
    assert PAIR in rig.pair_bends()
    ends = [rig.morphs[name].delta for name in methods]
    both = rig.neutral.with_vertices(rig.neutral.vertices + sum(ends))
    path = em.interpolate(rig.neutral, both, method)
    np.testing.assert_allclose(
        rig.pose({"jawOpen": 0.6, "mouthClose": 0.6}), path.at(0.6), atol=1e-4 * sheet().diameter
    )


def test_rotation_of_one_and_auto_of_the_other_are_one_method(folder: Path) -> None:
    """As when somebody takes what `init` suggests for jaws."""
    closing(folder)
    rig = rig_of(folder, changed(AUTO, methods__jawOpen="rotation"))
    assert PAIR in rig.pair_bends()


@pytest.mark.parametrize(
    "changes",
    [
        {"methods": {"mouthClose": "linear"}},
        {"inbetweens__mouthClose": {"0.3": "brow_30.obj"}},
    ],
)
def test_paths_of_other_kinds_have_no_pair_bend(folder: Path, changes: dict[str, Any]) -> None:
    closing(folder)
    assert not rig_of(folder, changed(AUTO, **changes)).pair_bends()


def test_pair_bends_of_a_rig_file_stay_with_the_paths_that_they_join(folder: Path) -> None:
    closing(folder)
    rig = rig_of(folder, AUTO)
    em.write(folder / "met.npz", rig)
    tables: dict[str, Any] = {"character": {"rig": "met.npz"}}
    kept = rig_of(folder, tables)
    assert dict(kept.sliders.correctives) == dict(rig.sliders.correctives)
    np.testing.assert_array_equal(kept.pose([0, 0.5, 0.4, 0]), rig.pose([0, 0.5, 0.4, 0]))
    own = rig_of(folder, changed(tables, correctives={"smile": ["jawOpen"]}))
    assert set(own.sliders.correctives) == {"smile", PAIR}
    on_top = rig_of(folder, changed(tables, correctives={"mouthClose": ["jawOpen", "mouthClose"]}))
    assert set(on_top.sliders.correctives) == {"mouthClose"}  # no driver is itself a corrective
    other = rig_of(
        folder, changed(tables, correctives={PAIR: {"drivers": ["jawOpen"], "law": "min"}})
    )
    assert other.sliders.correctives == {PAIR: em.Corrective(("jawOpen",), "min")}
    assert not rig_of(folder, changed(tables, methods={"jawOpen": "linear"})).pair_bends()
    anew = rig_of(folder, changed(tables, method={"default": "rotation"}))
    assert list(anew.pair_bends()) == [PAIR]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"methods__smil": "arc"}, "'smil' in [methods] is no target"),
        ({"methods__sx*": "arc"}, "'sx*' in [methods] stands for no target"),
        ({"inbetweens__browe": {"0.3": "brow_30.obj"}}, "'browe' in [inbetweens] is no target"),
        ({"groups__all": ["brwo"]}, "'brwo' in [groups], 'all', is no target"),
        ({"correctives__smiel": ["brow"]}, "'smiel' in [correctives] is no target"),
        ({"correctives__smile": ["bro"]}, "'bro' in [correctives], 'smile', is no target"),
        ({"correctives__smile": ["bro*"]}, "'bro*' in [correctives], 'smile', is no target"),
    ],
)
def test_names_that_are_no_target_are_refused(
    folder: Path, changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(FormatError) as refused:
        rig_of(folder, changed(TABLES, **changes))
    assert message in str(refused.value)
    known = ": there are brow, jawOpen, smile" if "sx*" in message else "did you mean"
    assert known in str(refused.value)


def test_files_that_do_not_fit_are_named(folder: Path) -> None:
    with pytest.raises(FileError, match=r"'no\*\.obj' stands for no mesh file"):
        rig_of(folder, changed(TABLES, character__targets="no*.obj"))
    with pytest.raises(FileError, match="no targets beside the neutral"):
        rig_of(folder, changed(TABLES, character__targets="neutral.obj"))
    with pytest.raises(
        FormatError, match=r"the region 'far' names vertex 900; .* vertices 0 to 48"
    ):
        rig_of(folder, changed(TABLES, regions__far={"vertices": "0-900", "method": "arc"}))
    em.write(folder / "small.obj", em.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
    with pytest.raises(TopologyError, match=r"small\.obj"):
        rig_of(folder, changed(TABLES, character__targets="small.obj"))
    shutil.copy(folder / "shapes" / "smile.obj", folder)
    with pytest.raises(FileError, match="are both called 'smile'"):
        rig_of(folder, changed(TABLES, character__targets=["shapes/*.obj", "smile.obj"]))


def test_one_file_named_twice_is_one_target(folder: Path) -> None:
    tables = changed(TABLES, character__targets=["shapes/*.obj", "shapes/smile.obj"])
    assert rig_of(folder, tables).names == ("brow", "jawOpen", "smile")


def test_a_name_with_the_letters_of_patterns_is_a_file_first(folder: Path) -> None:
    shutil.copy(folder / "shapes" / "smile.obj", folder / "smile[1].obj")
    tables = changed(TABLES, character__targets=["smile[1].obj"], methods={"smile[1]": "arc"})
    rig = rig_of(folder, tables)
    assert rig.morphs["smile[1]"].method == "arc"


def test_a_rig_file_keeps_its_paths_where_nothing_is_said(folder: Path) -> None:
    neutral = sheet()
    own = {n: em.interpolate(neutral, target(folder, n), "ease:3") for n in ("smile", "brow")}
    groups, correctives = {"all": ["smile", "brow"]}, {"brow": ["smile"]}
    em.write(folder / "two.npz", Rig(neutral, own, groups=groups, correctives=correctives))
    tables = {"character": {"rig": "two.npz"}, "methods": {"smile": "rotation"}}
    rig = rig_of(folder, tables)
    assert_same_path(rig.morphs["brow"], own["brow"])
    assert rig.morphs["smile"].method == "rotation"
    assert rig.sliders.groups == {"all": ("smile", "brow")}
    assert rig.sliders.correctives == {"brow": em.Corrective(("smile",))}
    remade = rig_of(folder, changed(tables, method__default="beam:3", methods=None))
    assert {morph.method for morph in remade.morphs.values()} == {"beam R=3"}
    assert rig_of(
        folder, {"character": {"rig": "two.npz"}, "groups": {"a": ["smile"]}}
    ).sliders.groups == {"a": ("smile",)}
    with pytest.raises(FormatError, match=r"'smle' in \[methods\] is no target"):
        rig_of(folder, changed(tables, methods={"smle": "arc"}))


def test_a_region_lies_on_the_path_of_a_rig_file(folder: Path) -> None:
    neutral, end = sheet(), target(folder, "smile")
    own = em.interpolate(neutral, end, "ease:3")
    em.write(folder / "one.npz", Rig(neutral, {"smile": own}))
    region = {"vertices": f"0-{len(neutral.vertices) - 1}", "method": "cosine"}
    rig = rig_of(folder, {"character": {"rig": "one.npz"}, "regions": {"all": region}})
    expected = em.interpolate(neutral, end, "cosine")
    np.testing.assert_allclose(rig.morphs["smile"].at(TIMES), expected.at(TIMES), atol=1e-13)


class Spoken:
    def __init__(self) -> None:
        self.lines: list[str] = []

    def __call__(self, line: str) -> None:
        self.lines.append(line)


def from_cache(folder: Path, tables: dict[str, Any]) -> bool:
    """Whether the rig came from a cache; it is the right one in any case."""
    spoken = Spoken()
    rig = rig_from_settings(read(folder, tables), cache=folder / "cache", say=spoken)
    expected = rig_of(folder, tables)
    assert rig.names == expected.names
    for name, morph in rig.morphs.items():
        assert_same_path(morph, expected.morphs[name])
    assert rig.sliders == expected.sliders
    return any("read from" in line for line in spoken.lines)


def test_the_cache_is_that_of_these_files_and_settings(folder: Path) -> None:
    """Settings that change paths, and every file that paths depend on, make it stale."""
    region = {"vertices": "left.json", "method": "cosine"}
    tables = changed(
        TABLES,
        character__curves="curves.json",
        regions__left=region,
        inbetweens__brow={"0.3": "brow_30.obj"},
    )
    assert [from_cache(folder, tables) for _ in range(2)] == [False, True]
    for change in (
        {"method__default": "beam:2"},
        {"methods__smile": "arc"},
        {"regions__left__falloff": 1},
        {"groups__all": ["brow"]},
        {"correctives__smile": ["brow"]},
        {"inbetweens__brow": {"0.4": "brow_30.obj"}},
    ):
        assert not from_cache(folder, changed(tables, **change)), change
    for harmless in (
        {"timing__default": "cosine"},
        {"export__glb": {"fps": 60}},
        {"character__name": "Grace", "character__unit": "mm"},
    ):
        assert from_cache(folder, changed(tables, **harmless)), harmless
    drawn = folder / "curves.json"
    for file, content in (
        ("curves.json", drawn.read_text() + "\n"),
        ("left.json", "[0, 1, 2, 7, 8, 9]"),
        ("brow_30.obj", (folder / "brow_60.obj").read_text()),
        ("shapes/smile.obj", (folder / "shapes" / "brow.obj").read_text()),
        ("neutral.obj", (folder / "other_rest.obj").read_text()),
    ):
        (folder / file).write_text(content)
        assert [from_cache(folder, tables) for _ in range(2)] == [False, True], file


def test_another_folder_or_rig_may_take_the_place_of_the_character(
    folder: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    settings = read(folder, changed(TABLES, methods={"smile": "arc"}))
    assert settings.with_rig(folder) is settings
    other = tmp_path_factory.mktemp("other")
    em.write(other / "neutral.obj", sheet())
    shutil.copy(folder / "shapes" / "smile.obj", other)
    rig = rig_from_settings(settings.with_rig(other), cache=None)
    assert rig.names == ("smile",)
    assert rig.morphs["smile"].method == "arc"
    rig = rig_from_settings(settings.with_rig(folder / "head.npz"), cache=None)
    assert rig.morphs["smile"].method == "arc"
    assert settings.with_rig(other).overridden == ("rig",)


def test_a_choice_of_the_command_line_counts_everywhere(folder: Path) -> None:
    """Its name and order, and nothing else; in-betweens stay, for they are shapes."""
    tables = changed(
        TABLES,
        method={"default": "beam:3", "closure": "compatible"},
        methods={"smile": {"method": "rotation", "material": {"damping": 2}}},
        regions__left={"vertices": "left.json", "method": "cosine", "closure": "rest"},
        inbetweens__brow={"0.3": "brow_30.obj"},
    )
    settings = read(folder, tables).with_choice(MethodChoice.of("beam:2"))
    assert settings.choice_for("smile").method() == em.Method(
        "beam", order=2, material=em.Material(damping=2), closure="compatible"
    )
    assert settings.choice_for("jawOpen").method() == em.Method(
        "beam", order=2, closure="compatible"
    )
    over = settings.regions["left"].choice.over(settings.choice_for("jawOpen")).method()
    assert over == em.Method("beam", order=2, closure="rest")
    assert rig_from_settings(settings, cache=None).morphs["brow"].method.startswith("through")
    everywhere = settings.with_choice(MethodChoice.of("beam:2:limit", damping=3.0))
    for name in ("smile", "jawOpen"):
        method = everywhere.choice_for(name).method()
        assert (method.closure, method.material.damping) == ("limit", 3.0)
    assert everywhere.overridden == ("method", "closure", "damping")


def test_a_rig_file_is_built_anew_where_a_file_that_it_names_has_changed(
    tmp_path: Path,
) -> None:
    """The target is in the buffer of a .gltf, a file of its own, which the cache does not know."""
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "<f4")
    views = [(0, 48), (48, 48), (96, 12)]
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "buffers": [{"uri": "face.bin", "byteLength": 108}],
        "bufferViews": [{"buffer": 0, "byteOffset": a, "byteLength": b} for a, b in views],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}
            | {"min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "meshes": [
            {
                "extras": {"targetNames": ["puff"]},
                "primitives": [
                    {"attributes": {"POSITION": 0}, "indices": 2, "targets": [{"POSITION": 1}]}
                ],
            }
        ],
    }
    (tmp_path / "face.gltf").write_text(json.dumps(document))
    (tmp_path / "elastomorph.toml").write_text('[character]\nrig = "face.gltf"\n')
    corners = np.array([0, 1, 2, 0, 2, 3], "<u2").tobytes()
    for moved in (0.5, 0.25):
        delta = np.zeros((4, 3), "<f4")
        delta[2] = moved
        (tmp_path / "face.bin").write_bytes(square.tobytes() + delta.tobytes() + corners)
        settings = read_settings(tmp_path / "elastomorph.toml")
        rig = rig_from_settings(settings, cache=tmp_path / "cache")
        assert np.abs(rig.morphs["puff"].delta).max() == moved
