"""Samples and bins."""

from __future__ import annotations

import math

import numpy as np
import pytest

from leakref import Grid, LeakrefError
from leakref.grid import SPACING, TIME_STEP


@pytest.mark.parametrize("shape", [(4, 5, 6), (5, 6, 7), (2, 3, 2)])
def test_bins_are_in_the_order_of_the_fft_and_only_frequencies_of_the_half_space(shape):
    grid = Grid(shape, (0.5, 0.25, 2.0))
    for axis in (0, 1):
        assert grid.bins(axis).tolist() == np.rint(np.fft.fftfreq(shape[axis], 1 / shape[axis])).tolist()
    assert grid.bins(2).tolist() == np.rint(np.fft.rfftfreq(shape[2], 1 / shape[2])).tolist()


def test_lengths_bins_nyquist_and_samples_count_n_d_on_each_axis_of_its_own():
    grid = Grid((4, 5, 6), (0.5, 0.3, 2.0))
    assert grid.lengths == (2.0, 1.5, 12.0)
    assert grid.bin_widths == (2 * math.pi / 2.0, 2 * math.pi / 1.5, 2 * math.pi / 12.0)
    assert grid.nyquist == (math.pi / 0.5, math.pi / 0.3, math.pi / 2.0)
    assert grid.wavenumber_resolution == 2 * math.pi / 1.5  # the coarser: decision D20
    assert grid.frequency_resolution == 2 * math.pi / 12.0
    assert [grid.samples(a).tolist() for a in range(3)] == [
        [0.0, 0.5, 1.0, 1.5],
        [0.3 * n for n in range(5)],
        [0.0, 2.0, 4.0, 6.0, 8.0, 10.0],
    ]


@pytest.mark.parametrize(
    ("length", "duration", "n", "nt"), [(5, 10, 140, 140), (10, 20, 280, 280), (20, 80, 560, 1120)]
)
def test_scaled_grid_has_the_spacings_of_the_paper(length, duration, n, nt):
    grid = Grid.scaled(length, duration)
    assert grid.shape == (n, n, nt)
    # one rounding or two in each product
    np.testing.assert_allclose(grid.spacing, (2 * math.pi / 28, 2 * math.pi / 28, 2 * math.pi / 14), rtol=4e-16)
    np.testing.assert_allclose(grid.bin_widths, (1 / length, 1 / length, 1 / duration), rtol=1e-15)
    assert (SPACING, TIME_STEP) == (1 / 28, 1 / 14)


def test_scaled_grid_keeps_its_extent_where_the_spacing_does_not_divide_it():
    np.testing.assert_allclose(Grid.scaled(5.01, 10.03).lengths, 2 * np.pi * np.array([5.01, 5.01, 10.03]), rtol=1e-15)


def test_a_grid_is_a_value():
    grid = Grid([4, np.int64(5), 6], [1, np.float32(0.5), 2])
    assert grid == Grid((4, 5, 6), (1.0, 0.5, 2.0))
    assert hash(grid) == hash(Grid((4, 5, 6), (1.0, 0.5, 2.0)))
    with pytest.raises(AttributeError):
        grid.shape = (1, 1, 1)


@pytest.mark.parametrize(
    "shape",
    [
        (1, 4, 4),
        (4, 4, 1),
        (0, 4, 4),
        (-4, 4, 4),
        (4.5, 4, 4),
        (4, 4),
        (4, 4, 4, 4),
        4,
        None,
        (np.nan, 4, 4),
        (np.inf, 4, 4),
        ("a", 4, 4),
        (4, 4, None),
    ],
)
def test_bad_shapes_are_refused(shape):
    with pytest.raises(LeakrefError, match=r"^Grid: .*shape.*; give \(nx, ny, nt\)"):
        Grid(shape, (1, 1, 1))


@pytest.mark.parametrize(
    "spacing", [(0, 1, 1), (1, -1, 1), (1, 1, np.nan), (np.inf, 1, 1), (1, 1), (1, 1, 1, 1), 1, None, ("a", 1, 1)]
)
def test_bad_spacings_are_refused(spacing):
    with pytest.raises(LeakrefError, match=r"^Grid: .*spacing"):
        Grid((4, 4, 4), spacing)


@pytest.mark.parametrize("extent", [(0, 10), (5, -1), (np.nan, 10), (5, np.inf), (1e-4, 10), (5, 0.01)])
def test_bad_extents_are_refused(extent):
    with pytest.raises(LeakrefError, match=r"^Grid"):
        Grid.scaled(*extent)
