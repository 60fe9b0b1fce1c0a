"""Dispersion, the Doppler shift of a profile, resolutions and units."""

from __future__ import annotations

import math

import numpy as np
import pytest

from leakref import ExponentialCurrent, LeakrefError, LinearCurrent, ProfileCurrent, Scales, SeaState, UniformCurrent
from leakref.dispersion import DEEP, Water, velocity_resolutions

K = np.array([0.4, 1.0, 2.3, 3.5])


@pytest.mark.parametrize("gravity", [1.0, 9.81])
def test_dispersion_of_deep_water(gravity):
    for k in K:  # two roundings each
        assert Water(gravity).frequency(k) == pytest.approx(math.sqrt(gravity * k), rel=4e-16)
        assert Water(gravity).phase_velocity(k) == pytest.approx(math.sqrt(gravity * k) / k, rel=4e-16)
        h = 1e-3 * k  # central difference of fourth order: error below h^4 k^-4 = 1e-12, rounding 1e-13
        slope = sum(w * math.sqrt(gravity * (k + n * h)) for n, w in ((-2, 1), (-1, -8), (1, 8), (2, -1))) / (12 * h)
        assert Water(gravity).group_velocity(k) == pytest.approx(slope, rel=2e-12)
    assert DEEP.frequency(0.0) == 0


def test_velocity_resolutions_are_those_of_the_equation():
    from_frequency, from_wavenumber = velocity_resolutions(K, 0.1, 0.05, Water(9.81))
    for k, a, b in zip(K, from_frequency, from_wavenumber, strict=True):
        assert a == pytest.approx(0.05 / k, rel=4e-16)
        assert b == pytest.approx(0.5 * math.sqrt(9.81 / k) * 0.1 / k, rel=1e-15)


@pytest.mark.parametrize("bad", [(0.0, 1, 1), ([1, -1], 1, 1), (1, 0, 1), (1, 1, -1), (1, np.nan, 1)])
def test_velocity_resolutions_refuse_what_is_not_positive(bad):
    with pytest.raises(LeakrefError, match=r"^velocity_resolutions: "):
        velocity_resolutions(*bad, water=DEEP)


# adaptive quadrature to 1e-12 of unit velocities, two components
@pytest.mark.parametrize(
    "closed",
    [UniformCurrent((0.2, -0.3)), LinearCurrent((0.2, -0.1), (0.05, 0.4)), ExponentialCurrent((0.3, -0.2), 0.7)],
)
def test_quadrature_of_a_profile_agrees_with_the_closed_form(closed):
    def profile(z):
        z = z[:, None]
        if isinstance(closed, UniformCurrent):
            return np.asarray(closed.velocity) + 0 * z
        if isinstance(closed, LinearCurrent):
            return np.asarray(closed.surface) + np.asarray(closed.shear) * z
        return np.asarray(closed.surface) * np.exp(z / closed.depth)

    expected = closed.doppler_shift_velocity(K)
    assert expected.shape == (4, 2)
    np.testing.assert_allclose(ProfileCurrent(profile).doppler_shift_velocity(K), expected, rtol=0, atol=2e-12)


def test_closed_forms_are_the_integral_of_the_equation():
    # 2k int U exp(2kz) dz by the midpoint rule down to where exp(2kz) = e^-40; error (2k dz)^2 / 24 < 1e-6
    z = -(np.arange(100_000) + 0.5) * 20 / 1.3 / 100_000
    weight = 2 * 1.3 * np.exp(2 * 1.3 * z) * 20 / 1.3 / 100_000
    linear, exponential = LinearCurrent((0.2, -0.1), (0.05, 0.4)), ExponentialCurrent((0.3, -0.2), 0.7)
    for component in (0, 1):
        direct = np.sum(weight * (linear.surface[component] + linear.shear[component] * z))
        assert linear.doppler_shift_velocity(np.array([1.3]))[0, component] == pytest.approx(direct, abs=1e-6)
        direct = np.sum(weight * exponential.surface[component] * np.exp(z / 0.7))
        assert exponential.doppler_shift_velocity(np.array([1.3]))[0, component] == pytest.approx(direct, abs=1e-6)


@pytest.mark.parametrize(
    ("profile", "fault"),
    [
        (lambda z: np.zeros(z.size), "shape"),
        (lambda z: np.full((z.size, 2), np.nan), "not finite"),
        (lambda z: np.random.default_rng(0).normal(size=(z.size, 2)) * np.sign(np.sin(1e9 * z))[:, None], "uncertain"),
    ],
)
def test_profiles_that_are_no_profiles_are_refused(profile, fault):
    with pytest.raises(LeakrefError, match=rf"^ProfileCurrent: .*{fault}.*; "):
        ProfileCurrent(profile).doppler_shift_velocity(K)


@pytest.mark.parametrize(
    "make",
    [
        lambda: UniformCurrent(0.3),
        lambda: UniformCurrent((0.1, 0.2, 0.3)),
        lambda: UniformCurrent((np.nan, 0.0)),
        lambda: LinearCurrent(0.1, 0.2),
        lambda: LinearCurrent((0.1, 0.0), (0.1, np.inf)),
        lambda: ExponentialCurrent((0.1, 0.0), 0.0),
        lambda: ExponentialCurrent(0.1, 1.0),
    ],
)
def test_currents_that_are_not_two_finite_components_are_refused(make):
    # a scalar must not become (U, U): that is another current
    with pytest.raises(LeakrefError):
        SeaState(length=2, current=make()).components(0)


def test_scales_are_powers_of_the_peak_wavenumber_and_gravity():
    scales = Scales(0.05, 9.81)
    assert scales.wavenumber == 0.05
    assert scales.frequency == pytest.approx(math.sqrt(9.81 * 0.05), rel=2e-16)
    assert scales.length * scales.wavenumber == 1
    assert scales.time == pytest.approx(1 / math.sqrt(9.81 * 0.05), rel=4e-16)
    assert scales.velocity == pytest.approx(math.sqrt(9.81 / 0.05), rel=4e-16)
    unit = Scales()
    assert (unit.wavenumber, unit.frequency, unit.length, unit.time, unit.velocity) == (1, 1, 1, 1, 1)


@pytest.mark.parametrize("bad", [(0, 9.81), (0.05, -9.81), (np.nan, 1), (1, np.inf)])
def test_scales_refuse_what_is_not_positive(bad):
    with pytest.raises(LeakrefError, match=r"^Scales: "):
        Scales(*bad)
