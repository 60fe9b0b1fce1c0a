"""Route A: the sign, the order and the halves of the transform."""

from __future__ import annotations

import numpy as np
import oracles
import pytest
from conftest import RECTANGULAR, waves_off_bins

from leakref import Components, Grid, LeakrefError, Spectrum, aligned_waves, fourier, leakage, synthesize

NAMES = ("box", "hann", "blackman", "kaiser-bessel")


def sampled(components: Components, grid: Grid) -> np.ndarray:
    return synthesize(components, *(grid.samples(axis) for axis in range(3)))


def every_bin(spectrum: Spectrum) -> dict[tuple[int, int, int], complex]:
    nt = spectrum.grid.shape[2]
    m = np.rint(np.fft.fftfreq(nt, 1 / nt)).astype(int).tolist()
    whole = spectrum.whole()
    return {
        (int(i), int(j), n): whole[a, b, c]
        for a, i in enumerate(spectrum.i)
        for b, j in enumerate(spectrum.j)
        for c, n in enumerate(m)
    }


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("shape", [(4, 5, 6), (5, 3, 7), (3, 4, 2)])
def test_every_bin_is_the_direct_sum_with_the_documented_sign(name, shape):
    grid = Grid(shape, (0.5, 0.7, 0.9))
    eta = np.random.default_rng(0).normal(size=shape)
    bins = every_bin(fourier(eta, grid, name))
    assert len(bins) == np.prod(shape)
    for numbers, value in bins.items():  # a hundred samples of order one, each rounded a few times
        assert abs(value - oracles.spectral_sum(eta, name, numbers)) < 2e-13


@pytest.mark.parametrize("route", ["A", "B"])
@pytest.mark.parametrize(
    ("name", "weights"),
    [("box", [0, 0, 1, 0, 0]), ("hann", [0, -0.25, 0.5, -0.25, 0]), ("blackman", [0.04, -0.25, 0.42, -0.25, 0.04])],
)
@pytest.mark.parametrize("grid", RECTANGULAR, ids=str)
def test_a_wave_on_a_bin_fills_1_27_or_125_bins_and_their_mirror_with_exact_weights(grid, name, weights, route):
    i, j, m = (2, -3, 2) if grid.shape[2] < 12 else (-3, 2, 5)
    wave, _ = aligned_waves(grid, [(i, j, m)], amplitude=[0.8], phase=[1.1], gravity=1.0)
    spectrum = fourier(sampled(wave, grid), grid, name) if route == "A" else leakage.spectrum(wave, grid, name)
    expected = np.zeros(grid.shape, dtype=complex)
    for sign in (1, -1):  # the wave at its own +k and +omega, its mirror at -k and -omega; weights overlap near 0
        for a in range(5):
            for b in range(5):
                for c in range(5):
                    at = tuple(np.add(np.multiply(sign, (i, j, m)), (a - 2, b - 2, c - 2)) % grid.shape)
                    expected[at] += (
                        0.4 * np.exp(1.1j * sign) * weights[a] * weights[b] * weights[c] * np.prod(grid.shape)
                    )
    found = spectrum.whole()
    lines = np.count_nonzero(weights) ** 3
    largest = np.abs(expected).max()
    assert np.count_nonzero(np.abs(found) > 1e-12 * largest) == np.count_nonzero(np.abs(expected) > 1e-12 * largest)
    assert np.count_nonzero(expected) <= 2 * lines
    # the surface's arguments are below 100: their rounding, 100 eps, mostly averages out
    assert np.abs(found - expected).max() < 1e-13 * largest


def test_a_wave_well_inside_fills_exactly_that_many_bins():
    grid = Grid((16, 18, 20), (0.5, 0.6, 0.7))
    for name, bins in (("box", 1), ("hann", 27), ("blackman", 125)):
        wave, _ = aligned_waves(grid, [(4, -5, 5)], gravity=1.0)
        power = np.abs(fourier(sampled(wave, grid), grid, name).values)
        assert np.count_nonzero(power > 1e-12 * power.max()) == bins  # the mirror is in the other half


@pytest.mark.parametrize("shape", [(6, 5, 8), (5, 6, 7)])
def test_whole_is_symmetric_and_its_energy_is_that_of_the_surface(shape):
    grid = Grid(shape, (0.5, 0.7, 0.9))
    eta = np.random.default_rng(1).normal(size=shape)
    spectrum = fourier(eta, grid, "box")
    whole = spectrum.whole()
    back = np.conj(whole[np.ix_(*(-np.arange(n) for n in shape))])
    assert np.abs(whole - back).max() < 1e-13
    # Parseval, over the whole and over the half space with its weights (decision D5); some 300 terms
    assert (np.abs(whole) ** 2).sum() == pytest.approx((eta**2).sum() * eta.size, rel=1e-14)
    assert 2 * (np.abs(spectrum.values) ** 2 @ spectrum.half_weight).sum() == pytest.approx(
        (eta**2).sum() * eta.size, rel=1e-14
    )


def test_axes_of_a_spectrum_are_those_of_its_bins():
    grid = Grid((6, 5, 8), (0.5, 0.7, 0.9))
    spectrum = fourier(np.zeros(grid.shape), grid)
    assert spectrum.window == "hann"
    np.testing.assert_allclose(spectrum.kx, 2 * np.pi * np.fft.fftfreq(6, 0.5), rtol=1e-15)
    np.testing.assert_allclose(spectrum.ky, 2 * np.pi * np.fft.fftfreq(5, 0.7), rtol=1e-15)
    np.testing.assert_allclose(spectrum.omega, 2 * np.pi * np.fft.rfftfreq(8, 0.9), rtol=1e-15)
    assert spectrum.half_weight.tolist() == [0.5, 1, 1, 1, 0.5]
    assert fourier(np.zeros((6, 5, 7)), Grid((6, 5, 7), (1, 1, 1))).half_weight.tolist() == [0.5, 1, 1, 1]


def test_strongest_is_the_largest_bin_by_its_numbers():
    grid = Grid((9, 8, 12), (0.5, 0.7, 0.9))
    wave, _ = aligned_waves(grid, [(-3, 2, 4)], amplitude=[2], gravity=1.0)
    largest, where = fourier(sampled(wave, grid), grid, "box").strongest
    assert where == (-3, 2, 4)
    assert largest == pytest.approx(9 * 8 * 12, rel=1e-13)
    assert leakage.spectrum(wave, grid, "box", largest_wavenumber=5.0).strongest[1] == (-3, 2, 4)


def test_symmetric_sampling_is_the_variant_and_threads_change_nothing():
    grid = Grid((6, 5, 8), (0.5, 0.7, 0.9))
    eta = np.random.default_rng(2).normal(size=grid.shape)
    hann = [0.5 - 0.5 * np.cos(2 * np.pi * np.arange(n) / (n - 1)) for n in grid.shape]
    tapered = eta * np.einsum("i,j,k->ijk", *hann)
    variant = fourier(eta, grid, "hann", symmetric=True).values
    assert np.abs(variant - fourier(tapered, grid, "box").values).max() < 1e-13
    assert np.abs(variant - fourier(eta, grid, "hann").values).max() > 1
    assert np.array_equal(fourier(eta, grid, workers=1).values, fourier(eta, grid, workers=2).values)


@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.int32])
def test_surface_is_not_modified_and_any_real_type_will_do(dtype):
    grid = Grid((6, 5, 8), (0.5, 0.7, 0.9))
    eta = (100 * np.random.default_rng(3).normal(size=grid.shape)).astype(dtype)
    before = eta.copy()
    eta.flags.writeable = False
    values = fourier(eta, grid, "hann").values
    assert np.array_equal(eta, before)
    assert values.dtype == np.complex128
    assert np.array_equal(values, fourier(before.astype(np.float64), grid, "hann").values)
    assert np.array_equal(values, fourier(np.asfortranarray(eta), grid, "hann").values)


def holding(value: float, shape=(4, 4, 4)) -> np.ndarray:
    eta = np.zeros(shape)
    eta[1, 2, 3] = value
    return eta


@pytest.mark.parametrize(
    ("surface", "window", "call", "fault"),
    [
        (holding(np.nan), "hann", "fourier", "1 of 64 values that are not finite"),
        (holding(-np.inf), "hann", "fourier", "1 of 64"),
        (np.zeros((4, 4, 4), dtype=complex), "hann", "fourier", "complex"),
        (np.zeros((4, 4)), "hann", "fourier", "2 dimensions"),
        (np.zeros((4, 4, 4, 1)), "hann", "fourier", "4 dimensions"),
        (np.zeros((4, 4, 5)), "hann", "fourier", "(4, 4, 5)"),
        (np.zeros((4, 4, 4)), "hanning", "window", "hanning"),
    ],
)
def test_bad_surfaces_and_windows_are_refused(surface, window, call, fault):
    with pytest.raises(LeakrefError) as caught:
        fourier(surface, Grid((4, 4, 4), (1, 1, 1)), window)
    assert caught.value.call == call
    assert fault in caught.value.fault


def test_whole_needs_all_bins():
    grid = RECTANGULAR[0]
    part = leakage.spectrum(waves_off_bins(grid, 0.1), grid, largest_wavenumber=2.0)
    with pytest.raises(LeakrefError, match=r"^Spectrum\.whole: only .* of \(12, 17\) bins"):
        part.whole()
