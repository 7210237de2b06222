"""Packets are read as they were written, and everything else is refused in words."""

from __future__ import annotations

import struct
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from elastomorph.live import FacePacket, PacketError, decode, encode
from elastomorph.live.packets import COLUMNS, MOST_BYTES, NAMES
from streams import packet, weights

printable = st.text(st.characters(categories=["L", "N", "P"]), min_size=1, max_size=40)
single = st.floats(-10, 10, width=32)
packets = st.builds(
    FacePacket,
    device=st.just("") | printable,
    subject=printable,
    frame=st.integers(0, 2**31 - 1),
    subframe=st.floats(0, 1, width=32, exclude_max=True),
    rate=st.sampled_from([(60, 1), (30, 1), (24, 1), (30000, 1001), (60000, 1001)]),
    weights=st.just(()) | st.tuples(*[single] * len(NAMES)),
)


@given(packets)
def test_what_is_encoded_is_decoded(one: FacePacket) -> None:
    assert decode(encode(one)) == one


def test_the_layout_is_that_of_the_app() -> None:
    """Byte by byte, as PyLiveLinkFace and LLV describe it: 312 bytes for the name iPhone."""
    device, subject = b"0123456789abcdef0123456789abcdef0123", b"iPhone"
    own = [i / 64 for i in range(61)]
    content = (
        b"\x06\x00\x00\x00\x24"
        + device
        + b"\x00\x00\x00\x06"
        + subject
        + struct.pack(">i", 1_234_567)
        + struct.pack(">f", 0.25)
        + struct.pack(">ii", 60, 1)
        + b"\x3d"
        + struct.pack(">61f", *own)
    )
    assert len(content) == 312
    found = decode(content)
    assert (found.device, found.subject) == (device.decode(), "iPhone")
    assert (found.count, found.per_second, found.weights) == (1_234_567.25, 60, tuple(own))
    assert encode(found) == content


def test_jaw_and_mouth_are_the_other_way_round_in_takes() -> None:
    """The engine's enumeration has left before right, the app's own files right before left."""
    assert NAMES[14:18] == ("JawForward", "JawLeft", "JawRight", "JawOpen")
    assert NAMES[21:23] == ("MouthLeft", "MouthRight")
    assert COLUMNS[14:18] == ("JawForward", "JawRight", "JawLeft", "JawOpen")
    assert COLUMNS[21:23] == ("MouthRight", "MouthLeft")
    assert set(NAMES) == set(COLUMNS)
    assert len(NAMES) == 61


@pytest.mark.parametrize("end", [b"", b"\0"])
def test_without_a_face_there_are_no_weights(end: bytes) -> None:
    content = encode(packet(7))[: -1 - 4 * 61]
    assert decode(content + end).weights == ()


def test_a_rate_whose_denominator_was_left_out() -> None:
    assert decode(encode(packet(7, rate=(30, 0)))).rate == (30, 1)


@given(st.integers(0, 309))
def test_no_part_of_a_packet_is_a_packet(length: int) -> None:
    whole = encode(packet(9, device="0123456789abcdef0123456789abcdef0123"))
    ends_before_weights = len(whole) - 1 - 4 * 61
    if length == ends_before_weights:
        return  # that is what an app sends without a face
    with pytest.raises(PacketError):
        decode(whole[:length])


@given(st.binary(max_size=MOST_BYTES + 20))
def test_any_bytes_are_refused_in_words(content: bytes) -> None:
    """Six as the first byte is where the reading begins; bytes by chance are never a packet."""
    for own in (content, b"\x06" + content):
        with pytest.raises(PacketError) as refusal:
            decode(own)
        assert str(refusal.value).isprintable()


@given(st.integers(0, 311), st.integers(1, 255))
def test_a_changed_byte_gives_a_packet_or_a_refusal(place: int, change: int) -> None:
    content = bytearray(encode(packet(9, device="0123456789abcdef0123456789abcdef0123")))
    content[place] ^= change
    with suppress(PacketError):
        found = decode(bytes(content))
        assert all(-10 <= weight <= 10 for weight in found.weights)
        assert found.subject.isprintable()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "it is empty"),
        (b"\x01" + bytes(583), "version 1, expected 6; in the app choose"),
        (bytes([6]) * (MOST_BYTES + 1), "longer than any"),
        (encode(packet(1)) + b"\0", "has 245 bytes of weights, expected 244 for 61"),
        (encode(packet(1))[:-4], "has 240 bytes of weights, expected 244 for 61"),
        (encode(packet(1))[:9], "before the subj"),
        (encode(packet(1, subject=" ")), "the subject has no name"),
        (encode(packet(1, subject="a\x1b[2J")), "cannot be printed"),
        (encode(packet(1, subject="a" * 256)), "256 bytes, expected at most 255"),
        (encode(packet(1, subject="\xe9")).replace(b"\xc3\xa9", b"\xe9\xe9"), "no text in UTF-8"),
        (encode(packet(-1)), "its frame is -1"),
        (encode(packet(1, rate=(0, 1))), "its rate is 0/1"),
        (encode(packet(1, rate=(-60, -1))), "its rate is -60/-1"),
        (encode(packet(1, rate=(60_000, 1))), "its rate is 60000/1"),
        (encode(packet(1, face=weights(JawOpen=float("nan")))), "JawOpen is nan"),
        (encode(packet(1, face=weights(HeadYaw=float("-inf")))), "HeadYaw is -inf"),
        (encode(packet(1, face=weights(TongueOut=11))), "TongueOut is 11, expected a number"),
        (encode(packet(1)).replace(b"\x3d\0", b"\x3c\0", 1), "announces 60 weights, expected 61"),
    ],
)
def test_refusals_say_why(content: bytes, words: str) -> None:
    with pytest.raises(PacketError, match=words):
        decode(content)
