"""Methods beside the paper's: each against loops written from its equations, and what all have in common."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import oracles
import pytest
from conftest import RECTANGULAR
from scipy.optimize import minimize

from leakref import (
    Components,
    Grid,
    LeakrefError,
    Note,
    SeaState,
    UniformCurrent,
    aligned_waves,
    analyse,
    chain,
    fast,
    fourier,
    leakage,
    lsiterative,
    nsp,
    nspadaptive,
    nspgrid,
    pcs,
    runs,
)
from leakref.cases import CASES
from leakref.dispersion import DEEP, Water
from leakref.methods import DEFAULT, METHODS
from leakref.shell import shell_at

MORE = [name for name in METHODS if name not in DEFAULT]
GRID = Grid((40, 44, 64), (0.8, 0.75, 0.9))
K = np.array([1.0, 1.25, 1.6, 2.0])
WATERS = {"deep": DEEP, "shallow": Water(1.0, depth=0.9), "film": Water(1.0, depth=1.5, surface_tension=0.05)}


def sea(spread=60.0, current=(0.12, -0.08), water=DEEP, realization=3):
    return SeaState(70.0, spread, length=5.0, current=UniformCurrent(current), water=water).components(realization)


def noise(grid):
    """A spectrum of noise: thresholds, edges and outliers all occur."""
    spectrum = fourier(np.random.default_rng(5).normal(size=grid.shape), grid, "box")
    return spectrum, spectrum.whole().tolist()


# ---------------------------------------------------------------- what all have in common


@pytest.mark.parametrize("window", ["hann", "box"])
@pytest.mark.parametrize("name", WATERS)
@pytest.mark.parametrize("method", MORE)
def test_surface_and_closed_form_agree(method, name, window):
    """Route A, the plain chain on the surface, and B, the fast path on the closed form: 1e-11 c0 and the same notes."""
    water = WATERS[name]
    waves = sea(water=water)
    (spectrum,) = chain.transform(waves, GRID, (window,))
    plain = analyse(spectrum, K, method=method, water=water, peak_wavenumber=1.0)
    twin = fast.realize(waves, GRID, K, windows=(window,), methods=(method,), water=water)[window, method]
    assert twin.notes == plain.notes
    assert twin.method == plain.method == method
    known = np.array([not note for note in plain.notes])
    assert known.sum() >= 2
    assert np.abs(twin.velocities - plain.velocities)[known].max() < 1e-11
    for field in ("score", "gradient", "hessian"):
        a, b = getattr(plain, field)[known], getattr(twin, field)[known]
        assert np.abs(a - b).max() < 1e-9 * max(1.0, np.abs(plain.hessian[known]).max())


@pytest.mark.parametrize("method", MORE)
def test_two_waves_on_bins_give_their_current(method):
    """Untapered nothing leaks, and what is left of G at the other branch is exp(-32): the current to rounding."""
    waves, current = aligned_waves(GRID, [(6, 2, 12), (-2, 6, 11)], water=DEEP)
    found = analyse(leakage.spectrum(waves, GRID, "box"), [1.2], method=method, gravity=1.0)
    assert np.abs(found.velocities[0] - current).max() < 1e-10


@pytest.mark.parametrize("method", MORE)
def test_in_still_water_a_tapered_broad_sea_has_no_current(method):
    """Below the larger velocity resolution, eq:dcdwk, at every wavenumber without a note."""
    found = analyse(leakage.spectrum(sea(120.0, (0.0, 0.0)), GRID, "hann"), K, method=method, gravity=1.0)
    known = np.array([not note for note in found.notes])
    larger = max(GRID.frequency_resolution, GRID.wavenumber_resolution / 2) / K
    assert known.sum() >= 3
    assert (np.hypot(*found.velocities.T) < larger)[known].all()


@pytest.mark.parametrize("method", MORE)
def test_units_amplitude_and_mirror_images(method):
    """Metres and seconds, twice the height, the cube seen in a mirror: the same current, as it is then written."""
    waves = sea(130.0)
    eta = chain.synthesize(waves, *(GRID.samples(axis) for axis in range(3)))
    plain = chain.extract(eta, GRID.spacing, K, gravity=1.0, method=method, peak_wavenumber=1.0).velocities
    k0, g = 0.05, 9.81
    spacing = tuple(d / s for d, s in zip(GRID.spacing, (k0, k0, math.sqrt(g * k0)), strict=True))
    metric = chain.extract(2 * eta, spacing, K * k0, gravity=g, method=method, peak_wavenumber=k0).velocities
    np.testing.assert_allclose(metric / math.sqrt(g / k0), plain, atol=1e-10, rtol=0, equal_nan=True)
    mirrored = np.roll(eta[::-1], 1, axis=0)  # n to -n, under which a periodic window is even
    turned = chain.extract(mirrored, GRID.spacing, K, gravity=1.0, method=method, peak_wavenumber=1.0).velocities
    np.testing.assert_allclose(turned * [-1, 1], plain, atol=1e-10, rtol=0, equal_nan=True)
    assert np.isfinite(plain).all(axis=1).sum() >= 3


@pytest.mark.parametrize("method", MORE)
def test_nothing_is_no_signal_and_what_is_no_setting_is_refused(method):
    spectrum = leakage.spectrum(sea(), GRID, "hann")
    near = np.hypot(*np.meshgrid(spectrum.kx, spectrum.ky, indexing="ij")) < 0.5
    silent = replace(spectrum, values=spectrum.values * near[:, :, None])
    found = analyse(silent, [1.4], method=method, gravity=1.0)
    assert found.notes == (Note.NO_SIGNAL,)
    assert np.isnan(found.velocities).all()
    for name, default in METHODS[method].settings.items():
        if isinstance(default, float):
            with pytest.raises(LeakrefError, match=rf"{name} = -1"):
                analyse(spectrum, K, method=method, gravity=1.0, **{name: -1.0})
    with pytest.raises(LeakrefError, match="gravity"):
        METHODS[method].extract(spectrum, K)


def test_nobody_gets_them_who_does_not_ask():
    assert DEFAULT == ("nsp", "ls")
    assert runs.Task(CASES["nsp-ls"][0], 0).methods == DEFAULT
    assert [method for _, method in fast.realize(sea(), GRID, K, windows=("hann",), gravity=1.0)] == list(DEFAULT)
    assert chain.reference.describe()["can"]["extract"]["methods"] == list(DEFAULT)


# ---------------------------------------------------------------- polar current shell


@pytest.mark.parametrize("grid", RECTANGULAR, ids=str)
def test_polar_current_shell_is_the_literal_fit(grid):
    spectrum, whole = noise(grid)
    found = pcs.extract(spectrum, 1.05, gravity=1.0)
    points = oracles.crest(whole, grid.bin_widths, 1.05, 0.2)
    a = 4 * grid.frequency_resolution

    def cost(c):
        off = [((w - kx * c[0] - ky * c[1]) / a) ** 2 for kx, ky, w in points]
        return a**2 / 3 * math.fsum(1 - max(1 - z, 0.0) ** 3 for z in off)

    assert cost(found.velocities[0]) == pytest.approx(found.score[0], rel=1e-12)
    # a minimum is only seen to the square root of the rounding of the cost
    fit = minimize(cost, found.velocities[0] + 1e-4, method="Nelder-Mead", options={"xatol": 1e-10, "fatol": 0})
    blur = np.sqrt(1e-14 * cost(fit.x) / np.linalg.eigvalsh(found.hessian[0])[0])
    assert np.abs(fit.x - found.velocities[0]).max() < 1e-8 + 10 * blur
    assert np.abs(found.gradient[0]).max() < 1e-12 * np.abs(found.hessian[0]).max()
    slope = oracles.differences(lambda u, v: cost((u, v)), found.velocities[0] + 0.01, 1e-3)
    bent = found.hessian[0] @ [0.01, 0.01]
    assert np.abs(slope - bent).max() < 0.2 * np.abs(bent).max()  # to first order in the step away from the minimum


def test_polar_current_shell_does_not_mind_an_outlier():
    """Twelve waves on bins within half a bin of one surface, and one 6 bins off: it is as if that were not there."""
    kx, ky, domega = GRID.bin_widths
    angle = 2 * np.pi * np.arange(13) / 13
    i, j = (np.rint(6 * wave) for wave in (np.cos(angle), np.sin(angle)))
    k = np.stack([i * kx, j * ky])
    m = np.rint((np.sqrt(np.hypot(*k)) + np.array([0.2, -0.1]) @ k) / domega) + 6 * (angle == 0)

    def velocity(method, first):
        part = slice(first, None)
        waves = Components(*k[:, part], m[part] * domega, np.ones(13 - first), angle[part])
        return analyse(leakage.spectrum(waves, GRID, "box"), [1.2], method=method, gravity=1.0).velocities[0]

    assert np.abs(velocity("pcs", 0) - velocity("pcs", 1)).max() < 1e-12
    assert np.abs(velocity("ls", 0) - velocity("ls", 1)).max() > 0.05


@pytest.mark.parametrize(("power", "noted"), [(0.2, True), (0.2001, False), (0.1999, False)])
def test_a_point_of_the_crest_at_the_threshold_is_noted(power, noted):
    waves, _ = aligned_waves(GRID, [(3, 1, 12), (-1, 3, 11)], amplitude=(1.0, np.sqrt(power)), gravity=1.0)
    found = pcs.extract(leakage.spectrum(waves, GRID, "box"), 0.6, gravity=1.0)
    assert (Note.THRESHOLD in found.notes[0]) == noted


def test_a_wave_half_way_between_frequencies_is_noted():
    kx, ky, domega = GRID.bin_widths
    waves = Components([3 * kx, -kx], [ky, 3 * ky], [12.5 * domega, 11 * domega], [1.0, 1.0], [0.0, 1.0])
    found = pcs.extract(leakage.spectrum(waves, GRID, "hann"), 0.6, gravity=1.0)
    assert Note.THRESHOLD in found.notes[0]


# ---------------------------------------------------------------- iterative least squares


@pytest.mark.parametrize("grid", RECTANGULAR, ids=str)
def test_iterative_least_squares_is_the_literal_repetition(grid):
    spectrum, whole = noise(grid)
    found = lsiterative.extract(spectrum, 1.05, gravity=1.0)
    expected, steps = oracles.iterative_least_squares(whole, grid.bin_widths, 1.05)
    assert found.velocities[0] == pytest.approx(expected, abs=1e-11)
    assert steps >= 1


def test_weak_bins_near_the_surface_count_and_others_do_not():
    """Two strong waves fix the first guess; a weak one near their surface pulls, one far from it does not."""
    kx, ky, domega = GRID.bin_widths
    two, current = aligned_waves(GRID, [(6, 2, 12), (-2, 6, 11)], gravity=1.0)
    k = np.array([5 * kx, -3 * ky])
    there = float(np.sqrt(np.hypot(*k)) + k @ current) / domega
    moved = {}
    for name, off, amplitude in (("near", 2, 0.25), ("far", 7, 0.25), ("faint", 2, 0.1)):
        omega = (round(there) + off) * domega
        waves = Components(*(np.append(getattr(two, n), v) for n, v in zip(
            ("kx", "ky", "omega", "amplitude", "phase"), (*k, omega, amplitude, 0.0), strict=True)))  # fmt: skip
        found = lsiterative.extract(leakage.spectrum(waves, GRID, "box"), 1.2, gravity=1.0).velocities[0]
        moved[name] = float(np.abs(found - current).max())
    assert moved["near"] > 1e-3
    assert max(moved["far"], moved["faint"]) < 1e-10


def test_without_a_first_guess_there_is_no_number():
    wave, _ = aligned_waves(GRID, [(3, 1, 12)], gravity=1.0)
    found = lsiterative.extract(leakage.spectrum(wave, GRID, "box"), 0.6, gravity=1.0)
    assert found.notes == (Note.TOO_FEW_BINS | Note.FLAT,)
    assert np.isnan(found.velocities).all()


# ---------------------------------------------------------------- start from a lattice


def best_of_lattice(shell, width):
    """The best point by N at each of them, all of them."""
    points = [(i / 10, j / 10) for i in range(-10, 11) for j in range(-10, 11)]
    points = [c for c in points if math.hypot(*c) <= nsp.score_range(shell, width, 1.0)]
    scores = [nsp.normalized_scalar_product(shell, c, width) for c in points]
    return min(
        (c for c, n in zip(points, scores, strict=True) if n >= max(scores) * (1 - 1e-9)), key=lambda c: math.hypot(*c)
    )


@pytest.mark.parametrize("spread", [15.0, 90.0])
@pytest.mark.parametrize("window", ["hann", "box"])
def test_the_search_starts_at_the_best_point_of_the_lattice(window, spread):
    waves = sea(spread)
    spectrum, width = leakage.spectrum(waves, GRID, window), 4 * GRID.frequency_resolution
    twin = fast.realize(waves, GRID, K, windows=(window,), methods=("nsp-grid",), gravity=1.0)[window, "nsp-grid"]
    for n, k in enumerate(K):
        shell = shell_at(spectrum, k, water=DEEP)
        best = best_of_lattice(shell, width)
        assert tuple(nspgrid.start(shell, width, 1.0)) == pytest.approx(best, abs=1e-12)
        alone = nsp.optimum(shell, width, 1.0, start=best)
        np.testing.assert_allclose(twin.velocities[n], alone.velocity, atol=1e-11, rtol=0)
        assert twin.notes[n] == alone.note


def test_a_lattice_finds_what_a_start_from_zero_misses():
    """A fast current and a narrow G: from zero current the search has nothing to climb."""
    grid = Grid((24, 24, 600), (0.9, 0.9, 0.6))
    waves, current = aligned_waves(grid, [(3, 1, 75), (1, -3, 78)], water=DEEP)
    spectrum = leakage.spectrum(waves, grid, "box")
    k = float(np.hypot(waves.kx, waves.ky).mean())
    lattice, zero = (analyse(spectrum, [k], method=m, gravity=1.0, search=False) for m in ("nsp-grid", "nsp"))
    assert np.hypot(*current) > 0.5
    assert np.abs(lattice.velocities[0] - current).max() < 1e-10
    assert not np.abs(zero.velocities[0] - current).max() < 1e-3


def test_of_equal_points_the_slowest_is_the_start():
    """One wave says nothing across itself: a line of the lattice scores alike, and its slowest point counts."""
    grid = Grid((40, 44, 128), (0.8, 0.75, 0.45))
    wave, _ = aligned_waves(grid, [(6, 0, 12)], gravity=1.0)
    shell = shell_at(leakage.spectrum(wave, grid, "box"), float(wave.kx[0]), water=DEEP)
    assert nspgrid.start(shell, 4 * grid.frequency_resolution, 1.0)[1] == 0


# ---------------------------------------------------------------- adaptive width


@pytest.mark.parametrize("name", WATERS)
def test_adaptive_width_is_that_of_both_resolutions(name):
    """The velocity is stationary for N of the width written out here, and not for that of the paper."""
    water, k = WATERS[name], 1.25
    spectrum = leakage.spectrum(sea(water=water), GRID, "hann")
    found = nspadaptive.extract(spectrum, k, water=water, peak_wavenumber=1.0)
    h = 1e-5
    slope = (float(water.frequency(k * (1 + h))) - float(water.frequency(k * (1 - h)))) / (2 * h * k)
    a = 4 * math.hypot(GRID.frequency_resolution, slope * max(GRID.bin_widths[:2]))
    shell = shell_at(spectrum, k, water=water)
    for width, still in ((a, True), (4 * GRID.frequency_resolution, False)):
        _, gradient, hessian = nsp.score_derivatives(shell, found.velocities[0], width)
        step = np.abs(np.linalg.solve(hessian, gradient)).max()
        assert (step < 1e-8) == still  # the slope is good to 1e-10


def test_of_a_huge_image_the_adaptive_width_is_that_of_the_paper():
    """Where cg dk is nothing beside domega."""
    grid = Grid((4000, 4000, 16), (0.9, 0.9, 0.6))
    assert nspadaptive.spread(grid, DEEP, 1.0) == pytest.approx(1.0, abs=1e-4)
    assert nspadaptive.spread(Grid((40, 40, 4000), (0.9, 0.9, 0.6)), DEEP, 1.0) > 10
