"""Which bins make a shell, and what a shell knows about itself."""

from __future__ import annotations

from dataclasses import FrozenInstanceError

import numpy as np
import oracles
import pytest

from leakref import Components, Grid, LeakrefError, Note, Spectrum, analyse, fourier, leakage, nsp, shell_wavenumbers
from leakref.dispersion import DEEP, Water, velocity_unit
from leakref.shell import (
    EDGE_MARGIN,
    HALF_WIDTH,
    Optimum,
    Shell,
    checked_wavenumbers,
    collect,
    nothing,
    shell_at,
)


def noise(grid: Grid, window: str = "box") -> Spectrum:
    return fourier(np.random.default_rng(0).normal(size=grid.shape), grid, window)


def numbers(shell: Shell, grid: Grid) -> set[tuple[int, int]]:
    dkx, dky, _ = grid.bin_widths
    i, j = (np.rint(k).astype(int).tolist() for k in (shell.kx / dkx, shell.ky / dky))
    return set(zip(i, j, strict=True))


@pytest.mark.parametrize("length", [1.0, 0.1, 7.3, np.pi])  # k = i dk and hypot(i, j) dk round differently for each
@pytest.mark.parametrize("ratio", [1, 2])
def test_a_shell_is_the_literal_list_of_its_bins_with_those_on_the_edge(length, ratio):
    grid = Grid((24, 24 * ratio + 1, 4), (length, length * ratio * 24 / (24 * ratio + 1), 1.0))
    spectrum, dk = noise(grid), grid.wavenumber_resolution
    for n in range(1, 9):
        shell = shell_at(spectrum, n * dk, water=DEEP)
        expected = oracles.shell_bins(n, grid.shape[:2], ratio)
        assert numbers(shell, grid) == set(expected)
        assert (n + 2, 0) in expected  # on the edge
        assert shell.kx.size == len(expected)
    assert (HALF_WIDTH, EDGE_MARGIN) == (2.0, 1e-9)


def test_a_shell_holds_magnitudes_frequencies_and_weights_of_its_columns():
    grid = Grid((12, 17, 22), (0.9, 0.6, 0.35))
    spectrum = noise(grid)
    shell = shell_at(spectrum, 1.5, water=Water(9.81), half_width=1.5)
    whole, dk = spectrum.whole(), grid.wavenumber_resolution
    assert np.array_equal(shell.omega, spectrum.omega)
    assert np.array_equal(shell.weight, spectrum.half_weight)
    for kx, ky, intrinsic, magnitude in zip(shell.kx, shell.ky, shell.intrinsic, shell.magnitude, strict=True):
        i, j = round(kx / grid.bin_widths[0]), round(ky / grid.bin_widths[1])
        assert abs(np.hypot(kx, ky) - 1.5) <= 1.5 * dk * (1 + 1e-9)
        assert intrinsic == pytest.approx(np.sqrt(9.81 * np.hypot(kx, ky)), rel=4e-16)  # of the bin, not of the shell
        assert np.array_equal(magnitude, np.abs(whole[i, j, : 22 // 2 + 1]))
    assert not shell.is_empty


def test_every_shell_of_a_truncated_spectrum_is_complete_or_refused():
    grid = Grid((32, 32, 8), (0.7, 0.7, 0.5))
    dk, whole = grid.wavenumber_resolution, noise(grid)
    refused = 0
    for reach in (4, 5.5, 6, 7, 7.5, 8, 9):
        keep = np.abs(whole.i) <= reach + 1e-9
        part = Spectrum(grid, "box", whole.i[keep], whole.j[keep], whole.values[np.ix_(keep, keep)])
        for n in (4, 4.5, 5, 5.9, 6):
            expected = numbers(shell_at(whole, n * dk, water=DEEP), grid)  # with the bins on its edge
            if max(max(bins) for bins in expected) > reach:
                refused += 1
                with pytest.raises(LeakrefError, match="larger largest_wavenumber"):
                    shell_at(part, n * dk, water=DEEP)
            elif n + 3 <= reach:  # in between it may be refused, but never be incomplete
                assert numbers(shell_at(part, n * dk, water=DEEP), grid) == expected
    assert 0 < refused < 35


def test_a_wave_elsewhere_is_all_that_a_shell_holds_and_that_is_said():
    # one wave off the bins: every shell that is not around it holds its leakage and nothing else
    grid = Grid((32, 30, 64), (0.7, 0.75, 0.5))  # every wave is clear of its own mirror image in frequency
    k = shell_wavenumbers(grid, 0.7, 3.4)
    rng, judged = np.random.default_rng(1), 0
    for window in ("box", "hann", "blackman", "kaiser-bessel"):
        for _ in range(3):
            modulus, angle = rng.uniform(0.7, 3.3), rng.uniform(0, 2 * np.pi)
            kx, ky = modulus * np.cos(angle), modulus * np.sin(angle)
            wave = Components(kx, ky, np.sqrt(modulus), 1.0, rng.uniform(0, 6))
            spectrum = leakage.spectrum(wave, grid, window)
            _, (i, j, _) = spectrum.strongest
            elsewhere = [k_i for k_i in k if (i, j) not in numbers(shell_at(spectrum, k_i, water=DEEP), grid)]
            for method in ("nsp", "ls"):
                for note in analyse(spectrum, elsewhere, method=method, gravity=1.0).notes:
                    judged += 1
                    assert note & (Note.LEAKAGE_FLOOR | Note.NO_SIGNAL | Note.UNCONVERGED), (window, method, note)
    assert judged > 100


def test_a_wave_in_the_shell_is_no_leakage_floor_and_rounding_is_no_signal():
    grid = Grid((32, 30, 40), (0.7, 0.75, 0.5))
    kx, _, domega = grid.bin_widths
    wave = Components(6 * kx, 0.0, 5 * domega, 1.0, 0.0)
    spectrum = leakage.spectrum(wave, grid, "hann")
    own = shell_at(spectrum, 6 * kx, water=DEEP)
    assert own.floor is None
    assert own.notes(own.magnitude > 0) == Note.NONE
    assert not own.is_empty
    far = shell_at(leakage.spectrum(wave, grid, "box"), 2 * kx, water=DEEP)
    assert far.is_empty
    assert shell_at(fourier(np.zeros(grid.shape), grid), 1.0, water=DEEP).is_empty
    # a faint wave, ten times above what the strong one may leak there, is a signal
    faint = Components([6 * kx, 2 * kx], [0.0, 0.0], [5 * domega, 9 * domega], [1.0, 1e-3], [0.0, 0.0])
    shell = shell_at(leakage.spectrum(faint, grid, "hann"), 1.5 * kx, half_width=1, water=DEEP)
    assert shell.floor is not None
    assert shell.notes(shell.magnitude > 0.5 * shell.magnitude.max()) == Note.NONE


def test_wavenumbers_may_be_one_number_or_a_list():
    assert checked_wavenumbers(0.7).tolist() == [0.7]
    assert checked_wavenumbers([1, 2]).dtype == np.float64


def test_velocity_unit_is_the_phase_velocity_at_the_peak():
    assert [velocity_unit(k, DEEP, None) for k in (0.25, 0.4, 2.0, 3.5, 4.0)] == [1.0] * 5  # scaled units
    for k in (0.05, 60.0):  # a gravity of 1 in other units: nothing is known of the peak
        assert velocity_unit(k, DEEP, None) == pytest.approx(k**-0.5, rel=4e-16)
    assert velocity_unit(2.0, Water(9.81), None) == pytest.approx(np.sqrt(9.81 / 2), rel=4e-16)  # decision D21
    assert velocity_unit(2.0, Water(9.81), 0.1) == pytest.approx(np.sqrt(98.1), rel=4e-16)


def test_notes_are_named_as_in_json():
    assert Note.NONE.names == []
    assert (Note.ANOTHER_BASIN | Note.TOO_FEW_BINS).names == ["another-basin", "too-few-bins"]
    every = ["another-basin", "edge", "too-few-bins", "flat", "no-signal", "leakage-floor", "threshold", "unconverged"]
    assert (~Note.NONE).names == every


def test_nothing_is_nan_throughout_and_a_record_is_frozen():
    record = collect(
        "nsp",
        np.array([1.0, 2.0]),
        [nothing(Note.NO_SIGNAL), Optimum(np.ones(2), 3.0, np.zeros(2), -np.eye(2), 7, Note.FLAT)],
    )
    for array, shape in (
        (record.velocities, (2, 2)),
        (record.score, (2,)),
        (record.gradient, (2, 2)),
        (record.hessian, (2, 2, 2)),
    ):
        assert array.shape == shape
        assert np.isnan(array[0]).all()
        assert np.isfinite(array[1]).all()
    assert record.evaluations.tolist() == [0, 7]
    assert record.notes == (Note.NO_SIGNAL, Note.FLAT)
    with pytest.raises(FrozenInstanceError):
        record.method = "ls"


GRID = Grid((16, 12, 8), (0.7, 0.9, 0.5))


@pytest.mark.parametrize(
    ("wavenumber", "settings", "fault", "remedy"),
    [
        (0.0, {}, "wavenumber = 0", "> 0"),
        (-1.0, {}, "wavenumber = -1", "> 0"),
        (np.nan, {}, "not finite", "remove"),
        (1.0, {"half_width": -2}, "half_width = -2", "> 0"),
        (3.0, {}, "past the Nyquist wavenumber", "ask for k below"),
        (50.0, {}, "past the Nyquist", "ask for k below"),
        (0.3, {"half_width": 0.1}, "no bin lies within 0.1 dk", "widen the shell"),
    ],
)
def test_bad_shells_are_refused(wavenumber, settings, fault, remedy):
    with pytest.raises(LeakrefError) as caught:
        shell_at(noise(GRID), wavenumber, **{"water": DEEP, **settings})
    assert caught.value.call == "shell_at"
    assert fault in caught.value.fault
    assert remedy in caught.value.remedy


def test_the_remedy_for_nyquist_is_one():
    dk, nyquist = GRID.wavenumber_resolution, min(GRID.nyquist[:2])
    assert shell_at(noise(GRID), (nyquist - 2 * dk) * (1 - 1e-6), water=DEEP).kx.size > 0
    with pytest.raises(LeakrefError):
        shell_at(noise(GRID), (nyquist - 2 * dk) * (1 + 1e-6), water=DEEP)


@pytest.mark.parametrize(
    ("wavenumbers", "fault"),
    [
        ([], "empty"),
        ([1, np.nan], "not finite"),
        ([1, 0], "not positive"),
        ([-1], "not positive"),
        ([[1.0]], "2 dimensions"),
        ("a", "numeric"),
        (None, ""),
    ],
)
def test_bad_wavenumbers_are_refused_by_the_call_that_was_made(wavenumbers, fault):
    with pytest.raises(LeakrefError) as caught:
        nsp.extract(noise(GRID), wavenumbers, gravity=1.0)
    assert fault in caught.value.fault
    assert "wavenumbers" in str(caught.value)
