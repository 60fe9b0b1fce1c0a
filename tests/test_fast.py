"""The fast path against the plain chain: same numbers, same basins, same notes, same refusals."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import RECTANGULAR, waves_off_bins
from hypothesis import HealthCheck, Phase, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from leakref import Components, Grid, LeakrefError, SeaState, UniformCurrent, aligned_waves, leakage, nsp, nspgrid
from leakref.chain import analyse, shell_wavenumbers
from leakref.dispersion import DEEP
from leakref.fast import _rings, _Seen, realize
from leakref.fast.score import scores
from leakref.fast.spectra import Disc, magnitudes
from leakref.methods import DEFAULT, METHODS
from leakref.shell import HALF_WIDTH, Note, shell_at
from leakref.window import WINDOWS
from leakref.window import window as named_window

SMALL = Grid.scaled(5, 10)
UNSAFE = Note.ANOTHER_BASIN | Note.EDGE | Note.FLAT | Note.THRESHOLD


def assert_same(components, grid, k, *, windows=("box", "hann"), reach=None, unit=1.0, **settings):
    """Compare with the plain chain shell by shell, and return the notes of all shells by the paper's methods."""
    settings.setdefault("gravity", 1.0)
    found = realize(components, grid, k, windows=windows, methods=tuple(METHODS), **settings)
    assert list(found) == [(window, method) for window in windows for method in METHODS]
    gravity = settings.pop("gravity")
    settings.setdefault("peak_wavenumber", 1.0)
    notes = []
    for window in windows:
        spectrum = leakage.spectrum(components, grid, window, largest_wavenumber=reach)
        for method in METHODS:
            plain = analyse(
                spectrum,
                k,
                gravity=gravity,
                method=method,
                **{
                    name: value for name, value in settings.items() if name in {"half_width", *METHODS[method].settings}
                },
            )
            fast = found[window, method]
            assert fast.method == method
            assert fast.notes == plain.notes
            assert np.array_equal(fast.wavenumbers, plain.wavenumbers)
            tolerance = unit * np.where([bool(note & UNSAFE) for note in plain.notes], 1e-6, 1e-11)[:, None]
            assert np.array_equal(np.isnan(fast.velocities), np.isnan(plain.velocities))
            assert np.all(~(np.abs(fast.velocities - plain.velocities) > tolerance))
            np.testing.assert_allclose(fast.score, plain.score, rtol=1e-9, atol=1e-12)
            scale = np.nanmax(np.abs(plain.hessian), initial=0.0)
            np.testing.assert_allclose(fast.hessian, plain.hessian, rtol=0, atol=1e-9 * scale)
            np.testing.assert_allclose(fast.gradient, plain.gradient, rtol=0, atol=1e-9 * scale * unit)
            assert np.all((fast.evaluations > 0) == (plain.evaluations > 0))
            notes += fast.notes if method in DEFAULT else ()
    return notes


@pytest.mark.parametrize("off", [0.0, 1e-9, 0.3, 0.5])
@pytest.mark.parametrize("grid", RECTANGULAR)
def test_magnitudes_are_those_of_the_closed_form(grid, off):
    disc = Disc(grid, 0.99 * min(grid.nyquist[:2]))
    i, j = disc.bins
    waves = waves_off_bins(grid, off)
    for name, magnitude in magnitudes(waves, grid, list(WINDOWS.values()), disc).items():
        plain = np.abs(leakage.spectrum(waves, grid, name).values[i, j])
        np.testing.assert_allclose(magnitude / magnitude.max(), plain / plain.max(), rtol=0, atol=5e-15, err_msg=name)


@pytest.mark.parametrize(
    ("spread", "direction", "peakedness", "current"),
    [(60, 75, 3.3, (0.0, 0.0)), (15, 90, 7.0, (0.0, 0.0)), (30, 60, 1.0, (0.1, -0.11)), (15, 75, 3.3, (-0.05, 0.02))],
)
def test_same_velocities_and_notes_as_the_plain_chain(spread, direction, peakedness, current):
    sea = SeaState(direction, spread, peakedness, 5, UniformCurrent(current))
    k = shell_wavenumbers(SMALL, 0.4, 3.5)[::2]
    assert_same(sea.components(0), SMALL, k[1::2], windows=("blackman",))
    assert_same(sea.components(1), SMALL, k)


def test_same_for_a_rotated_sea_that_is_no_lattice():
    sea = SeaState(75, 60, length=5).components(1).rotated(37, (15.0, 16.0))
    assert sea.separated() is None
    assert_same(sea, SMALL, shell_wavenumbers(SMALL, 0.4, 3.5)[::4], windows=("hann",))


def test_same_where_nothing_is_square_or_even_and_in_other_units():
    grid = Grid((141, 100, 125), (0.217 * 20, 0.31 * 20, 0.46 * np.sqrt(20 / 9.81)))
    sea = SeaState(65, 40, length=5, current=UniformCurrent((0.05, 0.03))).components(2)
    waves = Components(sea.kx / 20, sea.ky / 20, sea.omega * np.sqrt(9.81 / 20), sea.amplitude, sea.phase)
    assert_same(waves, grid, np.array([0.6, 1.3, 2.2]) / 20, gravity=9.81, peak_wavenumber=1 / 20, unit=14.0)


@pytest.mark.parametrize(
    "settings",
    [
        {"width": 2.0},
        {"width": 6.5, "half_width": 1.0},
        {"threshold": 0.6},
        {"search": False},
        {"peak_wavenumber": 1.7},
    ],
)
def test_same_under_other_settings(settings):
    assert_same(SeaState(75, 30, length=5).components(0), SMALL, [0.8, 1.4, 2.6], **settings)


@st.composite
def hostile(draw):
    """Waves, a grid of 2 to 64 samples a side, oblong, odd, prime or coarse, wavenumbers, and settings of both ways."""
    size = st.one_of(st.sampled_from([2, 3, 5, 7, 13, 16, 31, 61, 64]), st.integers(2, 64))
    grid = Grid((draw(size), draw(size), draw(size)), tuple(draw(st.floats(0.2, 2.0)) for _ in range(3)))
    rng, kind = np.random.default_rng(draw(st.integers(0, 2**32))), draw(st.sampled_from(["sea", "waves", "bins"]))
    n, nyquist = int(rng.integers(1, 9)), np.array(grid.nyquist)
    kx, ky, omega = rng.uniform(-1, 1, (3, n)) * nyquist[:, None]  # in the corners too
    if kind == "bins":
        kx, ky, omega = (np.rint(v / bin) * bin for v, bin in zip((kx, ky, omega), grid.bin_widths, strict=True))
    if kind == "sea":
        k, angle = rng.uniform(0.1, 0.95, n) * nyquist[:2].min(), rng.uniform(0, 2 * np.pi, n)
        kx, ky = k * np.cos(angle), k * np.sin(angle)
        omega = np.sqrt(k) + kx * rng.uniform(-0.5, 0.5) + ky * rng.uniform(-0.5, 0.5)
    half_width = draw(st.sampled_from([2.0, 1.0, 3.0]))
    inner = nyquist[:2].min() - half_width * grid.wavenumber_resolution
    wanted = rng.uniform(0.05, 1.01, 2) * (inner if inner > 0 else nyquist[:2].min())  # past the end now and then
    return (
        Components(kx, ky, omega, rng.uniform(0.1, 1, n), rng.uniform(0, 6, n)),
        grid,
        wanted,
        {"width": draw(st.sampled_from([4.0, 2.0, 6.5, 1.0, 0.5])), "half_width": half_width},
    )


def assert_same_or_same_refusal(case):
    waves, grid, k, settings = case
    refusal = None
    try:
        spectrum = leakage.spectrum(waves, grid, "box")
        for k_i in k:
            shell_at(spectrum, k_i, half_width=settings["half_width"], water=DEEP)
    except LeakrefError as error:
        refusal = error.fault
    if refusal is None:
        assert_same(waves, grid, k, windows=("box", "hann", "blackman", "kaiser-bessel"), **settings)
    else:
        with pytest.raises(LeakrefError) as other:
            realize(waves, grid, k, **{"gravity": 1.0, **settings})
        assert other.value.fault == refusal


def hostile_cases(count):
    return lambda test: given(hostile())(
        hypothesis_settings(
            max_examples=count,
            derandomize=True,
            database=None,
            deadline=None,
            phases=[Phase.explicit, Phase.generate],
            suppress_health_check=[HealthCheck.too_slow],  # each is compared with the plain chain
        )(test)
    )


@hostile_cases(25)
def test_same_on_any_grid(case):
    assert_same_or_same_refusal(case)


@pytest.mark.slow
@hostile_cases(200)
def test_same_on_many_grids(case):
    assert_same_or_same_refusal(case)


@pytest.mark.parametrize("nt", [*range(2, 12), 17, 30, 33, 34, 35, 36, 37])
def test_same_for_short_videos(nt):
    """Shorter than the Gaussian is wide, as tabulated for other basins."""
    grid = Grid((60, 56, nt), (0.5, 0.6, 0.9))
    assert_same(SeaState(70, 40, length=5).components(0), grid, [0.9, 1.6])


def test_no_velocity_where_the_surface_has_left_the_band():
    """A video so coarse that Nelder-Mead climbs to where most of the dispersion surface is past the last frequency."""
    grid, k, lost = Grid((44, 48, 9), (0.7, 0.6, 3.0)), np.linspace(0.8, 2.4, 5), 0
    for realization in range(2):
        waves = SeaState(70, 40, length=4).components(realization)
        assert_same(waves, grid, k)
        for (window, method), record in realize(waves, grid, k, gravity=1.0).items():
            for k_i, velocity, note in zip(k, record.velocities, record.notes, strict=True):
                lost += Note.EDGE in note and bool(np.isnan(velocity[0]))
                shell = shell_at(leakage.spectrum(waves, grid, window), k_i, water=DEEP)
                past = np.abs(shell.intrinsic + np.stack([shell.kx, shell.ky], axis=1) @ velocity) > shell.omega[-1]
                assert method == "ls" or np.mean(past) <= 0.5
    assert lost


def test_same_where_the_gaussian_is_clipped_at_the_nyquist_frequency():
    grid = Grid((140, 140, 46), (SMALL.spacing[0], SMALL.spacing[1], 1.4))
    sea = SeaState(75, 60, length=5, current=UniformCurrent((0.1, 0.1)))
    assert_same(sea.components(0), grid, [0.8, 1.6, 2.4, 3.0])


def test_same_notes_for_shells_without_a_wave_and_for_few_waves():
    components, _ = aligned_waves(SMALL, [(5, 3, 11), (-3, 6, 12)], gravity=1.0)
    notes = assert_same(components, SMALL, [1.2, 2.8])
    assert any(Note.NO_SIGNAL in note for note in notes)
    one = Components(components.kx[:1] * 1.03, components.ky[:1], components.omega[:1] * 1.02, [1.0], [0.4])
    notes = assert_same(one, SMALL, [1.2, 2.8])
    assert any(Note.LEAKAGE_FLOOR in note for note in notes)


def test_same_with_a_window_that_is_no_cosine_sum():
    assert_same(SeaState(75, 60, length=5).components(0), SMALL, [1.0, 2.0], windows=("kaiser-bessel",))


def test_other_basins_are_found_where_the_plain_chain_finds_them():
    sea, k = SeaState(90, 15, length=5), shell_wavenumbers(SMALL, 0.4, 3.5)[6::2]
    notes = [note for n in (1, 22) for note in assert_same(sea.components(n), SMALL, k, windows=("box",))]
    assert any(Note.ANOTHER_BASIN in note for note in notes)


def test_same_input_same_bits_and_untouched():
    waves = SeaState(75, 60, length=5).components(0)
    before = {name: getattr(waves, name).copy() for name in waves.__dataclass_fields__}
    first, second = (realize(waves, SMALL, [1.0, 1.4], gravity=1.0) for _ in range(2))
    backwards = realize(waves, SMALL, [1.4, 1.0], windows=("hann", "box"), methods=("ls", "nsp"), gravity=1.0)
    for key, record in first.items():
        assert np.array_equal(record.velocities, second[key].velocities)
        assert np.array_equal(record.velocities, backwards[key].velocities[::-1])
    assert all(np.array_equal(getattr(waves, name), value) for name, value in before.items())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"windows": ("hamming",)}, "no window named 'hamming'"),
        ({"methods": ("psd",)}, "no method named 'psd'"),
        ({"wavenumbers": [13.9]}, "past the Nyquist wavenumber"),
        ({"wavenumbers": []}, "wavenumbers is empty"),
        ({"wavenumbers": [0.05], "half_width": 0.1}, "no bin lies within"),
        ({"wavenumbers": [np.nan]}, "not finite"),
        ({"width": 0.0}, "width"),
        ({"gravity": -1.0}, "gravity"),
        ({"threshold": 1.5}, "threshold = 1.5"),
    ],
)
def test_refusals(arguments, message):
    arguments = {"wavenumbers": [1.0], **arguments}
    with pytest.raises(LeakrefError, match=message):
        realize(SeaState(length=5).components(0), SMALL, **{"gravity": 1.0, **arguments})


@pytest.mark.slow
@pytest.mark.parametrize(("length", "duration"), [(10, 20), (10, 80), (20, 20)])
@pytest.mark.parametrize("spread", [15, 60])
def test_same_for_larger_domains(length, duration, spread):
    grid = Grid.scaled(length, duration)
    sea = SeaState(75, spread, 3.3, length, UniformCurrent((0.1, 0.1))).components(1)
    k = shell_wavenumbers(grid, 0.4, 3.5)[:: 2 if length == 10 else 6]
    assert_same(sea, grid, k, reach=k.max() + 3 * grid.wavenumber_resolution)


def test_compiled_scores_are_those_of_the_reference_but_for_a_factor(small_grid, small_sea):
    """What chooses the start of `nsp-grid`, whose velocity is the same from many a start."""
    radius = 0.9 * min(small_grid.nyquist[:2])
    disc, rings = _rings(small_grid, radius, (1.0, 1.6), DEEP, 1.0, nsp.WIDTH, HALF_WIDTH)
    seen = _Seen(disc, "box", magnitudes(small_sea, small_grid, [named_window("box")], disc)["box"], rings)
    for ring in rings:
        velocities, shell = 0.3 * nspgrid.LATTICE[::7], seen._shell(ring)
        seen.models.made[:] = 0
        found = scores(ring._replace(magnitude=seen.magnitude), seen.models, velocities)
        ratio = found / [nsp.normalized_scalar_product(shell, c, seen.width * seen.step) for c in velocities]
        np.testing.assert_allclose(ratio, ratio[0], rtol=1e-9)
