"""The spectrum: its sign, its symmetries, and the closed form against the FFT."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from leakref import Components, Grid, fourier, synthesize
from leakref._base import FloatArray
from leakref.window import window as named_window

from .examined import SINGLE, Examined
from .strategies import examples, grids, waves, windows

Array = npt.NDArray[Any]
ROUNDING = 1e-13
"""Of the largest |S|: the FFT and the closed form agree to 2e-14 for cubes of 351 million samples."""


def noise(grid: Grid, seed: int) -> FloatArray:
    """Any surface: white noise. What holds of a transform holds of all surfaces."""
    return np.random.default_rng(seed).standard_normal(grid.shape)


def reversed_bins(s: Array, axes: tuple[int, ...] = (0, 1, 2)) -> Array:
    """S at (-k, -omega), or with some axes reversed only."""
    return np.asarray(np.roll(np.flip(s, axes), (1,) * len(axes), axes))


def spectra(examined: Examined, grid: Grid, window: str, *surfaces: FloatArray) -> list[Array]:
    """S of each surface, all divided by the largest |S| of them: unnormalised is up to one factor."""
    examined.offered("spectrum", window=window)
    found = [examined.ask("spectrum", eta, grid.spacing, window) for eta in surfaces]
    largest = max(np.abs(s).max() for s in found)
    assume(largest > 0)
    return [s / largest for s in found]


def near(examined: Examined, one: Array, other: Array) -> None:
    """Fail unless two spectra of largest value about 1 agree, the reference to rounding, others to single precision."""
    allowed = ROUNDING if examined.is_reference else SINGLE
    error = float(np.abs(one - other).max())
    assert error <= allowed, f"differs by {error:.2g} of the largest |S|, should be at most {allowed:.0e}"


SEEDS = st.integers(0, 10**6)


@examples(120, shrink=True)
@given(data=st.data(), grid=grids(), window=windows())
def test_closed_form_is_the_fft_of_the_surface(modules: Any, data: st.DataObject, grid: Grid, window: str) -> None:
    """Route B against route A on every bin, for waves on bins, off them and within rounding of them: 1e-13 of the sum
    of the amplitudes times the samples."""
    components = data.draw(waves(grid), label="waves")
    a, b = (modules.chain.transform(components, grid, (window,), route=route)[0].values for route in "AB")
    assert np.abs(a - b).max() <= ROUNDING * components.amplitude.sum() * np.prod(grid.shape)


@examples(60, shrink=True)
@given(data=st.data(), grid=grids(), window=windows())
def test_spectrum_is_that_of_the_waves(examined: Examined, data: st.DataObject, grid: Grid, window: str) -> None:
    """A few waves have the spectrum that follows from the paper's sums, up to one factor, in size and phase where S is
    complex: 1e-13 of the largest |S|, others single precision; they may sample their window at n / (N - 1)."""
    components = data.draw(waves(grid), label="waves")
    eta = synthesize(components, *(grid.samples(axis) for axis in range(3)))
    assume(np.abs(eta).max() > 1e-3)
    (s,) = spectra(examined, grid, window, eta)
    samplings: list[dict[str, bool]] = [{}] if examined.is_reference else [{}, {"symmetric": True}]
    errors = []
    for sampling in samplings:
        should = fourier(eta, grid, window, workers=1, **sampling).whole()
        should = should if np.iscomplexobj(s) else np.abs(should)
        assume(np.abs(should).max() > 1e-3 * np.abs(eta).max())  # the window may leave nothing of so short an axis
        factor = float((np.vdot(should, s) / np.vdot(should, should)).real)
        errors.append(float(np.abs(s - factor * should).max()))
    allowed = ROUNDING if examined.is_reference else SINGLE
    assert min(errors) <= allowed, f"{min(errors):.2g} of the largest |S| off, should be at most {allowed:.0e}"


@examples(60, shrink=True)
@given(data=st.data(), grid=grids())
@example(data=None, grid=Grid((5, 7, 8), (1.0, 2.0, 0.5)))
def test_a_wave_on_a_bin_is_at_its_own_bin_and_its_mirror_image(examined: Examined, data: Any, grid: Grid) -> None:
    """Box: S is at (+k, +omega) and (-k, -omega), nowhere else; 1e-13, others single precision. A forward transform in
    time puts it at (-k, +omega)."""
    examined.offered("spectrum", window="box")
    bins = [1, 2, 3] if data is None else [data.draw(st.integers(-((n - 1) // 2), (n - 1) // 2)) for n in grid.shape]
    kx, ky, omega = np.array(bins) * grid.bin_widths
    wave = Components(kx, ky, omega, np.array(1.0), np.array(0.4))
    eta = synthesize(wave, *(grid.samples(axis) for axis in range(3)))
    (s,) = spectra(examined, grid, "box", eta)
    should = np.zeros(grid.shape)
    should[tuple(bins)] = should[tuple(-b for b in bins)] = 1.0
    near(examined, np.abs(s), should)


@examples(60, shrink=True)
@given(grid=grids(), window=windows(), seed=SEEDS)
def test_the_spectrum_of_a_real_signal_is_its_own_mirror_image(
    examined: Examined, grid: Grid, window: str, seed: int
) -> None:
    """S(-k, -omega) = conj S(k, omega): 1e-13, others single precision."""
    (s,) = spectra(examined, grid, window, noise(grid, seed))
    near(examined, s, reversed_bins(s).conj())


@examples(60, shrink=True)
@given(grid=grids(), window=windows(), seed=SEEDS, factor=st.floats(-3, 3))
def test_the_spectrum_is_linear(examined: Examined, grid: Grid, window: str, seed: int, factor: float) -> None:
    """S of a sum is the sum of S: 1e-13, others single precision; not asked of those that return a magnitude."""
    one, other = noise(grid, seed), noise(grid, seed + 1)
    a, b, both = spectra(examined, grid, window, one, other, one + factor * other)
    if not np.iscomplexobj(a):
        pytest.skip("returns the magnitude of S, which is not linear")
    near(examined, both, a + factor * b)


@examples(60, shrink=True)
@given(grid=grids(), window=windows(), seed=SEEDS)
def test_parseval(examined: Examined, grid: Grid, window: str, seed: int) -> None:
    """The sum of |S|^2 over the mean square of the tapered surface is the same for all surfaces, and the squared number
    of samples for the reference: 1e-13 times it, others single precision. Box and Hann, sampled either way (D1)."""
    examined.offered("spectrum", window=window)
    surfaces = [noise(grid, seed), 1 + noise(grid, seed + 1)]
    energies = [float((np.abs(examined.ask("spectrum", eta, grid.spacing, window)) ** 2).sum()) for eta in surfaces]
    misses = []
    for symmetric in [False] if examined.is_reference else [False, True]:
        w = [named_window(window).samples(n, symmetric=symmetric) for n in grid.shape]
        tapered = [(w[0][:, None, None] * w[1][:, None] * w[2] * eta) ** 2 for eta in surfaces]
        assume(all(t.max() > 1e-3 for t in tapered))
        one, other = (e / (t.sum() * t.size) for e, t in zip(energies, tapered, strict=True))
        misses.append(max(abs(one - 1), abs(other - 1)) if examined.is_reference else abs(one - other) / abs(one))
    assert min(misses) <= (ROUNDING if examined.is_reference else 4 * SINGLE)


@examples(60, shrink=True)
@given(data=st.data(), grid=grids(), seed=SEEDS)
def test_a_circular_shift_turns_phases_only(examined: Examined, data: st.DataObject, grid: Grid, seed: int) -> None:
    """Box only: 1e-13, others single precision. S times exp(-i (k.x - omega t)) of the shift."""
    eta = noise(grid, seed)
    steps = tuple(data.draw(st.integers(-n, n)) for n in grid.shape)
    a, b = spectra(examined, grid, "box", eta, np.roll(eta, steps, (0, 1, 2)))
    turn = sum(
        sign * step * np.fft.fftfreq(n).reshape([-1 if axis == at else 1 for at in range(3)])
        for axis, (sign, step, n) in enumerate(zip((1, 1, -1), steps, grid.shape, strict=True))
    )
    near(examined, b, a * np.exp(-2j * np.pi * turn) if np.iscomplexobj(a) else a)


@examples(60, shrink=True)
@given(grid=grids(), window=windows(), seed=SEEDS, axis=st.integers(0, 2))
def test_index_reversal_reverses_the_axis_of_the_spectrum(
    examined: Examined, grid: Grid, window: str, seed: int, axis: int
) -> None:
    """In size: index n to -n modulo the size, under which a periodic window is even, or the plain flip (D1). 1e-13,
    others single precision."""
    eta = noise(grid, seed)
    flips = [np.roll(np.flip(eta, axis), shift, axis) for shift in ((1,) if examined.is_reference else (1, 0))]
    s, *found = (np.abs(s) for s in spectra(examined, grid, window, eta, *flips))
    should = reversed_bins(s, (axis,))
    near(examined, min(found, key=lambda turned: float(np.abs(turned - should).max())), should)
