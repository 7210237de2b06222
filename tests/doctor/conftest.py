"""The small head with a few of its shapes: a sound rig to plant faults in."""

from __future__ import annotations

import pytest

from elastomorph.model.mesh import Mesh
from small_head import head, shapes

SOUND = (
    "browInnerUp",
    "eyeBlink_L",
    "eyeBlink_R",
    "mouthLeft",
    "mouthRight",
    "mouthSmile_L",
    "mouthSmile_R",
)


@pytest.fixture(scope="session")
def face() -> Mesh:
    """The small head."""
    return head()


@pytest.fixture
def rig() -> dict[str, Mesh]:
    """Shapes of the head by file."""
    return {f"{name}.obj": shapes()[name] for name in SOUND}
