"""Changes to the bytes of a file that know nothing of its format, or only that it holds numbers."""

from __future__ import annotations

import gzip
import re
from collections.abc import Callable
from random import Random

__all__ = ["MOST_BYTES", "changed", "recoded"]

MOST_BYTES = 1_000_000
"""Inputs stay below this, as that is what the limits on time and memory are for."""

_NUMBER = re.compile(rb"-?[0-9]+(?:\.[0-9]*)?(?:[eE][+-]?[0-9]+)?")
_WORDS = (
    b"0 -0 1 -1 2 3 255 256 65535 65536 2147483647 2147483648 -2147483648 4294967295 4294967296 "
    b"9223372036854775807 9223372036854775808 -9223372036854775809 1000000000000000000 1e18 -1e18 "
    b"1e308 1e309 -1e309 1e-320 5e-324 nan NaN -nan inf -Infinity 0x10 1_000 1,5 1.5 .5 5. + - . "
    b"true null [] {} \"\" 'a' \xd9\xa1 ; # \\"
).split(b" ")
_LONG = (b"9" * 5000, b"0" * 5000 + b"1", b"1" * 400, b"0." + b"0" * 400 + b"1")
_RUNS = (b"\0", b"\xff", b" ", b"\n", b"[", b"(", b"{", b"/", b"1", b"\x80", b"\\", b'"')
_INTEGERS = tuple(
    (value % (1 << 8 * width)).to_bytes(width, order)
    for width in (1, 2, 4, 8)
    for order in ("little", "big")
    for value in (0, 1, -1, -2, 1 << (8 * width - 1), (1 << (8 * width - 1)) - 1, 1000)
)


def changed(random: Random, content: bytes, other: bytes) -> tuple[str, bytes]:
    """One to four changes to the content, and what they were.

    Args:
        random: Where chance comes from.
        content: The file.
        other: Another file of the format, to splice with.
    """
    steps = []
    for _ in range(random.choice((1, 1, 1, 2, 2, 3, 4))):
        change = random.choice(_CHANGES)
        content = change(random, content, other)
        steps.append(change.__name__.removeprefix("_"))
    return " + ".join(steps), content[: MOST_BYTES - 1]


def recoded(content: bytes) -> dict[str, bytes]:
    """The content as other programs mangle it: encodings, line ends, compression."""
    text = content.decode("utf-8", "replace")
    return {
        "UTF-16 with mark": text.encode("utf-16"),
        "UTF-16 without mark": text.encode("utf-16-le"),
        "UTF-32": text.encode("utf-32"),
        "UTF-8 with mark": b"\xef\xbb\xbf" + content,
        "UTF-8 with two marks": b"\xef\xbb\xbf" * 2 + content,
        "Latin-1 letters": content.replace(b"a", b"\xe4"),
        "a NUL in the middle": content[: len(content) // 2] + b"\0" + content[len(content) // 2 :],
        "NULs behind": content + bytes(1000),
        "Windows line ends": content.replace(b"\n", b"\r\n"),
        "Mac line ends": content.replace(b"\n", b"\r"),
        "form feeds for line ends": content.replace(b"\n", b"\f"),
        "no line ends": content.replace(b"\n", b" "),
        "compressed with gzip": gzip.compress(content, mtime=0),
        "twice in a row": content * 2,
        "empty": b"",
        "one byte": content[:1],
        "blanks": b" " * 1000,
        "line ends": b"\n" * (MOST_BYTES - 1),
        "one line of blanks": b" " * (MOST_BYTES - 1),
        "a megabyte of zeros": bytes(MOST_BYTES - 1),
        "a megabyte of digits": b"1" * (MOST_BYTES - 1),
        "a megabyte of brackets": b"[" * (MOST_BYTES - 1),
        "a megabyte of quotes": b'"' * (MOST_BYTES - 1),
    }


def _flip_bits(random: Random, content: bytes, other: bytes) -> bytes:
    changed = bytearray(content)
    for _ in range(random.choice((1, 1, 1, 2, 8))):
        if changed:
            changed[random.randrange(len(changed))] ^= 1 << random.randrange(8)
    return bytes(changed)


def _replace_run(random: Random, content: bytes, other: bytes) -> bytes:
    start, stop = _part(random, content)
    run = random.choice(_RUNS) * (stop - start)
    return (
        content[:start]
        + (random.randbytes(stop - start), run)[random.randrange(2)]
        + (content[stop:])
    )


def _replace_integer(random: Random, content: bytes, other: bytes) -> bytes:
    integer = random.choice(_INTEGERS)
    place = random.randrange(len(content) + 1)
    if random.random() < 0.5:
        place -= place % len(integer)
    return content[:place] + integer + content[place + len(integer) :]


def _replace_number(random: Random, content: bytes, other: bytes) -> bytes:
    numbers = list(_NUMBER.finditer(content[:100_000]))
    if not numbers:
        return _replace_integer(random, content, other)
    found = random.choice(numbers)
    new = random.choice(_LONG) if random.random() < 0.1 else random.choice(_WORDS)
    return content[: found.start()] + new + content[found.end() :]


def _insert(random: Random, content: bytes, other: bytes) -> bytes:
    place = random.randrange(len(content) + 1)
    new = random.choice((*_WORDS, *_RUNS, random.randbytes(random.randrange(1, 9))))
    return content[:place] + new + content[place:]


def _leave_out(random: Random, content: bytes, other: bytes) -> bytes:
    start, stop = _part(random, content)
    return content[:start] + content[stop:]


def _repeat(random: Random, content: bytes, other: bytes) -> bytes:
    start, stop = _part(random, content)
    room = max(1, (MOST_BYTES - 1 - len(content)) // max(1, stop - start))
    times = min(room, random.choice((1, 2, 10, 1000, 1_000_000)))
    return content[:start] + content[start:stop] * times + content[start:]


def _swap(random: Random, content: bytes, other: bytes) -> bytes:
    (a, b), (c, d) = sorted((_part(random, content), _part(random, content)))
    if b > c:
        return content
    return content[:a] + content[c:d] + content[b:c] + content[a:b] + content[d:]


def _splice(random: Random, content: bytes, other: bytes) -> bytes:
    place, there = random.randrange(len(content) + 1), random.randrange(len(other) + 1)
    return content[:place] + other[there:]


def _cut(random: Random, content: bytes, other: bytes) -> bytes:
    return content[: random.randrange(len(content) + 1)]


def _swap_lines(random: Random, content: bytes, other: bytes) -> bytes:
    lines = content.split(b"\n")
    a, b = random.randrange(len(lines)), random.randrange(len(lines))
    lines[a], lines[b] = lines[b], lines[a]
    return b"\n".join(lines)


def _repeat_line(random: Random, content: bytes, other: bytes) -> bytes:
    lines = content.split(b"\n")
    place = random.randrange(len(lines))
    times = random.choice((1, 2, 100, 100_000))
    times = min(times, (MOST_BYTES - len(content)) // (len(lines[place]) + 1))
    return b"\n".join([*lines[:place], *[lines[place]] * times, *lines[place:]])


def _part(random: Random, content: bytes) -> tuple[int, int]:
    length = min(len(content), random.choice((1, 1, 2, 4, 8, 30, 200, len(content))))
    start = random.randrange(len(content) - length + 1)
    return start, start + length


_CHANGES: tuple[Callable[[Random, bytes, bytes], bytes], ...] = (
    _flip_bits,
    _flip_bits,
    _replace_run,
    _replace_integer,
    _replace_integer,
    _replace_number,
    _replace_number,
    _replace_number,
    _insert,
    _leave_out,
    _repeat,
    _swap,
    _splice,
    _cut,
    _swap_lines,
    _repeat_line,
)
