"""Route B against route A, and against direct sums."""

from __future__ import annotations

import numpy as np
import oracles
import pytest
from conftest import RECTANGULAR, waves_off_bins
from tools import peak_memory

from leakref import Components, Grid, LeakrefError, SeaState, UniformCurrent, fourier, leakage, synthesize
from leakref.window import window

NAMES = ("box", "hann", "blackman", "kaiser-bessel")
AGREEMENT = 1e-13  # of the largest |S|, as the issue asks


def apart(components: Components, grid: Grid, name: str, **settings) -> float:
    """Largest difference between the routes, relative to the largest |S|."""
    a = fourier(synthesize(components, *(grid.samples(axis) for axis in range(3))), grid, name)
    b = leakage.spectrum(components, grid, name, **settings)
    rows, columns = (np.flatnonzero(np.isin(all_bins, some)) for all_bins, some in ((a.i, b.i), (a.j, b.j)))
    assert (a.grid, a.window) == (b.grid, b.window)
    return float(np.abs(a.values[np.ix_(rows, columns)] - b.values).max() / np.abs(a.values).max())


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("off", [0, 1e-12, 1e-9, 1e-3, 0.5, 0.3])
@pytest.mark.parametrize("grid", RECTANGULAR, ids=str)
def test_routes_agree_on_rectangles_and_near_bins(grid, off, name):
    assert apart(waves_off_bins(grid, off), grid, name) < AGREEMENT


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("grid", RECTANGULAR, ids=str)
def test_routes_agree_for_a_lattice_and_for_a_list_of_waves(grid, name):
    sea = SeaState(direction=35, spread=90, length=2, current=UniformCurrent((0.3, -0.2))).components(1)
    assert sea.separated() is not None
    assert apart(sea, grid, name) < AGREEMENT
    turned = sea.rotated(25, (1.0, 2.0))
    assert turned.separated() is None
    assert apart(turned, grid, name) < AGREEMENT


@pytest.mark.parametrize("name", NAMES)
def test_routes_agree_on_the_smallest_domain_of_the_paper(name):
    assert apart(SeaState(length=5).components(0), Grid.scaled(5, 10), name) < AGREEMENT


@pytest.mark.slow
@pytest.mark.parametrize("name", ["box", "hann"])
def test_routes_agree_on_the_common_domain_of_the_paper(name):
    sea = SeaState(length=10, current=UniformCurrent((0.2, 0.1))).components(1)
    assert apart(sea, Grid.scaled(10, 20), name) < AGREEMENT


@pytest.mark.slow
@pytest.mark.parametrize("name", ["box", "hann"])
def test_routes_agree_on_the_largest_domain_of_the_paper(name):
    # 351 million samples: some frequencies, summed over blocks of time, so that the surface is never there at once
    grid, sea = Grid.scaled(20, 80), SeaState(length=20).components(0)
    b = leakage.spectrum(sea, grid, name, largest_wavenumber=3.7)
    largest, (_, _, strongest) = b.strongest
    m = np.array([0, 40, strongest, strongest + 1, 150, grid.shape[2] // 2])
    x, y, t = (grid.samples(axis) for axis in range(3))
    planes, taper = np.zeros((x.size, y.size, m.size), dtype=complex), [window(name).samples(n) for n in grid.shape]
    for start in range(0, t.size, 80):
        block = np.arange(start, min(start + 80, t.size))
        turns = np.exp(2j * np.pi * (np.outer(block, m) % t.size) / t.size) * taper[2][block, None]
        eta = synthesize(sea, x, y, t[block]).reshape(-1, block.size)
        planes += (eta @ turns.real + 1j * (eta @ turns.imag)).reshape(planes.shape)
    a = np.fft.fft2(planes * (taper[0][:, None] * taper[1])[:, :, None], axes=(0, 1))
    assert np.abs(a[np.ix_(b.i, b.j)] - b.values[:, :, m]).max() < AGREEMENT * largest


def test_route_b_alone_is_the_direct_sum_at_single_bins():
    grid = Grid((5, 6, 7), (0.9, 0.7, 0.8))
    waves = waves_off_bins(grid, 0.5)
    eta = oracles.surface(waves, *(grid.samples(axis).tolist() for axis in range(3)))
    for name in NAMES:
        values = leakage.spectrum(waves, grid, name).values
        for i, j, m in [(0, 0, 0), (1, -2, 3), (-2, 2, 1), (2, 3, 2)]:
            # 210 samples below 4, a handful of roundings each
            assert abs(values[i, j, m] - oracles.spectral_sum(eta, name, (i, j, m))) < 5e-13


@pytest.mark.parametrize("listed", [False, True])
def test_part_of_the_bins_is_a_part_of_all_of_them(listed):
    grid = RECTANGULAR[0]
    sea = SeaState(length=2).components(0)
    sea = sea.rotated(10, (0, 0)) if listed else sea
    all_of_them, part = leakage.spectrum(sea, grid), leakage.spectrum(sea, grid, largest_wavenumber=2.0)
    kx, ky, _ = grid.bin_widths
    assert (np.abs(part.i).max(), np.abs(part.j).max()) == (int(2.0 / kx), int(2.0 / ky))
    same = all_of_them.values[np.ix_(part.i, part.j)]  # signed bin numbers index the order of the FFT
    assert np.abs(same - part.values).max() < 1e-14 * np.abs(same).max()
    on_a_bin = leakage.spectrum(sea, grid, largest_wavenumber=2 * kx)  # decided with a margin, not by rounding
    assert np.abs(on_a_bin.i).max() == 2


def test_blocks_of_frequencies_make_no_difference(monkeypatch):
    grid, sea = RECTANGULAR[1], SeaState(length=2).components(0)
    whole = leakage.spectrum(sea, grid).values
    monkeypatch.setattr(leakage, "_BUFFER", 1)
    assert np.abs(leakage.spectrum(sea, grid).values - whole).max() < 1e-15 * np.abs(whole).max()


def test_spectrum_is_linear_and_deterministic():
    grid = RECTANGULAR[2]
    waves = waves_off_bins(grid, 0.3)
    fields = ("kx", "ky", "omega", "amplitude", "phase")
    one, rest = (Components(*(getattr(waves, n)[part] for n in fields)) for part in (slice(0, 1), slice(1, None)))
    total = leakage.spectrum(waves, grid).values
    parts = leakage.spectrum(one, grid).values + leakage.spectrum(rest, grid).values
    assert np.abs(total - parts).max() < 1e-14 * np.abs(total).max()
    assert np.array_equal(total, leakage.spectrum(waves, grid).values)


@pytest.mark.slow
def test_route_b_runs_the_largest_domain_in_under_one_and_a_half_gigabytes():
    code = (
        "from leakref import Grid, SeaState, analyse, leakage, shell_wavenumbers\n"
        "grid = Grid.scaled(20, 80); sea = SeaState(length=20).components(0)\n"
        "k = shell_wavenumbers(grid, 0.4, 3.5)\n"
        "s = leakage.spectrum(sea, grid, 'hann', largest_wavenumber=3.5 + 3 / 20)\n"
        "assert abs(analyse(s, k[[12, -1]], gravity=1.0).velocities).max() < 1\n"
    )
    assert 50e6 < peak_memory(code) < 1.5e9


@pytest.mark.parametrize("largest", [-1.0, np.nan])
def test_a_largest_wavenumber_that_leaves_no_bins_is_refused(largest):
    with pytest.raises(LeakrefError):
        leakage.spectrum(waves_off_bins(RECTANGULAR[0], 0.1), RECTANGULAR[0], largest_wavenumber=largest)


def test_unknown_windows_are_refused():
    with pytest.raises(LeakrefError, match="no window named 'welch'"):
        leakage.spectrum(waves_off_bins(RECTANGULAR[0], 0.1), RECTANGULAR[0], "welch")
