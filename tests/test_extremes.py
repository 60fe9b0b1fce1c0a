"""Magnitudes that no sea has: the right number, or a refusal in words. Never a traceback, never a warning."""

from __future__ import annotations

import json
from contextlib import suppress

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

import leakref
from leakref import Grid, LeakrefError, SeaState, UniformCurrent, chain
from leakref.cli import app
from leakref.cubes import blocks, files
from leakref.methods import METHODS

GRID = Grid((20, 22, 32), (0.8, 0.75, 0.9))
SEA = SeaState(direction=70, spread=60, length=3, current=UniformCurrent((0.07, -0.04))).components(3)
ETA = leakref.synthesize(SEA, *(GRID.samples(axis) for axis in range(3)))
ETA /= np.abs(ETA).max()
WAVENUMBERS = [1.2]
FOUND = {
    method: chain.extract(ETA, GRID.spacing, WAVENUMBERS, method=method, gravity=1.0).velocities for method in METHODS
}
POWERS = st.floats(-323, 308)
FEW = settings(max_examples=40, deadline=None, derandomize=True)


@pytest.mark.parametrize("method", METHODS)
@FEW
@given(st.floats(-300, 308))
def test_velocities_do_not_depend_on_the_amplitude(method, power):
    found = chain.extract(ETA * 10.0**power, GRID.spacing, WAVENUMBERS, method=method, gravity=1.0)
    np.testing.assert_allclose(found.velocities, FOUND[method], atol=1e-6)  # the simplex ends where rounding has it


@pytest.mark.parametrize("factor", [5e-324, 1e-320, 1e-310, np.finfo(np.float32).tiny, np.finfo(np.float64).max])
def test_the_ends_of_what_can_be_stored_are_no_end(factor):
    for method in METHODS:
        assert np.isfinite(
            chain.extract(ETA * factor, GRID.spacing, WAVENUMBERS, method=method, gravity=1.0).velocities
        ).all()


def test_a_power_of_two_changes_no_bit():
    for power in (-900, -101, -99, 99, 101, 1000):
        found = chain.extract(np.ldexp(ETA, power), GRID.spacing, WAVENUMBERS, gravity=1.0)
        assert np.array_equal(found.velocities, FOUND["nsp"])


@FEW
@given(*[POWERS] * 4, st.sampled_from(list(METHODS)))
def test_any_spacing_gravity_and_wavenumber_gives_a_number_or_a_refusal(length, time, gravity, wavenumber, method):
    dx, dt, g, k = (10.0**power for power in (length, time, gravity, wavenumber))
    with suppress(LeakrefError):
        assert chain.extract(ETA, (dx, dx, dt), [k], gravity=g, method=method).velocities.shape == (1, 2)


@FEW
@given(*[st.floats(-1.7e308, 1.7e308), POWERS, POWERS, POWERS, POWERS], st.sampled_from(["none", "mean", "linear"]))
def test_any_file_gives_numbers_or_one_line(tmp_path_factory, start, length, time, gravity, amplitude, detrend):
    path = tmp_path_factory.getbasetemp() / "extreme.npz"
    with np.errstate(all="ignore"):
        steps = (10.0**length, 10.0**length, 10.0**time)
        x, y, t = (start + np.arange(n) * d for n, d in zip(GRID.shape, steps, strict=True))
        np.savez(path, eta=ETA * 10.0**amplitude, x=x, y=y, t=t, gravity=10.0**gravity)
    done = CliRunner().invoke(app, ["extract", str(path), "--detrend", detrend, "--json"], catch_exceptions=False)
    assert done.exit_code in (0, 1, 2), done.stderr  # 1: waves that are scaled like this lie on no dispersion shell
    assert done.stderr.count("\n") == (done.exit_code == 2)
    assert done.exit_code == 2 or json.loads(done.stdout)["ok"] is (done.exit_code == 0)


@pytest.mark.parametrize("detrend", ["none", "mean", "linear"])
@pytest.mark.parametrize("power", [-1000, 0, 1020])
def test_the_trend_removed_is_said_in_the_file_s_units(detrend, power, tmp_path):
    files.write(tmp_path / "a.npz", files.Cube(np.ldexp(ETA + 0.5, power), GRID, 1.0), "npz")
    words = ["extract", str(tmp_path / "a.npz"), "--wavenumbers", "1.2", "--detrend", detrend, "--json"]
    found = json.loads(CliRunner().invoke(app, words, catch_exceptions=False).stdout)
    should = np.ldexp((ETA + 0.5).mean(), power) if detrend != "none" else 0.0
    np.testing.assert_allclose(found["removed"]["mean"], should, rtol=1e-12)


@pytest.mark.parametrize("factor", [1e308, 1e-300])
def test_a_cube_in_blocks_is_refused_where_its_samples_cannot_be_squared(factor):
    with pytest.raises(LeakrefError, match=r"samples of .*nearer to 1"):
        blocks.fourier_in_blocks(ETA * factor, GRID)
    with pytest.raises(LeakrefError, match="nearer to 1"):
        blocks.trend(ETA * factor, "mean")


@pytest.mark.parametrize("current", [(0.1,), (0.1, 0.2, 0.3), 0.1, (0.1, np.nan), [[0.1], [0.2]]])
def test_a_current_has_two_components_wherever_it_is_given(current, tmp_path):
    with pytest.raises(LeakrefError, match="current"):
        files.Cube(ETA, GRID, 1.0, current=np.array(current))
    with pytest.raises(LeakrefError, match="is no current"):
        SeaState(current=current)

    class Own:
        def doppler_shift_velocity(self, wavenumber):
            return np.broadcast_to(current, (wavenumber.size, *np.shape(current)))

    with pytest.raises(LeakrefError, match="elocit"):
        SeaState(length=2, current=Own()).components(0)
    linear, exponential = leakref.LinearCurrent, leakref.ExponentialCurrent
    for make in (UniformCurrent, lambda c: linear(c, (0, 0)), lambda c: linear((0, 0), c), lambda c: exponential(c, 1)):
        with pytest.raises(LeakrefError):
            make(current)
    if np.ravel(current).size != 2:  # a column is what MATLAB has
        files.write(tmp_path / "a.npz", files.Cube(ETA, GRID, 1.0), "npz")
        with np.load(tmp_path / "a.npz") as kept:
            np.savez(tmp_path / "b.npz", **kept, current=np.array(current))
        with pytest.raises(LeakrefError, match=r"b\.npz: current = .* is not a vector; give two"):
            files.read(tmp_path / "b.npz")


@pytest.mark.parametrize("chunks", [(5, 11, 8), None])
def test_netcdf_that_was_not_written_to_its_end_is_called_that(chunks, tmp_path):
    with h5py.File(tmp_path / "a.nc", "w") as file:
        eta = file.create_dataset("eta", GRID.shape, "f8", chunks=chunks)
        if chunks:
            eta[:5, :11, :8] = ETA[:5, :11, :8]
        file["x"], file["y"], file["t"] = (GRID.samples(axis) for axis in range(3))
        file["gravity"] = 1.0
    with pytest.raises(LeakrefError, match=r"of which \d of \d+ parts were ever written; finish writing it"):
        files.read(tmp_path / "a.nc", axes="xyt")
    with h5py.File(tmp_path / "a.nc", "a") as file:
        file["eta"][:] = ETA
    assert np.array_equal(files.read(tmp_path / "a.nc", axes="xyt").surface, ETA)
