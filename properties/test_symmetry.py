"""Symmetries: a changed surface has the changed current, whatever the current is."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from hypothesis import given, strategies as st

from leakref._base import FloatArray
from leakref.certify.cubes import Cube
from .examined import Examined, same
from .strategies import examples, seas

Change = Callable[[FloatArray, int], FloatArray]
BROAD = 150.0
"""degrees: from here on an untapered optimum is sharp, far from the mirror basin."""


def reverse(surface: FloatArray, axes: tuple[int, ...], shift: int) -> FloatArray:
    """Index n to -n modulo the size (`shift` 1), under which a periodic window is even, or the plain flip (0)."""
    return np.roll(np.flip(surface, axes), (shift,) * len(axes), axes)


def held(examined: Examined, cube: Cube, change: Change, matrix: FloatArray, *, exchanged: bool = False,
         windows: tuple[str, ...] | None = None, exact: float = 1e-10) -> None:
    """Fail unless the changed surface gives the velocities, `matrix` applied: under a shift of 1, or, in other codes than
    the reference, of 0, which is that of a window sampled symmetrically (D1)."""
    dx, dy, dt = cube.spacing
    spacing = (dy, dx, dt) if exchanged else cube.spacing
    for window in windows or examined.windows():
        examined.offered("extract", window=window)
        for method in examined.methods():
            should = examined.velocities(cube.surface, cube, window, method) @ matrix.T
            for shift in (1,) if examined.is_reference else (1, 0):
                surface = np.ascontiguousarray(change(cube.surface, shift))
                found = examined.velocities(surface, cube, window, method, spacing=spacing)
                try:
                    same(examined, cube, window, method, found, should, (surface, spacing), exact=exact)
                    break
                except AssertionError:
                    if shift == 0 or examined.is_reference:
                        raise


@examples(16)
@given(cube=seas(narrowest=BROAD), exchanged=st.booleans(), axes=st.sampled_from([(), (0,), (1,), (0, 1)]))
def test_quarter_turns_mirror_images_and_exchanged_axes(examined: Examined, cube: Cube, exchanged: bool,
                                                        axes: tuple[int, ...]) -> None:
    """All eight, by index reversal modulo n and exchange of the axes with their spacings: exact for box and a periodic
    window; 1e-10 c0, others a tenth of the smaller resolution. Not in shells of which the reference has something to
    note: untapered, the start simplex does not turn with the sea."""
    def change(eta: FloatArray, shift: int) -> FloatArray:
        return reverse(eta.transpose(1, 0, 2) if exchanged else eta, axes, shift)

    matrix = np.eye(2)[::-1] if exchanged else np.eye(2)
    for axis in axes:
        matrix = np.diag([-1.0, 1.0] if axis == 0 else [1.0, -1.0]) @ matrix
    held(examined, cube, change, matrix, exchanged=exchanged)


@examples(8)
@given(cube=seas(narrowest=BROAD))
def test_played_backwards_the_current_is_reversed(examined: Examined, cube: Cube) -> None:
    """c to -c, by index reversal modulo n in time: 1e-10 c0, others a tenth of the smaller resolution."""
    held(examined, cube, lambda eta, shift: reverse(eta, (2,), shift), -np.eye(2))


@examples(8)
@given(cube=seas(narrowest=BROAD), steps=st.tuples(*3 * [st.integers(-40, 40)]))
def test_a_circular_shift_changes_nothing_untapered(examined: Examined, cube: Cube, steps: tuple[int, ...]) -> None:
    """Box only: a cube has no edge then. 1e-10 c0, others a tenth of the smaller resolution."""
    held(examined, cube, lambda eta, _: np.roll(eta, steps, (0, 1, 2)), np.eye(2), windows=("box",))


@examples(8)
@given(cube=seas(narrowest=BROAD), factor=st.integers(-6, 6).map(lambda n: 10.0**n), negative=st.booleans())
def test_amplitude_does_not_matter(examined: Examined, cube: Cube, factor: float, negative: bool) -> None:
    """Any factor, of either sign: 1e-10 c0, others a tenth of the smaller resolution."""
    held(examined, cube, lambda eta, _: eta * (-factor if negative else factor), np.eye(2))


@examples(8)
@given(cube=seas(narrowest=BROAD), offset=st.floats(-10, 10))
def test_an_added_constant_changes_nothing(examined: Examined, cube: Cube, offset: float) -> None:
    """Up to ten standard deviations, in shells that keep clear of the window's bins around zero, box and Hann: 1e-10 c0,
    others a tenth of the smaller resolution. (The rounding grows with the offset: 2e-10 at 1e6.)"""
    held(examined, cube, lambda eta, _: eta + offset * eta.std(), np.eye(2))
