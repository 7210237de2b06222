"""What cannot be meant by a recipe is one sentence that names the file, the line and the key."""

from __future__ import annotations

from pathlib import Path
from textwrap import dedent

import numpy as np
import pytest
from farm_rigs import NAMES, RIG
from hypothesis import given, settings
from hypothesis import strategies as st

import elastomorph as em
from elastomorph.farm.sampling import controls
from elastomorph.farm.sampling.recipe import read_recipe, recipe_from

SPARSE = '[[mixture]]\nkind = "sparse"\n'

REFUSED = [
    ("versoin = 1", 1, "unknown table or key 'versoin': did you mean 'version'"),
    ("version = 2", 1, "version 2 of recipes, and this package knows 1"),
    ("version = true", 1, "version true of recipes"),
    ("seed = -1", 1, "'seed' must be at least 0 and at most 1.84467e"),
    (f"seed = 1{'0' * 400}", 1, "found a number too large to show"),
    ("seed = 1.5", 1, "'seed' must be a whole number"),
    ("mixture = 3", 1, r"'mixture' is a list of tables: write \[\[mixture\]\]"),
    ("[mixture]", 1, r"'mixture' is a list of tables"),
    ("[[mixture]]\nshare = 1", 1, "'mixture #1' needs a kind of mixture, it has none: there are"),
    (SPARSE + '[[mixture]]\nkind = "sprase"', 4, "found 'sprase': did you mean 'sparse'"),
    (SPARSE + SPARSE + "actve = 3", 5, r"unknown key 'actve' in \[mixture #2\].*'active'"),
    (SPARSE * 101, 201, r"there are more than 100 \[\[mixture\]\]"),
    (SPARSE + "share = 0", 3, "'mixture #1.share' must be above 0 and at most 1e.09, found 0"),
    (SPARSE + SPARSE + "share = 1e-12", 5, "mixture #2.share: it is so small beside the others"),
    (SPARSE + "symmetric = 1.2", 3, "'mixture #1.symmetric' must be at least 0 and at most 1"),
    (SPARSE + "active = 58", 3, "mixture #1.active: of 57 sliders 58 cannot be on"),
    (SPARSE + "active = 1e-9", 3, "of 57 sliders 1e-09 cannot be on"),
    (SPARSE + "power = nan", 3, "must be a finite number"),
    (SPARSE + 'sliders = ["jawOpn"]', 3, "no slider, group or pattern 'jawOpn': did you mean 'jaw"),
    (SPARSE + 'sliders = ["late"]\n[identity]\nsliders = ["late"]', 3, "only sliders of the ident"),
    ("[limits]\njawOpen = [0, 0.8]\njawOpn = [0, 1]", 3, "limits.jawOpn: the rig has no slider"),
    ("[limits]\njawOpen = [1, 0.8]", 2, "goes from 1 to 0.8; the lowest stands first"),
    ("[limits]\njawOpen = [0, 1, 2]", 2, r"must be a finite number or two, \[lowest, highest\]"),
    ("[limits]\njawOpen = [0, 1e9]", 2, "at most 1000, found 1000000000.0"),
    ('[limits]\n"jaw*" = [0, 1]\n"*Open" = [0, 2]', 3, "'jaw\\*' and '\\*Open' give 'jawOpen' dif"),
    ('[[mixture]]\nkind = "dirichlet"\nsum = 60', 3, "limits add up to 57 cannot sum to 60"),
    ('[[mixture]]\nkind = "dirichlet"\nconcentration = 0.01', 3, "at least 0.05 and at most 1000"),
    ('[[mixture]]\nkind = "grid"', 1, "6 levels of 57 sliders are more than 2,147,483,648 faces"),
    ('[[mixture]]\nkind = "grid"\nsliders = ["jaw*"]\nlevels = 1', 4, "levels' must be at least 2"),
    ('[[mixture]]\nkind = "grid"\nsliders = "*Open"\nlevels = 65537', 4, "at most 65536"),
    (
        '[limits]\njawOpen = 0\n[[mixture]]\nkind = "grid"\nsliders = "jawOpen"',
        5,
        "their limits leave each of these sliders one value",
    ),
    (
        '[limits]\n"*" = [0.5, 1]\n[[mixture]]\nkind = "dirichlet"',
        3,
        "limits add up to at least 28.5 cannot sum to 1",
    ),
    (
        '[identity]\nsliders = ["late"]\nlaw = "uniform"\nmean = 1',
        3,
        "'mean' and 'deviation' are of the normal law",
    ),
    (
        '[limits]\n"jaw*" = [-1, 1]\n'
        '[[mixture]]\nkind = "grid"\nsliders = "jaw*"\nnormalize = true',
        6,
        "weights below 0 cannot be divided by their sum",
    ),
    ('[[mixture]]\nkind = "take"', 1, r"\[mixture #1\] needs 'files', such as"),
    ('[[mixture]]\nkind = "take"\nfiles = "a*.csv"', 3, r"no file is called like 'a\*.csv'"),
    ('[[mixture]]\nkind = "take"\nfiles = "still.csv"', 3, "still.csv has one frame"),
    (
        '[[mixture]]\nkind = "take"\nfiles = "other.csv"',
        3,
        "no weight of other.csv drives",
    ),
    ('[[exclude]]\nsliders = ["jaw*"]', 1, "either 'most', a number, or 'one = true'"),
    ('[[exclude]]\nsliders = ["jaw*"]\nmost = 1\none = true', 1, "either 'most', a number, or"),
    ("[[exclude]]\nmost = 1", 1, r"\[exclude #1\] needs 'sliders'"),
    ('[[exclude]]\nsliders = "jawOpen"\none = true', 2, "one slider alone excludes nothing"),
    (
        '[limits]\n"jaw*" = [0.3, 1]\n[[exclude]]\nsliders = "jaw*"\nmost = 1',
        5,
        "limits of jawForward, jawRight, jawLeft, jawOpen alone add up to 1.2, so their sum is",
    ),
    (
        '[limits]\n"jaw*" = [0.3, 1]\n[[exclude]]\nsliders = "jaw*"\none = true',
        5,
        "leave out 0, so each of them always stays",
    ),
    ('[timing]\nlaw = "slow"', 2, "timing.law: timing 'slow' is unknown"),
    (
        '[identity]\nsliders = ["late"]\nmean = 4',
        3,
        "of 'scar' the mean must be from -2.9999. to 3, found 4",
    ),
    ('[identity]\nsliders = ["late"]\nlaw = "gauss"', 3, "law' cannot be 'gauss'"),
    ("[head]\nyaw = [-30, 300]", 2, "'head.yaw' must be at least -180 and at most 180"),
    ("[head]\nyow = [-30, 30]", 2, r"unknown key 'yow' in \[head\]: did you mean 'yaw'"),
    ("[pictures]\nsize = 100000", 2, "at most 4096"),
    ('[pictures]\narrays = ["colors"]', 2, "cannot be 'colors': did you mean 'colour'"),
    ("[landmarks]\nnose = 3", 2, "landmarks.nose: there is no vertex 3; the rig has 3"),
    ('[landmarks]\nfile = "none.json"', 2, "names the file 'none.json', which does not exist"),
    ('[landmarks]\nfile = "still.csv"', 2, "it is not JSON"),
    ("[limits]\nx = = 1\ny = 2", 2, "not TOML"),
]


@pytest.mark.parametrize(("text", "line", "said"), REFUSED)
def test_a_recipe_is_refused_in_one_sentence(
    tmp_path: Path, text: str, line: int, said: str
) -> None:
    (tmp_path / "still.csv").write_text("time,jawOpen\n0,0.5\n")
    (tmp_path / "other.csv").write_text("time,tail\n0,0.5\n0.1,0.5\n")
    file = tmp_path / "recipe.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(em.FormatError, match=said) as refused:
        em.FaceSampler(RIG, file)
    assert refused.value.path == file
    assert refused.value.line == line
    assert "\n" not in str(refused.value)


def test_a_missing_take_is_named(tmp_path: Path) -> None:
    recipe = {"mixture": [{"kind": "take", "files": [str(tmp_path / "none.csv")]}]}
    with pytest.raises(em.FileError, match=r"none\.csv"):
        em.FaceSampler(RIG, recipe)


@pytest.mark.parametrize(
    ("arrays", "said"),
    [
        ({"times": [0.0, 1.0]}, "there is no array"),
        ({"names": ["jawOpen"], "times": [1.0, 0.0], "weights": [[0.0], [1.0]]}, "times must rise"),
        ({"names": ["jawOpen"], "times": [0.0, 1.0], "weights": [[0.0]]}, "has the shape"),
        ({"names": ["jawOpen"] * 2, "times": [0.0], "weights": [[0.0, 1.0]]}, "'jawOpen' twice"),
    ],
)
def test_damaged_archives_of_takes(tmp_path: Path, arrays: dict[str, object], said: str) -> None:
    np.savez(tmp_path / "take.npz", **{n: np.array(value) for n, value in arrays.items()})
    with pytest.raises(em.FormatError, match=said):
        em.FaceSampler(RIG, {"mixture": [{"kind": "take", "files": [str(tmp_path / "take.npz")]}]})


def test_a_slider_must_not_be_called_as_a_column_of_its_own() -> None:
    rig = em.Rig(RIG.neutral, {"t": RIG["jawOpen"], "u": RIG["jawOpen"]})
    with pytest.raises(em.ParameterError, match="slider 't', which is the name of a column"):
        em.FaceSampler(rig, {"timing": {}})


def test_a_recipe_in_python_is_as_one_in_a_file(tmp_path: Path) -> None:
    file = tmp_path / "recipe.toml"
    file.write_text(
        dedent("""
        seed = 12
        [limits]
        jawOpen = [0, 0.5]
        scar = 0.25
        [landmarks]
        nose = 1
        file = "points.json"
        """)
    )
    (tmp_path / "points.json").write_text('{"version": 1, "vertices": {"chin": 2}}')
    given = {
        "seed": np.int64(12),
        "limits": {"jawOpen": (0, np.float64(0.5)), "scar": 0.25},
        "landmarks": {"chin": 2, "nose": 1},
    }
    assert recipe_from(given) == read_recipe(file)
    assert (em.FaceSampler(RIG, file).values(0, 50)[:, NAMES.index("scar")] == 0.25).all()


words = st.sampled_from([*NAMES[:4], "jaw*", "kind", "share", "sliders", "head", "", "é"])
plain = words | st.integers() | st.floats() | st.booleans() | st.lists(st.floats(), max_size=3)
tables = st.dictionaries(words, plain | st.lists(words, max_size=2), max_size=4)


@settings(max_examples=200, deadline=None)
@given(
    st.dictionaries(
        st.sampled_from(["seed", "limits", "mixture", "exclude", "timing", "head", "landmarks"]),
        plain | tables | st.lists(tables, max_size=2),
    )
)
def test_whatever_is_given_is_a_recipe_or_refused(content: dict[str, object]) -> None:
    try:
        sampler = em.FaceSampler(RIG, content)
    except em.ParameterError as error:
        assert str(error).startswith("recipe: ")  # noqa: PT017
        return
    assert sampler.codes(0, 3).shape == (3, len(sampler.columns))
    again = em.FaceSampler.restored(RIG, sampler.recipe.text(), sampler.tables)
    assert again.recipe == sampler.recipe


@pytest.mark.parametrize(
    "recipe",
    [
        {"mixture": [{"kind": "sparse", "sliders": ["x" * 100_000 + "*"]}]},
        {"limits": {"x" * 100_000: [0, 1]}},
        {"mixture": [{"kind": "take", "files": ["x" * 100_000 + "*"]}]},
    ],
)
def test_a_long_pattern_is_not_repeated_whole(recipe: dict[str, object]) -> None:
    with pytest.raises(em.ParameterError) as raised:
        em.FaceSampler(RIG, recipe)
    assert len(str(raised.value)) < 1000


def test_words_are_looked_up_and_each_pattern_is_tried_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tried = []
    monkeypatch.setattr(controls, "fnmatchcase", lambda *own: tried.append(own) or True)
    places = controls.places_of(RIG.sliders, [*NAMES, "jaw*"] * 1000, ())
    assert places == [*range(len(NAMES))]
    assert len(tried) == len(NAMES)
