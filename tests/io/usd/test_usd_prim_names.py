"""Every name becomes a valid prim name, and no two the same."""

from __future__ import annotations

import re

from hypothesis import given
from hypothesis import strategies as st

from elastomorph.io.usd.exact import prim_names


def test_illegal_characters_become_underscores() -> None:
    assert prim_names(["jawOpen", "jaw open.v2", "Lächeln", "1st", "", "a:b"]) == [
        "jawOpen",
        "jaw_open_v2",
        "L_cheln",
        "_1st",
        "_",
        "a_b",
    ]


def test_names_that_become_the_same_are_numbered() -> None:
    assert prim_names(["a b", "a.b", "a_b_1"], taken=["a_b"]) == ["a_b_1", "a_b_2", "a_b_1_1"]


@given(names=st.lists(st.text()), taken=st.lists(st.sampled_from(["_", "a", "a_1"])))
def test_all_names_are_valid_and_different(names: list[str], taken: list[str]) -> None:
    found = prim_names(names, taken)
    assert len(found) == len(names)
    assert len({*found, *taken}) == len(found) + len(set(taken))
    assert all(re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name) for name in found)
