"""Chains: every item once, neighbours next to each other, in a fixed order."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from topologies import patiently

from elastomorph.curves.extraction import ordered_chains


def links_of(chains: list[tuple[list[int], bool]], count: int) -> np.ndarray:
    links = np.full((count, 2), -1, dtype=np.int32)
    for items, closed in chains:
        for place, item in enumerate(items):
            if place or closed:
                links[item, 0] = items[place - 1]
            if place + 1 < len(items) or closed:
                links[item, 1] = items[(place + 1) % len(items)]
    return links


@st.composite
def chain_lists(draw):
    lengths = draw(st.lists(st.integers(1, 9), min_size=1, max_size=8))
    labels = draw(st.permutations(range(sum(lengths))))
    chains, start = [], 0
    for length in lengths:
        closed = length > 1 and draw(st.booleans())
        chains.append((labels[start : start + length], closed))
        start += length
    return chains


@patiently
@given(chain_lists(), st.randoms())
def test_chains_are_recovered_from_their_links(chains, random):
    count = sum(len(items) for items, _ in chains)
    links = links_of(chains, count)
    for item in range(count):
        if random.random() < 0.5:
            links[item] = links[item, ::-1]
    found = ordered_chains(links)
    expected = []
    for items, closed in chains:
        if closed:
            start = items.index(min(items))
            forward = items[start:] + items[:start]
            backward = forward[:1] + forward[:0:-1]
            expected.append((min(forward, backward), True))
        else:
            expected.append((min(items, items[::-1]), False))
    expected.sort(key=lambda chain: min(chain[0]))
    got = [
        (items.tolist(), closed)
        for items, closed in zip(found.arrays(), found.closed.tolist(), strict=True)
    ]
    assert got == expected


def test_nothing_has_no_chains():
    found = ordered_chains(np.empty((0, 2), dtype=np.int32))
    assert len(found.items) == 0
    assert found.arrays() == []


def test_owners_and_places_follow_the_sequences():
    found = ordered_chains(links_of([([0, 1, 2], True), ([3], False), ([5, 4], False)], 6))
    assert found.owners().tolist() == [0, 0, 0, 1, 2, 2]
    assert found.lengths.tolist() == [3, 1, 2]
