"""Options of rivals, and that each is what its table says it is."""

from __future__ import annotations

import inspect

import pytest
from sheets import between

import elastomorph as em
from elastomorph.rivals import RIVALS, ElasticSolid, FiniteDifference, FiniteElement, Rival


def test_labels_tell_what_is_not_usual() -> None:
    assert ElasticSolid().label == "elastic-solid"
    assert ElasticSolid("linear", nodes=100).label == "elastic-solid linear nodes=100"
    assert FiniteDifference(closure="rest").label == "finite-difference rest"
    labels = [rival.label for rival in RIVALS]
    assert len(set(labels)) == len(labels)


@pytest.mark.parametrize("rival", RIVALS, ids=lambda rival: rival.label)
def test_each_file_names_its_source_and_what_is_ours(rival: Rival) -> None:
    words = inspect.getdoc(inspect.getmodule(type(rival))) or ""
    assert f"``{rival.name}``" in words
    assert "Ours, where" in words


@pytest.mark.usefixtures("skfem")
def test_an_unknown_elasticity(sheet: em.Mesh) -> None:
    with pytest.raises(em.ParameterError, match="elasticity must be one of corotational, linear"):
        ElasticSolid("rubber").poses(between(sheet, sheet.vertices + 1.0), [0.5])


@pytest.mark.usefixtures("skfem")
@pytest.mark.parametrize("rival", RIVALS, ids=lambda rival: rival.label)
def test_what_is_no_recording_is_refused(rival: Rival) -> None:
    with pytest.raises(em.ParameterError, match="must be a MeshSequence"):
        rival.poses("scan.####.obj", [0.5])  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("kind", "points"),
    [
        *((FiniteDifference, n) for n in (0, 2, 4, -1, 5.5)),
        *((FiniteElement, n) for n in (0, 1, 3)),
    ],
)
def test_points_among_which_vertices_are_not_are_refused(kind: type[Rival], points: int) -> None:
    """They would converge to first order only."""
    with pytest.raises(em.ParameterError):
        kind(points=points)  # type: ignore[call-arg]
