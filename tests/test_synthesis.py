"""From waves to a surface."""

from __future__ import annotations

import tracemalloc

import numpy as np
import oracles
import pytest
from conftest import waves_off_bins

from leakref import Components, Grid, LeakrefError, SeaState, aligned_waves, synthesis, synthesize

X, Y, T = np.array([0.0, 0.3, 1.9, 2.0]), np.array([-1.0, 0.0, 0.4]), np.array([0.0, 0.7, 1.1, 5.0, 5.1])
# the argument of each cosine is below 30, so its rounding below 30 eps = 7e-15; times the sum of amplitudes
LATTICE = SeaState(length=1.5, spread=90).components(2)


@pytest.mark.parametrize(
    "components",
    [LATTICE, LATTICE.rotated(20, (1, 2)), Components(0.7, -1.1, -0.4, 2.0, 0.3)],
    ids=["lattice", "list", "one wave"],
)
def test_surface_is_the_triple_loop_at_any_coordinates(components):
    eta = synthesize(components, X, Y, T)
    assert eta.shape == (4, 3, 5)
    assert eta.dtype == np.float64
    tolerance = 1e-14 * np.abs(components.amplitude).sum()
    np.testing.assert_allclose(eta, oracles.surface(components, X, Y, T), rtol=0, atol=tolerance)


def test_a_wave_travels_where_its_wavenumber_points_and_its_phase_leads():
    eta = synthesize(Components(1.0, 2.0, 0.5, 3.0, 0.25), [0.2], [0.1], [1.0])
    assert eta[0, 0, 0] == pytest.approx(3 * np.cos(0.2 + 2 * 0.1 - 0.5 + 0.25), rel=1e-15)
    moving = Components(1.0, 0.0, 1.0, 1.0, 0.0)  # crest at x = t
    assert synthesize(moving, [2.0], [0.0], [2.0])[0, 0, 0] == pytest.approx(1, abs=1e-15)


@pytest.mark.parametrize("components", [LATTICE, LATTICE.rotated(20, (1, 2))], ids=["lattice", "list"])
def test_blocks_of_time_make_no_difference(components, monkeypatch):
    whole = synthesize(components, X, Y, T)
    monkeypatch.setattr(synthesis, "_BUFFER", 1)  # one time a block
    np.testing.assert_allclose(synthesize(components, X, Y, T), whole, rtol=0, atol=1e-14 * components.amplitude.sum())


def test_out_is_filled_and_returned():
    out = np.full((4, 3, 5), np.nan)
    assert synthesize(LATTICE, X, Y, T, out=out) is out
    assert np.array_equal(out, synthesize(LATTICE, X, Y, T))


@pytest.mark.parametrize(
    ("x", "y", "t"),
    [(np.arange(30) * 0.2, np.arange(31) * 0.2, np.arange(100) * 0.1), ([0.0], [0.0], np.arange(4000) * 0.1)],
    ids=["camera", "gauge"],
)
def test_memory_beside_the_surface_is_bounded(x, y, t, monkeypatch):
    # at one gauge many times fit a block, and the lattice must not be copied for each of them
    monkeypatch.setattr(synthesis, "_BUFFER", 2**17)
    sea, surface = SeaState(length=3).components(0), np.empty((len(x), len(y), len(t)))
    tracemalloc.start()
    synthesize(sea, x, y, t, out=surface)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 6 * 16 * 2**17  # a few times the buffer of complex numbers, which is 2 MB here


def test_waves_repeat_after_the_domain_if_they_are_on_bins():
    grid = Grid((8, 9, 20), (1.0, 0.7, 0.5))
    waves, _ = aligned_waves(grid, [(1, 2, 3), (-2, 1, 4)], gravity=1.0)
    x, y, t = (grid.samples(a) for a in range(3))
    moved = synthesize(waves, x + grid.lengths[0], y - 2 * grid.lengths[1], t + grid.lengths[2])
    np.testing.assert_allclose(moved, synthesize(waves, x, y, t), rtol=0, atol=2e-14)


def test_a_quarter_turn_about_the_centre_of_the_samples_turns_the_array():
    n, d = 12, 0.8
    x, t = np.arange(n) * d, np.arange(5) * 0.9
    centre = (n - 1) * d / 2
    sea = SeaState(direction=20, length=2).components(0)
    eta, turned = synthesize(sea, x, x, t), synthesize(sea.rotated(90, (centre, centre)), x, x, t)
    # what was at (y, -x) is now at (x, y): new[i, j] = old[j, n - 1 - i]
    index = np.arange(n)
    expected = eta[index[None, :], n - 1 - index[:, None]]
    np.testing.assert_allclose(turned, expected, rtol=0, atol=2e-14 * sea.amplitude.sum())
    assert np.abs(turned - eta).max() > 0.1 * np.abs(eta).max()


def test_components_and_coordinates_are_left_alone():
    waves = waves_off_bins(Grid((8, 9, 20), (1.0, 0.7, 0.5)), 0.3)
    inputs = [getattr(waves, n) for n in ("kx", "ky", "omega", "amplitude", "phase")] + [X, Y, T]
    before = [v.copy() for v in inputs]
    for v in inputs:
        v.flags.writeable = False
    try:
        first, second = synthesize(waves, X, Y, T), synthesize(waves, X, Y, T)
    finally:
        for v in inputs:
            v.flags.writeable = True
    assert all(np.array_equal(a, b) for a, b in zip(before, inputs, strict=True))
    assert np.array_equal(first, second)


@pytest.mark.parametrize(
    ("arguments", "out", "fault"),
    [
        (([], Y, T), None, "no samples"),
        ((X, [[0.0]], T), None, "y has shape (1, 1)"),
        ((X, Y, [np.nan]), None, "t holds"),
        ((X, Y, T), np.empty((4, 3, 4)), "out has shape (4, 3, 4)"),
    ],
)
def test_bad_input_is_refused(arguments, out, fault):
    with pytest.raises(LeakrefError) as caught:
        synthesize(LATTICE, *arguments, out=out)
    assert caught.value.call == "synthesize"
    assert fault in caught.value.fault


def test_out_that_cannot_hold_float64_is_refused():
    with pytest.raises(LeakrefError, match=r"^synthesize: out "):  # float32 would round silently
        synthesize(LATTICE, X, Y, T, out=np.empty((4, 3, 5), dtype=np.float32))
