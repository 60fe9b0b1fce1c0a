"""Water with a bottom and a surface tension: the law, the Doppler shift, the sea, both routes, fast path, ensembles.

Witnesses are the high-precision oracle (`golden.oracle`, 40 digits, written otherwise), quadrature, and limits.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy.integrate import quad

from leakref import (
    Components,
    ExponentialCurrent,
    Grid,
    LeakrefError,
    LinearCurrent,
    ProfileCurrent,
    Scales,
    SeaState,
    UniformCurrent,
    aligned_waves,
    ensemble,
    fast,
    leastsquares,
    nsp,
    runs,
)
from leakref.cases import Configuration
from leakref.chain import analyse, extract, shell_wavenumbers, transform
from leakref.currents import weight
from leakref.dispersion import DEEP, Water, velocity_resolutions, velocity_unit
from leakref.golden import oracle
from leakref.methods import METHODS
from leakref.sea import jonswap
from leakref.shell import Note, shell_at
from leakref.synthesis import synthesize

mpf = oracle.mpf
# S k0^2 / g of clean water, 7.28e-5 m3/s2, where the peak is 10, 5 and 2 cm long
TENSION = {10: 0.0293, 5: 0.117, 2: 0.732}
WATERS = {
    "0.7": Water(1.0, depth=0.7),
    "1.2": Water(1.0, depth=1.2),
    "2": Water(1.0, depth=2.0),
    "10cm": Water(1.0, surface_tension=TENSION[10], depth=0.7),
    "5cm": Water(1.0, surface_tension=TENSION[5], depth=1.2),
    "2cm": Water(1.0, surface_tension=TENSION[2]),
}
GRIDS = {  # no two sides alike: oblong and even, odd, prime
    "oblong": Grid((40, 56, 64), (0.8, 0.62, 0.45)),
    "odd": Grid((45, 39, 63), (0.7, 0.75, 0.5)),
    "prime": Grid((37, 43, 61), (0.85, 0.7, 0.48)),
}
SMALL = Grid.scaled(5, 10)
K = [1.0, 1.4, 1.8]
UNSAFE = Note.ANOTHER_BASIN | Note.EDGE | Note.FLAT | Note.THRESHOLD  # as in test_fast
CURRENT = (0.1, -0.06)
waters = pytest.mark.parametrize("water", WATERS.values(), ids=WATERS)
grids = pytest.mark.parametrize("grid", GRIDS.values(), ids=GRIDS)


def seas(water, realization=3, length=5, direction=70, current=CURRENT):
    return SeaState(direction, 60, length=length, current=UniformCurrent(current), water=water).components(realization)


def grid_resolutions(grid):
    return grid.wavenumber_resolution, grid.frequency_resolution


def given_to_oracle(water):
    return water.gravity, None if water.depth == np.inf else water.depth, water.surface_tension


@oracle.at_digits
def exact(function, k, *rest):
    return np.array([float(function(mpf(float(one)), *rest)) for one in k])


# ---- the law


@pytest.mark.parametrize("gravity", [1.0, 9.81])
@pytest.mark.parametrize("tension", [0.0, 7.28e-5, 0.5])
@pytest.mark.parametrize("depth", [1e-4, 1e-3, 0.03, 0.7, 1.2, 2.0, 40.0, 1e4, np.inf])
def test_the_law_is_that_of_the_oracle_from_shallow_to_deep(gravity, tension, depth):
    k, water = np.array([0.01, 0.3, 1.0, 2.7, 90.0]), Water(gravity, depth, tension)
    given = given_to_oracle(water)
    with np.errstate(over="raise", invalid="raise", divide="raise"):
        omega, phase, group = water.frequency(k), water.phase_velocity(k), water.group_velocity(k)
        density, factor = water.density_factor(k), water.depth_factor(k)
    exactly, slope = exact(oracle.dispersion, k, *given), exact(oracle.group_velocity, k, *given)
    # some ten roundings each, in products and roots of positive terms: no digit is lost anywhere
    np.testing.assert_allclose(omega, exactly, rtol=1e-15)
    np.testing.assert_allclose(phase, exactly / k, rtol=1e-15)
    np.testing.assert_allclose(group, slope, rtol=1.5e-15)
    np.testing.assert_allclose(density, 2 * slope / k, rtol=2e-15)
    np.testing.assert_allclose(factor, exact(oracle.depth_factor, k, given[1]), rtol=1.5e-15)


def test_without_bottom_and_tension_it_is_deep_water_bit_for_bit():
    k = np.random.default_rng(2).uniform(1e-3, 50, 1000)
    for g in (1.0, 9.81):
        water = Water(g, depth=np.inf, surface_tension=0.0)
        assert water == Water(g)
        assert np.array_equal(water.frequency(k), np.sqrt(g * k))
        assert np.array_equal(water.phase_velocity(k), np.sqrt(g / k))
        assert np.array_equal(water.group_velocity(k), np.sqrt(g / k) / 2)
        assert np.array_equal(water.density_factor(k), k**-1.5 * float(np.sqrt(g)))
        assert np.array_equal(water.depth_factor(k), np.ones(k.size))
    for deep in (Water(1.0, depth=1e5), Water(1.0, depth=1e60)):  # nothing beside 1 is left of the bottom
        for name in ("frequency", "phase_velocity", "group_velocity", "density_factor", "depth_factor"):
            assert np.array_equal(getattr(deep, name)(k), getattr(DEEP, name)(k)), name


@waters
def test_a_wavenumber_of_zero_has_no_frequency(water):
    assert water.frequency(0.0) == 0
    assert water.frequency(np.array([[0.0, 1.0]])).shape == (1, 2)
    assert np.shape(water.frequency(1.0)) == ()


@pytest.mark.parametrize("shift", [1e-3, 0.3])
@waters
def test_the_resolution_by_wavenumber_is_that_of_the_group_velocity(water, shift):
    from_frequency, from_wavenumber = velocity_resolutions(K, shift, 0.05, water)
    np.testing.assert_allclose(from_frequency, 0.05 / np.array(K), rtol=1e-15)
    np.testing.assert_allclose(
        from_wavenumber, exact(oracle.group_velocity, K, *given_to_oracle(water)) * shift / K, rtol=2e-15
    )


@waters
def test_the_search_is_measured_in_phase_velocities_of_the_peak_in_this_water(water):
    assert velocity_unit(1.7, water, None) == velocity_unit(1.7, water, 1.0) == float(water.phase_velocity(1.0))
    assert velocity_unit(1.7, replace(water, gravity=9.81), None) == float(
        replace(water, gravity=9.81).phase_velocity(1.7)
    )
    (spectrum,) = transform(seas(water), GRIDS["odd"], ("hann",), route="B")
    shell = shell_at(spectrum, 1.4, water=water)
    unit, a = velocity_unit(1.4, water, 1.0), 4 * spectrum.grid.frequency_resolution
    assert shell.frequency == pytest.approx(float(water.frequency(1.4)), rel=1e-15)
    inside = (shell.omega[-1] - float(water.frequency(1.4)) - 3 * a) / 1.4
    assert nsp.score_range(shell, a, unit) == pytest.approx(min(1.2 * unit, inside), rel=1e-14)


BAD = [("depth", value) for value in (0, 0.0, -1, -np.inf, np.nan, "4", "deep", True, None, [1.0, 2.0], 1e70)]
BAD += [("surface_tension", value) for value in (-1e-9, np.nan, np.inf, "0.1", "clean", True, None, [0.1])]
BAD += [("gravity", value) for value in (0, -9.81, np.nan, np.inf, "9.81", True)]


@pytest.mark.parametrize(("name", "value"), BAD)
def test_what_is_no_depth_tension_or_gravity_is_refused(name, value):
    with pytest.raises(LeakrefError, match=rf"^Water: {name} ") as refused:
        Water(**{"gravity": 1.0, name: value})
    assert refused.value.remedy
    if name != "gravity":
        with pytest.raises(LeakrefError, match=rf"^Water: {name} "):
            Configuration("depth", **{name: value})


def test_seas_are_in_scaled_units():
    for water, fault in ((Water(9.81, 4.0), "scaled units"), (4.0, "no law"), (Water, "no law"), (None, "")):
        if water is None:
            assert SeaState(water=DEEP).water is DEEP
            continue
        with pytest.raises(LeakrefError, match=rf"^SeaState: water = .*{fault}"):
            SeaState(water=water)
    with pytest.raises(LeakrefError, match=r"^aligned_waves: gravity"):
        aligned_waves(SMALL, [(5, 3, 11)], gravity=0)


# ---- the Doppler shift of a current that varies with depth

KS = np.array([0.2, 1.0, 2.3, 3.5])
DEPTHS = [1e-3, 0.05, 0.7, 1.2, 2.0, 40.0, 1e4, np.inf]
PROFILES = {
    "uniform": (UniformCurrent((0.2, -0.3)), {"velocity": (0.2, -0.3)}),
    "linear": (LinearCurrent((0.2, -0.1), (0.05, 0.4)), {"velocity": (0.2, -0.1), "shear": (0.05, 0.4)}),
    "exponential": (ExponentialCurrent((0.3, -0.2), 0.7), {"layers": [(0.3, -0.2, 0.7)]}),
    "thin": (ExponentialCurrent((0.3, -0.2), 0.01), {"layers": [(0.3, -0.2, 0.01)]}),
    "thick": (ExponentialCurrent((0.3, -0.2), 300.0), {"layers": [(0.3, -0.2, 300.0)]}),
}
# where 1 / d is 2 k, and to either side of it
PROFILES |= {
    f"p=q{off:+g}": (ExponentialCurrent((0.3, -0.2), 0.5 + off), {"layers": [(0.3, -0.2, 0.5 + off)]})
    for off in (0.0, 1e-15, -1e-12, 1e-9, -1e-6, 1e-3)
}


def as_profile(current, z):
    z = z[:, None]
    if isinstance(current, LinearCurrent):
        return np.asarray(current.surface) + np.asarray(current.shear) * z
    if isinstance(current, ExponentialCurrent):
        return np.asarray(current.surface) * np.exp(z / current.depth)
    return np.asarray(current.velocity) + 0 * z


@pytest.mark.parametrize("depth", DEPTHS)
@pytest.mark.parametrize("name", PROFILES)
def test_closed_forms_are_the_quadrature_of_the_profile(name, depth):
    current, _ = PROFILES[name]
    with np.errstate(over="raise", invalid="raise", divide="raise"):
        closed = current.doppler_shift_velocity(KS, Water(1.0, depth=depth))
        integral = ProfileCurrent(partial(as_profile, current)).doppler_shift_velocity(KS, Water(1.0, depth=depth))
    np.testing.assert_allclose(integral, closed, rtol=0, atol=1e-12)


@pytest.mark.parametrize("depth", [1e-3, 0.7, 40.0])
@pytest.mark.parametrize("name", PROFILES)
def test_closed_forms_are_the_integral_of_the_oracle(name, depth):
    current, profile = PROFILES[name]
    closed = current.doppler_shift_velocity(KS[1:2], Water(1.0, depth=depth))

    @oracle.at_digits
    def exactly():
        return [[float(v) for v in oracle.doppler(profile, k, depth)] for k in KS[1:2]]

    # the linear one is a difference of two parts, each rounded some three times
    np.testing.assert_allclose(closed, exactly(), rtol=2e-15, atol=2e-16 if name == "linear" else 0)


@pytest.mark.parametrize("name", PROFILES)
def test_far_above_the_bottom_the_shift_is_that_of_deep_water(name):
    current, _ = PROFILES[name]
    deep = current.doppler_shift_velocity(KS)
    assert np.array_equal(current.doppler_shift_velocity(KS, Water(1.0, depth=np.inf, surface_tension=0.3)), deep)
    for depth in (400.0, 1e4, 1e60):
        far = current.doppler_shift_velocity(KS, Water(1.0, depth=depth))
        rest = (
            1.0 if name != "thick" else 1 / -np.expm1(-2 * KS[:, None] * depth - depth / current.depth)
        )  # all is in h
        np.testing.assert_allclose(far * rest, deep, rtol=2e-15, atol=1e-16)
    assert np.array_equal(
        ProfileCurrent(partial(as_profile, current)).doppler_shift_velocity(KS, Water(1.0, depth=1e60)),
        ProfileCurrent(partial(as_profile, current)).doppler_shift_velocity(KS),
    )


@pytest.mark.parametrize("depth", [1e-3, 0.7, 2.0, 1e4, np.inf])
def test_the_weight_over_depth_adds_up_to_one_and_is_the_cosh_of_the_equation(depth):
    water = Water(1.0, depth=depth)
    for k in (0.3, 2.3):
        bottom = min(depth, 20 / k)
        total = quad(lambda z, k=k: float(weight(k, z, water)), -bottom, 0, epsabs=1e-13, epsrel=1e-13)[0]
        assert total == pytest.approx(1, abs=1e-12)
        for z in (0.0, -0.3 * bottom, -bottom):

            @oracle.at_digits
            def exactly(k=k, z=z):
                k, z, mp = mpf(k), mpf(z), oracle.mp
                if depth == np.inf:
                    return float(2 * k * mp.exp(2 * k * z))
                return float(2 * k * mp.cosh(2 * k * (z + mpf(depth))) / mp.sinh(2 * k * mpf(depth)))

            assert float(weight(k, z, water)) == pytest.approx(exactly(), rel=4e-16 * max(5, 4 * k * bottom))
    assert weight(1.0, 0.0, Water(1.0, depth=1e-3)) == pytest.approx(1e3, rel=2e-6)  # 1 / h (1 + (2 k h)^2 / 3)


class Own:
    """A current of somebody's own, without a depth."""

    def doppler_shift_velocity(self, wavenumber):
        return np.tile([0.1, 0.2], (wavenumber.size, 1))


class Deeper(Own):
    def doppler_shift_velocity(self, wavenumber, water=DEEP):
        return np.full((wavenumber.size, 2), min(water.depth, 9.0))


def test_a_current_of_ones_own_is_asked_with_the_water_only_above_a_bottom():
    for water in (DEEP, WATERS["2cm"]):
        assert SeaState(length=2, current=Own(), water=water).components(0).kx.size
    with pytest.raises(
        LeakrefError, match=r"^SeaState.components: Own knows no bottom.* 0.7 deep.*\(wavenumber, water"
    ):
        SeaState(length=2, current=Own(), water=WATERS["0.7"]).components(0)
    for water, speed in ((DEEP, 9.0), (WATERS["0.7"], 0.7)):
        sea = SeaState(length=2, current=Deeper(), water=water).components(0)
        k = np.hypot(sea.kx, sea.ky)
        np.testing.assert_allclose(sea.omega, water.frequency(k) + speed * (sea.kx + sea.ky), rtol=1e-14, atol=1e-14)


# ---- the sea


@waters
def test_the_sea_is_that_of_the_oracle(water):
    _, depth, tension = given_to_oracle(water)
    profile = {"velocity": (0.2, -0.1), "shear": (0.05, 0.4)}
    given = {"direction": 70.0, "spread": 60.0, "peakedness": 3.3, "length": 1.1, "realization": 4}
    sea = SeaState(70.0, 60.0, 3.3, 1.1, LinearCurrent((0.2, -0.1), (0.05, 0.4)), water).components(4)

    @oracle.at_digits
    def exactly():
        seen = {**given, "depth": depth, "surface_tension": tension}
        closed = LinearCurrent((0.2, -0.1), (0.05, 0.4))  # the oracle's own integral is held against it above

        def shift(k):
            if depth is not None and abs(k - 1) < 0.1:
                return oracle.doppler(profile, k, depth)
            return closed.doppler_shift_velocity(np.array([float(k)]), water)[0].tolist()

        return [[float(v) for v in column] for column in oracle.components(seen, shift)]

    kx, ky, omega, amplitude, phase = map(np.array, exactly())
    k = np.hypot(kx, ky)
    np.testing.assert_allclose([sea.kx, sea.ky], [kx, ky], rtol=4e-16, atol=4e-16)
    np.testing.assert_allclose(sea.omega, omega, rtol=0, atol=4e-15)
    assert np.array_equal(sea.phase, phase)
    # roundings in the exponents count as often as the exponents are large (golden.stages.waves)
    scale = amplitude * (12 + 2.5 / np.minimum(k, 1) ** 4) + amplitude.max() * 720 * np.pi / 60 / 50
    assert np.all(np.abs(sea.amplitude - amplitude) <= 2.3e-16 * scale)


@waters
def test_the_energy_of_a_sea_is_the_integral_of_its_spectrum_over_frequencies(water):
    """By a sum over the lattice, and over omega and theta: what the density factor is for."""
    peak = float(water.frequency(1.0))
    own = SeaState(70.0, 120.0, 3.3, 40.0, water=water).components(0)

    def density(k):  # S D d omega / d k by the oracle's derivative, which is no formula of the chain
        slope = float(oracle.group_velocity(k, *given_to_oracle(water)))
        factor = float(oracle.depth_factor(k, given_to_oracle(water)[1]))
        return float(jonswap(float(oracle.dispersion(k, *given_to_oracle(water))) / peak)) * factor * slope

    total = quad(density, 0.2, 3.5, limit=200, epsrel=1e-8)[0] * np.pi / 3  # f integrates to half of 120 degrees
    assert own.variance == pytest.approx(total, rel=5e-3)  # the lattice is 0.0085 wide


def test_a_sea_far_above_the_bottom_is_that_of_deep_water():
    deep, far = (seas(water) for water in (DEEP, Water(1.0, depth=1e5)))
    for name in ("kx", "ky", "omega", "amplitude", "phase"):
        assert np.array_equal(getattr(deep, name), getattr(far, name)), name
    for water in WATERS.values():  # the same waves and phases in every water, with its own energy and frequency
        other = seas(water)
        assert set(zip(other.kx, other.ky, other.phase, strict=True)) <= set(
            zip(deep.kx, deep.ky, deep.phase, strict=True)
        )


# ---- both routes, methods, fast path


@grids
@waters
def test_both_routes_give_one_spectrum_and_one_velocity(water, grid):
    waves = seas(water, 3 + grid.shape[0])
    seen = {route: {s.window: s for s in transform(waves, grid, ("box", "hann"), route=route)} for route in "AB"}
    for window in ("box", "hann"):
        a, b = (seen[route][window].values for route in "AB")
        assert np.abs(a - b).max() <= 1e-13 * np.abs(b).max()
    quick = fast.realize(waves, grid, K, methods=tuple(METHODS), water=water)
    unflagged = 0
    for (window, method), twin in quick.items():
        found = [analyse(seen[r][window], K, water=water, method=method, peak_wavenumber=1.0) for r in "AB"]
        clean = np.array([not note for note in found[1].notes])
        unflagged += clean.sum()
        assert np.abs(found[0].velocities - found[1].velocities)[clean].max(initial=0) <= 1e-11
        for record in found:
            assert [n.names for n in record.notes] == [n.names for n in found[1].notes]
        assert twin.notes == found[1].notes
        tolerance = np.where([bool(note & UNSAFE) for note in twin.notes], 1e-6, 1e-11)[:, None]
        assert np.all(~(np.abs(twin.velocities - found[1].velocities) > tolerance))
        np.testing.assert_allclose(twin.score, found[1].score, rtol=1e-9, atol=1e-12)
        scale = np.nanmax(np.abs(found[1].hessian), initial=0.0)
        np.testing.assert_allclose(twin.hessian, found[1].hessian, rtol=0, atol=1e-9 * scale)
        if (window, method) == ("hann", "nsp"):  # and the current is found, to the resolution
            resolution = np.maximum(*velocity_resolutions(K, *grid_resolutions(grid), water))
            off = np.hypot(*(found[1].velocities - CURRENT).T)
            assert np.all(~(off[clean] > resolution[clean])), method
    assert unflagged >= 5


@waters
def test_the_fast_path_is_the_chain_on_the_grid_of_the_paper(water):
    waves, k = seas(water, 1, 5), shell_wavenumbers(SMALL, 0.4, 3.5)[::3]
    quick = fast.realize(waves, SMALL, k, windows=("hann",), methods=tuple(METHODS), water=water)
    (spectrum,) = transform(waves, SMALL, ("hann",), route="B", largest_wavenumber=4.2)
    for method in METHODS:
        plain = analyse(spectrum, k, water=water, method=method, peak_wavenumber=1.0)
        twin = quick["hann", method]
        assert twin.notes == plain.notes
        tolerance = np.where([bool(note & UNSAFE) for note in plain.notes], 1e-6, 1e-11)[:, None]
        assert np.all(~(np.abs(twin.velocities - plain.velocities) > tolerance))


def test_what_is_beyond_reach_is_measured_by_the_waves_of_this_water_in_chain_and_fast_path():
    """A current of 0.75 c0 is within 1.2 c0, but not within 1.2 of the phase velocity at the peak, 0.54 c0."""
    water, grid = Water(1.0, depth=0.3), GRIDS["odd"]
    waves = seas(water, 2, 5, 90, (0.0, 0.75))
    twin = fast.realize(waves, grid, K[1:], windows=("hann",), methods=("nsp",), water=water)["hann", "nsp"]
    (spectrum,) = transform(waves, grid, ("hann",), route="B")
    plain = analyse(spectrum, K[1:], water=water, peak_wavenumber=1.0)
    assert all(Note.EDGE in note for note in plain.notes)
    assert twin.notes == plain.notes
    assert np.abs(plain.velocities - [0.0, 0.75]).max() < 0.1


def swell(water):
    """Six waves, about as in the golden vectors."""
    n = np.arange(6)
    k, angle = 0.7 + 0.16 * n, np.radians(115.0 + 60 * ((n * np.sqrt(2)) % 1 - 0.5))
    kx, ky = k * np.cos(angle), k * np.sin(angle)
    omega = water.frequency(k) + kx * 0.3 - ky * 0.2
    return Components(kx, ky, omega, 0.3 + 0.1 * n, 1.1 * n)


@pytest.mark.parametrize(("name", "window"), [("0.7", "box"), ("2", "hann"), ("5cm", "hann"), ("2cm", "box")])
def test_velocities_are_those_of_the_oracle(name, window):
    water, grid, k_i = WATERS[name].to_units(Scales(1.0, 9.81)), Grid((11, 13, 53), (1.2, 0.9, 0.2)), 1.1  # all prime
    waves = swell(water)
    (spectrum,) = transform(waves, grid, (window,), route="A")
    listed = [getattr(waves, v).tolist() for v in ("kx", "ky", "omega", "amplitude", "phase")]
    gravity, depth, tension = given_to_oracle(water)
    start = nsp.extract(spectrum, [k_i], water=water)

    @oracle.at_digits
    def exactly():
        bins = sorted(oracle.shell_bins(grid.shape, grid.spacing, k_i))
        values = oracle.spectrum(listed, grid.shape, grid.spacing, window, bins)
        shell = oracle.Shell(values, bins, grid.shape, grid.spacing, gravity, depth=depth, surface_tension=tension)
        found = oracle.newton(shell, start.velocities[0].tolist()), oracle.least_squares(shell)
        return [[float(v) for v in c] for c in found]

    by_nsp, by_ls = exactly()
    assert not start.notes[0] & UNSAFE
    assert np.abs(start.velocities[0] - by_nsp).max() <= 1e-11
    fitted = leastsquares.extract(spectrum, [k_i], water=water)
    assert not fitted.notes[0] & UNSAFE
    assert np.abs(fitted.velocities[0] - by_ls).max() <= 1e-11


@waters
def test_two_waves_on_bins_give_their_current_exactly(water):
    bins = [(8, 5, 0), (-4, 9, 0)]
    grid = Grid((48, 44, 96), (2 * np.pi * 8 / 48, 2 * np.pi * 8.2 / 44, 1.0))  # omega0 > 2 a
    k = [np.hypot(i * grid.bin_widths[0], j * grid.bin_widths[1]) for i, j, _ in bins]
    bins = [
        (i, j, round(float(water.frequency(one)) / grid.frequency_resolution))
        for (i, j, _), one in zip(bins, k, strict=True)
    ]
    waves, current = aligned_waves(grid, bins, water=water)
    assert np.hypot(*current) < 0.1
    shift = waves.omega - waves.kx * current[0] - waves.ky * current[1]
    np.testing.assert_allclose(shift, exact(oracle.dispersion, k, *given_to_oracle(water)), rtol=1e-14)
    (spectrum,) = transform(waves, grid, ("box",), route="A")
    for method, record in METHODS.items():
        width = nsp.WIDTH * record.spread(grid, water, float(np.mean(k))) * grid.frequency_resolution
        if min(shift.min(), grid.nyquist[2] - shift.max()) < 3 * width:
            assert method == "nsp-adaptive"  # whose G reaches its mirror image, or past the band
            continue
        found = analyse(spectrum, [float(np.mean(k))], water=water, method=method)
        assert np.abs(found.velocities - current).max() < 1e-11, method


def test_a_surface_is_extracted_in_its_water():
    waves, grid = seas(WATERS["0.7"]), GRIDS["oblong"]
    (spectrum,) = transform(waves, grid, ("hann",), route="A")
    x, y, t = (grid.samples(axis) for axis in range(3))

    found = extract(synthesize(waves, x, y, t), grid.spacing, K, water=WATERS["0.7"])
    assert np.array_equal(found.velocities, analyse(spectrum, K, water=WATERS["0.7"]).velocities)
    assert (
        np.abs(found.velocities - extract(synthesize(waves, x, y, t), grid.spacing, K, gravity=1.0).velocities).max()
        > 0.1
    )


# c0 at k = 1, 1.4 and 1.8, of a trial with other realisations and programs (design, section 10): NSP, Hann, L 5, T 10
TRIAL = {
    1.0: (0.125, 0.079, 0.036),
    1.5: (0.053, 0.035, 0.016),
    2.0: (0.025, 0.022, 0.012),
    np.inf: (0.008, 0.015, 0.011),
}


@pytest.mark.parametrize("depth", TRIAL)
def test_a_current_is_recovered_with_the_depth_known_and_not_if_deep_water_is_assumed(depth):
    water, errors = Water(1.0, depth=depth), {}
    for realization in range(12):
        waves = seas(water, realization, 5, 90, (0.0, 0.0))
        for assumed in (water, DEEP):
            found = fast.realize(waves, SMALL, K, windows=("hann",), methods=("nsp",), water=assumed, search=False)
            errors.setdefault(assumed, []).append(np.hypot(*found["hann", "nsp"].velocities.T))
    known, deep = (np.mean(errors[assumed], axis=0) for assumed in (water, DEEP))
    assert known.max() < 0.02  # half of the smaller resolution at k = 1.8 and a fifth of that at 1
    np.testing.assert_allclose(deep, TRIAL[depth], rtol=0.25, atol=0.004)


@pytest.mark.parametrize("depth", [0.7, 1.2])
def test_a_sheared_current_shifts_waves_as_its_kernel_above_the_bottom_says(depth):
    water, current = Water(1.0, depth=depth), LinearCurrent((0.1, 0.05), (0.0, 0.4))
    truth = current.doppler_shift_velocity(np.array(K), water)
    off = []
    for realization in range(8):
        waves = SeaState(90, 60, length=5, current=current, water=water).components(realization)
        found = fast.realize(waves, SMALL, K, windows=("hann",), methods=("nsp",), water=water, search=False)
        off.append(found["hann", "nsp"].velocities - truth)
    # along the waves, far less than what the kernel of deep water would make of it
    deep = current.doppler_shift_velocity(np.array(K))[:, 1] - truth[:, 1]
    assert abs(np.mean(off, axis=0)[0, 1]) < 0.01 < abs(deep[0]) / 2


# ---- units, cases, ensembles


@pytest.mark.parametrize("scales", [Scales(0.25, 9.81), Scales(2 * np.pi / 0.05, 9.81), Scales(3.0, 1.6)])
@waters
def test_water_goes_to_other_units_and_back(water, scales):
    other = water.to_units(scales)
    back = other.to_scaled(scales)
    assert back.gravity == 1.0
    assert (back.depth, back.surface_tension) == pytest.approx((water.depth, water.surface_tension), rel=1e-15)
    assert other.depth == pytest.approx(water.depth / scales.peak_wavenumber, rel=1e-15)
    k = np.array([0.4, 1.0, 3.5])
    for name, unit in (
        ("frequency", scales.frequency),
        ("phase_velocity", scales.velocity),
        ("group_velocity", scales.velocity),
    ):
        here, there = getattr(water, name)(k), getattr(other, name)(k * scales.wavenumber)
        np.testing.assert_allclose(there, here * unit, rtol=3e-15)


def test_clean_water_of_five_centimetres():
    metric = Water(9.81, 0.01, 7.28e-5)
    scaled = metric.to_scaled(Scales(2 * np.pi / 0.05, 9.81))
    assert scaled.surface_tension == pytest.approx(TENSION[5], rel=2e-3)
    assert scaled.depth == pytest.approx(2 * np.pi / 5, rel=1e-14)
    assert float(Water(9.81, 4.0).frequency(0.25)) == pytest.approx(np.sqrt(9.81 * 0.25 * np.tanh(1.0)), rel=1e-15)


@pytest.mark.parametrize("scales", [Scales(0.25, 9.81), Scales(2 * np.pi / 0.05, 9.81)])
def test_velocities_are_the_same_in_other_units(scales):
    water, grid = WATERS["5cm"], GRIDS["prime"]
    waves, (dx, dy, dt) = seas(water), grid.spacing
    metric = Grid(grid.shape, (dx * scales.length, dy * scales.length, dt * scales.time))
    k = np.array(K) * scales.wavenumber
    for method in METHODS:
        (here,), (there,) = transform(waves, grid, ("hann",)), transform(waves.to_units(scales), metric, ("hann",))
        one = analyse(here, K, water=water, method=method, peak_wavenumber=1.0)
        other = analyse(there, k, water=water.to_units(scales), method=method, peak_wavenumber=scales.wavenumber)
        assert np.abs(other.velocities / scales.velocity - one.velocities).max() < 1e-11
        assert other.notes == one.notes


def test_configurations_and_ensembles_have_a_water(tmp_path):
    made = Configuration("depth", length=5, duration=10, depth=0.7, surface_tension=0.1, varied=("depth",))
    assert made.id == "depth/kh=0.7"
    assert made.water == Water(1.0, depth=0.7, surface_tension=0.1)
    assert Configuration("any").water == DEEP
    assert made.grid == replace(made, depth=np.inf).grid  # the same samples in every water
    sea = SeaState(length=5, water=made.water).components(1)
    assert np.array_equal(made.components(1).omega, sea.omega)
    a, b = (ensemble.realize(made, 0, methods=("nsp",), route=route) for route in "AB")
    for key, one in a.items():
        clean = [not note for note in one.notes]
        assert np.abs(one.velocities - b[key].velocities)[clean].max() <= 1e-11
    (first,) = runs.run([made], realizations=2, methods=("ls",), folder=tmp_path)
    (again,) = runs.run([made], realizations=2, methods=("ls",), folder=tmp_path)
    (deep,) = runs.run([replace(made, depth=np.inf)], realizations=2, methods=("ls",), folder=tmp_path)
    assert np.array_equal(first[1].velocities, again[1].velocities, equal_nan=True)
    assert (
        np.nanmax(np.abs(first[1].velocities - deep[1].velocities)) > 1e-2
    )  # and is not taken from the other's folder
    for one in (*first, *deep):
        grid, k = one.configuration.grid, one.wavenumbers
        group = exact(oracle.group_velocity, k, *given_to_oracle(one.configuration.water))
        np.testing.assert_allclose(one.resolutions[1], group * grid.wavenumber_resolution / k, rtol=2e-15)
