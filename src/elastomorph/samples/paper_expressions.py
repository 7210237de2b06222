"""The paper's five expressions, composed of ARKit-named shapes (Sec. 4.4)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from elastomorph.model.mesh import Mesh
from elastomorph.rig.naming import shape_of

EXPRESSIONS: dict[str, dict[str, float]] = {
    "sad": {"mouthFrown": 1.0, "browInnerUp": 1.0, "mouthShrugLower": 0.4},
    "angry": {"browDown": 1.0, "noseSneer": 0.8, "mouthPress": 0.6, "eyeSquint": 0.5},
    "confused": {"browOuterUpLeft": 1.0, "browDownRight": 0.8, "mouthLeft": 0.6},
    "grinning": {"mouthSmile": 1.0, "cheekSquint": 0.7, "mouthUpperUp": 0.4},
    "puff": {"cheekPuff": 1.0, "mouthPress": 0.5},
}
"""The five expressions as weights of shapes; a name without a side stands for both."""


def sided(name: str, known: Iterable[str]) -> list[str]:
    """The shapes that a name stands for, in whatever spelling: itself, or its left and right."""
    wanted = (name, f"{name}Left", f"{name}Right")
    return [each for each in known if each == name or shape_of(each) in wanted]


def compose_expressions(neutral: Mesh, targets: Mapping[str, Mesh]) -> dict[str, Mesh]:
    """The five expressions as sums of weighted displacements of a rig's shapes.

    Args:
        neutral: The face at rest.
        targets: Shapes by name; those the rig lacks are left out.

    Returns:
        The expressions that move anything.
    """
    expressions: dict[str, Mesh] = {}
    for name, recipe in EXPRESSIONS.items():
        vertices = neutral.vertices.copy()
        for shape, weight in recipe.items():
            for target in sided(shape, targets):
                vertices += weight * (targets[target].vertices - neutral.vertices)
        if (vertices != neutral.vertices).any():
            expressions[name] = neutral.with_vertices(vertices)
    return expressions
