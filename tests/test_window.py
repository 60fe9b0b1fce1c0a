"""Tapers, and their transforms."""

from __future__ import annotations

import math

import numpy as np
import oracles
import pytest

from leakref import LeakrefError
from leakref.window import KAISER_SHAPE, WINDOWS, Window, dirichlet, window

NAMES = ("box", "hann", "blackman", "kaiser-bessel")
OFFSETS = (0.0, 1e-12, -1e-9, 1e-3, 0.5, -0.25, 1e-16)


def test_the_windows_of_the_paper_are_there():
    assert tuple(WINDOWS) == NAMES
    assert all(window(name) is WINDOWS[name] and window(name).name == name for name in NAMES)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("size", [2, 7, 16])
def test_samples_are_periodic_and_symmetric_ones_end_where_they_begin(name, size):
    w, tolerance = window(name), 2e-15  # the arguments 2 pi j s are rounded: eps (2 pi / 2 + 4 pi 0.08)
    np.testing.assert_allclose(w.samples(size), oracles.window(name, size), rtol=0, atol=tolerance)
    np.testing.assert_allclose(w.samples(size)[1:], w.samples(size)[:0:-1], rtol=0, atol=tolerance)
    # symmetric sampling of n + 1 is the periodic one of n, with the first sample repeated
    symmetric = w.samples(size + 1, symmetric=True)
    np.testing.assert_allclose(symmetric, np.append(w.samples(size), w.samples(size)[0]), rtol=0, atol=tolerance)


@pytest.mark.parametrize("size", [2, 5, 16, 27])
@pytest.mark.parametrize("offset", OFFSETS)
def test_dirichlet_kernel_is_the_sum_of_exponentials_to_the_last_digits(size, offset):
    positions = np.array([near + offset for near in (0, 1, -size // 2, 3 * size + 1, -1000)])
    bins = np.arange(-size - 1, size + 2)
    kernel = dirichlet(bins, positions, size)
    assert kernel.shape == (bins.size, positions.size)
    for n, row in zip(bins, kernel, strict=True):
        for u, value in zip(positions, row, strict=True):
            exact = complex(oracles.exponential_sum(int(n), float(u), size))
            # r and d are exact, so what is lost is rounding: 8 eps of the value, 8 eps^2 of the size where it vanishes
            assert abs(value - exact) <= 2e-15 * abs(exact) + 1e-31 * size


def test_dirichlet_kernel_on_a_bin_is_the_size_there_and_exactly_nothing_elsewhere():
    kernel = dirichlet(np.arange(-8, 9), [3.0, -13.0], 16)
    assert np.array_equal(kernel, np.where(np.arange(-8, 9)[:, None] == 3, 16, 0) * np.ones((1, 2)))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("offset", OFFSETS)
@pytest.mark.parametrize("size", [9, 16])
def test_response_is_the_direct_sum_over_the_samples(name, offset, size):
    positions, bins = np.array([0.0, 3.0, -2.0]) + offset, np.array([-size // 2, -1, 0, 2, 3, 4])
    response = window(name).response(bins, positions, size)
    w = oracles.window(name, size)
    exact = [[complex(oracles.exponential_sum(int(n), float(u), size, w)) for u in positions] for n in bins]
    # samples are right to 4e-16 and exponents to 2 pi u eps: 2e-15 each
    np.testing.assert_allclose(response, exact, rtol=0, atol=4e-15 * size)


@pytest.mark.parametrize("name", NAMES)
def test_transform_is_the_integral_over_the_centred_window(name):
    offsets = np.array([0, 1e-9, 0.3, 0.5, 1.0, np.sqrt(3.0), 2.0, 2.5, -4.7, 9.5])
    exact = [oracles.window_transform(name, v) for v in offsets]
    np.testing.assert_allclose(window(name).transform(offsets), exact, rtol=0, atol=2e-15)


@pytest.mark.parametrize(("name", "zero"), [("box", 1), ("hann", 2), ("blackman", 3), ("kaiser-bessel", 2)])
def test_main_lobe_ends_where_it_should(name, zero):
    w = window(name)
    assert abs(w.transform(zero)) < 1e-15
    assert w.transform(np.linspace(0, zero - 0.01, 100)).min() > 0
    assert abs(KAISER_SHAPE - math.pi * math.sqrt(3)) < 1e-15


@pytest.mark.parametrize("name", ["box", "hann", "blackman"])
def test_cosine_sums_fill_exactly_one_three_or_five_bins(name):
    spectrum = np.fft.fft(window(name).samples(64)) / 64
    a = window(name).coefficients
    expected = np.zeros(64)
    expected[0] = a[0]
    for j in range(1, len(a)):
        expected[[j, -j]] = (-1) ** j * a[j] / 2
    np.testing.assert_allclose(spectrum, expected, rtol=0, atol=1e-16)
    assert np.count_nonzero(expected) == {"box": 1, "hann": 3, "blackman": 5}[name]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("size", [16, 40, 41])
def test_sidelobe_envelope_bounds_what_any_wave_leaks(name, size):
    bins = np.arange(-size // 2 + 1, size // 2)
    envelope = window(name).sidelobe_envelope(bins, size)
    for offset in np.linspace(-0.5, 0.5, 41):
        seen = np.abs(window(name).response(bins, [offset], size)[:, 0])
        assert (seen <= seen.max() * envelope * (1 + 1e-9) + 1e-15 * size).all()
    assert envelope[size // 2 - 1 + size % 2] == 1  # the bin itself
    assert envelope.min() < 0.2  # a bound that bounds nothing is none


def test_a_new_cosine_sum_needs_nothing_but_its_coefficients():
    w = Window("hamming", "Hamming", (0.54, 0.46))
    assert w.samples(8)[0] == pytest.approx(0.08, abs=1e-16)
    assert w.response([0], [0.0], 8)[0, 0] == pytest.approx(0.54 * 8, rel=1e-15)


@pytest.mark.parametrize("name", ["Hann", "", "kaiser", None])
def test_unknown_windows_are_refused_with_the_list_of_names(name):
    listed = r"^window: no window named .*; choose one of box, hann, blackman, kaiser-bessel"
    with pytest.raises(LeakrefError, match=listed):
        window(name)


@pytest.mark.parametrize("size", [1, 0, -4, 2.5, np.nan])
def test_bad_sizes_are_refused(size):
    with pytest.raises(LeakrefError, match=r"^Window\.samples: size = "):
        window("hann").samples(size)
