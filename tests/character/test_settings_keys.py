"""Every key of the schema is read and changes what it is documented to change."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from characters import TABLES, changed, write_settings_file
from elastomorph.character import read_settings, rig_from_settings, settings_tables
from elastomorph.character.schema import FREE, export_options, tables
from elastomorph.io.npz.rig import rig_arrays
from elastomorph.rig import Rig

pytestmark = pytest.mark.filterwarnings("ignore::elastomorph.errors.TimeLawWarning")

METHOD: dict[str, tuple[dict[str, Any], Any]] = {
    "order": ({}, 4),
    "closure": ({}, "rest"),
    "load": ({"name": "beam"}, [0.2, 0.1, 0.7]),
    "basis": ({}, "fourier"),
    "stiffness": ({"material": {"rigidity": 0.01}}, "length"),
    "harmonics": ({"material": {"rigidity": 0.01}}, 1),
    "tolerance": ({"name": "rotation"}, 1e-2),
    "straight_within": ({"name": "auto"}, 0.5),
    "material": ({}, {"rigidity": 0.01}),
}
"""What each key of a method needs beside it, and its value."""


def method_cases(place: str, text: str) -> dict[str, tuple[dict[str, Any], dict[str, Any]]]:
    """The tables before and after each key of a method at one place."""
    cases = {}
    for key, (beside, value) in METHOD.items():
        before = {text: beside.get("name", "beam" if key == "order" else "beam:3")}
        before |= {name: own for name, own in beside.items() if name != "name"}
        with_place = changed(BASE, **{f"{place}__{own}": given for own, given in before.items()})
        cases[key] = (with_place, changed(with_place, **{f"{place}__{key}": value}))
    return cases


BASE = changed(
    TABLES,
    inbetweens__brow={"0.3": "brow_30.obj", "0.6": "brow_60.obj"},
    regions__left={"vertices": "left.json", "method": "ease:3"},
    methods__smile={"method": "beam:3"},
)
BARE = changed(BASE, regions=None)
RIG: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "character.rig": (TABLES, {"character": {"rig": "head.npz"}}),
    "character.mesh": (
        {"character": {"rig": "heads.glb"}},
        {"character": {"rig": "heads.glb", "mesh": "left"}},
    ),
    "character.neutral": (BASE, changed(BASE, character__neutral="other_rest.obj")),
    "character.targets": (
        TABLES,
        changed(TABLES, character__targets=["shapes/jawOpen.obj", "shapes/s*.obj"]),
    ),
    "character.curves": (BASE, changed(BASE, character__curves="curves.json")),
    "character.weld": (
        {"character": {"rig": "cut/cut.npz"}, "method": {"default": "rotation"}},
        {"character": {"rig": "cut/cut.npz", "weld": False}, "method": {"default": "rotation"}},
    ),
    "character.correctives": (TABLES, changed(TABLES, character__correctives="simplex.json")),
    "correctives.*.drivers": (
        changed(TABLES, correctives__smile={"drivers": ["jawOpen"], "law": "min"}),
        changed(TABLES, correctives__smile={"drivers": ["jawOpen", "brow"], "law": "min"}),
    ),
    "correctives.*.law": (
        changed(TABLES, correctives__smile={"drivers": ["jawOpen", "brow"]}),
        changed(TABLES, correctives__smile={"drivers": ["jawOpen", "brow"], "law": "min"}),
    ),
    **{
        f"correctives.*.{key}": (
            changed(TABLES, correctives__smile={"drivers": ["jawOpen"], "law": law, key: first}),
            changed(TABLES, correctives__smile={"drivers": ["jawOpen"], "law": law, key: second}),
        )
        for key, law, first, second in (
            ("gains", "hinge", [0.5], [1.5]),
            ("sharpness", "softmin", 4, 2.5),
        )
    },
    "method.default": (BASE, changed(BASE, method__default="arc")),
    "methods.*.method": (BASE, changed(BASE, methods__smile__method="beam:2")),
    "regions.*.method": (BASE, changed(BASE, regions__left__method="cosine")),
    "regions.*.vertices": (BASE, changed(BASE, regions__left__vertices="top.json")),
    "regions.*.falloff": (BASE, changed(BASE, regions__left__falloff=1)),
    "inbetweens.*.method": (BASE, changed(BASE, inbetweens__brow__method="linear")),
    **{
        f"material.{name}": (
            changed(BARE, method__closure="rest", method__material={"rigidity": 0.01}),
            changed(BARE, method__closure="rest", method__material={"rigidity": 0.01, name: 0.3}),
        )
        for name in ("mass", "damping", "rigidity")
    },
    **{f"method.{key}": case for key, case in method_cases("method", "default").items()},
    **{f"methods.*.{key}": case for key, case in method_cases("methods__smile", "method").items()},
    **{f"regions.*.{key}": case for key, case in method_cases("regions__left", "method").items()},
}
"""Keys that change the rig: tables before and after."""

GLB = {
    "normals": "none",
    "tolerance": 1e-4,
    "keys_tolerance": 1e-3,
    "fps": 60,
    "sparse": False,
    "compress": True,
    "clips": True,
}
USD = {"tolerance": 1e-4, "most_inbetweens": 5, "fps": 24}
EXPORT: dict[str, tuple[dict[str, Any], str]] = {
    "character.unit": (changed(TABLES, character__unit="mm"), "face.usda"),
    "timing.default": (changed(TABLES, timing__default="minimum-jerk"), "face.glb"),
    **{
        f"export.glb.{k}": (changed(TABLES, export__glb={k: v}), "face.glb") for k, v in GLB.items()
    },
    **{
        f"export.usd.{k}": (changed(TABLES, export__usd={k: v}), "face.usdc")
        for k, v in USD.items()
    },
}
"""Keys that change what is written: tables, and a file of a format that they are for."""

LISTS = {
    "methods": (TABLES, changed(TABLES, **{"methods__jaw*": "rotation"})),
    "inbetweens.*": (BASE, changed(BASE, inbetweens__brow={"0.3": "brow_30.obj"})),
    "groups": (TABLES, changed(TABLES, groups__mouth=["jaw*", "smile"])),
    "correctives": (TABLES, changed(TABLES, correctives__smile=["jawOpen", "smile"])),
}
"""Tables with names of the user's: tables before and after."""


def rig_of(folder: Path, tables: dict[str, Any], name: str) -> Rig:
    settings = read_settings(write_settings_file(folder, tables, name))
    return rig_from_settings(settings, cache=None)


def same(one: Rig, other: Rig) -> bool:
    """Whether rigs agree to the last bit, labels apart."""
    left, right = rig_arrays(one), rig_arrays(other)
    names = set(left) - {"methods"}
    return set(left) == set(right) and all(np.array_equal(left[n], right[n]) for n in names)


def test_every_key_of_the_schema_is_tried() -> None:
    """A key that is added without a test of what it does fails here."""
    keys = {f"{table}.{key}" for table, own in tables().items() for key in own}
    assert keys == {*RIG, *EXPORT, "character.name", "character.root"}  # root: of USD
    assert set(LISTS) == set(FREE)


@pytest.mark.parametrize("key", [*RIG, *LISTS])
def test_a_key_of_the_paths_changes_the_rig(character: Path, key: str) -> None:
    before, after = {**RIG, **LISTS}[key]
    kept = rig_of(character, before, "before.toml")
    assert same(kept, rig_of(character, before, "before.toml"))
    assert not same(kept, rig_of(character, after, "after.toml"))


@pytest.mark.parametrize("key", EXPORT)
def test_a_key_of_the_export_reaches_the_writer_and_no_path(character: Path, key: str) -> None:
    after, file = EXPORT[key]
    plain = read_settings(write_settings_file(character, TABLES, "before.toml"))
    settings = read_settings(write_settings_file(character, after, "after.toml"))
    options = [export_options(own, file) for own in (plain, settings)]
    for own in options:
        own.pop("settings")
    assert options[0] != options[1]
    rigs = [rig_from_settings(own, cache=None) for own in (plain, settings)]
    assert same(*rigs)


def test_the_name_reaches_outputs(character: Path) -> None:
    """It is the name of the folder where none is given."""
    plain = read_settings(write_settings_file(character, TABLES, "before.toml"))
    assert settings_tables(plain)["character"]["name"] == character.name
    named = changed(TABLES, character__name="Grace")
    settings = read_settings(write_settings_file(character, named, "after.toml"))
    assert settings_tables(settings)["character"]["name"] == "Grace"


@pytest.mark.parametrize("key", [*RIG, *LISTS, *EXPORT])
def test_the_tables_kept_in_outputs_read_back_as_the_same_settings(
    character: Path, key: str
) -> None:
    """What an output says of its settings, written as a file, makes the same rig and output."""
    after = EXPORT[key][0] if key in EXPORT else {**RIG, **LISTS}[key][1]
    settings = read_settings(write_settings_file(character, after, "after.toml"))
    kept = settings_tables(settings)
    kept.pop("made_with")
    again = read_settings(write_settings_file(character, kept, "again.toml"))
    kept_again = settings_tables(again)
    kept_again.pop("made_with")
    assert kept_again == kept
    if key not in EXPORT and "rig" not in key:
        assert same(*(rig_from_settings(own, cache=None) for own in (settings, again)))
