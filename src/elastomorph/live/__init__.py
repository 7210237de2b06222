"""Live: the face of a phone's Live Link Face in the viewer, as it moves.

`LivePage` serves a rig and shows on it what comes by UDP; `Replay` sends a recorded take as a phone
would.
"""

from __future__ import annotations

from elastomorph.live.packets import FacePacket, PacketError, decode, encode
from elastomorph.live.replay import Replay, Weather
from elastomorph.live.serving import PORT, LivePage, require_possible

__all__ = [
    "PORT",
    "FacePacket",
    "LivePage",
    "PacketError",
    "Replay",
    "Weather",
    "decode",
    "encode",
    "require_possible",
]
