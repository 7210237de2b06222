"""Archives made to harm: bombs, lying headers, pickles, and arrays that contradict each other."""

from __future__ import annotations

import io
import struct
import warnings
import zipfile
from collections.abc import Iterator, Mapping
from random import Random
from typing import Any

import numpy as np

from hostile.byte_changes import MOST_BYTES

__all__ = ["archive", "archive_files", "arrays_of", "damaged_arrays"]

_DEFLATED = zipfile.ZIP_DEFLATED


def arrays_of(content: bytes) -> dict[str, np.ndarray]:
    """The arrays of an archive."""
    with np.load(io.BytesIO(content)) as found:
        return dict(found)


def archive(members: Mapping[str, Any], method: int = zipfile.ZIP_STORED) -> bytes:
    """An archive of arrays, or of raw bytes where those are given."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as packed:
        for name, value in members.items():
            raw = value if isinstance(value, bytes) else npy(value)
            packed.writestr(zipfile.ZipInfo(f"{name}.npy"), raw, method)
    return file.getvalue()


def npy(array: Any) -> bytes:
    """An array as a member of an archive."""
    file = io.BytesIO()
    np.lib.format.write_array(file, np.asarray(array), allow_pickle=True)
    return file.getvalue()


def headed(header: str, body: bytes = b"", version: tuple[int, int] = (1, 0)) -> bytes:
    """A member with any header."""
    text = header.encode("latin-1", "replace")
    length = struct.pack("<H" if version == (1, 0) else "<I", len(text))
    return b"\x93NUMPY" + bytes(version) + length + text + body


def archive_files(members: Mapping[str, np.ndarray], main: str) -> Iterator[tuple[str, bytes]]:
    """Archives, each with what it is.

    Args:
        members: Arrays that make a whole archive.
        main: Name of the array of positions.
    """
    shape = members[main].shape
    for name, array in members.items():
        rest = {key: value for key, value in members.items() if key != name}
        yield f"without {name}", archive(rest)
        for label, strange in _strange_arrays(array):
            yield f"{name} {label}", archive({**rest, name: strange})
        for label, raw in _strange_headers(array):
            yield f"{name} {label}", archive({**rest, name: raw})
    for kind in ("f2", "i1", "u1", "f4", "f8"):
        rows = 400_000_000 // (np.dtype(kind).itemsize * max(1, int(np.prod(shape[:-2])) * 3))
        dense = (*shape[:-2], rows, 3)
        yield f"{main} of 400 MB of zeros as {kind}", _bomb(members, main, dense, kind)
    for mega in (2, 4, 6, 8, 10, 15, 20, 30, 40, 60, 90):
        for kind in ("i1", "f4", "f8"):
            rows = (mega << 20) // (np.dtype(kind).itemsize * max(1, int(np.prod(shape[:-2])) * 3))
            yield (
                f"{main} of {mega} MB of zeros as {kind}",
                _bomb(members, main, (*shape[:-2], rows, 3), kind, 850_000),
            )
    for name, array in members.items():
        if array.ndim == 1:
            kind = "<U1" if array.dtype.kind == "U" else array.dtype.str
            for length in (300_000, 1_000_000, 4_000_000, 8_000_000):
                yield f"{length:,} of {name}", _bomb(members, name, (length,), kind, 900_000)
    text = next((name for name, array in members.items() if array.dtype.kind == "U"), None)
    if text is not None:
        yield (
            f"{text} of no characters",
            archive({**members, text: headed(_header("<U0", (3,)))}),
        )
        yield (
            f"{text} of no characters, often",
            archive(
                {
                    **members,
                    text: headed(
                        "{'descr': '<U0', 'fortran_order': False, 'shape': (1000000000,)}"
                    ),
                }
            ),
        )
        wide = _bomb(members, text, (1,), "<U10000000")
        yield f"one long text in {text}", wide
    yield "many members", archive({**members, **{f"m{i}": b"" for i in range(7000)}})
    for method in (zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA):
        yield f"packed by method {method}", archive(members, method)
        zeros = np.zeros((*shape[:-2], 12_000_000, 3), "f4")
        yield f"a bomb packed by method {method}", archive({**members, main: zeros}, method)
        del zeros
    whole = archive(members)
    yield "an archive in an archive", archive({main: whole})
    yield "text before the archive", b"#!/bin/sh\n" * 100 + whole
    yield "text behind the archive", whole + b"text " * 1000
    yield "names of folders", archive({f"../{name}": value for name, value in members.items()})
    twice = io.BytesIO(whole)
    with zipfile.ZipFile(twice, "a") as packed, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        packed.writestr(f"{main}.npy", npy(np.zeros((2, 3))))
    yield "a name twice", twice.getvalue()
    yield "no archive but an array", npy(members[main])
    for place in _places(whole, b"PK\x01\x02"):
        for offset, label in ((20, "packed size"), (24, "size"), (42, "place"), (10, "method")):
            for value in (0, 1, 0x7FFFFFFF, 0xFFFFFFFE, 0xFFFFFFFF):
                lying = bytearray(whole)
                if offset == 10:
                    struct.pack_into("<H", lying, place + offset, value & 0xFFFF)
                else:
                    struct.pack_into("<I", lying, place + offset, value)
                yield f"a lying {label} of {value}", bytes(lying)
    end = whole.rfind(b"PK\x05\x06")
    for offset in (8, 10, 12, 16, 20):
        for value in (0, 1, 0xFFFF):
            lying = bytearray(whole)
            struct.pack_into("<H", lying, end + offset, value)
            yield f"a lying directory at {offset}", bytes(lying)
    packed_well = archive(members, _DEFLATED)
    for mark in (b"PK\x01\x02", b"PK\x03\x04"):
        for place in _places(packed_well, mark)[:2]:
            lying = bytearray(packed_well)
            flag = place + (8 if mark == b"PK\x01\x02" else 6)
            lying[flag] |= 1
            yield "a password", bytes(lying)


def damaged_arrays(random: Random, members: Mapping[str, np.ndarray]) -> tuple[str, bytes]:
    """An intact archive of arrays of which one or two hold something else."""
    own, labels = dict(members), []
    for _ in range(random.choice((1, 1, 2))):
        name = random.choice(list(own))
        array = own[name]
        array = array.copy() if isinstance(array, np.ndarray) else array
        if isinstance(array, bytes):
            continue
        if array.size and random.random() < 0.7 and array.dtype.kind in "fiu":
            values: tuple[Any, ...] = (0, 1, -1, 2, 3, 127, 1000, 2**31 - 1, -(2**31))
            if array.dtype.kind == "f":
                values += (np.nan, np.inf, -np.inf, 1e308, -1e308, 5e-324, 0.5)
            value = random.choice(values)
            place = random.randrange(array.size)
            with np.errstate(all="ignore"):
                array.reshape(-1)[place] = np.array(value).astype(array.dtype)
            labels.append(f"{name}[{place}] = {value}")
        else:
            label, array = random.choice(_strange_arrays(array))
            labels.append(f"{name} {label}")
        own[name] = array
    return ", ".join(labels), archive(own, random.choice((zipfile.ZIP_STORED, _DEFLATED)))


@np.errstate(all="ignore")
def _strange_arrays(array: np.ndarray) -> list[tuple[str, Any]]:
    found: list[tuple[str, Any]] = [
        ("pickled", np.array([{"a": 1}, None], dtype=object)),
        ("of records", np.zeros(3, dtype=[("x", "f8"), ("y", "i4")])),
        ("complex", np.zeros(array.shape, dtype=complex)),
        ("of truths", np.zeros(array.shape, dtype=bool)),
        ("of dates", np.zeros(array.shape, dtype="M8[s]")),
        ("of bytes", np.zeros(array.shape, dtype="S4")),
        ("of texts", np.full(array.shape, "a\0b")),
        ("one number", np.array(1)),
        ("empty", array[:0] if array.ndim else np.zeros(0)),
        ("twice as long", np.concatenate([array, array]) if array.ndim else np.zeros((2, 2))),
        ("one shorter", array[:-1] if array.ndim else np.zeros(())),
        ("one dimension more", array[None]),
        ("flat", array.reshape(-1)),
        ("turned", np.asfortranarray(array.T)),
        ("whole numbers", array.astype("i8") if array.dtype.kind in "fiu" else np.arange(3)),
        ("big-endian", array.astype(array.dtype.newbyteorder(">"))),
    ]
    if array.dtype.kind in "fiu":
        found.append(("of long floats", array.astype(np.longdouble)))
        found.append(("of huge long floats", array.astype(np.longdouble) + np.longdouble("1e4000")))
        found.append(("of half floats", array.astype("f2")))
        found.append(("of unsigned numbers", np.full(array.shape, 2**64 - 1, dtype="u8")))
        found.append(("of least numbers", np.full(array.shape, -(2**63), dtype="i8")))
        found.append(("of ones", np.ones_like(array)))
        found.append(("negative", -array.astype("i8")))
    if array.dtype.kind == "f":
        for value in (np.nan, np.inf, -np.inf, 1e308, -1e308, 5e-324):
            found.append((f"of {value}", np.full_like(array, value)))
        mixed = np.full(array.shape, 1.7e308)
        mixed.reshape(-1)[::2] *= -1
        found.append(("of huge numbers of both signs", mixed))
    if array.dtype.kind == "U":
        for code in (0xD800, 0x110000, 0xFFFFFFFF, 0):
            raw = np.full(max(array.size, 1), code, dtype="<u4").view("<U1")
            found.append((f"of the character {code:x}", _as_raw(raw, array)))
        found.append(("all the same", np.full(array.shape, "same")))
    return found


def _as_raw(raw: np.ndarray, array: np.ndarray) -> bytes:
    return headed(_header("<U1", array.shape), raw.tobytes())


def _header(descr: Any, shape: tuple[int, ...]) -> str:
    return repr({"descr": descr, "fortran_order": False, "shape": shape})


def _strange_headers(array: np.ndarray) -> Iterator[tuple[str, bytes]]:
    body = array.tobytes()
    descr, shape = array.dtype.str, array.shape
    for label, kind, size in (
        ("endless", descr, (10**12,)),
        ("beyond 64 bits", descr, (0, 10**30, 3)),
        ("less than nothing", descr, (-1, -3)),
        ("minus twice", descr, (-2, -2, 3)),
        ("of objects", "|O", shape),
        ("of arrays", (descr, (3,)), shape),
        ("of void", "|V1000000000", shape),
    ):
        yield f"header {label}", headed(_header(kind, size), body)
    for label, header in (
        ("nested", "(" * 9000),
        ("negated", "-" * 9000 + "1"),
        ("called", "__import__('os').system('true')"),
        ("without shape", f"{{'descr': '{descr}', 'fortran_order': False}}"),
        ("with more", _header(descr, shape)[:-1] + ", 'x': 1}"),
        ("long", _header(descr, shape) + " " * 60000),
    ):
        yield f"header {label}", headed(header, body)
    yield "of version 3", headed(f"{{'descr': '{descr}'}}", body, (3, 0))
    yield "of version 9", headed(f"{{'descr': '{descr}'}}", body, (9, 9))
    yield "cut", npy(array)[:-1]
    yield "with more behind", npy(array) + b"\0"
    yield (
        "with a pickle for body",
        headed(
            _header("|O", shape),
            b"cos\nsystem\n(S'touch /tmp/elastomorph-unpickled'\ntR.",
        ),
    )


def _bomb(
    members: Mapping[str, np.ndarray],
    name: str,
    shape: tuple[int, ...],
    kind: str,
    padding: int = 0,
) -> bytes:
    """The archive with one array of zeros, deflated as it is made, so that it costs nothing."""
    header = {"descr": np.dtype(kind).newbyteorder("<").str, "fortran_order": False, "shape": shape}
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", _DEFLATED) as packed:
        for other, array in members.items():
            if other != name:
                packed.writestr(f"{other}.npy", npy(array))
        # An archive may unpack to more, the larger it is.
        packed.writestr("padding.npy", Random(0).randbytes(padding), zipfile.ZIP_STORED)
        with packed.open(f"{name}.npy", "w", force_zip64=True) as member:
            np.lib.format.write_array_header_1_0(member, header)
            left = int(np.prod(shape, dtype=object)) * np.dtype(kind).itemsize
            block = bytes(1 << 20)
            while left > 0:
                member.write(block[: min(left, len(block))])
                left -= len(block)
    return file.getvalue()[:MOST_BYTES]


def _places(content: bytes, mark: bytes) -> list[int]:
    found, place = [], content.find(mark)
    while place >= 0:
        found.append(place)
        place = content.find(mark, place + 1)
    return found
