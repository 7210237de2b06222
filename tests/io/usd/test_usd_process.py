"""No file takes the program down, fills its memory or leads it out of its folder."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner
from usd_rigs import grid, read_in_this_process, sample_rig

import elastomorph as em
from elastomorph.cli import app
from elastomorph.errors import FileError, FormatError, MissingExtraError, ParameterError
from elastomorph.io.untrusted import MemoryBudget
from elastomorph.io.usd import read_usd, write_usd
from elastomorph.io.usd.composed import _is_shared as is_shared
from elastomorph.rig import Rig
from needs import extra

extra("pxr", "usd")


def refused(path: Path) -> bool:
    """Whether the file is refused; anything but a FormatError that names it is a failure."""
    try:
        read_usd(path)
    except FormatError as error:
        if str(path) not in str(error):
            raise
        return True
    return False


@pytest.mark.slow
@pytest.mark.parametrize("suffix", ["usda", "usdc"])
def test_files_cut_off_or_changed_give_a_rig_or_an_error_of_ours(
    tmp_path: Path, suffix: str
) -> None:
    whole = tmp_path / f"whole.{suffix}"
    write_usd(whole, Rig(grid(), {}))
    content = whole.read_bytes()
    random = np.random.default_rng(0)
    cut = [content[: len(content) * part // 3] for part in range(3)]
    changed = []
    for _ in range(3):
        bytes_now = bytearray(content)
        for place in random.integers(0, len(content), 3):
            bytes_now[place] ^= 0xFF
        changed.append(bytes(bytes_now))
    paths = []
    for i, one in enumerate([*cut, *changed]):
        paths.append(tmp_path / f"{i}.{suffix}")
        paths[-1].write_bytes(one)
    with ThreadPoolExecutor(2) as pool:
        outcomes = list(pool.map(refused, paths))
    assert all(outcomes[:3])


@pytest.mark.parametrize(
    ("name", "content"),
    [("a.usda", b""), ("b.usda", b"#usda 1.0\n(("), ("c.usdc", b"PXR-USDC"), ("d.usd", b"\0" * 99)],
)
def test_what_is_no_usd_is_refused_and_usd_prints_nothing(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], name: str, content: bytes
) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(FormatError, match=rf"{name}: (USD cannot read it|no mesh)"):
        read_usd(tmp_path / name)
    out, err = capfd.readouterr()
    assert out == err == ""


def test_files_that_are_not_there(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="no such file"):
        read_usd(tmp_path / "a.usd")
    (tmp_path / "b.usd").mkdir()
    with pytest.raises(FileError, match="a folder"):
        read_usd(tmp_path / "b.usd")
    with pytest.raises(FormatError, match="expected a name that ends in"):
        read_usd(tmp_path / "a.abc")


def test_without_usd_the_error_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a.usda").write_text("#usda 1.0\n")
    monkeypatch.setattr("elastomorph.io.usd.reader.find_spec", lambda name: None)
    with pytest.raises(MissingExtraError, match=r"elastomorph\[usd\]"):
        read_usd(tmp_path / "a.usda")


@pytest.fixture
def inside_and_outside(tmp_path: Path) -> tuple[Path, Path]:
    """A folder with a rig in a folder below it, and the same rig outside."""
    inside = tmp_path / "inside"
    (inside / "parts").mkdir(parents=True)
    write_usd(tmp_path / "outside.usda", sample_rig())
    write_usd(inside / "parts" / "face.usda", sample_rig())
    return inside, tmp_path / "outside.usda"


def composed(folder: Path, body: str) -> Path:
    path = folder / "composed.usda"
    path.write_text(f"#usda 1.0\n{body}\n")
    return path


ARCS = {
    "reference": 'def "A" (references = @{}@) {{}}',
    "payload": 'def "A" (payload = @{}@) {{}}',
    "sublayer": "(subLayers = [@{}@])",
    "variant": 'def "A" (\nvariants = {{ string v = "x" }}\nprepend variantSets = "v"\n) {{\n'
    'variantSet "v" = {{\n"x" (references = @{}@) {{\n}}\n}}\n}}',
}


@pytest.mark.parametrize("arc", ARCS)
def test_files_in_the_same_folder_are_followed(
    inside_and_outside: tuple[Path, Path], arc: str
) -> None:
    path = composed(inside_and_outside[0], ARCS[arc].format("./parts/face.usda"))
    assert read_in_this_process(path, inside_and_outside[1].parent).names == sample_rig().names


@pytest.mark.parametrize("arc", ARCS)
def test_files_beside_the_folder_are_followed(
    inside_and_outside: tuple[Path, Path], arc: str
) -> None:
    """As studios lay out assets: what a layer names relative to itself is of its project."""
    inside, outside = inside_and_outside
    path = composed(inside, ARCS[arc].format("../outside.usda"))
    assert read_in_this_process(path, inside).names == sample_rig().names
    (inside / "parts" / "second.usda").write_text(
        '#usda 1.0\n(defaultPrim = "A")\n' + ARCS["reference"].format("../../outside.usda")
    )
    path = composed(inside, ARCS[arc].format("./parts/second.usda"))
    assert read_in_this_process(path, inside).names == sample_rig().names
    outside.unlink()
    assert refused(path)


@pytest.mark.parametrize("arc", ARCS)
def test_files_outside_the_root_are_not(inside_and_outside: tuple[Path, Path], arc: str) -> None:
    inside, outside = inside_and_outside
    path = composed(inside, ARCS[arc].format("../outside.usda"))
    wanted = r"composed of '\.\./outside\.usda', which is no file in .* name a higher folder"
    with pytest.raises(FormatError, match=wanted):
        read_in_this_process(path, inside, f"--root={inside}")
    with pytest.raises(FormatError, match=r"is not in the root .* name a higher one"):
        read_in_this_process(path, inside, f"--root={inside / 'parts'}")
    assert read_in_this_process(path, inside, f"--root={outside.parent}").names


def test_the_root_is_named_in_python(inside_and_outside: tuple[Path, Path]) -> None:
    inside, outside = inside_and_outside
    path = composed(inside, ARCS["reference"].format("../outside.usda"))
    assert em.read_rig(path, root=outside.parent).names == sample_rig().names
    with pytest.raises(FormatError, match="composed of"):
        em.read_rig(path, root=inside)
    with pytest.raises(ParameterError, match="root"):
        em.read_rig("built-in.glb", root=inside)


@pytest.mark.parametrize("verb", ["inspect", "bend --dry-run", "export -o a.npz"])
def test_the_root_is_named_on_the_command_line(
    inside_and_outside: tuple[Path, Path], verb: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Absolute paths lead out of the folder of a file, unless its user says where all may lie."""
    inside, outside = inside_and_outside
    path = composed(inside, ARCS["reference"].format(outside))
    monkeypatch.chdir(inside)

    def failed(*words: object) -> bool:
        return CliRunner().invoke(app, [*map(str, words)]).exit_code != 0

    name, *more = verb.split()
    environment = dict(os.environ)
    assert failed(name, path, *more)
    assert not failed("--root", outside.parent, name, path, *more)
    assert failed("--root", inside / "nowhere", name, path, *more)
    if name in ("bend", "export"):
        settings = inside / "elastomorph.toml"
        settings.write_text(f'[character]\nrig = "{path.name}"\nroot = ".."\n')
        assert not failed(name, settings, *more, *["--overwrite"] * (name == "export"))
    assert dict(os.environ) == environment


@pytest.mark.parametrize("shared", ["home", "above home", "temporary"])
def test_what_all_share_is_no_project(
    inside_and_outside: tuple[Path, Path], shared: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file that came by mail does not reach the other folders of a home."""
    inside, outside = inside_and_outside
    path = composed(inside, ARCS["reference"].format("../outside.usda"))
    if shared == "temporary":
        monkeypatch.setattr("elastomorph.io.usd.composed.gettempdir", lambda: str(outside.parent))
    else:
        home = outside.parent / "someone" if shared == "above home" else outside.parent
        monkeypatch.setattr(Path, "home", lambda: home)
    with pytest.raises(FormatError, match="composed of"):
        read_in_this_process(path, inside)
    assert read_in_this_process(path, inside, f"--root={outside.parent}").names


def test_nothing_on_top_of_the_disk_is_a_project() -> None:
    for folder in ("/", "/mnt", str(Path.home()), str(Path.home().parent)):
        assert is_shared(Path(folder))
    assert not is_shared(Path("/mnt/show"))


def test_no_detour_leads_outside(inside_and_outside: tuple[Path, Path]) -> None:
    """Not an absolute path, a link, a working folder, a URL or an expression."""
    inside, outside = inside_and_outside
    names = [str(outside), "https://example.org/face.usda", "gone.usda", "`'../outside.usda'`"]
    if os.name == "posix":
        (inside / "link.usda").symlink_to(outside)
        (inside / "folder").symlink_to(outside.parent, target_is_directory=True)
        names += ["./link.usda", "./folder/outside.usda"]
    for name in names:
        for options in ((), (f"--root={inside}",)):
            path = composed(inside, ARCS["reference"].format(name))
            with pytest.raises(FormatError, match="it is composed of"):
                read_in_this_process(path, inside.parent, *options)
    assert refused(path)


@pytest.mark.skipif(os.name != "posix", reason="needs links")
def test_dots_behind_a_link_are_those_of_usd(inside_and_outside: tuple[Path, Path]) -> None:
    """USD takes ``link/..`` for the folder of the link, the disk for that of its target."""
    inside, outside = inside_and_outside
    (outside.parent / "far" / "deep").mkdir(parents=True)
    (outside.parent / "far" / "face.usda").write_bytes(outside.read_bytes())
    (inside / "link").symlink_to(outside.parent / "far" / "deep", target_is_directory=True)
    path = composed(inside, ARCS["reference"].format("./link/../face.usda"))
    with pytest.raises(FormatError, match="composed of"):
        read_in_this_process(path, inside, f"--root={inside}")
    write_usd(inside / "face.usda", sample_rig())
    assert read_in_this_process(path, inside, f"--root={inside}").names == sample_rig().names


def test_value_clips_are_refused(inside_and_outside: tuple[Path, Path]) -> None:
    clips = 'def "A" (clips = { dictionary default = { asset[] assetPaths = [@../outside.usda@] }'
    path = composed(inside_and_outside[0], f"{clips} }}) {{}}")
    with pytest.raises(FormatError, match="the prim /A takes its values from clips"):
        read_in_this_process(path, path.parent)


def test_shapes_that_would_fill_the_memory_are_refused(
    tmp_path: Path,
) -> None:
    path = tmp_path / "a.usda"
    write_usd(path, sample_rig())
    with pytest.raises(FormatError, match="would take more memory than"):
        read_in_this_process(path, tmp_path, budget=MemoryBudget(path, -174_000))
