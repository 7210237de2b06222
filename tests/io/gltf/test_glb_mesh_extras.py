"""Packed lists come back, and cannot be made to unpack to more than they should."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from elastomorph.io.gltf.mesh_extras import packed, packed_bytes, unpacked, unpacked_bytes

INT32 = st.integers(-(2**31), 2**31 - 1)


@given(st.lists(INT32, max_size=50))
def test_a_list_comes_back(integers: list[int]) -> None:
    assert unpacked(packed(integers), len(integers)).tolist() == integers


def test_a_list_that_rises_by_one_costs_next_to_nothing() -> None:
    assert len(packed(np.arange(100_000))) < 600


@given(st.lists(INT32, max_size=9), st.integers(0, 12))
def test_another_number_of_numbers_is_refused(integers: list[int], count: int) -> None:
    if count != len(integers):
        with pytest.raises(ValueError, match="more or fewer"):
            unpacked(packed(integers), count)


@pytest.mark.parametrize("text", [None, 3, [], "", "no base64 !", "AAAA", "ä", packed([1])[:-4]])
def test_what_is_no_packed_list_is_refused(text: object) -> None:
    with pytest.raises(ValueError, match="packed text"):
        unpacked(text, 3)


def test_a_text_that_would_unpack_to_a_gigabyte_is_not_unpacked() -> None:
    text = packed_bytes(bytes(1 << 26))
    tracemalloc.start()
    try:
        with pytest.raises(ValueError, match="more or fewer"):
            unpacked_bytes(text, 8)
        assert tracemalloc.get_traced_memory()[1] < 1 << 20
    finally:
        tracemalloc.stop()
