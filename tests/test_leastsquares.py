"""Least squares against a literal loop, and an optimiser."""

from __future__ import annotations

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
    aligned_waves,
    fourier,
    leakage,
    leastsquares,
    shell_wavenumbers,
)
from leakref.dispersion import DEEP
from leakref.leastsquares import THRESHOLD, optimum
from leakref.shell import shell_at

GRID = Grid((20, 24, 64), (0.8, 0.7, 0.9))


@pytest.mark.parametrize("gravity", [1.0, 3.0])
@pytest.mark.parametrize("threshold", [0.2, 0.05])
@pytest.mark.parametrize("grid", RECTANGULAR, ids=str)
def test_minimum_is_the_literal_sum_over_strong_bins_of_the_half_space(grid, threshold, gravity):
    spectrum = fourier(np.random.default_rng(5).normal(size=grid.shape), grid, "box")
    expected, data = oracles.least_squares(spectrum.whole().tolist(), grid.bin_widths, 1.05, threshold, gravity)
    found = leastsquares.extract(spectrum, 1.05, threshold=threshold, gravity=gravity)
    # noise: well conditioned normal equations of some dozens of terms
    assert found.velocities[0] == pytest.approx(expected, abs=1e-12)
    cost = sum((omega0 + kx * expected[0] + ky * expected[1] - omega) ** 2 for kx, ky, omega, omega0 in data)
    assert found.score[0] == pytest.approx(cost, rel=1e-12)
    assert len(data) > 10
    assert found.method == "ls"


def test_gradient_vanishes_and_the_hessian_is_that_of_the_cost(tapered):
    k = shell_wavenumbers(tapered.grid, 0.5, 2.6)
    whole, found = tapered.whole().tolist(), leastsquares.extract(tapered, k, gravity=1.0)
    for n, k_i in list(enumerate(k))[::4]:
        _, data = oracles.least_squares(whole, tapered.grid.bin_widths, k_i, THRESHOLD)

        def cost(u, v, data=data):
            return sum((omega0 + kx * u + ky * v - omega) ** 2 for kx, ky, omega, omega0 in data)

        scale = found.hessian[n].max()
        assert np.abs(found.gradient[n]).max() < 1e-13 * scale
        # quadratic: differences are exact but for the rounding of the cost over the step
        assert np.abs(oracles.differences(cost, found.velocities[n], 0.1)).max() < 1e-12 * scale
        moved = np.array([oracles.differences(cost, found.velocities[n] + 0.1 * unit, 0.1) for unit in np.eye(2)]) / 0.1
        np.testing.assert_allclose(found.hessian[n], moved, rtol=0, atol=1e-11 * scale)
        assert np.linalg.eigvalsh(found.hessian[n])[0] > 0
        fit = minimize(
            lambda c, cost=cost: cost(*c),
            [0.0, 0.0],
            method="Nelder-Mead",
            options={"xatol": 1e-9, "fatol": 0, "maxiter": 400},
        )
        # a minimum is only seen to the square root of the rounding of the cost (decision D8)
        blur = np.sqrt(1e-14 * cost(*found.velocities[n]) / np.linalg.eigvalsh(found.hessian[n])[0])
        assert np.abs(fit.x - found.velocities[n]).max() < 1e-8 + 10 * blur


def test_threshold_is_of_the_shells_own_largest_power_and_inclusive():
    # a strong wave in another shell must not matter (decision D7)
    kx, ky, domega = GRID.bin_widths
    near, _ = aligned_waves(GRID, [(3, 1, 12), (-1, 3, 11)], gravity=1.0)
    strong = Components(
        *(
            np.append(getattr(near, n), v)
            for n, v in (("kx", 8 * kx), ("ky", 0.0), ("omega", 20 * domega), ("amplitude", 50.0), ("phase", 0.0))
        )
    )
    one, other = (
        leastsquares.extract(leakage.spectrum(c, GRID, "box"), 1.2, gravity=1.0).velocities for c in (near, strong)
    )
    assert np.abs(one - other).max() < 1e-12
    # a third wave that does not share the current counts as soon as its power is a fifth
    for power, counts in ((0.19, False), (0.21, True)):
        third = Components(
            *(
                np.append(getattr(near, n), v)
                for n, v in (
                    ("kx", 3 * kx),
                    ("ky", -ky),
                    ("omega", 14 * domega),
                    ("amplitude", np.sqrt(power)),
                    ("phase", 0.0),
                )
            )
        )
        velocity = leastsquares.extract(leakage.spectrum(third, GRID, "box"), 1.2, gravity=1.0).velocities
        assert (np.abs(velocity - one).max() > 1e-3) == counts


def test_a_bin_at_the_threshold_is_noted():
    for power, noted in ((0.2, True), (0.2001, False), (0.1999, False)):
        waves, _ = aligned_waves(GRID, [(3, 1, 12), (-1, 3, 11)], amplitude=(1.0, np.sqrt(power)), gravity=1.0)
        found = leastsquares.extract(leakage.spectrum(waves, GRID, "box"), 1.2, gravity=1.0)
        assert (Note.THRESHOLD in found.notes[0]) == noted


def test_one_wave_or_one_bin_is_flat_and_no_number():
    wave, _ = aligned_waves(GRID, [(3, 1, 12)], gravity=1.0)
    alone = leastsquares.extract(leakage.spectrum(wave, GRID, "box"), 1.2, gravity=1.0)
    assert alone.notes == (Note.TOO_FEW_BINS | Note.FLAT,)
    kx, ky, domega = GRID.bin_widths
    column = Components([3 * kx] * 2, [ky] * 2, [12 * domega, 14 * domega], [1.0, 0.9], [0.0, 1.0])
    two = leastsquares.extract(leakage.spectrum(column, GRID, "box"), 1.2, gravity=1.0)  # two bins, one direction
    assert two.notes == (Note.FLAT,)
    for found in (alone, two):
        assert all(np.isnan(getattr(found, n)).all() for n in ("velocities", "score", "gradient", "hessian"))


def test_no_signal_is_no_number():
    found = leastsquares.extract(fourier(np.zeros(GRID.shape), GRID), [1.2, 1.4], gravity=1.0)
    assert found.notes == (Note.NO_SIGNAL,) * 2
    assert np.isnan(found.velocities).all()
    assert found.evaluations.tolist() == [0, 0]


def test_optimum_takes_the_threshold_of_the_paper_by_default(tapered):
    shell = shell_at(tapered, 1.0, water=DEEP)
    assert np.array_equal(optimum(shell).velocity, optimum(shell, 0.2).velocity)
    assert not np.array_equal(optimum(shell).velocity, optimum(shell, 0.5).velocity)
    assert THRESHOLD == 0.2


@pytest.mark.parametrize(
    ("settings", "fault"),
    [
        ({"threshold": 0}, "threshold = 0"),
        ({"threshold": -0.2}, "threshold = -0.2"),
        ({"threshold": 1.1}, "threshold = 1.1"),
        ({"threshold": np.nan}, "threshold = nan"),
        ({"gravity": -1}, "gravity = -1"),
        ({"half_width": 0}, "half_width = 0"),
    ],
)
def test_bad_settings_are_refused(tapered, settings, fault):
    with pytest.raises(LeakrefError) as caught:
        leastsquares.extract(tapered, 1.0, **{"gravity": 1.0, **settings})
    assert fault in caught.value.fault
    assert caught.value.remedy
