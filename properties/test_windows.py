"""Windows: their lobes at arbitrary offsets, their zeros on bins, and their symmetry."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from leakref._base import FloatArray

from .examined import SINGLE, Examined
from .strategies import examples, offsets, sizes, windows

COSINES = {"box": (1.0,), "hann": (0.5, 0.5), "blackman": (0.42, 0.5, 0.08)}
"""a_j of w = sum of a_j cos(2 pi j t / T), t from the middle: eq:hann and app:window_comparison."""
NODES, WEIGHTS = np.polynomial.legendre.leggauss(200)


def textbook(name: str, t: FloatArray) -> FloatArray:
    """The window at times `t` from its middle, in half durations: -1 to 1."""
    if name in COSINES:
        return np.asarray(sum(a * np.cos(np.pi * j * t) for j, a in enumerate(COSINES[name])))
    shape = np.pi * np.sqrt(3)  # decision D14
    return np.i0(shape * np.sqrt(np.maximum(1 - t**2, 0))) / np.i0(shape)


@examples(200, shrink=True)
@given(name=windows(), offset=offsets(20.0))
@example(name="hann", offset=1.0)
@example(name="blackman", offset=-2.0)
@example(name="hann", offset=1 + 1e-9)
def test_lobe_is_the_transform_of_the_textbook_window(modules: Any, name: str, offset: float) -> None:
    """At arbitrary offsets, to 1e-14: Gauss-Legendre with 200 nodes has 40 half waves to rounding."""
    integral = (WEIGHTS * textbook(name, NODES) * np.cos(np.pi * NODES * offset)).sum() / 2
    assert abs(float(modules.window.window(name).transform(offset)) - integral) < 1e-14


@examples(100, shrink=True)
@given(name=st.sampled_from(list(COSINES)), distance=st.integers(1, 10**6), size=sizes(256))
def test_lobes_vanish_on_bins(modules: Any, name: str, distance: int, size: int) -> None:
    """Beyond the bins of the window's own lines. The lobes to 3e-16: each is a sinc, sin(pi v) / (pi v), and pi v is
    rounded. The transform of the samples, periodic (D1), to 1e-15 of their number."""
    window, lines = modules.window.window(name), len(COSINES[name])
    for v in (distance + lines - 1, -distance - lines + 1):
        assert abs(float(window.transform(v))) < 3e-16
    beyond = np.fft.fft(window.samples(size))[lines : size - lines + 1]
    assert np.abs(beyond).max(initial=0) < 1e-15 * size


@examples(100, shrink=True)
@given(name=windows(), size=sizes(128), nearest=st.integers(-64, 64), rest=offsets(0.5))
@example(name="box", size=128, nearest=60, rest=1e-9)
@example(name="hann", size=127, nearest=-63, rest=1e-3)
def test_response_is_the_sum_over_samples(modules: Any, name: str, size: int, nearest: int, rest: float) -> None:
    """On every bin, for a wave on a bin, between bins or within rounding of one, to 2e-14 of the number of samples:
    what the sum itself loses, its phases being those of at most half a turn for each sample.

    A kernel in which n - u of large numbers is formed errs by 6e-6 at 1e-9 of a bin.
    """
    position, bins, m = nearest + rest, np.arange(size), np.arange(size)
    turns = ((bins[:, None] - nearest) * m) % size / size - (position - nearest) * m / size
    window = modules.window.window(name)
    sums = (window.samples(size) * np.exp(-2j * np.pi * turns)).sum(axis=1)
    assert np.abs(window.response(bins, position, size)[:, 0] - sums).max() <= 2e-14 * size


@pytest.mark.parametrize("name", [*COSINES, "kaiser-bessel"])
@examples(60, shrink=True)
@given(size=sizes(256), offset=offsets(6.0))
@example(size=2, offset=0.0)
@example(size=3, offset=1.0)
def test_samples_have_the_lobes_of_the_window(examined: Examined, name: str, size: int, offset: float) -> None:
    """The transform of the samples of a window at any offset is that of the textbook window sampled at n / N, or at
    n / (N - 1) in other codes than the reference (decision D1); to 1e-14 of N, others to single precision."""
    examined.offered("window", name=name)
    w, n = examined.ask("window", name, size), np.arange(size)
    wave = np.exp(2j * np.pi * offset * n / size)
    lobes = [
        abs(complex(((w - textbook(name, 2 * n / over - 1)) * wave).sum())) / size
        for over in (size, *([] if examined.is_reference else [size - 1]))
    ]
    assert min(lobes) <= (1e-14 if examined.is_reference else SINGLE), f"{name}[{size}] = {w}, at {offset} bins"


@pytest.mark.parametrize("name", [*COSINES, "kaiser-bessel"])
@examples(60, shrink=True)
@given(size=sizes(1024))
def test_windows_are_even_and_between_zero_and_one(examined: Examined, name: str, size: int) -> None:
    """Under index reversal modulo n, or the plain flip in other codes: to 1e-15, others to single precision."""
    examined.offered("window", name=name)
    w = examined.ask("window", name, size)
    allowed = 1e-15 * size if examined.is_reference else SINGLE
    flips = [np.roll(w[::-1], 1), *([] if examined.is_reference else [w[::-1]])]
    assert min(np.abs(w - flipped).max() for flipped in flips) <= allowed
    assert -allowed <= w.min() <= w.max() <= 1 + allowed
