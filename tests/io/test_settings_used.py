"""What a file says of how it was made comes back as it was given."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_samples import house, same_bits

import elastomorph as em
from elastomorph.errors import FileError, FormatError
from elastomorph.io.registry import settings_used
from needs import extra

TABLES = {
    "character": {"name": "Ada 𝄞 \"'\n", "note": ""},
    "method": {"default": "beam:2", "mass": 0.1},
    "groups": {"nobody": []},
    "empty": {},
}
SUFFIXES = (".glb", ".npz", ".usda", ".usdc")


def rig() -> em.Rig:
    moved = house().with_vertices(house().vertices + 1.0)
    return em.Rig(house(), {"up": em.interpolate(house(), moved, "ease:2")})


def require_library(suffix: str) -> None:
    if "usd" in suffix:
        extra("pxr", "usd")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_rig_keeps_its_settings(tmp_path: Path, suffix: str) -> None:
    """And is otherwise the rig it is without."""
    require_library(suffix)
    plain, made = tmp_path / f"plain{suffix}", tmp_path / f"made{suffix}"
    em.write(plain, rig())
    em.write(made, rig(), settings=TABLES)
    assert settings_used(plain) is None
    assert settings_used(made) == TABLES
    one, other = em.read_rig(plain), em.read_rig(made)
    assert one.names == other.names
    assert same_bits(one.morphs["up"].at(0.3), other.morphs["up"].at(0.3))


def test_without_settings_files_are_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a.npz", "b.npz"):
        em.write(tmp_path / name, rig(), **({} if name == "a.npz" else {"settings": None}))
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


values = st.integers(-(2**53), 2**53) | st.floats(allow_nan=False, allow_infinity=False) | st.text()
texts = st.dictionaries(
    st.text(), values | st.dictionaries(st.text(), values, max_size=3), max_size=4
)


@settings(max_examples=40, deadline=None)
@given(texts)
def test_any_json_comes_back_from_an_archive(
    tmp_path_factory: pytest.TempPathFactory, tables: dict[str, object]
) -> None:
    path = tmp_path_factory.mktemp("any") / "rig.npz"
    em.write(path, rig(), settings=tables)
    assert settings_used(path) == tables


def test_an_evaluation_keeps_them_under_a_key(tmp_path: Path) -> None:
    (tmp_path / "evaluation.json").write_text(json.dumps({"methods": [], "settings": TABLES}))
    assert settings_used(tmp_path / "evaluation.json") == TABLES
    for content in ("[]", "3", "{}", '{"settings": 3}', "no JSON", "[" * 10_000):
        (tmp_path / "other.json").write_text(content)
        assert settings_used(tmp_path / "other.json") is None


def test_files_of_other_kinds_have_none(tmp_path: Path) -> None:
    em.write(tmp_path / "house.obj", house())
    em.write(tmp_path / "house.npz", house())
    for name in ("house.obj", "house.npz"):
        assert settings_used(tmp_path / name) is None


def test_foreign_and_damaged_gltf(tmp_path: Path) -> None:
    document = {
        "asset": {"version": "2.0"},
        "meshes": [3, {"extras": [1]}, {"extras": {"elastomorph": 1}}],
    }
    (tmp_path / "foreign.gltf").write_text(json.dumps(document))
    assert settings_used(tmp_path / "foreign.gltf") is None
    (tmp_path / "damaged.glb").write_bytes(b"glTF")
    with pytest.raises(FormatError):
        settings_used(tmp_path / "damaged.glb")
    with pytest.raises(FileError):
        settings_used(tmp_path / "none.glb")
