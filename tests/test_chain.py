"""From samples to velocities in one call, by either route, and the interface of an implementation."""

from __future__ import annotations

import numpy as np
import pytest

import leakref
from leakref import (
    Components,
    Grid,
    LeakrefError,
    Note,
    SeaState,
    UniformCurrent,
    analyse,
    extract,
    fourier,
    leakage,
    leastsquares,
    nsp,
    reference,
    shell_wavenumbers,
    synthesize,
    transform,
)
from leakref.certify.subject.inprocess import Implementation
from leakref.chain import Reference
from leakref.dispersion import DEEP, Water
from leakref.methods import DEFAULT, METHODS
from leakref.window import WINDOWS

PRECISION = 1e-11  # of a velocity in c0: the rounding of F times up to 530, in shells without a note


@pytest.fixture(scope="module")
def surface(small_grid, small_sea):
    eta = synthesize(small_sea, *(small_grid.samples(axis) for axis in range(3)))
    eta.flags.writeable = False
    return eta


@pytest.mark.parametrize(("length", "first", "last"), [(5, 2, 17), (10, 4, 35), (20, 8, 70)])
def test_shells_are_whole_multiples_of_dk_from_0_4_to_3_5(length, first, last):
    k = shell_wavenumbers(Grid.scaled(length, 10), 0.4, 3.5)
    assert k == pytest.approx(np.arange(first, last + 1) / length, rel=1e-14)
    rectangle = Grid((20, 30, 8), (0.5, 0.8, 1.0))
    assert shell_wavenumbers(rectangle, 0.1, 2.0) == pytest.approx(np.arange(1, 4) * 2 * np.pi / 10)  # the coarser side


@pytest.mark.parametrize("method", ["nsp", "ls"])
@pytest.mark.parametrize("window", ["box", "hann", "blackman", "kaiser-bessel"])
def test_velocities_by_either_route_are_the_same(small_grid, small_sea, surface, window, method):
    k = shell_wavenumbers(small_grid, 0.5, 2.6)
    (a,) = transform(small_sea, small_grid, (window,))
    (b,) = transform(small_sea, small_grid, (window,), route="B", largest_wavenumber=3.2)
    assert np.abs(b.kx).max() <= 3.2 < np.abs(a.kx).max()
    one, other = (analyse(s, k, method=method, gravity=1.0) for s in (a, b))
    assert one.notes == other.notes
    sound = [not note for note in one.notes]
    assert sum(sound) >= 6
    assert np.abs(one.velocities - other.velocities)[sound].max() < PRECISION
    whole = extract(surface, small_grid.spacing, k, window=window, method=method, gravity=1.0)
    assert np.array_equal(whole.velocities, one.velocities)


def test_the_current_is_recovered_within_the_resolutions(small_grid, small_sea, surface):
    k = shell_wavenumbers(small_grid, 0.8, 2.6)
    found = extract(surface, small_grid.spacing, k, gravity=1.0).velocities
    # the paper's finding: a tapered spectrum errs by less than half its resolution, here about 0.1 c0 and less
    current = np.array([0.07, -0.04])
    assert np.abs(found - current).max() < 0.05
    assert np.abs(found + current).max() > 0.1


@pytest.mark.parametrize("method", ["nsp", "ls"])
def test_settings_reach_the_method_and_only_the_method_that_has_them(tapered, method):
    k = [1.0, 1.4]
    direct = {"nsp": nsp, "ls": leastsquares}[method].extract
    wide = analyse(tapered, k, method=method, half_width=1.0, gravity=1.1)
    assert np.array_equal(wide.velocities, direct(tapered, k, half_width=1.0, gravity=1.1).velocities)
    assert not np.array_equal(wide.velocities, direct(tapered, k, gravity=1.1).velocities)
    assert analyse(tapered, k, method=method, peak_wavenumber=1.0, search=False, gravity=1.0).method == method
    assert DEFAULT == ("nsp", "ls")


def test_extraction_is_deterministic_and_leaves_its_input_alone(small_grid, surface):
    before, k = surface.copy(), np.array([1.0, 1.4])
    k.flags.writeable = False
    for method in METHODS:
        one, other = (extract(surface, small_grid.spacing, k, method=method, gravity=1.0) for _ in range(2))
        for name in ("velocities", "score", "gradient", "hessian"):
            assert np.array_equal(getattr(one, name), getattr(other, name))
    assert np.array_equal(surface, before)
    assert np.array_equal(
        extract(surface.tolist(), small_grid.spacing, [1.0], gravity=1.0).velocities,
        extract(surface, small_grid.spacing, [1.0], gravity=1.0).velocities,
    )


@pytest.mark.parametrize("method", ["nsp", "ls"])
def test_amplitude_does_not_matter(small_grid, surface, method):
    one, other = (
        extract(eta, small_grid.spacing, [1.0, 1.4, 2.0], method=method, gravity=1.0)
        for eta in (surface, 1e-3 * surface)
    )
    assert np.abs(one.velocities - other.velocities).max() < PRECISION
    assert not any(one.notes)


@pytest.mark.parametrize("method", ["nsp", "ls"])
def test_a_sea_turned_about_the_centre_turns_its_velocities(method):
    # periodic Hann is symmetric about n / 2 and 0 at index 0: the turn by index reversal modulo n is exact
    grid = Grid((42, 42, 64), (0.8, 0.8, 0.9))
    sea = SeaState(direction=20, length=5, current=UniformCurrent((0.1, 0.05))).components(1)
    centre, k = (grid.lengths[0] / 2, grid.lengths[1] / 2), shell_wavenumbers(grid, 0.6, 2.4)
    found = {}
    for angle in (0, 90, 180, 270):
        (spectrum,) = transform(sea.rotated(angle, centre), grid, ("hann",), route="A")
        found[angle] = analyse(spectrum, k, method=method, gravity=1.0)
    sound = [not note for note in found[0].notes]
    assert sum(sound) >= 6
    for angle, extraction in found.items():
        c, s = round(np.cos(np.radians(angle))), round(np.sin(np.radians(angle)))
        expected = found[0].velocities @ np.array([[c, s], [-s, c]])
        assert np.abs(extraction.velocities - expected)[sound].max() < PRECISION
        assert extraction.notes == found[0].notes
    spectra = [transform(sea.rotated(a, centre), grid, ("hann",))[0].whole() for a in (0, 90)]
    i, j = np.meshgrid(np.arange(42), np.arange(42), indexing="ij")
    # (kx, ky) of the turned sea was (ky, -kx)
    assert np.abs(np.abs(spectra[1]) - np.abs(spectra[0][j, -i])).max() < 1e-12 * np.abs(spectra[0]).max()


@pytest.mark.parametrize("method", ["nsp", "ls"])
def test_mirror_images_by_index_reversal_modulo_n_mirror_the_velocities(small_grid, surface, method):
    k = [0.9, 1.4, 2.0]
    found = extract(surface, small_grid.spacing, k, method=method, gravity=1.0)
    assert not any(found.notes)
    for axis, sign in ((0, (-1, 1)), (1, (1, -1)), (2, (-1, -1))):
        reversed_ = np.roll(np.flip(surface, axis), 1, axis)
        other = extract(reversed_, small_grid.spacing, k, method=method, gravity=1.0)
        assert np.abs(other.velocities - found.velocities * sign).max() < PRECISION
        assert np.abs(other.velocities - found.velocities).max() > 1e-3


def test_a_circular_shift_changes_nothing_under_box(small_grid, surface):
    k = shell_wavenumbers(small_grid, 0.8, 2.6)
    found = extract(surface, small_grid.spacing, k, window="box", gravity=1.0)
    moved = extract(np.roll(surface, (7, -5, 11), (0, 1, 2)), small_grid.spacing, k, window="box", gravity=1.0)
    sound = [not note for note in found.notes]
    assert sum(sound) >= 4
    assert np.abs(moved.velocities - found.velocities)[sound].max() < PRECISION


@pytest.mark.parametrize("route", ["A", "B"])
def test_a_silent_shell_is_nan_and_noted_among_others(route):
    grid = Grid.scaled(5, 10)
    waves = Components([1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 1.0], [0.0, 1.0])
    (spectrum,) = transform(waves, grid, ("box",), route=route)
    found = analyse(spectrum, [1.0, 2.0], method="ls", gravity=1.0)
    assert found.velocities[0] == pytest.approx([0, 0], abs=1e-10)
    assert np.isnan(found.velocities[1]).all()
    assert found.notes == (Note.NONE, Note.NO_SIGNAL)


def test_the_reference_is_an_implementation_of_every_stage(small_grid, small_sea, surface):
    assert isinstance(reference, Reference)
    assert leakref.chain.reference is reference
    assert all(hasattr(Reference, name) for name in vars(Implementation) if not name.startswith("_"))
    described = reference.describe()
    assert (described["name"], described["version"]) == ("leakref", leakref.__version__)
    assert [described[n] for n in ("units", "axes", "y", "direction")] == ["scaled", "xyt", "up", "to"]
    assert described["can"]["extract"] == {"methods": ["nsp", "ls"], "windows": list(WINDOWS), "resolves": "wavenumber"}
    assert set(described["can"]) == {"extract", "spectrum", "window", "synthesize"}
    assert np.array_equal(reference.window("hann", 8), WINDOWS["hann"].samples(8))
    axes = [small_grid.samples(axis) for axis in range(3)]
    assert np.array_equal(reference.synthesize(small_sea, *axes), surface)
    for window in WINDOWS:
        assert np.array_equal(
            reference.spectrum(surface, small_grid.spacing, window=window), fourier(surface, small_grid, window).whole()
        )
    velocities = reference.extract(surface, small_grid.spacing, np.array([1.0]), gravity=1.0, window="box", method="ls")
    assert velocities.shape == (1, 2)
    assert np.array_equal(
        velocities, extract(surface, small_grid.spacing, 1.0, window="box", method="ls", gravity=1.0).velocities
    )


STILL = np.zeros((8, 8, 8))
GRID = Grid((8, 8, 8), (1, 1, 1))
WAVE = Components([1.0], [0.0], [1.0], [1.0], [0.0])


def holding(value: float) -> np.ndarray:
    eta = STILL.copy()
    eta[1, 2, 3] = value
    return eta


@pytest.mark.parametrize(
    ("refused", "call", "fault", "remedy"),
    [
        (
            lambda: extract(holding(np.nan), (1, 1, 1), [1.0], gravity=1.0),
            "extract",
            "1 of 512 values that are not finite",
            "remove",
        ),
        (lambda: extract(holding(np.inf), (1, 1, 1), [1.0], gravity=1.0), "extract", "1 of 512 values", "fill"),
        (lambda: extract(STILL + 0j, (1, 1, 1), [1.0], gravity=1.0), "extract", "complex", "real numbers"),
        (
            lambda: extract(STILL[0], (1, 1, 1), [1.0], gravity=1.0),
            "extract",
            "shape (8, 8), 2 dimensions",
            "3 dimensions",
        ),
        (lambda: extract(STILL[None], (1, 1, 1), [1.0], gravity=1.0), "extract", "4 dimensions", "3 dimensions"),
        (lambda: extract(STILL[:1], (1, 1, 1), [1.0], gravity=1.0), "Grid", "(1, 8, 8)", "two samples or more"),
        (lambda: extract(STILL[:, :, :1], (1, 1, 1), [1.0], gravity=1.0), "Grid", "(8, 8, 1)", "two samples or more"),
        (lambda: extract(STILL[:, :0], (1, 1, 1), [1.0], gravity=1.0), "Grid", "(8, 0, 8)", "two samples or more"),
        (lambda: extract(STILL, (1, 0, 1), [1.0], gravity=1.0), "Grid", "spacing", "> 0"),
        (lambda: extract(STILL, (1, 1, -1), [1.0], gravity=1.0), "Grid", "spacing", "> 0"),
        (lambda: extract(STILL, (1, 1), [1.0], gravity=1.0), "Grid", "spacing", "(dx, dy, dt)"),
        (
            lambda: extract(STILL, (1, 1, 1), [1.0], window="welch", gravity=1.0),
            "window",
            "'welch'",
            "box, hann, blackman, kaiser",
        ),
        (lambda: extract(STILL, (1, 1, 1), [1.0], method="nelder", gravity=1.0), "analyse", "'nelder'", "nsp, ls"),
        (lambda: extract(STILL, (1, 1, 1), [1.0], gravity=0), "extract", "gravity = 0", "> 0"),
        (lambda: extract(STILL, (1, 1, 1), [3.0], gravity=1.0), "shell_at", "Nyquist wavenumber", "ask for k below"),
        (lambda: extract(STILL, (1, 1, 1), [0.4], half_width=0.1, gravity=1.0), "shell_at", "no bin", "widen"),
        (lambda: extract(STILL, (1, 1, 1), [], gravity=1.0), "", "empty", "at least one"),
        (lambda: extract(STILL, (1, 1, 1), [np.nan], gravity=1.0), "", "not finite", "remove"),
        (lambda: extract(STILL, (1, 1, 1), [-1.0], gravity=1.0), "", "not positive", "> 0"),
        (lambda: reference.spectrum(STILL[0], (1, 1, 1)), "spectrum", "2 dimensions", "3 dimensions"),
        (
            lambda: transform(WAVE, GRID, ("hann",), route="C"),
            "transform",
            "'C'",
            "A (surface and FFT) or B (closed form)",
        ),
        (lambda: transform(WAVE, GRID, ("hann", "welch"), route="B"), "window", "'welch'", "box"),
        (
            lambda: analyse(fourier(STILL, GRID), [1.0], method="ls", threshold=2, gravity=1.0),
            "leastsquares.extract",
            "threshold = 2",
            "at most 1",
        ),
        (
            lambda: analyse(leakage.spectrum(WAVE, GRID, largest_wavenumber=0.5), [1.0], gravity=1.0),
            "shell_at",
            "the spectrum only to",
            "larger largest_wavenumber",
        ),
        (lambda: shell_wavenumbers(GRID, -1.0, 2.0), "shell_wavenumbers", "smallest = -1", "> 0"),
        (lambda: shell_wavenumbers(GRID, np.nan, 2.0), "shell_wavenumbers", "smallest", ""),
    ],
)
def test_bad_input_is_refused_by_call_fault_and_remedy(refused, call, fault, remedy):
    with pytest.raises(LeakrefError) as caught:
        refused()
    assert caught.value.call.endswith(call)
    assert fault in caught.value.fault
    assert remedy in caught.value.remedy
    assert str(caught.value) == f"{caught.value.call}: {caught.value.fault}; {caught.value.remedy}."


@pytest.mark.parametrize("call", [extract, analyse, nsp.extract, leastsquares.extract])
def test_no_gravity_is_taken_for_granted(call, small_grid):
    """1 would be right in scaled units only: who has metres would get a plausible answer."""
    surface = np.zeros(small_grid.shape)
    given = (surface, small_grid.spacing) if call is extract else (fourier(surface, small_grid),)
    with pytest.raises(LeakrefError, match=r"neither gravity nor water; .* 9\.81 for metres and seconds") as refused:
        call(*given, [1.0])
    assert refused.value.call.endswith(call.__name__)
    with pytest.raises(LeakrefError, match=r"gravity = 1\.0, and that of water is 9\.81; give the water alone"):
        call(*given, [1.0], gravity=1.0, water=Water(9.81, 3.0))
    assert np.isnan(call(*given, [1.0], gravity=9.81, water=Water(9.81, 3.0)).velocities).all()
    assert np.isnan(call(*given, [1.0], gravity=1.0).velocities).all()
    assert np.isnan(call(*given, [1.0], water=DEEP).velocities).all()


def test_no_wavenumbers_are_taken_for_granted(small_grid):
    with pytest.raises(TypeError):
        shell_wavenumbers(small_grid)
