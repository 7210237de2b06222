"""PyTorch gives the faces of NumPy, and their derivatives."""

from __future__ import annotations

import numpy as np
import pytest

import elastomorph as em
from elastomorph.rig import Rig
from needs import extra

torch = extra("torch", "torch")

from elastomorph.rig.torch_module import RigModule  # noqa: E402


def test_backend_gives_the_same_faces(rig: Rig) -> None:
    rows = np.random.default_rng(0).random((7, 5))
    numpy = rig.batch(rows, 0.4)
    assert np.abs(rig.batch(rows, 0.4, backend="torch") - numpy).max() < 1e-5 * rig.neutral.diameter


@pytest.mark.parametrize("times", [None, 0.4, 1.3])
def test_module_gives_the_same_faces(small: Rig, times: float | None) -> None:
    driven = Rig(small.neutral, small.morphs, correctives={"c": ("a", "c")})
    rows = np.random.default_rng(1).uniform(-0.4, 1.4, (6, 3))
    module = RigModule(driven, torch.float64)
    when = None if times is None else torch.tensor(times, dtype=torch.float64)
    faces = module(torch.from_numpy(rows), when).numpy()
    np.testing.assert_allclose(faces, driven.batch(rows, times, dtype=np.float64), atol=1e-12)


LAWS = [
    *(em.Corrective(("a", "b"), law) for law in ("min", "allMul", "extMul", "mulAvgExt")),
    em.Corrective(("a", "b", "c"), "mulAvgAll"),
    em.Corrective(("b", "a"), "hinge", (0.5, 1.5)),
    em.Corrective(("a", "b"), "softmin", (3.0,)),
]


@pytest.mark.parametrize("law", LAWS, ids=lambda own: own.law)
def test_correctives_follow_their_laws(small: Rig, law: em.Corrective) -> None:
    """Below 0, at 0, at ties and above 1 too, with derivatives that are numbers."""
    driven = Rig(small.neutral, small.morphs, correctives={"c": law})
    rows = np.random.default_rng(2).uniform(-0.4, 1.4, (12, len(driven.names)))
    rows[:3] = [[0.0], [0.6], [1.0]]
    weights = torch.tensor(rows, requires_grad=True)
    faces = RigModule(driven, torch.float64)(weights)
    expected = driven.batch(rows, dtype=np.float64)
    np.testing.assert_allclose(faces.detach().numpy(), expected, atol=1e-12)
    assert torch.isfinite(torch.autograd.grad(faces.sum(), weights)[0]).all()


def test_gradient_is_the_velocity(small: Rig) -> None:
    module = RigModule(small, torch.float64)
    rows = torch.tensor([[0.3, 0.0, 0.8]], dtype=torch.float64, requires_grad=True)
    out = module(rows)
    gradient = torch.autograd.grad(out[0, 5, 1], rows)[0][0].numpy()
    at = {"a": 0.3, "c": 0.8}
    expected = [small.velocity(at, {name: 1.0})[5, 1] for name in "abc"]
    np.testing.assert_allclose(gradient, expected, atol=1e-12)


def test_a_face_is_fitted_back(small: Rig) -> None:
    """Gradient descent finds the weights a face was made with."""
    module = RigModule(small, torch.float64)
    wanted = torch.tensor([[0.2, 0.7, 0.5]], dtype=torch.float64)
    face = module(wanted)
    rows = torch.full((1, 3), 0.4, dtype=torch.float64, requires_grad=True)
    solver = torch.optim.LBFGS([rows], max_iter=100, line_search_fn="strong_wolfe")

    def closure() -> torch.Tensor:
        solver.zero_grad()
        loss = ((module(rows) - face) ** 2).sum()
        loss.backward()
        return loss

    solver.step(closure)
    np.testing.assert_allclose(rows.detach().numpy(), wanted.numpy(), atol=1e-4)
