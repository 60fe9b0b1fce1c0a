"""Cubes in blocks: the same numbers, without the cube in memory."""

from __future__ import annotations

import tracemalloc
from contextlib import contextmanager

import numpy as np
import pytest

from leakref import Grid, LeakrefError, fourier
from leakref.cubes.blocks import fourier_in_blocks, plane, trend

GRID = Grid((12, 17, 22), (0.9, 0.6, 0.35))
ORDERS = [(0, 1, 2), (1, 0, 2), (2, 1, 0), (1, 2, 0), (0, 2, 1)]


def stored(surface, order):
    """The same surface[x, y, t], laid out in memory with another axis slowest."""
    return np.ascontiguousarray(surface.transpose(order)).transpose(np.argsort(order))


@pytest.fixture(scope="module")
def surface():
    return np.random.default_rng(4).normal(size=GRID.shape)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("shape", [(12, 17, 22), (11, 16, 21)])
@pytest.mark.parametrize("window", ["box", "hann"])
def test_transform_is_that_of_the_whole_cube_on_the_bins_kept(surface, order, shape, window):
    grid = Grid(shape, GRID.spacing)
    eta = surface[: shape[0], : shape[1], : shape[2]]
    whole = fourier(eta, grid, window)
    for largest, block, held in ((None, 1, 2**30), (2.0, 3000, 2**30), (2.0, 10**9, 2**30), (2.0, 3000, 9000)):
        how = {"largest_wavenumber": largest, "block": block, "held": held}
        kept = fourier_in_blocks(stored(eta, order), grid, window, **how)
        assert kept.values.shape == (kept.i.size, kept.j.size, shape[2] // 2 + 1)
        assert kept.values.shape[:2] == (shape[:2] if largest is None else (7, 7))
        # the root mean square error of a bin of an FFT is at most eps log2(n) times the norm of the samples
        difference = np.abs(kept.values - whole.values[np.ix_(kept.i, kept.j)]).max()
        assert difference <= 4 * np.finfo(float).eps * np.log2(eta.size) * np.linalg.norm(eta)


def test_the_trend_is_found_and_removed_in_blocks(surface):
    x, y, t = np.meshgrid(*(np.arange(n) for n in GRID.shape), indexing="ij")
    inclined = 3 + 0.1 * x - 0.2 * y + 0.05 * t
    for order in ORDERS:
        found = trend(stored(inclined, order), "linear", block=2000)
        np.testing.assert_allclose(found, [inclined.mean(), 0.1, -0.2, 0.05], rtol=0, atol=1e-13)
        np.testing.assert_allclose(plane(found, GRID.shape), inclined, rtol=0, atol=1e-12)
    assert trend(inclined, "mean", block=2000)[1:].tolist() == [0, 0, 0]
    assert trend(inclined, "none").tolist() == [0, 0, 0, 0]
    # least squares of a surface that is no plane: what is left is orthogonal to the plane
    found = trend(surface, "linear")
    left = surface - plane(found, GRID.shape)
    for index in (np.ones_like(x), x, y, t):
        assert abs(np.sum(left * index)) < 1e-9
    whole, kept = (fourier(left, GRID), fourier_in_blocks(surface, GRID, remove=found, block=2000))
    np.testing.assert_allclose(kept.values, whole.values, rtol=0, atol=1e-11)


def test_memory_stays_far_below_the_cube(tmp_path):
    grid = Grid((64, 60, 512), (0.5, 0.5, 0.3))
    cube = np.lib.format.open_memmap(tmp_path / "eta.npy", "w+", np.float32, grid.shape)
    cube[:] = np.random.default_rng(1).normal(size=grid.shape)
    cube.flush()
    tracemalloc.start()
    kept = fourier_in_blocks(cube, grid, largest_wavenumber=1.0, remove=trend(cube, "linear", block=2**18), block=2**18)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert kept.values.shape == (11, 9, 257)
    assert peak < 8 * cube.size / 3  # the cube as float64 is 15.7 MB


def test_what_is_kept_on_the_way_is_no_more_than_is_held(tmp_path, monkeypatch):
    """Many samples along the slowest axis and few bins in the end: read in several passes, the same bits."""
    grid = Grid((400, 24, 128), (0.5, 0.5, 0.3))
    cube = np.lib.format.open_memmap(tmp_path / "eta.npy", "w+", np.float32, grid.shape)
    cube[:] = np.random.default_rng(1).normal(size=grid.shape)
    peaks, found = [], []
    for held in (2**30, 2**18):
        tracemalloc.start()
        found.append(fourier_in_blocks(cube, grid, largest_wavenumber=1.0, block=2**16, held=held).values)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    np.testing.assert_array_equal(*found)
    assert 16 * 400 * 3 * 65 > 4 * 2**18
    assert peaks[1] < peaks[0] - 2**19


def test_samples_that_are_not_finite_are_refused_with_their_place(surface):
    bad = surface.copy()
    bad[7, 2, 3] = np.nan
    with pytest.raises(LeakrefError, match=r"samples 7\.\.\.7 along x, holds 1 of"):
        fourier_in_blocks(bad, GRID, block=1)
    with pytest.raises(LeakrefError, match="1 of 4488"):
        trend(bad, "mean")


def test_wrong_use_is_refused(surface):
    with pytest.raises(LeakrefError, match="shape"):
        fourier_in_blocks(surface[1:], GRID)
    with pytest.raises(LeakrefError, match="no trend is called 'cubic'"):
        trend(surface, "cubic")


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 0, 1)])
def test_every_block_and_every_row_is_a_step_of_the_progress(monkeypatch, order):
    """A long file shows how far it has come, in the blocks and then along the last axis, and each bar ends full."""
    bars = []

    @contextmanager
    def bar(what, total):
        bars.append([what, total, 0])

        def step():
            bars[-1][2] += 1

        yield step

    monkeypatch.setattr("leakref.cubes.blocks.progress_bar", bar)
    cube = np.random.default_rng(0).normal(size=[(24, 26, 28)[n] for n in np.argsort(order)]).transpose(order)
    cube = np.ascontiguousarray(cube.transpose(np.argsort(order))).transpose(order)
    trend(cube, "mean", block=8 * 26 * 28 * 3)
    fourier_in_blocks(cube, Grid(cube.shape, (1.0, 1.0, 1.0)), "hann", block=8 * 26 * 28 * 3)
    assert [what.split(",")[0] for what, *_ in bars] == ["looking for a trend", *["transforming (hann)"] * 2]
    assert all(total == steps > 1 for _, total, steps in bars), bars
