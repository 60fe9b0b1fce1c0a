"""Scale: the same dimensionless sea in other units has the same current."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from leakref.certify.checks.criteria import unflagged
from leakref.certify.checks.inputs import Cube
from leakref.methods import METHODS

from .examined import PRECISION, Examined, same
from .strategies import examples, seas


@examples(16)
@given(cube=seas(), scale=st.floats(-1, 1).map(lambda n: float(10**n)))
def test_two_peak_wavenumbers_give_the_same_current(examined: Examined, cube: Cube, scale: float) -> None:
    """The same dimensionless sea with waves ten times as short to ten times as long: 1e-10 c0, others a tenth of the
    smaller resolution. A width, a range of frequencies or a gravity set for one sea state shows."""
    for window in examined.windows():
        for method in examined.methods():
            should, found = (examined.velocities(cube.surface, cube, window, method, scale=s) for s in (1.0, scale))
            same(examined, cube, window, method, found, should)


@examples(16)
@given(cube=seas(shells=1), length=st.floats(-1, 1), time=st.floats(-1, 1), method=st.sampled_from(list(METHODS)))
def test_units_of_length_and_time_are_free(modules: Any, cube: Cube, length: float, time: float, method: str) -> None:
    """Lengths by one factor, times by another, gravity by length over time squared: velocities by length over time, to
    1e-10 c0, where nothing is to be noted."""
    length, time = 10.0**length, 10.0**time
    dx, dy, dt = cube.spacing
    units = {"gravity": length / time**2, "peak_wavenumber": 1 / length}
    found = (
        modules.chain.extract(
            cube.surface, (dx * length, dy * length, dt * time), cube.wavenumbers / length, method=method, **units
        ).velocities
        * time
        / length
    )
    should = modules.chain.extract(cube.surface, cube.spacing, cube.wavenumbers, method=method, gravity=1.0).velocities
    known = unflagged(cube, "hann", method)
    assert np.abs(found - should)[known].max(initial=0) < PRECISION
