"""Every movement of a take evaluated: onsets and offsets apart, and their means."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from elastomorph.curves import CurveNetwork
from elastomorph.errors import ParameterError
from elastomorph.evaluation.evaluation import AnyMethod, evaluate
from elastomorph.evaluation.results import Evaluation
from elastomorph.evaluation.segments import Movement, find_movements
from elastomorph.evaluation.summary import MethodSummary, mean_summaries
from elastomorph.model.sequence import MeshSequence

__all__ = ["JudgedMovement", "evaluate_movements", "mean_lines"]


@dataclass(frozen=True, eq=False)
class JudgedMovement:
    """One movement and how the methods did on it.

    Attributes:
        movement: Where it is in the take.
        evaluation: The methods compared with it.
    """

    movement: Movement
    evaluation: Evaluation


def evaluate_movements(
    take: MeshSequence,
    curves: CurveNetwork,
    methods: Callable[[MeshSequence], Sequence[AnyMethod] | Mapping[str, AnyMethod]],
    *,
    edge: float = 0.05,
    progress: Callable[[str], None] = lambda _: None,
) -> list[JudgedMovement]:
    """Find the movements of a take and evaluate methods on each.

    Args:
        take: A recorded take, rigid motion of the head removed.
        curves: The curves errors are measured along.
        methods: The methods for one movement; scanned in-betweens differ from one to the next.
        edge: Share of the rise cut off at either end, see `find_movements`.
        progress: Told which movement is being evaluated.

    Raises:
        ParameterError: The take holds no movement.
    """
    movements = find_movements(take.frames, edge=edge)
    if not movements:
        raise ParameterError(
            "no movement was found: from rest to an apex and back, of at least 0.5 % of D"
        )
    judged = []
    for number, move in enumerate(movements, start=1):
        progress(f"{move.kind} {move.start}-{move.stop} ({number} of {len(movements)})")
        part = take.part(move.start, move.stop)
        judged.append(JudgedMovement(move, evaluate(part, methods(part), curves)))
    return judged


def mean_lines(judged: Sequence[JudgedMovement]) -> dict[str, list[MethodSummary]]:
    """The mean of each error over the onsets, the offsets and all movements, by title."""
    groups = {
        "onsets": [one for one in judged if one.movement.kind == "onset"],
        "offsets": [one for one in judged if one.movement.kind == "offset"],
        "movements": list(judged),
    }
    return {
        f"Mean over {len(group)} {kind}": mean_summaries([one.evaluation for one in group])
        for kind, group in groups.items()
        if group
    }
