"""A folder of meshes is a rig; once more it comes from a cache that is never trusted blindly."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mesh_samples import house, same_bits
from test_rig_npz import assert_same_rig

import elastomorph as em
from cards import card, image_of
from elastomorph.curves import Curve, CurveNetwork
from elastomorph.errors import FileError, FormatError, ParameterError, TopologyError
from elastomorph.io import rig_cache, rig_folder
from elastomorph.io.rig_cache import CACHE_SUFFIX, settings_digest, user_cache_folder
from elastomorph.io.rig_folder import find_rig_files, read_rig_folder
from elastomorph.paths import Method
from elastomorph.physics import Load, Material
from elastomorph.rig import Rig
from needs import extra, not_root


@pytest.fixture(autouse=True)
def user_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The cache folder of the user, empty and of this test alone."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "user cache"))
    return tmp_path / "user cache" / "elastomorph"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A neutral and two targets, in three formats, among other files."""
    place = tmp_path / "faces"
    place.mkdir()
    em.write(place / "Generic_Neutral.obj", house())
    random = np.random.default_rng(2)
    for name in ("smile.ply", "jawOpen.npz"):
        em.write(place / name, moved(random.normal(size=(5, 3))))
    (place / "notes.txt").write_text("no mesh")
    (place / ".hidden.obj").write_text("no mesh either")
    (place / "older.obj").mkdir()
    return place


def moved(offset: np.ndarray | float) -> em.Mesh:
    return house().with_vertices(house().vertices + offset)


def caches(place: Path) -> list[Path]:
    return sorted(place.glob(f"*{CACHE_SUFFIX}"))


class Spoken:
    """What a reader said it does."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def __call__(self, line: str) -> None:
        self.lines.append(line)

    @property
    def from_cache(self) -> bool:
        return any("read from" in line for line in self.lines)


def read(folder: Path, **options: object) -> tuple[Rig, bool]:
    """The rig, and whether it came from a cache."""
    spoken = Spoken()
    rig = read_rig_folder(folder, say=spoken, **options)  # type: ignore[arg-type]
    return rig, spoken.from_cache


def test_every_file_but_the_neutral_is_a_target_named_by_its_stem(folder: Path) -> None:
    rig, _ = read(folder)
    assert rig.names == ("jawOpen", "smile")
    assert rig.neutral.name == str(folder / "Generic_Neutral.obj")
    for name, file in (("jawOpen", "jawOpen.npz"), ("smile", "smile.ply")):
        assert same_bits(rig.morphs[name].target.vertices, em.read(folder / file).vertices)


@pytest.mark.parametrize("method", ["linear", "ease:3", "beam:2", Method("beam", order=3)])
def test_paths_are_those_of_interpolate(folder: Path, method: str | Method) -> None:
    rig, _ = read(folder, method=method, cache=None)
    neutral = em.read(folder / "Generic_Neutral.obj")
    for name, file in (("jawOpen", "jawOpen.npz"), ("smile", "smile.ply")):
        expected = em.interpolate(neutral, em.read(folder / file), method)
        assert same_bits(rig.morphs[name].at([0.25, 1.5]), expected.at([0.25, 1.5]))
        assert rig.morphs[name].method == expected.method


def test_settings_and_curves_reach_the_method(folder: Path) -> None:
    curves = CurveNetwork([Curve([0, 1, 2, 3], closed=True)], 5)
    material = Material(2, 0.5, 1)
    rig, _ = read(folder, method="beam", curves=curves, order=3, material=material)
    neutral, target = em.read(folder / "Generic_Neutral.obj"), em.read(folder / "smile.ply")
    expected = em.interpolate(neutral, target, "beam", curves=curves, order=3, material=material)
    assert same_bits(rig.morphs["smile"].bends, expected.bends)
    with pytest.raises(ParameterError, match="auto has no colour"):
        read(folder, colour=1)


@pytest.mark.parametrize("name", ["smile", "smile.ply"])
def test_the_neutral_may_be_named(folder: Path, name: str) -> None:
    rig, _ = read(folder, neutral=name)
    assert rig.names == ("Generic_Neutral", "jawOpen")
    assert rig.neutral.name == str(folder / "smile.ply")


def test_the_neutral_may_lie_elsewhere(folder: Path, tmp_path: Path) -> None:
    em.write(tmp_path / "rest.obj", house())
    assert read(folder, neutral=tmp_path / "rest.obj")[0].names == (
        "Generic_Neutral",
        "jawOpen",
        "smile",
    )
    assert find_rig_files(folder, folder / "smile.ply").neutral == folder / "smile.ply"
    with pytest.raises(FileError, match="no neutral 'nobody'"):
        find_rig_files(folder, "nobody")


def test_which_neutral_is_never_guessed(folder: Path, tmp_path: Path) -> None:
    """One that is called just "neutral" wins; of several others none does."""
    em.write(folder / "neutral_smile.obj", house())
    with pytest.raises(FileError, match=r"found Generic_Neutral\.obj, neutral_smile\.obj"):
        find_rig_files(folder)
    em.write(folder / "Neutral.ply", house())
    assert find_rig_files(folder).neutral == folder / "Neutral.ply"
    with pytest.raises(FileError, match="no such folder"):
        find_rig_files(tmp_path / "none")
    with pytest.raises(FileError, match="this is a file"):
        find_rig_files(folder / "smile.ply")
    (tmp_path / "empty").mkdir()
    with pytest.raises(FileError, match="among the 0 there, found none"):
        find_rig_files(tmp_path / "empty")
    em.write(tmp_path / "empty" / "neutral.obj", house())
    with pytest.raises(FileError, match="no targets beside the neutral"):
        find_rig_files(tmp_path / "empty")


def test_two_files_of_one_name_are_refused(folder: Path) -> None:
    em.write(folder / "smile.obj", house())
    with pytest.raises(FileError, match=r"smile.obj and smile.ply are both called 'smile'"):
        read(folder)


def test_another_topology_names_file_and_polygon(folder: Path) -> None:
    faces = [[0, 1, 2, 3], [3, 4, 2]]
    em.write(folder / "wrong.obj", em.Mesh(house().vertices, faces))
    with pytest.raises(TopologyError, match=r"wrong\.obj .* polygon that differs is 1 \(line"):
        read(folder)
    assert caches(user_cache_folder() or folder) == []


def test_damaged_files_are_refused_by_name(folder: Path) -> None:
    (folder / "smile.ply").write_text("not a mesh")
    with pytest.raises(FormatError, match=r"smile\.ply"):
        read(folder)


def test_the_second_time_it_comes_from_the_cache_and_is_the_same(
    folder: Path, user_cache: Path
) -> None:
    first, cached = read(folder, method="beam:3")
    assert not cached
    assert len(caches(user_cache)) == 1
    second, cached = read(folder, method="beam:3")
    assert cached
    assert_same_rig(first, second)
    assert second.neutral.name == first.neutral.name


def test_a_cache_may_lie_in_a_folder_of_its_own_or_beside_the_files(
    folder: Path, user_cache: Path, tmp_path: Path
) -> None:
    for place in (tmp_path / "new" / "caches", folder):
        assert [read(folder, cache=place)[1] for _ in range(2)] == [False, True]
        assert len(caches(place)) == 1
    assert not user_cache.exists()


@pytest.mark.parametrize("off", [None, False])
def test_without_a_cache_nothing_is_kept(folder: Path, user_cache: Path, off: bool | None) -> None:
    assert [read(folder, cache=off)[1] for _ in range(2)] == [False, False]
    assert not user_cache.exists()


def rewritten(folder: Path) -> None:
    em.write(folder / "smile.ply", moved(7.0))


def rewritten_with_its_old_date_and_size(folder: Path) -> None:
    file = folder / "smile.ply"
    before = file.stat()
    content = bytearray(file.read_bytes())
    content[-30] ^= 1  # in the polygons' vertices or coordinates: another content, equally long
    vertices = content.index(b"end_header\n") + len(b"end_header\n")
    content[-30] ^= 1
    content[vertices] ^= 1
    file.write_bytes(content)
    os.utime(file, ns=(before.st_atime_ns, before.st_mtime_ns))
    assert file.stat().st_size == before.st_size


def added(folder: Path) -> None:
    em.write(folder / "brow.obj", moved(1.0))


def removed(folder: Path) -> None:
    (folder / "smile.ply").unlink()


def renamed(folder: Path) -> None:
    (folder / "smile.ply").rename(folder / "frown.ply")


def swapped(folder: Path) -> None:
    (folder / "jawOpen.npz").unlink()
    em.write(folder / "jawOpen.ply", em.read(folder / "smile.ply"))


def neutral_changed(folder: Path) -> None:
    em.write(folder / "Generic_Neutral.obj", moved(0.5))


@pytest.mark.parametrize(
    "change",
    [
        rewritten,
        rewritten_with_its_old_date_and_size,
        added,
        removed,
        renamed,
        swapped,
        neutral_changed,
    ],
)
def test_a_change_of_any_file_makes_the_cache_stale(
    folder: Path, user_cache: Path, change: Callable[[Path], None]
) -> None:
    read(folder, method="beam:2")
    change(folder)
    rig, cached = read(folder, method="beam:2")
    assert not cached
    assert_same_rig(rig, read(folder, method="beam:2", cache=None)[0])
    assert read(folder, method="beam:2")[1]
    assert len(caches(user_cache)) == 1


def test_files_that_are_only_touched_or_moved_in_time_keep_the_cache(folder: Path) -> None:
    read(folder)
    for file in folder.iterdir():
        os.utime(file, (1, 1))
    assert read(folder)[1]


def test_each_method_and_setting_has_its_own_cache(folder: Path, user_cache: Path) -> None:
    curves = CurveNetwork([Curve([0, 1, 2, 3], closed=True)], 5)
    options: list[dict[str, object]] = [
        {},
        {"method": "beam"},
        {"method": "beam", "order": 3},
        {"method": "beam", "material": Material(1, 2, 1)},
        {"method": "beam", "curves": curves},
        {"method": "beam", "region": [0, 1]},
        {"method": "beam", "region": np.array([0, 2])},
        {"method": Method("beam", load=Load([1, 2]))},
        {"neutral": "smile"},
    ]
    for option in options:
        assert not read(folder, **option)[1]
    for option in options:
        assert read(folder, **option)[1]
    assert len(caches(user_cache)) == len(options)


def test_two_folders_of_one_name_do_not_share_a_cache(folder: Path, tmp_path: Path) -> None:
    other = tmp_path / "elsewhere" / folder.name
    shutil.copytree(folder, other)
    em.write(other / "smile.ply", moved(3.0))
    for _ in range(2):
        assert not same_bits(
            read(folder)[0].morphs["smile"].delta, read(other)[0].morphs["smile"].delta
        )
    assert read(folder)[1]
    assert read(other)[1]


def test_another_version_of_the_code_builds_anew(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read(folder)
    monkeypatch.setattr(rig_cache, "code_version", lambda: "another")
    assert [read(folder)[1] for _ in range(2)] == [False, True]


def test_a_damaged_cache_is_rebuilt_without_a_word(folder: Path, user_cache: Path) -> None:
    expected = read(folder)[0]
    (file,) = caches(user_cache)
    whole = file.read_bytes()
    for content in (b"", b"PK", whole[: len(whole) // 2], whole[:-1], whole[:100] + whole[101:]):
        file.write_bytes(content)
        rig, cached = read(folder)
        assert not cached
        assert_same_rig(rig, expected)
        assert file.read_bytes() == whole
    for place in range(0, len(whole), len(whole) // 60):
        changed = bytearray(whole)
        changed[place] ^= 0xFF
        file.write_bytes(changed)
        assert_same_rig(read(folder)[0], expected)


def test_a_cache_that_is_another_archive_is_rebuilt(folder: Path, user_cache: Path) -> None:
    read(folder)
    (file,) = caches(user_cache)
    np.savez(file.with_suffix(".npz"), vertices=np.zeros((3, 3)))
    file.with_suffix(".npz").replace(file)
    assert [read(folder)[1] for _ in range(2)] == [False, True]


def test_where_no_cache_can_be_written_reading_still_works(
    folder: Path, user_cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    user_cache.parent.mkdir()
    user_cache.write_text("a file where the folder should be")
    assert [read(folder)[1] for _ in range(2)] == [False, False]

    def refuse(*_: object) -> None:
        raise FileError(tmp_path, "you have no permission to write in this folder")

    monkeypatch.setattr(rig_cache, "write_arrays", refuse)
    assert [read(folder, cache=tmp_path / "denied")[1] for _ in range(2)] == [False, False]


@not_root
def test_a_read_only_cache_folder_is_no_obstacle(folder: Path, tmp_path: Path) -> None:
    place = tmp_path / "locked"
    place.mkdir(mode=0o500)
    assert [read(folder, cache=place)[1] for _ in range(2)] == [False, False]


def test_a_cache_that_may_only_be_read_is_read(folder: Path, user_cache: Path) -> None:
    read(folder)
    (file,) = caches(user_cache)
    file.chmod(0o400)
    assert read(folder)[1]


def test_a_file_that_changes_while_it_is_read_is_not_remembered(
    folder: Path, user_cache: Path
) -> None:
    def change(line: str) -> None:
        if "jawOpen" in line:
            em.write(folder / "smile.ply", moved(9.0))

    read_rig_folder(folder, say=change)
    assert not user_cache.exists()
    assert not read(folder)[1]


def test_paths_of_the_built_in_head_are_made_once(
    user_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Kept as those of a folder; each caller has a rig of its own, on the neutral of samples."""
    made = []
    build = rig_folder.with_paths
    few = rig_folder.rig_as_stored("built-in").only(["jawOpen", "jawLeft"])
    monkeypatch.setattr(rig_folder, "rig_as_stored", lambda _: few)
    monkeypatch.setattr(rig_folder, "with_paths", lambda *a, **k: made.append(1) or build(*a, **k))
    first, second = (em.read_rig("built-in", method="arc") for _ in range(2))
    assert len(made) == len(caches(user_cache)) == 1
    assert_same_rig(first, second)
    assert first.neutral is second.neutral is em.samples.head()
    jaw, other = first.morphs["jawOpen"], second.morphs["jawOpen"]
    assert (first is second, jaw is other) == (False, False)
    for fixed in (jaw.bends, jaw.delta, jaw.target.vertices, jaw.neutral.vertices):
        with pytest.raises(ValueError, match="read-only"):
            fixed[:] = 0
    with pytest.raises(TypeError):
        first.morphs["jawOpen"] = first.morphs["jawLeft"]
    em.read_rig("built-in", method="ease")
    em.read_rig("built-in", method="ease", cache=None)
    assert (len(made), len(caches(user_cache))) == (3, 2)
    with pytest.raises(ParameterError):
        em.read_rig("built-in", neutral="head.obj")


def test_settings_that_cannot_be_named_are_not_cached(folder: Path, user_cache: Path) -> None:
    assert settings_digest(lambda: 1) is None
    assert settings_digest(np.array([object()])) is None
    assert settings_digest(b"bytes") is None


def test_settings_that_differ_in_any_way_have_another_digest() -> None:
    different: list[object] = [
        None, True, 1, 1.0, "1", [1], [[1]], [1, 1], {"a": 1}, {"b": 1}, np.array([1]),
        np.array([1.0]), np.array([[1]]), Path("1"), 0.0, -0.0, Material(), Method(), Load([1]),
        CurveNetwork([], 1), CurveNetwork([], 2), CurveNetwork([Curve([0])], 1), "", [],
    ]  # fmt: skip
    digests = [settings_digest(value) for value in different]
    assert None not in digests
    assert len(set(digests)) == len(different)
    assert settings_digest(Method("beam", order=2)) == settings_digest(Method("beam", order=2))
    assert settings_digest(np.float64(0.1)) == settings_digest(0.1)


def test_old_caches_go_first_when_they_take_too_much_room(
    folder: Path, user_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file_of: dict[str, Path] = {}
    for age, method in enumerate(["linear", "ease:2", "ease:3"]):
        read(folder, method=method)
        (file_of[method],) = set(caches(user_cache)) - set(file_of.values())
        os.utime(file_of[method], (1000 + age, 1000 + age))
    size = max(file.stat().st_size for file in caches(user_cache))
    read(folder, method="linear")  # used again, so "ease:2" is now the oldest
    monkeypatch.setattr(rig_cache, "_MOST_BYTES", int(3.5 * size))
    read(folder, method="ease:4")
    assert [method for method, file in file_of.items() if file.exists()] == ["linear", "ease:3"]
    assert len(caches(user_cache)) == 3


def test_the_cache_folder_of_the_user(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert user_cache_folder() == tmp_path / "user cache" / "elastomorph"
    monkeypatch.setenv("XDG_CACHE_HOME", "not/absolute")
    monkeypatch.setattr(Path, "home", lambda: tmp_path)
    for system, expected in (
        ("linux", tmp_path / ".cache" / "elastomorph"),
        ("darwin", tmp_path / "Library" / "Caches" / "elastomorph"),
    ):
        monkeypatch.setattr(rig_cache.sys, "platform", system)
        assert user_cache_folder() == expected
    monkeypatch.setattr(rig_cache.sys, "platform", "win32")
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path / "Local"))
    assert user_cache_folder() == tmp_path / "Local" / "elastomorph" / "Cache"


def test_without_a_home_there_is_no_cache_and_no_error(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rig_cache, "user_cache_folder", lambda: None)
    assert [read(folder)[1] for _ in range(2)] == [False, False]


def test_the_code_is_named_by_its_sources(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    rig_cache.code_version.cache_clear()
    before = rig_cache.code_version()
    for content in ("a = 1", "a = 2"):
        (tmp_path / "package" / "io").mkdir(parents=True, exist_ok=True)
        (tmp_path / "package" / "io" / "rig_cache.py").write_text(content)
        monkeypatch.setattr(
            rig_cache, "__file__", str(tmp_path / "package" / "io" / "rig_cache.py")
        )
        rig_cache.code_version.cache_clear()
        after = rig_cache.code_version()
        assert after != before
        before = after
    monkeypatch.undo()
    rig_cache.code_version.cache_clear()


@pytest.mark.realdata
def test_a_production_rig_comes_from_the_cache_the_second_time(
    data_dir: Path, user_cache: Path
) -> None:
    """57 targets of 26,719 vertices as beams, the same from the files and from the cache."""
    place = data_dir / "ict-facekit"
    first, cached = read(place, method="beam:2")
    assert not cached
    second, cached = read(place, method="beam:2")
    assert cached
    assert_same_rig(first, second)
    assert len(first) == 57


@pytest.mark.parametrize("suffix", [".glb", ".usdz"])
def test_looks_of_a_material_library_come_with_it_and_are_exported(
    tmp_path: Path, suffix: str
) -> None:
    """The first time, and from the cache."""
    if suffix == ".usdz":
        extra("pxr", "usd")
    rig = tmp_path / "rig"
    rig.mkdir()
    mesh = replace(card(None), material_library="card.mtl")
    em.write(rig / "neutral.obj", mesh)
    em.write(rig / "up.obj", mesh.with_vertices(mesh.vertices + [0, 0, 1]))
    (rig / "card.mtl").write_text("newmtl card\nKd 1 1 1\nmap_Kd skin.png\n")
    (rig / "skin.png").write_bytes(image_of())
    for cached in (False, True):
        found, from_cache = read(rig)
        assert from_cache is cached
        em.write(tmp_path / f"card{suffix}", found)
        exported = em.read_rig(tmp_path / f"card{suffix}")
        for own in (found, exported):
            assert own.neutral.appearance is not None
            texture = own.neutral.appearance["card"].texture
            assert texture is not None
            assert texture.image == image_of()
            assert all(morph.neutral is own.neutral for morph in own.morphs.values())
