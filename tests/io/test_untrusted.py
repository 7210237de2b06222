"""The memory a file may take follows its size, and stays below 256 MB for one under a megabyte."""

from __future__ import annotations

import pytest

from elastomorph.errors import FormatError
from elastomorph.io.untrusted import MemoryBudget, allowed_memory


def test_a_file_under_a_megabyte_may_take_less_than_256_mb() -> None:
    assert allowed_memory(1_000_000) < 256_000_000
    assert allowed_memory(0) > 16 << 20


def test_what_is_spent_adds_up() -> None:
    budget = MemoryBudget("face.glb", 1000)
    budget.spend(allowed_memory(1000) - 10)
    budget.spend(10)
    words = r"face\.glb: it would take more memory than 32 MiB, as no face in a file of 1,000 bytes"
    with pytest.raises(FormatError, match=words):
        budget.spend(1)


def test_a_larger_file_may_take_more_for_each_byte() -> None:
    """Eight hundred sparse correctives of a production head fit into what ten megabytes may."""
    rates = [allowed_memory(size + 1) - allowed_memory(size) for size in (0, 999_999, 2_000_000)]
    assert rates == sorted(rates)
    MemoryBudget("head.glb", 10_000_000).spend_fields(24_000, 800, copies=2)


def test_files_that_belong_to_it_add_to_what_it_may_take() -> None:
    budget = MemoryBudget("face.gltf", 1000)
    budget.add_size(5000)
    budget.spend(allowed_memory(6000))
    with pytest.raises(FormatError):
        budget.spend(1)


def test_fields_cost_what_float64_vectors_take() -> None:
    """Of a rig of 27,000 vertices, 50 fields held twice are 65 MB; ten times as many fail."""
    MemoryBudget("face.glb", 250_000).spend_fields(27_000, 50, copies=2)
    with pytest.raises(FormatError):
        MemoryBudget("face.glb", 250_000).spend_fields(27_000, 500, copies=2)


def test_things_cost_even_where_they_hold_nothing() -> None:
    MemoryBudget("face.glb", 100_000).spend_objects(1000)
    with pytest.raises(FormatError):
        MemoryBudget("face.glb", 100_000).spend_objects(100_000)


def test_looking_up_many_entries_among_many_names_is_too_much() -> None:
    MemoryBudget("face.glb", 100_000).spend_lookups(1000, 1000)
    with pytest.raises(FormatError):
        MemoryBudget("face.glb", 100_000).spend_lookups(100_000, 4000)
