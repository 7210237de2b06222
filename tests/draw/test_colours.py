"""Heat maps keep their range."""

from __future__ import annotations

import matplotlib
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from elastomorph.draw.pictures import COLOUR_MAP, SCALE_ENDS, heat_colours, round_up
from elastomorph.errors import ParameterError
from elastomorph.viewer.page import shipped_page


def test_the_ends_of_the_range_take_the_ends_of_the_map() -> None:
    table = matplotlib.colormaps[COLOUR_MAP]
    colours = heat_colours([0.0, 4.0, 9.0, -1.0], 4.0)
    np.testing.assert_array_equal(colours[0], table(0.0)[:3])
    np.testing.assert_array_equal(colours[1], table(1.0)[:3])
    np.testing.assert_array_equal(colours[2], colours[1])
    np.testing.assert_array_equal(colours[3], colours[0])


def test_more_error_is_darker_everywhere() -> None:
    """So the map reads in grey too. Rec. 709 luminance."""
    luminance = heat_colours(np.linspace(0, 1, 256), 1.0) @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(luminance) < 0).all()


@pytest.mark.parametrize(
    ("values", "options"),
    [
        ([np.nan], {"highest": 1.0}),
        ([[1.0]], {"highest": 1.0}),
        ([1.0], {"highest": 0.0}),
        ([1.0], {"highest": np.inf}),
        ([1.0], {"highest": 1.0, "colour_map": "no such map"}),
    ],
)
def test_what_has_no_colour_is_refused(values: object, options: dict[str, object]) -> None:
    with pytest.raises(ParameterError):
        heat_colours(values, **options)  # type: ignore[arg-type]


@given(st.floats(1e-12, 1e12))
def test_a_scale_ends_at_a_round_number_just_above(value: float) -> None:
    top = round_up(value)
    assert value * (1 - 1e-9) <= top <= value * 1.6
    assert round_up(top) == pytest.approx(top)
    # A scale is marked in quarters, with few digits.
    mantissa, power = f"{top / 4:.12e}".split("e")
    assert float(mantissa) * 10 == pytest.approx(round(float(mantissa) * 10)), power


def test_a_scale_of_nothing_ends_at_one() -> None:
    assert round_up(0.0) == 1.0
    for bad in (-1.0, np.nan, np.inf):
        with pytest.raises(ParameterError):
            round_up(bad)


def test_the_viewer_has_the_same_colours() -> None:
    """Every colour of its scale is that of pictures at the same share of the largest distance."""
    table = matplotlib.colormaps[COLOUR_MAP]
    wanted = [matplotlib.colors.to_hex(table(share)) for share in np.linspace(0, 1, 33)]
    page = shipped_page()
    found = [page.find(colour) for colour in wanted]
    assert min(found) > 0
    # One list in this order, nothing but quotation marks and commas between them.
    assert max(np.diff(found)) <= len(wanted[0]) + 3
    assert min(np.diff(found)) > 0


def test_the_viewer_ends_its_scale_at_the_same_numbers() -> None:
    ends = ",".join(f"{end:g}" for end in SCALE_ENDS)
    assert f"[{ends}]" in shipped_page()
