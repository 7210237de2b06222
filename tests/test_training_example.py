"""The example that trains on a data set: it learns, and what ignoring the bends costs shows."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

from needs import extra, installed

pytestmark = pytest.mark.documentation

installed("zarr", "farm")
EXAMPLE = Path(__file__).parents[1] / "examples" / "landmarks_to_weights.py"


@pytest.mark.parametrize("by", ["numpy", "torch"])
def test_it_learns_the_faces_it_was_shown(by: str) -> None:
    if by == "torch":
        extra("torch", "torch")
    spec = importlib.util.spec_from_file_location("landmarks_to_weights", EXAMPLE)
    assert spec is not None
    assert spec.loader is not None
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    words = ["--faces", "4000", *(["--without-torch"] if by == "numpy" else [])]
    table = {pair: vertices for pair, (_, vertices) in example.main(words).items()}
    assert table["bent", "bent"] < table["none", "bent"] / (20 if by == "numpy" else 2)
    if by == "numpy":
        assert table["linear", "bent"] > 2 * table["bent", "bent"]
