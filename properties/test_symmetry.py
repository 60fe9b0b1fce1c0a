"""Symmetries: a changed surface has the changed current, whatever the current is."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from leakref._base import FloatArray
from leakref.certify.checks.inputs import Cube

from .examined import Examined, same
from .strategies import examples, seas

Change = Callable[[FloatArray], FloatArray]
BROAD = 150.0
"""degrees: from here on an untapered optimum is sharp, far from the mirror basin."""


def placed(surface: FloatArray, reversed_: tuple[int, ...], exchanged: bool, one_way: bool) -> list[FloatArray]:
    """The surface with axes reversed by index, n to -n modulo the size, under which a periodic window is even.

    Unless `one_way` also shifted by a sample or two: a window that is sampled symmetrically (D1), or seen from the
    other end where rows are counted downwards, has its middle elsewhere.
    """
    flipped = np.flip(surface, reversed_)
    steps = [(1, 0, -1) if axis in reversed_ else (0, 1, -1) if exchanged and axis < 2 else (0,) for axis in range(3)]
    ways = [tuple(step[0] for step in steps)] if one_way else list(itertools.product(*steps))
    return [np.ascontiguousarray(np.roll(flipped, way, (0, 1, 2))) for way in ways]


def held(
    examined: Examined,
    cube: Cube,
    matrix: FloatArray,
    change: Change = lambda eta: eta,
    *,
    reversed_: tuple[int, ...] = (),
    exchanged: bool = False,
    windows: tuple[str, ...] | None = None,
) -> None:
    """Fail unless the changed surface gives the velocities, `matrix` applied: in one of the ways in which other codes
    than the reference may place their window."""
    dx, dy, dt = cube.spacing
    spacing = (dy, dx, dt) if exchanged else cube.spacing
    changed = change(cube.surface.transpose(1, 0, 2) if exchanged else cube.surface)
    surfaces = placed(changed, reversed_, exchanged, examined.is_reference)
    for window in windows or examined.windows():
        examined.offered("extract", window=window)
        for method in examined.methods():
            should = examined.velocities(cube.surface, cube, window, method) @ matrix.T
            failed = None
            for surface in surfaces:
                found = examined.velocities_of_changed(surface, cube, window, method, spacing)
                try:
                    same(examined, cube, window, method, found, should, (surface, spacing))
                    break
                except AssertionError as difference:
                    failed = failed or difference
            else:
                raise AssertionError(str(failed)) from failed


@examples(16)
@given(cube=seas(narrowest=BROAD), exchanged=st.booleans(), axes=st.sampled_from([(), (0,), (1,), (0, 1)]))
def test_quarter_turns_mirror_images_and_exchanged_axes(
    examined: Examined, cube: Cube, exchanged: bool, axes: tuple[int, ...]
) -> None:
    """All eight, by index reversal modulo n and exchange of the axes with their spacings: exact for box and a periodic
    window; 1e-10 c0, others a tenth of the smaller resolution. Not in shells of which the reference has something to
    note: untapered, the start simplex does not turn with the sea."""
    matrix = np.eye(2)[::-1] if exchanged else np.eye(2)
    for axis in axes:
        matrix = np.diag([-1.0, 1.0] if axis == 0 else [1.0, -1.0]) @ matrix
    held(examined, cube, matrix, reversed_=axes, exchanged=exchanged)


@examples(8)
@given(cube=seas(narrowest=BROAD))
def test_played_backwards_the_current_is_reversed(examined: Examined, cube: Cube) -> None:
    """c to -c, by index reversal modulo n in time: 1e-10 c0, others a tenth of the smaller resolution."""
    held(examined, cube, -np.eye(2), reversed_=(2,))


@examples(8)
@given(cube=seas(narrowest=BROAD), steps=st.tuples(*3 * [st.integers(-40, 40)]))
def test_a_circular_shift_changes_nothing_untapered(examined: Examined, cube: Cube, steps: tuple[int, ...]) -> None:
    """Box only: a cube has no edge then. 1e-10 c0, others a tenth of the smaller resolution."""
    held(examined, cube, np.eye(2), lambda eta: np.roll(eta, steps, (0, 1, 2)), windows=("box",))


@examples(8)
@given(cube=seas(narrowest=BROAD), factor=st.integers(-6, 6).map(lambda n: 10.0**n), negative=st.booleans())
def test_amplitude_does_not_matter(examined: Examined, cube: Cube, factor: float, negative: bool) -> None:
    """Any factor, of either sign: 1e-10 c0, others a tenth of the smaller resolution."""
    held(examined, cube, np.eye(2), lambda eta: eta * (-factor if negative else factor))


@examples(8)
@given(cube=seas(narrowest=BROAD), offset=st.floats(-10, 10))
def test_an_added_constant_changes_nothing(examined: Examined, cube: Cube, offset: float) -> None:
    """Up to ten standard deviations, in shells that keep clear of the window's bins around zero, box and Hann: 1e-10
    c0, others a tenth of the smaller resolution. (The rounding grows with the offset: 2e-10 at 1e6.)"""
    held(examined, cube, np.eye(2), lambda eta: eta + offset * eta.std())
