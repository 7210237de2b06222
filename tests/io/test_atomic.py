"""Files are read with clear errors, and written whole or not at all."""

from __future__ import annotations

import errno
import gzip
import os
import stat
import sys
from pathlib import Path

import pytest

from elastomorph.errors import FileError, FormatError
from elastomorph.io.atomic import (
    is_file,
    is_folder,
    opened,
    read_bytes,
    replacing,
    replacing_path,
    size_of,
)
from needs import not_root

posix = pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX permissions and links")


@pytest.mark.parametrize("old", [None, b"old"])
@pytest.mark.parametrize("by_path", [False, True])
def test_the_new_content_is_there_once_the_block_ends(
    tmp_path: Path, old: bytes | None, by_path: bool
) -> None:
    path = tmp_path / "face.obj"
    if old is not None:
        path.write_bytes(old)
    if by_path:
        with replacing_path(path) as temporary:
            temporary.write_bytes(b"new")
    else:
        with replacing(path) as file:
            file.write(b"new")
    assert path.read_bytes() == b"new"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("old", [None, b"old"])
@pytest.mark.parametrize("by_path", [False, True])
@pytest.mark.parametrize("error", [KeyError("oops"), KeyboardInterrupt(), SystemExit(1)])
def test_an_error_or_interrupt_leaves_the_old_file_and_nothing_else(
    tmp_path: Path, old: bytes | None, by_path: bool, error: BaseException
) -> None:
    path = tmp_path / "face.obj"
    if old is not None:
        path.write_bytes(old)

    def write_half() -> None:
        if by_path:
            with replacing_path(path) as temporary:
                temporary.write_bytes(b"half of the n")
                raise error
        with replacing(path) as file:
            file.write(b"half of the n")
            raise error

    with pytest.raises(type(error)):
        write_half()
    assert [p.read_bytes() for p in tmp_path.iterdir()] == ([] if old is None else [old])


def test_readers_see_the_old_file_until_the_block_ends(tmp_path: Path) -> None:
    path = tmp_path / "face.obj"
    path.write_bytes(b"old")
    with replacing(path) as file:
        file.write(b"new" * 100_000)
        assert path.read_bytes() == b"old"


def test_a_full_disk_is_a_file_error_that_names_the_file(tmp_path: Path) -> None:
    path = tmp_path / "face.obj"
    with pytest.raises(FileError, match=r"face\.obj: .*No space left"), replacing(path):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert list(tmp_path.iterdir()) == []


def test_the_temporary_name_is_beside_the_file_with_its_suffix(tmp_path: Path) -> None:
    with replacing_path(tmp_path / "rig.glb") as temporary:
        assert temporary.parent == tmp_path
        assert temporary.suffix == ".glb"
        assert temporary.is_file()


def test_a_very_long_name_has_room_for_the_temporary_one(tmp_path: Path) -> None:
    path = tmp_path / ("x" * 251 + ".obj")
    with replacing(path) as file:
        file.write(b"new")
    assert path.read_bytes() == b"new"


def test_a_library_that_takes_the_temporary_file_away_is_reported(tmp_path: Path) -> None:
    path = tmp_path / "face.obj"
    path.write_bytes(b"old")
    with pytest.raises(FileError, match="cannot be written"), replacing_path(path) as temporary:
        temporary.unlink()
    assert path.read_bytes() == b"old"


def test_a_complaint_about_the_temporary_name_becomes_one_about_the_file(tmp_path: Path) -> None:
    path = tmp_path / "face.obj"
    with pytest.raises(FormatError) as caught, replacing_path(path) as temporary:
        raise FormatError(temporary, "the name 'a' cannot be written")
    assert str(caught.value) == f"{path}: the name 'a' cannot be written"


def test_a_complaint_about_another_file_stays_as_it_is(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"^texture\.png: "), replacing(tmp_path / "a.glb"):
        raise FileError("texture.png", "there is no such file")


def test_folders_are_not_made(tmp_path: Path) -> None:
    missing = tmp_path / "tpyo"
    with pytest.raises(FileError, match="tpyo does not exist"), replacing(missing / "face.obj"):
        pass
    assert not missing.exists()


def test_a_folder_is_not_replaced(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="this is a folder"), replacing(tmp_path):
        pass


@posix
def test_a_device_is_not_replaced() -> None:
    with pytest.raises(FileError, match="device or a pipe"), replacing("/dev/null"):
        pass
    assert stat.S_ISCHR(Path("/dev/null").stat().st_mode)


@posix
def test_a_link_stays_and_what_it_points_to_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    target = tmp_path / "real" / "face.obj"
    target.write_bytes(b"old")
    link = tmp_path / "link.obj"
    link.symlink_to(target)
    with replacing(link) as file:
        file.write(b"new")
    assert link.is_symlink()
    assert target.read_bytes() == b"new"


@posix
def test_a_new_file_has_the_permissions_of_any_new_file(tmp_path: Path) -> None:
    plain = tmp_path / "plain"
    plain.touch()
    with replacing(tmp_path / "ours"):
        pass
    assert (tmp_path / "ours").stat().st_mode == plain.stat().st_mode


@posix
def test_a_replaced_file_keeps_its_permissions(tmp_path: Path) -> None:
    path = tmp_path / "face.obj"
    path.touch(mode=0o640)
    path.chmod(0o640)
    with replacing(path) as file:
        file.write(b"new")
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


@posix
@not_root
def test_protected_files_and_folders_are_respected(tmp_path: Path) -> None:
    path = tmp_path / "face.obj"
    path.write_bytes(b"old")
    path.chmod(0o444)
    with pytest.raises(FileError, match="write-protected"), replacing(path):
        pass
    path.chmod(0o000)
    with pytest.raises(FileError, match="no permission to read"):
        read_bytes(path)
    tmp_path.chmod(0o555)
    try:
        with pytest.raises(FileError, match="no permission to write"), replacing(tmp_path / "b"):
            pass
    finally:
        tmp_path.chmod(0o755)


def test_reading_gives_the_content(tmp_path: Path) -> None:
    path = tmp_path / "a.bin"
    path.write_bytes(bytes(range(256)))
    assert read_bytes(path) == read_bytes(str(path)) == bytes(range(256))


def test_reading_what_is_not_there_says_what_is_missing(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"face\.obj: there is no such file"):
        read_bytes(tmp_path / "face.obj")
    with pytest.raises(FileError, match=r"the folder .*tpyo does not exist"):
        read_bytes(tmp_path / "tpyo" / "face.obj")


def test_reading_a_folder_or_an_impossible_name_is_a_file_error(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="this is a folder"):
        read_bytes(tmp_path)
    with pytest.raises(FileError, match="null"):
        read_bytes("a\0b")
    with pytest.raises(FileError, match="null"), replacing("a\0b"):
        pass


@posix
def test_reading_a_device_or_pipe_does_not_hang(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe.obj"
    os.mkfifo(pipe)
    for path in (pipe, Path("/dev/zero")):
        with pytest.raises(FileError, match="device or a pipe"):
            read_bytes(path)


@posix
def test_links_that_lead_in_circles_are_a_file_error(tmp_path: Path) -> None:
    loop = tmp_path / "loop.obj"
    loop.symlink_to(loop)
    with pytest.raises(FileError):
        read_bytes(loop)
    with pytest.raises(FileError), replacing(loop):
        pass


def test_an_error_of_the_system_while_reading_is_a_file_error(tmp_path: Path) -> None:
    path = tmp_path / "a.bin"
    path.write_bytes(b"1")
    with pytest.raises(FileError, match=r"a\.bin: the file cannot be read"), opened(path):
        raise OSError(errno.EIO, os.strerror(errno.EIO))


def test_a_file_compressed_with_gzip_says_so(tmp_path: Path) -> None:
    (tmp_path / "face.obj").write_bytes(gzip.compress(b"v 0 0 0"))
    with pytest.raises(FormatError, match=r"face\.obj: this file is compressed with gzip; unpack"):
        read_bytes(tmp_path / "face.obj")


@pytest.mark.parametrize("path", ["~/face.obj", "~nobody/face.obj", "~"])
def test_the_sign_of_the_home_folder_is_explained(path: str) -> None:
    """Python does not read it as a shell does."""
    with pytest.raises(FileError, match=r"stands for a home folder in a shell only"):
        read_bytes(path)


def test_a_file_that_grows_while_it_is_read_is_read_as_it_is_found(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"1" * 10)
    with opened(path) as file:
        assert file.read(4) == b"1111"
        with path.open("ab") as more:
            more.write(b"2")
        assert file.read() == b"1111112"


def test_what_cannot_be_asked_is_not_there(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"12")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    assert is_file(tmp_path / "a")
    assert is_folder(tmp_path)
    assert size_of(tmp_path / "a") == 2
    for odd in ("n" * 300, "n/" * 3000, "a\0", "a/b", "loop", "gone"):
        assert not is_file(tmp_path / odd)
        assert not is_folder(tmp_path / odd)
        assert size_of(tmp_path / odd) == 0
