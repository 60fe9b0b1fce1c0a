"""Timings, out of the default run: `pytest --benchmark-only tests/test_benchmarks.py`. Nothing here asserts a time."""

from dataclasses import replace

import numpy as np
import pytest
from literal import realize as literal

from leakref import analyse, fast, fourier, leakage, runs, synthesize
from leakref.cases import configurations

(BASE,) = configurations(["nsp-ls"])
GRID, K = BASE.grid, BASE.wavenumbers


@pytest.fixture(scope="module")
def waves():
    return BASE.components(0)


@pytest.fixture(scope="module")
def surface(waves):
    return synthesize(waves, *(GRID.samples(axis) for axis in range(3)))


@pytest.fixture(scope="module")
def spectrum(waves):
    return leakage.spectrum(waves, GRID, "hann", largest_wavenumber=3.9)


@pytest.mark.benchmark(group="surface")
def test_synthesis(benchmark, waves):
    eta = benchmark(synthesize, waves, *(GRID.samples(axis) for axis in range(3)))
    assert eta.var() == pytest.approx(waves.variance, rel=0.1)


@pytest.mark.benchmark(group="spectrum")
@pytest.mark.parametrize("workers", [1, 2])
def test_taper_and_fft(benchmark, surface, workers):
    assert benchmark(fourier, surface, GRID, "hann", workers=workers).values.shape == (280, 280, 141)


@pytest.mark.benchmark(group="spectrum")
def test_closed_form(benchmark, waves):
    assert benchmark(leakage.spectrum, waves, GRID, "hann", largest_wavenumber=3.9).values.any()


@pytest.mark.benchmark(group="extraction")
@pytest.mark.parametrize("method", ["nsp", "ls"])
def test_literal_extraction(benchmark, spectrum, method):
    settings = {"search": False} if method == "nsp" else {}
    found = benchmark.pedantic(analyse, (spectrum, K), {"method": method, **settings}, rounds=2)
    assert np.isfinite(found.velocities).all()


@pytest.mark.benchmark(group="realization")
def test_realization_literal(benchmark, waves):
    assert len(benchmark.pedantic(literal, (waves, GRID, K), rounds=1)) == 4


@pytest.mark.benchmark(group="realization")
@pytest.mark.parametrize("search", [False, True])
def test_realization_fast(benchmark, waves, search):
    with runs.one_thread():
        assert len(benchmark(fast.realize, waves, GRID, K, search=search)) == 4


@pytest.mark.benchmark(group="growth")
@pytest.mark.parametrize(("length", "duration"), [(5, 20), (10, 20), (20, 20), (10, 10), (10, 80), (20, 80)])
def test_growth(benchmark, length, duration):
    one = replace(BASE, length=length, duration=duration)
    with runs.one_thread():
        benchmark.pedantic(fast.realize, (one.components(0), one.grid, one.wavenumbers), rounds=3, warmup_rounds=1)


@pytest.mark.benchmark(group="workers")
@pytest.mark.parametrize("workers", [1, 2])
def test_ensemble(benchmark, workers):
    with runs.pool(workers) as executor:
        benchmark.pedantic(
            lambda: list(runs.run([BASE], realizations=20, executor=executor)), rounds=2, warmup_rounds=1
        )
