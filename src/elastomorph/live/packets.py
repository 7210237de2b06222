"""Packets of Live Link Face in its mode for ARKit, one a frame, as they come by UDP.

All numbers are big-endian::

    uint8    6, the version of the layout
    int32 n, n bytes    id of the phone
    int32 n, n bytes    subject name, as people wrote it in the app
    int32, float32      frame since midnight, and the part of a frame beyond it
    int32, int32        frames a second, as a fraction
    uint8    61, the number of weights; 0, or the end of the packet, where no face is seen
    61 x float32        52 shapes of ARKit, then nine angles of head and eyes in radians

Jaw and mouth come with their left shape first, and with the right one first in takes (.csv) of the
same app. So the format is described by those who read it: JimWest/PyLiveLinkFace and think-biq/LLV
on GitHub, whose lists of shapes are the enumeration EARFaceBlendShape of Unreal Engine. Versions 1
to 5 of the layout were those of sample apps before Live Link Face. In its other mode, MetaHuman
Animator, the app sends 584 bytes with 269 controls of a MetaHuman instead of shapes, which is all
that RamesTheGeneric/LiveLinkFace_MH_CTRL there has found out about many of them.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from elastomorph.errors import ParameterError
from elastomorph.rig.naming import ARKIT

VERSION = 6
MOST_BYTES = 1024
"""No packet is longer; one that is cannot be."""

_LONGEST_NAME = 255
_FARTHEST = 10.0
_FASTEST = 1000.0
_TIME = struct.Struct("!ifii")
_LENGTH = struct.Struct("!i")

_ANGLES = tuple(
    f"{of}{axis}" for of in ("Head", "LeftEye", "RightEye") for axis in ("Yaw", "Pitch", "Roll")
)
COLUMNS = tuple(name[0].upper() + name[1:] for name in ARKIT) + _ANGLES
"""The weights in the order of takes (.csv)."""

_OTHER_SIDE = {"JawRight": "JawLeft", "MouthRight": "MouthLeft"}
_OTHER_SIDE |= {left: right for right, left in _OTHER_SIDE.items()}
NAMES = tuple(_OTHER_SIDE.get(name, name) for name in COLUMNS)
"""The weights in the order of packets."""

_WEIGHTS = struct.Struct(f"!{len(NAMES)}f")


class PacketError(ParameterError):
    """Bytes that are no packet of Live Link Face; the sentence says why."""


@dataclass(frozen=True, slots=True)
class FacePacket:
    """One frame of one phone.

    Attributes:
        device: Id of the phone, which stays the same.
        subject: Its name, as people chose it.
        frame: Frames since midnight.
        subframe: Part of a frame beyond that, 0 to below 1.
        rate: Frames a second that are counted, as numerator and denominator.
        weights: In the order of `NAMES`; none where no face is seen.
    """

    device: str
    subject: str
    frame: int
    subframe: float
    rate: tuple[int, int]
    weights: tuple[float, ...]

    @property
    def count(self) -> float:
        """Frames since midnight, with the part of one."""
        return self.frame + self.subframe

    @property
    def per_second(self) -> float:
        """Frames that are counted in a second."""
        return self.rate[0] / self.rate[1]


def decode(packet: bytes) -> FacePacket:
    """What a packet says.

    Raises:
        PacketError: It is none, or one of another layout.
    """
    if len(packet) > MOST_BYTES:
        raise PacketError(f"it is longer than any, above {MOST_BYTES:,} bytes")
    if not packet:
        raise PacketError("it is empty")
    if packet[0] != VERSION:
        raise PacketError(
            f"its layout has the version {packet[0]}, expected {VERSION}; in the app choose the "
            "capture mode 'Live Link (ARKit)'"
        )
    device, place = _text(packet, 1, "the id of the phone")
    subject, place = _text(packet, place, "the subject name")
    if not subject.strip():
        raise PacketError("the subject has no name")
    if len(packet) < place + _TIME.size:
        raise PacketError(f"it ends after {len(packet)} bytes, within its time")
    frame, subframe, numerator, denominator = _TIME.unpack_from(packet, place)
    rate = (numerator, denominator or 1)  # some senders leave it at 0
    _require_time(frame, subframe, rate)
    weights = _weights(packet, place + _TIME.size)
    return FacePacket(device, subject, frame, subframe, rate, weights)


def encode(packet: FacePacket) -> bytes:
    """The bytes of a packet."""
    parts = [bytes([VERSION])]
    for name in (packet.device, packet.subject):
        text = name.encode()
        parts += [_LENGTH.pack(len(text)), text]
    parts.append(_TIME.pack(packet.frame, packet.subframe, *packet.rate))
    parts.append(bytes([len(packet.weights)]))
    if packet.weights:
        parts.append(_WEIGHTS.pack(*packet.weights))
    return b"".join(parts)


def _text(packet: bytes, place: int, what: str) -> tuple[str, int]:
    """A name at a place, and the place behind it."""
    if len(packet) < place + _LENGTH.size:
        raise PacketError(f"it ends after {len(packet)} bytes, before {what}")
    length = _LENGTH.unpack_from(packet, place)[0]
    start = place + _LENGTH.size
    if not 0 <= length <= _LONGEST_NAME:
        raise PacketError(f"{what} has {length:,} bytes, expected at most {_LONGEST_NAME}")
    if len(packet) < start + length:
        raise PacketError(f"it ends after {len(packet)} bytes, within {what}")
    try:
        text = packet[start : start + length].decode()
    except UnicodeDecodeError:
        raise PacketError(f"{what} is no text in UTF-8") from None
    if not text.isprintable():
        raise PacketError(f"{what} has characters that cannot be printed")
    return text, start + length


def _require_time(frame: int, subframe: float, rate: tuple[int, int]) -> None:
    if frame < 0 or not 0 <= subframe < 1:
        raise PacketError(f"its frame is {frame} and {subframe:g}, expected both from 0, below 1")
    numerator, denominator = rate
    if numerator <= 0 or denominator <= 0 or not 1 <= numerator / denominator <= _FASTEST:
        raise PacketError(
            f"its rate is {numerator}/{denominator} frames a second, expected 1 to {_FASTEST:g}"
        )


def _weights(packet: bytes, place: int) -> tuple[float, ...]:
    rest = len(packet) - place
    if rest == 0 or (rest == 1 and packet[place] == 0):
        return ()
    if packet[place] != len(NAMES):
        raise PacketError(f"it announces {packet[place]} weights, expected {len(NAMES)}")
    if rest - 1 != _WEIGHTS.size:
        raise PacketError(
            f"it has {rest - 1} bytes of weights, expected {_WEIGHTS.size} for {len(NAMES)}"
        )
    weights: tuple[float, ...] = _WEIGHTS.unpack_from(packet, place + 1)
    # Written so that what is no number is refused too.
    if not all(-_FARTHEST <= weight <= _FARTHEST for weight in weights):
        first = next(i for i, one in enumerate(weights) if not -_FARTHEST <= one <= _FARTHEST)
        raise PacketError(
            f"{NAMES[first]} is {weights[first]:g}, expected a number within {_FARTHEST:g}"
        )
    return weights
