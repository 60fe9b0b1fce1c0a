"""The normalized scalar product against a literal loop, and its optimum."""

from __future__ import annotations

import itertools
import math
import tracemalloc
from functools import partial

import numpy as np
import oracles
import pytest
from conftest import RECTANGULAR
from scipy.optimize import root

from leakref import (
    Components,
    Grid,
    LeakrefError,
    Note,
    Scales,
    SeaState,
    UniformCurrent,
    aligned_waves,
    analyse,
    extract,
    fourier,
    leakage,
    nsp,
    shell_wavenumbers,
    synthesize,
)
from leakref.dispersion import DEEP, Water
from leakref.nsp import START, WIDTH, characteristic_function, normalized_scalar_product, optimum, score_derivatives
from leakref.shell import Shell, shell_at

VELOCITIES = ((0.0, 0.0), (0.3, -0.2), (-0.7, 0.1), (1.4, 0.9))
NUMBER_FIELDS = ("velocities", "score", "gradient", "hessian")


@pytest.mark.parametrize("gravity", [1.0, 3.0])
@pytest.mark.parametrize("grid", RECTANGULAR, ids=str)
def test_score_is_the_literal_loop_over_half_and_whole_space(grid, gravity):
    # a few thousand positive terms: no cancellation, so rounding stays below 1e-13
    spectrum = fourier(np.random.default_rng(5).normal(size=grid.shape), grid, "box")
    whole, width = spectrum.whole().tolist(), 3 * grid.frequency_resolution
    shell = shell_at(spectrum, 1.05, water=Water(gravity))
    for velocity in VELOCITIES:
        score = normalized_scalar_product(shell, velocity, width)
        for half in (True, False):
            literal = oracles.normalized_scalar_product(
                whole, grid.bin_widths, 1.05, velocity, width, half=half, gravity=gravity
            )
            assert score == pytest.approx(literal, rel=1e-12)
        assert score_derivatives(shell, velocity, width)[0] == pytest.approx(score, rel=1e-13)


@pytest.mark.parametrize("grid", RECTANGULAR[:2], ids=str)
def test_as_printed_the_whole_space_cannot_tell_a_current_from_its_negative(grid):
    sea = SeaState(direction=30, spread=120, length=1.5, current=UniformCurrent((0.3, 0.2))).components(0)
    whole = leakage.spectrum(sea, grid).whole().tolist()

    def score(velocity, branch):
        return oracles.normalized_scalar_product(whole, grid.bin_widths, 1.05, velocity, 0.8, branch=branch)

    for c in VELOCITIES[1:]:
        back = (-c[0], -c[1])
        assert score(c, oracles.as_printed) == pytest.approx(score(back, oracles.as_printed), rel=1e-12)
        assert abs(score(c, oracles.mirrored) / score(back, oracles.mirrored) - 1) > 1e-2


def test_characteristic_function_has_both_branches_of_a_real_signal(tapered):
    shell = shell_at(tapered, 1.0, water=DEEP)
    g = characteristic_function(shell, (0.4, -0.9), 0.4)
    for n in range(0, shell.kx.size, 7):
        kx, ky = float(shell.kx[n]), float(shell.ky[n])
        omega0 = math.sqrt(math.hypot(kx, ky))
        for m in (0, 5, 31):
            expected = sum(
                math.exp(-2 * ((m * tapered.grid.frequency_resolution - centre) / 0.4) ** 2)
                for centre in (omega0 + kx * 0.4 - ky * 0.9, oracles.mirrored((kx, ky), (0.4, -0.9), omega0))
            )
            assert g[n, m] == pytest.approx(expected, rel=1e-12, abs=1e-300)  # exponents up to 1000 lose 3 digits
    assert g.shape == shell.magnitude.shape


@pytest.mark.parametrize("velocity", VELOCITIES)
def test_derivatives_are_those_of_finite_differences(untapered, velocity):
    shell, width = shell_at(untapered, 1.2, water=DEEP), WIDTH * untapered.grid.frequency_resolution
    v0 = width / 1.2  # N varies on this scale; step 0.004 v0: truncation 0.004^4 / 30 * 4^5, rounding 1e-14 / 0.004
    n, gradient, hessian = score_derivatives(shell, velocity, width)
    slope = oracles.differences(lambda u, v: normalized_scalar_product(shell, (u, v), width), velocity, 0.004 * v0)
    np.testing.assert_allclose(gradient, slope, rtol=0, atol=1e-8 * n / v0)
    for component in (0, 1):

        def slopes(u, v, component=component):
            return score_derivatives(shell, (u, v), width)[1][component]

        bend = oracles.differences(slopes, velocity, 0.004 * v0)
        np.testing.assert_allclose(hessian[component], bend, rtol=0, atol=4e-8 * n / v0**2)
    assert np.abs(gradient).max() > 1e-4 * n  # away from the optimum there is something to compare


@pytest.mark.parametrize("window", ["tapered", "untapered"])
def test_the_optimum_has_a_vanishing_gradient_and_a_negative_definite_hessian(request, window):
    spectrum = request.getfixturevalue(window)
    k = shell_wavenumbers(spectrum.grid, 0.5, 2.6)
    width, found = WIDTH * spectrum.grid.frequency_resolution, nsp.extract(spectrum, k, gravity=1.0)
    assert sum(not n for n in found.notes) >= 6
    for n, k_i in enumerate(k):
        v0, shell, at = width / k_i, shell_at(spectrum, k_i, water=DEEP), found.velocities[n]
        scale = found.score[n] / v0
        # the last step was below 1e-13 c0, the curvature is some 4 N / v0^2, and N is rounded to 1e-14
        assert np.abs(found.gradient[n]).max() < 1e-11 * found.score[n] / v0**2

        def score(u, v, shell=shell):
            return normalized_scalar_product(shell, (u, v), width)

        def slopes(u, v, c, shell=shell):
            return score_derivatives(shell, (u, v), width)[1][c]

        assert np.abs(oracles.differences(score, at, 0.004 * v0)).max() < 1e-8 * scale
        bend = np.array([oracles.differences(partial(slopes, c=c), at, 0.004 * v0) for c in (0, 1)])
        np.testing.assert_allclose(found.hessian[n], bend, rtol=0, atol=4e-8 * scale / v0)
        curvature = np.linalg.eigvalsh((bend + bend.T) / 2)
        assert curvature[1] < 0
        assert np.linalg.eigvalsh(found.hessian[n])[1] < 0
        assert found.score[n] == pytest.approx(normalized_scalar_product(shell, at, width), rel=1e-13)
        # a flat optimum is one whose softer curvature is below 0.05 N / c0^2
        assert bool(found.notes[n] & Note.FLAT) == (-curvature[1] < 0.05 * found.score[n])


@pytest.mark.parametrize("window", ["tapered", "untapered"])
def test_another_start_in_the_same_basin_gives_the_same_velocity(request, window, monkeypatch):
    spectrum = request.getfixturevalue(window)
    k = shell_wavenumbers(spectrum.grid, 0.5, 2.6)
    width, found = WIDTH * spectrum.grid.frequency_resolution, nsp.extract(spectrum, k, gravity=1.0)
    sound = [n for n, note in enumerate(found.notes) if not note]
    for n in sound:
        shell = shell_at(spectrum, k[n], water=DEEP)
        for du, dv in ((0.1, 0.0), (-0.05, 0.08), (0.0, -0.1)):
            start = found.velocities[n] + np.array((du, dv)) * width / k[n]
            derivatives = partial(score_derivatives, shell, width=width)
            again = root(
                lambda c, of=derivatives: of(c)[1],
                start,
                jac=lambda c, of=derivatives: of(c)[2],
                options={"xtol": 1e-15},
            )
            assert np.abs(again.x - found.velocities[n]).max() < 1e-11
    for start in (1e-4, 1e-3):
        monkeypatch.setattr(nsp, "START", start)
        again = nsp.extract(spectrum, k[sound], gravity=1.0).velocities
        moved = np.abs(again - found.velocities[sound]).max(axis=1)
        same_basin = moved < 0.1 * width / k[sound]
        assert same_basin.all() or window == "untapered"  # tapered seas have one basin near rest
        assert moved[same_basin].max() < 1e-11
    assert START == 2.5e-4


# nx, ny, nt, dx, dy, dt and two waves that share a shell; lower frequency at least 2 a = 8 bins
PAIRS = (
    (Grid((20, 24, 64), (0.8, 0.7, 0.9)), (3, 1), (-1, 3)),
    (Grid((21, 18, 75), (0.7, 0.9, 1.0)), (1, 3), (3, -1)),
    (Grid((24, 25, 80), (0.6, 0.6, 1.0)), (-3, -2), (2, -3)),
)


def common_current(grid, first, second, towards):
    """Two waves on bins of whole numbers nearest to the current `towards`."""
    bins = []
    for i, j in (first, second):
        kx, ky = i * grid.bin_widths[0], j * grid.bin_widths[1]
        omega = math.sqrt(math.hypot(kx, ky)) + kx * towards[0] + ky * towards[1]
        bins.append((i, j, round(omega / grid.frequency_resolution)))
    assert min(m for *_, m in bins) >= 8
    return aligned_waves(grid, bins, gravity=1.0)


@pytest.mark.parametrize("method", ["nsp", "ls"])
@pytest.mark.parametrize("towards", list(itertools.product((0.11, -0.11), (0.09, -0.09))), ids=str)
@pytest.mark.parametrize("pair", PAIRS, ids=lambda pair: str(pair[0].shape))
def test_two_waves_on_bins_return_their_common_current_under_box(pair, towards, method):
    grid, first, second = pair
    waves, current = common_current(grid, first, second, towards)
    assert (np.sign(current) == np.sign(towards)).all()
    assert np.abs(current).min() > 0.04  # so that a flipped, exchanged or missing component is seen
    assert abs(abs(current[0]) - abs(current[1])) > 0.005
    k = float(np.hypot(waves.kx, waves.ky).mean())
    eta = synthesize(waves, *(grid.samples(axis) for axis in range(3)))
    found = extract(eta, grid.spacing, k, window="box", method=method, gravity=1.0)
    closed = analyse(leakage.spectrum(waves, grid, "box"), k, method=method, gravity=1.0)
    for one in (found, closed):
        assert np.abs(one.velocities[0] - current).max() < 1e-10
        assert one.notes == (Note.NONE,)
    # the planted faults: what is seen by a camera with one axis reversed, and by one that films backwards
    for reverse, expected in (
        ((slice(None, None, -1),), current * (-1, 1)),
        ((slice(None), slice(None, None, -1)), current * (1, -1)),
        ((slice(None), slice(None), slice(None, None, -1)), -current),
    ):
        other = extract(eta[reverse], grid.spacing, k, window="box", method=method, gravity=1.0).velocities[0]
        assert np.abs(other - expected).max() < 1e-10
        assert np.abs(other - current).max() > 0.08


def test_one_wave_on_a_bin_fixes_the_component_along_it_and_the_rest_is_called_flat():
    grid = PAIRS[0][0]
    wave, current = aligned_waves(grid, [(3, 1, 12)], gravity=1.0)
    k = np.array([wave.kx[0], wave.ky[0]])
    found = nsp.extract(leakage.spectrum(wave, grid, "box"), np.hypot(*k), gravity=1.0)
    assert found.velocities[0] @ k == pytest.approx(current @ k, abs=1e-10)
    assert Note.FLAT in found.notes[0]


def test_memory_of_an_extraction_does_not_grow_with_the_number_of_shells(tapered):
    peaks = []
    for count in (1, 1, 12):  # the first run also pays for what is imported or cached once
        tracemalloc.start()
        nsp.extract(tapered, np.full(count, 2.5), gravity=1.0)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] > 1e5
    assert peaks[2] < 1.05 * peaks[1]


def test_a_field_in_other_units_gives_the_same_velocities(tapered, small_sea):
    scales, grid = Scales(0.05, 9.81), tapered.grid
    k = shell_wavenumbers(grid, 0.5, 2.6)
    spacing = np.array(grid.spacing) * (scales.length, scales.length, scales.time)
    si = leakage.spectrum(small_sea.to_units(scales), Grid(grid.shape, tuple(spacing)), "hann")
    ours = nsp.extract(tapered, k, gravity=1.0)
    for peak in (0.05, None):  # unknown: decision D21
        theirs = nsp.extract(si, k * scales.wavenumber, gravity=9.81, peak_wavenumber=peak)
        # the honest precision of a velocity: rounding of F times up to 530
        assert np.abs(theirs.velocities / scales.velocity - ours.velocities).max() < 1e-11
        assert peak is None or theirs.notes == ours.notes


def test_units_by_powers_of_two_change_no_bit_and_no_step_of_the_search(untapered, small_sea):
    scales, grid = Scales(1 / 16, 4.0), untapered.grid
    assert (scales.frequency, scales.velocity) == (0.5, 8.0)
    k, spacing = shell_wavenumbers(grid, 0.5, 2.6), np.array(grid.spacing) * (16, 16, 2)
    other = leakage.spectrum(small_sea.to_units(scales), Grid(grid.shape, tuple(spacing)), "box")
    ours, theirs = (
        nsp.extract(untapered, k, gravity=1.0),
        nsp.extract(other, k / 16, gravity=4.0, peak_wavenumber=1 / 16),
    )
    assert np.array_equal(theirs.velocities, 8 * ours.velocities)
    assert np.array_equal(theirs.evaluations, ours.evaluations)
    assert theirs.notes == ours.notes


def test_order_number_and_repetition_of_wavenumbers_do_not_matter(tapered):
    k = shell_wavenumbers(tapered.grid, 0.6, 2.0)
    found, backwards = nsp.extract(tapered, k, gravity=1.0), nsp.extract(tapered, k[::-1], gravity=1.0)
    for name in NUMBER_FIELDS:
        assert np.array_equal(getattr(found, name), getattr(backwards, name)[::-1])
        assert np.array_equal(getattr(found, name), getattr(nsp.extract(tapered, k, gravity=1.0), name))
    assert found.notes == backwards.notes[::-1]
    assert np.array_equal(nsp.extract(tapered, float(k[2]), gravity=1.0).velocities[0], found.velocities[2])
    assert found.method == "nsp"
    assert (found.evaluations > 20).all()


def scene(grid: Grid, *waves) -> Components:
    """Waves (i, j, m, amplitude) on bins of `grid`."""
    i, j, m, amplitude = np.array(waves, dtype=float).T
    kx, ky, omega = np.array(grid.bin_widths)[:, None] * (i, j, m)
    return Components(kx, ky, omega, amplitude, np.arange(len(waves)))


def test_no_signal_is_no_number():
    grid = PAIRS[0][0]
    elsewhere, _ = aligned_waves(grid, [(6, 1, 18)], gravity=1.0)
    for spectrum in (fourier(np.zeros(grid.shape), grid), leakage.spectrum(elsewhere, grid, "box")):
        found = nsp.extract(spectrum, 1.2, gravity=1.0)
        assert found.notes == (Note.NO_SIGNAL,)
        assert all(np.isnan(getattr(found, name)).all() for name in NUMBER_FIELDS)
        assert found.evaluations.tolist() == [0]


def test_another_basin_is_noted_where_it_scores_higher_and_only_then():
    grid = Grid((32, 32, 84), (0.7, 0.7, 0.7))  # the band is wide: the search reaches 1.2 c0
    kx, _, domega = grid.bin_widths
    k = 5 * kx
    rest = round(math.sqrt(k) / domega)
    swept = round(0.8 * k / domega)  # waves that move with 0.8 c0 along x, beside others at rest

    def note(at_rest, in_motion, **settings):
        waves = scene(
            grid,
            (5, 0, rest, at_rest),
            (0, 5, rest, at_rest),
            (-4, 3, rest, at_rest),
            (5, 0, rest + swept, in_motion),
            (0, -5, rest, in_motion),
            (4, 3, rest + round(0.8 * swept), in_motion),
        )
        found = nsp.extract(leakage.spectrum(waves, grid, "hann"), k, gravity=1.0, **settings)
        return found.notes[0], found.velocities[0]

    higher, velocity = note(0.3, 3.0)
    assert np.abs(velocity).max() < 0.2  # Nelder-Mead stays with the weak waves at rest
    assert Note.ANOTHER_BASIN in higher
    assert Note.ANOTHER_BASIN not in note(3.0, 0.3)[0]
    assert Note.ANOTHER_BASIN not in note(0.3, 3.0, search=False)[0]


def test_edge_is_noted_beyond_the_reach_of_the_search():
    grid, first, second = PAIRS[0]
    waves, current = common_current(grid, first, second, (0.11, 0.09))
    k, spectrum = float(np.hypot(waves.kx, waves.ky).mean()), leakage.spectrum(waves, grid, "box")
    assert nsp.extract(spectrum, k, gravity=1.0).notes == (Note.NONE,)
    slow = nsp.extract(
        spectrum, k, peak_wavenumber=100.0, gravity=1.0
    )  # c0 = 0.1, and the current is faster than 1.2 c0
    assert np.hypot(*current) > 0.12
    assert slow.velocities[0] == pytest.approx(current, abs=1e-10)
    assert Note.EDGE in slow.notes[0]
    # and where the Nyquist frequency is so near that G leaves the band before: omega_N - omega0 - 3 a < k |c|
    near = Grid((*grid.shape[:2], 26), (*grid.spacing[:2], 2.1))
    turned, _ = aligned_waves(near, [(3, 1, 10), (-1, 3, 11)], gravity=1.0)
    assert Note.EDGE in nsp.extract(leakage.spectrum(turned, near, "box"), k, width=1.0, gravity=1.0).notes[0]


def test_too_few_bins_are_noted():
    grid = Grid((24, 24, 64), (0.7, 0.7, 0.9))
    waves = scene(grid, (3, 0, 10, 1.0), (0, 3, 11, 1.0))
    spectrum = leakage.spectrum(waves, grid, "box")
    k = 3 * grid.wavenumber_resolution
    assert (
        Note.TOO_FEW_BINS in nsp.extract(spectrum, k, half_width=0.1, gravity=1.0).notes[0]
    )  # (3, 0), (0, 3) and mirrors
    assert Note.TOO_FEW_BINS not in nsp.extract(spectrum, k, gravity=1.0).notes[0]


def test_a_shell_of_nothing_but_the_mean_is_flat_with_too_few_bins_or_no_number(untapered):
    dk = untapered.grid.wavenumber_resolution
    found = nsp.extract(untapered, 0.1 * dk, half_width=0.5, gravity=1.0)  # k = 0 alone: nothing depends on the current
    assert np.isnan(found.velocities).all() or found.notes[0] & Note.FLAT
    assert found.notes[0] & (Note.UNCONVERGED | Note.TOO_FEW_BINS | Note.NO_SIGNAL)


def by_hand(magnitude) -> Shell:
    omega = np.arange(20) * 0.1
    kx, ky = np.array([1.0, 0.0, 0.7]), np.array([0.0, 1.0, 0.7])
    return Shell(
        1.0,
        1.0,
        kx,
        ky,
        np.sqrt(np.hypot(kx, ky)),
        omega,
        np.where(omega == 0, 0.5, 1.0),
        magnitude(omega) * np.ones((3, 1)),
        None,
        False,
    )


@pytest.mark.parametrize(
    ("magnitude", "reason"),
    [(np.ones_like, Note.UNCONVERGED), (lambda w: np.exp(-3 * w), Note.EDGE)],
    ids=["no slope", "no end to it"],
)
def test_a_score_without_a_maximum_is_no_number(magnitude, reason):
    found = optimum(by_hand(magnitude), 0.4, 1.0)
    assert found.note == reason
    assert all(np.isnan(v).all() for v in (found.velocity, found.score, found.gradient, found.hessian))
    assert found.evaluations > 0


@pytest.mark.parametrize(
    ("settings", "fault"),
    [
        ({"width": 0}, "width = 0"),
        ({"width": -4}, "width = -4"),
        ({"width": np.nan}, "width"),
        ({"half_width": 0}, "half_width = 0"),
        ({"gravity": 0}, "gravity = 0"),
        ({"gravity": np.inf}, "gravity"),
        ({"peak_wavenumber": 0}, "peak_wavenumber = 0"),
        ({"peak_wavenumber": -1}, "peak_wavenumber = -1"),
        ({"peak_wavenumber": np.nan}, "peak_wavenumber"),
    ],
)
def test_bad_settings_are_refused(tapered, settings, fault):
    with pytest.raises(LeakrefError, match=r"^nsp\.extract: ") as caught:
        nsp.extract(tapered, 1.0, **{"gravity": 1.0, **settings})
    assert fault in caught.value.fault
