"""The sea state: spectrum, spreading, lattice, phases; and lists of waves."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import oracles
import pytest
from scipy.integrate import quad

from leakref import Components, ExponentialCurrent, Grid, LeakrefError, Scales, SeaState, UniformCurrent, aligned_waves
from leakref.sea import INPUT_SPACING, LARGEST_WAVENUMBER, directional_spreading, jonswap, uniform_phases


def test_jonswap_is_the_printed_formula():
    for w in (0.6, 0.95, 1.0, 1.000001, 1.2, 1.87):
        for gamma in (1.0, 3.3, 7.0):
            sigma = 0.07 if w <= 1 else 0.09
            r = math.exp(-0.5 * ((w - 1) / sigma) ** 2)
            # the exponents are a few units: some ten roundings
            assert jonswap(w, gamma) == pytest.approx(w**-5 * math.exp(-5 / 4 * w**-4) * gamma**r, rel=5e-15)
    assert jonswap(1.0) == pytest.approx(math.exp(-1.25) * 3.3, rel=1e-15)
    assert jonswap([0.9, 1.1]).shape == (2,)


def test_spreading_is_a_squared_cosine_of_full_width_across_the_cut():
    assert directional_spreading(170.0, -170, 60) == pytest.approx(math.cos(math.pi * 20 / 60) ** 2, rel=1e-14)
    assert directional_spreading([60, 90, 105, 120.001, 270], 90, 60) == pytest.approx([0, 1, 0.5, 0, 0], abs=1e-15)
    theta = np.linspace(-180, 180, 3601)[:-1]
    # the trapezoidal rule of a squared cosine between its roots, both on the mesh, is exact
    assert directional_spreading(theta, 35, 80).sum() * 0.1 == pytest.approx(40, rel=1e-13)


@pytest.mark.parametrize(
    ("counter", "key", "block"),
    [  # the known answers of Random123
        ([0] * 4, [0] * 2, "16554d9eca36314c db20fe9d672d0fdc d7e772cee186176b 7e68b68aec7ba23b"),
        ([2**64 - 1] * 4, [2**64 - 1] * 2, "87b092c3013fe90b 438c3c67be8d0224 9cc7d7c69cd777b6 a09caebf594f0ba0"),
        (
            [0x243F6A8885A308D3, 0x13198A2E03707344, 0xA4093822299F31D0, 0x082EFA98EC4E6C89],
            [0x452821E638D01377, 0xBE5466CF34E90C6C],
            "a528f45403e61d95 38c72dbd566e9788 a5a1610e72fd18b5 57bd43b5e52b7fe6",
        ),
    ],
)
def test_the_oracle_of_philox_gives_its_known_answers(counter, key, block):
    assert [f"{word:016x}" for word in oracles.philox4x64_10(counter, key)] == block.split()


@pytest.mark.parametrize("realization", [0, 1, 99, 2**63 - 1])
def test_phases_are_the_first_word_of_a_philox_block_of_each_lattice_point(realization):
    i, j = np.array([0, 3, 3, -7, 3, 0]), np.array([0, -2, 5, 1, 4, -1])
    for a, b, phase in zip(i, j, uniform_phases(realization, i, j), strict=True):
        word = oracles.philox4x64_10([int(b) + 2**32, int(a) + 2**32, 0, 0], [realization, 0])[0]
        assert phase == pytest.approx((word >> 11) * 2**-53 * 2 * math.pi, rel=3e-16)


def test_phases_are_uniform_and_differ_between_realisations():
    i, j = (v.ravel() for v in np.mgrid[-50:50, -50:50])
    phases = np.array([uniform_phases(r, i, j) for r in (0, 1)])
    assert 0 <= phases.min() < phases.max() < 2 * np.pi
    # of 20,000 uniform phases every moment exp(i n phase) is 0 +- 1 / sqrt(20000) = 0.007; five of those
    assert all(abs(np.exp(1j * n * phases).mean()) < 0.036 for n in (1, 2, 3))
    assert abs(np.exp(1j * (phases[0] - phases[1])).mean()) < 0.05
    assert np.unique(phases).size == phases.size


def by_lattice_point(components: Components, length: float) -> dict[tuple[int, int], tuple[float, float, float]]:
    i, j = (np.rint(k * length / INPUT_SPACING).astype(int) for k in (components.kx, components.ky))
    rest = zip(components.omega, components.amplitude, components.phase, strict=True)
    return dict(zip(zip(i.tolist(), j.tolist(), strict=True), rest, strict=True))


def test_components_are_the_equations_on_every_lattice_point_and_nowhere_else():
    sea = SeaState(direction=101, spread=70, peakedness=5, length=3, current=UniformCurrent((0.2, -0.3)))
    found, dk, expected = by_lattice_point(sea.components(4), 3), 0.341 / 3, 0
    for i in range(-31, 32):
        for j in range(-31, 32):
            k, off = dk * math.hypot(i, j), math.degrees(math.atan2(j, i)) - 101
            off -= 360 * round(off / 360)
            if not 0 < k <= 3.5 or abs(off) >= 35:
                continue
            energy = k**-1.5 * float(jonswap(math.sqrt(k), 5)) * math.cos(math.pi * off / 70) ** 2 * dk**2
            expected += 1
            omega, amplitude, _ = found[i, j]
            assert omega == pytest.approx(math.sqrt(k) + dk * (0.2 * i - 0.3 * j), abs=1e-15 * 4)
            # a squared cosine near its root: the angle's rounding, 1e-14 degrees, over the distance to the root
            assert amplitude == pytest.approx(math.sqrt(energy), rel=1e-14 + 1e-14 / (35 - abs(off)))
    assert len(found) == expected
    assert (INPUT_SPACING, LARGEST_WAVENUMBER) == (0.341, 3.5)


@pytest.mark.parametrize(("spread", "peakedness"), [(60, 3.3), (120, 1.0), (360, 7.0)])
def test_energy_of_the_sea_is_the_integral_of_its_spectrum(spread, peakedness):
    # int S(omega) d omega up to k = 3.5, times int f d theta = half the spread
    integral = (
        quad(lambda w: float(jonswap(w, peakedness)), 0.3, math.sqrt(3.5), epsabs=1e-12, limit=200, points=[1.0])[0]
        * math.radians(spread)
        / 2
    )
    fine, coarse = (
        SeaState(direction=90, spread=spread, peakedness=peakedness, length=n).components(0).variance for n in (40, 20)
    )
    # a sum over lattice points: what is wrong is the ragged edge at k = 3.5, spread pi / 360 * 3.5 / dk = 200 cells
    # of it or more, half a cell each with random signs, of some 2 % of the mean density: 3e-4; five times that
    assert fine == pytest.approx(integral, rel=1.5e-3)
    assert coarse == pytest.approx(integral, rel=3e-3)


def test_seas_that_differ_in_spread_peakedness_direction_or_current_share_phases():
    sea = SeaState(direction=90, spread=60, length=4)
    base = by_lattice_point(sea.components(5), 4)
    for change in (
        {"spread": 15},
        {"peakedness": 7},
        {"current": UniformCurrent((0.3, 0.1))},
        {"direction": 80},
        {"current": ExponentialCurrent((0.3, 0.0), 0.5)},
    ):
        other = by_lattice_point(replace(sea, **change).components(5), 4)
        shared = base.keys() & other.keys()
        assert len(shared) > 50
        assert all(base[p][2] == other[p][2] for p in shared)
        assert any(base[p][:2] != other[p][:2] for p in shared)
    assert not any(base[p][2] == v[2] for p, v in by_lattice_point(sea.components(6), 4).items())


def test_components_are_deterministic_and_refer_to_the_intrinsic_frequency():
    a, b = (SeaState(length=3).components(1) for _ in range(2))
    moving = SeaState(length=3, current=UniformCurrent((0.4, 0.2))).components(1)
    for name in ("kx", "ky", "omega", "amplitude", "phase"):
        assert np.array_equal(getattr(a, name), getattr(b, name))
    assert np.array_equal(a.amplitude, moving.amplitude)  # decision D17: a current changes frequencies alone
    assert moving.omega - a.omega == pytest.approx(0.4 * a.kx + 0.2 * a.ky, abs=1e-15)


def test_rotation_turns_the_waves_and_keeps_the_phase_at_the_centre():
    sea, centre = SeaState(length=2).components(0), (1.7, -0.6)
    turned = sea.rotated(37, centre)
    assert np.array_equal(turned.omega, sea.omega)
    assert np.array_equal(turned.amplitude, sea.amplitude)
    angle = np.angle((turned.kx + 1j * turned.ky) / (sea.kx + 1j * sea.ky))
    assert angle == pytest.approx(np.full(sea.kx.size, math.radians(37)), abs=4e-16 * 4)
    before, after = (c.kx * centre[0] + c.ky * centre[1] + c.phase for c in (sea, turned))
    assert after == pytest.approx(before, abs=2e-14)  # terms of up to 10, six of them


def test_other_units_scale_wavenumber_frequency_and_amplitude():
    sea = SeaState(length=2).components(0)
    si = sea.to_units(Scales(0.05, 9.81))
    assert si.kx == pytest.approx(0.05 * sea.kx, rel=2e-16)
    assert si.omega == pytest.approx(math.sqrt(9.81 * 0.05) * sea.omega, rel=4e-16)
    assert si.amplitude == pytest.approx(sea.amplitude / 0.05, rel=4e-16)
    assert np.hypot(si.kx, si.ky) * 9.81 == pytest.approx(si.omega**2, rel=4e-15)
    assert np.array_equal(si.phase, sea.phase)


def test_separated_rebuilds_the_waves_and_declines_where_it_cannot_pay():
    sea = SeaState(length=2).components(0)
    a, i, b, j = sea.separated()
    assert np.array_equal(a[i], sea.kx)
    assert np.array_equal(b[j], sea.ky)
    assert sea.rotated(30, (0, 0)).separated() is None
    doubled = Components(*(np.tile(getattr(sea, n), 2) for n in ("kx", "ky", "omega", "amplitude", "phase")))
    assert doubled.separated() is None  # two waves on one lattice point would overwrite each other


def test_variance_is_the_mean_square_of_the_surface():
    grid = Grid((8, 9, 20), (1.0, 0.7, 0.5))
    waves, _ = aligned_waves(grid, [(1, 2, 3), (-2, 1, 4)], gravity=1.0)
    eta = np.array(oracles.surface(waves, *(grid.samples(a) for a in range(3))))
    assert waves.variance == pytest.approx((1.0 + 0.49) / 2, rel=1e-15)
    assert (eta**2).mean() == pytest.approx(waves.variance, rel=1e-13)  # waves on bins are orthogonal


@pytest.mark.parametrize("gravity", [1.0, 9.81])
def test_aligned_waves_are_on_their_bins_and_on_the_dispersion_relation(gravity):
    grid = Grid((20, 24, 64), (0.8, 0.7, 0.9))
    waves, current = aligned_waves(grid, [(3, 1, 12), (-1, 4, 15)], amplitude=(2, 3), phase=(0, 1), gravity=gravity)
    for n, (i, j, m) in enumerate([(3, 1, 12), (-1, 4, 15)]):
        kx, ky, omega = waves.kx[n], waves.ky[n], waves.omega[n]
        assert (kx, ky, omega) == (i * grid.bin_widths[0], j * grid.bin_widths[1], m * grid.bin_widths[2])
        # a 2x2 system of condition 2
        assert omega == pytest.approx(
            math.sqrt(gravity * math.hypot(kx, ky)) + kx * current[0] + ky * current[1], abs=1e-14
        )
    assert waves.amplitude.tolist() == [2, 3]
    assert waves.phase.tolist() == [0, 1]


def test_one_aligned_wave_fixes_the_current_along_it():
    waves, current = aligned_waves(Grid((20, 24, 64), (0.8, 0.7, 0.9)), [(3, -1, 12)], gravity=1.0)
    assert current[0] * waves.ky[0] == pytest.approx(current[1] * waves.kx[0], abs=1e-15)
    k = math.hypot(waves.kx[0], waves.ky[0])
    shifted = math.sqrt(k) + waves.kx[0] * current[0] + waves.ky[0] * current[1]
    assert waves.omega[0] == pytest.approx(shifted, abs=1e-15)


GRID = Grid((20, 24, 64), (0.8, 0.7, 0.9))


@pytest.mark.parametrize(
    ("call", "refused", "fault"),
    [
        ("aligned_waves", lambda: aligned_waves(GRID, [(1, 1, 9), (2, 2, 9)], gravity=1.0), "parallel"),
        ("aligned_waves", lambda: aligned_waves(GRID, [(0, 0, 9)], gravity=1.0), "zero"),
        ("aligned_waves", lambda: aligned_waves(GRID, [], gravity=1.0), "0 waves"),
        ("aligned_waves", lambda: aligned_waves(GRID, [(1, 0, 9)] * 3, gravity=1.0), "3 waves"),
        ("aligned_waves", lambda: aligned_waves(GRID, [(1.5, 0, 9)], gravity=1.0), "1.5"),  # on no bin
        ("aligned_waves", lambda: aligned_waves(GRID, [(11, 0, 9)], gravity=1.0), "11"),  # past Nyquist: seen elsewhere
        ("aligned_waves", lambda: aligned_waves(GRID, [(1, 0, 33)], gravity=1.0), "33"),
        ("Components", lambda: Components([1, 2], [1], [1], [1], [1]), "sizes"),
        ("Components", lambda: Components([], [], [], [], []), "sizes"),
        ("Components", lambda: Components([1], [np.nan], [1], [1], [1]), "ky"),
        ("Components", lambda: Components([1], [1], [1], [np.inf], [1]), "amplitude"),
        ("Components", lambda: Components([[1]], [1], [1], [1], [1]), "kx"),
        ("SeaState", lambda: SeaState(direction=np.nan), "direction"),
        ("SeaState", lambda: SeaState(spread=0), "spread"),
        ("SeaState", lambda: SeaState(spread=361), "spread"),
        ("SeaState", lambda: SeaState(peakedness=-1), "peakedness"),
        ("SeaState", lambda: SeaState(length=0), "length"),
        ("SeaState.components", lambda: SeaState(length=2).components(-1), "realization = -1"),
        ("SeaState.components", lambda: SeaState(length=2).components(0.5), "realization = 0.5"),
        ("SeaState.components", lambda: SeaState(length=2).components(np.nan), "realization = nan"),
        ("SeaState.components", lambda: SeaState(length=2).components(2**63), "realization"),
        ("SeaState.components", lambda: SeaState(direction=7, spread=0.01, length=1).components(0), "no lattice point"),
    ],
)
def test_bad_input_is_refused(call, refused, fault):
    with pytest.raises(LeakrefError) as caught:
        refused()
    assert caught.value.call == call
    assert fault in caught.value.fault
    assert caught.value.remedy
