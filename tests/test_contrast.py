"""Is there a dispersion shell? Calibrated on the seas of the paper, on noise, on still frames and on swell alone."""

from __future__ import annotations

import re
from functools import partial

import numpy as np
import pytest

from leakref import Components, Grid, SeaState, fourier, leakage, synthesize
from leakref.cases import PAPER_CASES, Configuration
from leakref.chain import analyse, shell_wavenumbers
from leakref.cubes import causes, contrast, depths
from leakref.cubes.cube import Cube
from leakref.cubes.screen import shells_with_signal
from leakref.cubes.wavenumbers import default_wavenumbers
from leakref.dispersion import DEEP, Water

SEAS = [c for members in PAPER_CASES.values() for c in members]
QUICK = [
    Configuration("quick", length=5, duration=10, direction=75, spread=60),
    Configuration("quick", length=5, duration=10, direction=60, spread=15, peakedness=7),
    Configuration("quick", length=5, duration=10, spread=15, speed=0.15, current_direction=-90),
    Configuration("quick", length=5, duration=10, speed=0.15, current_direction=90, rotation=30),
]


def judged(spectrum, k, water=DEEP):
    """The verdict on a spectrum, as `leakref extract` comes to it, and its contrasts."""
    k = k[shells_with_signal(spectrum, k, 0.5)]
    some = k[:: max(1, k.size // 5)]
    found = analyse(spectrum, some, water=water, search=False).velocities if some.size else np.zeros((0, 2))
    contrasts = contrast.contrasts(spectrum, some, found, water)
    still = {"depth": water.depth, "surface_tension": water.surface_tension}
    cube = Cube(np.zeros((2, 2, 2)), spectrum.grid, water.gravity, **still)
    return causes.judge(contrast.band(spectrum, k, water), contrasts, cube), contrasts


def of(configuration, realization=0):
    sea, grid = configuration.components(realization), configuration.grid
    reach = 3.5 + 3 * grid.wavenumber_resolution
    return leakage.spectrum(sea, grid, "hann", largest_wavenumber=reach), shell_wavenumbers(grid, 0.5, 3.5)


@pytest.mark.parametrize("configuration", [*QUICK, *(pytest.param(c, marks=pytest.mark.slow, id=c.id) for c in SEAS)])
def test_no_sea_of_the_paper_is_called_one_without_a_shell(configuration):
    verdict, contrasts = judged(*of(configuration))
    assert (verdict.holds, verdict.words) == (True, ())
    assert verdict.share > 1.5 * contrast.SHARE
    assert np.mean(np.array(contrasts) > contrast.CONTRAST) > 0.9


def in_depth(kh, **varied):
    varied = {"length": 5, "duration": 10} | varied
    return Configuration("depth", depth=kh, varied=("depth",), **varied)


SHALLOW = [0.7, 1.0, 1.5, 2.0]


@pytest.mark.parametrize("kh", SHALLOW)
@pytest.mark.parametrize(
    "varied",
    [
        {},
        {"direction": 60, "spread": 15, "peakedness": 7},
        {"speed": 0.15, "current_direction": -90},
        pytest.param({"length": 10, "duration": 20}, marks=pytest.mark.slow),
        pytest.param({"length": 20, "duration": 20, "spread": 15}, marks=pytest.mark.slow),
    ],
)
def test_no_sea_of_a_known_depth_is_called_one_without_a_shell_or_of_another(kh, varied):
    configuration = in_depth(kh, **varied)
    verdict, contrasts = judged(*of(configuration), configuration.water)
    assert (verdict.holds, verdict.words) == (True, ())
    assert verdict.share > 1.5 * contrast.SHARE
    assert np.mean(np.array(contrasts) > contrast.CONTRAST) > 0.9
    low, high = verdict.depths
    assert low <= kh <= high


@pytest.mark.parametrize("kh", [0.5, 0.7, 1.0])
@pytest.mark.parametrize("taken", [np.inf, 3.0, 0.25])
def test_a_depth_that_is_not_there_is_told_with_the_one_that_is(kh, taken):
    """Deep water taken for granted, a depth too large and one too small; within what the cube leaves open."""
    verdict, _ = judged(*of(in_depth(kh, direction=75)), Water(1.0, depth=taken))
    assert not verdict.holds
    (said,) = (word for word in verdict.words if "--depth" in word)
    found = float(re.search(r"--depth (\S+)", said)[1])
    low, high = verdict.depths
    assert low * 0.99 <= kh <= high * 1.01
    assert found == pytest.approx(kh, rel=0.25)


def test_where_k_h_is_large_nothing_is_said_of_the_depth():
    for water in (DEEP, Water(1.0, depth=6.0), Water(1.0, depth=50.0)):
        verdict, _ = judged(*of(in_depth(3.0)), water)
        assert (verdict.holds, verdict.words) == (True, ())
        assert 1 < verdict.depths[0] < 4
        assert verdict.depths[1] == np.inf


def test_the_depth_of_waves_all_alike_is_told_to_a_tenth():
    """By the fit alone, in a larger cube: what the words and the JSON are made of."""
    spectrum, k = of(in_depth(0.8, length=8, duration=16))
    found = depths.fit(contrast.band(spectrum, k[shells_with_signal(spectrum, k, 0.5)], DEEP), metric=False)
    assert found.water.depth == pytest.approx(0.8, rel=0.1)
    assert found.shallowest < 0.8 < found.deepest < 1.5 * found.shallowest
    assert not found.is_deep


@pytest.mark.parametrize("decibels", [0, -10, -20])
def test_noise_on_top_hides_no_shell(decibels):
    sea, grid = QUICK[3].components(0), Grid((70, 68, 80), (2 * np.pi * 5 / 70, 2 * np.pi * 5 / 68, np.pi / 4))
    eta = synthesize(sea, *(grid.samples(axis) for axis in range(3)))
    noise = np.random.default_rng(0).normal(size=eta.shape) * eta.std() * 10 ** (-decibels / 20)
    verdict, _ = judged(fourier(eta + noise, grid), shell_wavenumbers(grid, 0.8, 3.0))
    assert (verdict.holds, verdict.words) == (True, ())


@pytest.mark.parametrize("shape", [(60, 70, 80), (48, 48, 300)])
@pytest.mark.parametrize("kind", ["noise", "still", "still and smooth", "nothing"])
def test_what_is_no_sea_has_no_shell(shape, kind):
    rng, grid = np.random.default_rng(1), Grid(shape, (0.3, 0.28, 0.4))
    picture = rng.normal(size=shape[:2])
    if kind == "still and smooth":
        picture = sum(np.roll(picture, (i, j), (0, 1)) for i in range(4) for j in range(4))
    cube = rng.normal(size=shape) if kind == "noise" else np.repeat(picture[:, :, None], shape[2], axis=2)
    verdict, _ = judged(fourier(cube * (kind != "nothing"), grid), default_wavenumbers(grid))
    assert not verdict.holds
    assert verdict.words[0].startswith("No dispersion shell")
    assert not any("Comes right" in word for word in verdict.words)


@pytest.mark.parametrize("spread", [15, 60])
@pytest.mark.parametrize("length", [2.0, 3.3])
def test_half_an_hour_of_swell_alone_has_no_shell_at_shorter_waves(length, spread):
    """Waves of a tenth of a hertz in a picture of two or three wavelengths: elsewhere there is only what leaks."""
    sea = SeaState(direction=70, spread=spread, peakedness=7, length=length).components(0)
    swell = np.hypot(sea.kx, sea.ky) < 1.25
    sea = Components(*(getattr(sea, name)[swell] for name in ("kx", "ky", "omega", "amplitude", "phase")))
    n, periods = int(28 * length), 180
    d = 2 * np.pi * length / n
    grid = Grid((n, n, 5 * periods), (d, d, 2 * np.pi / 5))
    verdict, contrasts = judged(leakage.spectrum(sea, grid, "hann", largest_wavenumber=7), default_wavenumbers(grid, 6))
    assert not verdict.holds, (verdict, contrasts)


@pytest.mark.parametrize(
    ("factor", "holds"), [(1 / 1.2, False), (0.9, True), (1.0, True), (10 / 9, True), (1.2, False), (3.13, False)]
)
def test_a_wrong_step_is_told_by_its_factor(factor, holds):
    """As if dt were wrong by `factor`: the surface is looked for at 1 / factor of where it is."""
    spectrum, k = of(Configuration("a", length=5, duration=20, direction=60, spread=30, speed=0.1))
    verdict, _ = judged(spectrum, k, Water(factor**-2))
    assert verdict.holds is holds
    said = [float(word) for word in re.findall(r"dt x ([0-9.]+)", " ".join(verdict.words))]
    assert said == pytest.approx([factor] * len(said), rel=0.04)
    assert bool(said) is (factor != 1)


def test_the_contrast_is_energy_near_over_energy_beside(small_grid):
    """Two waves on bins, one on the surface of still water and one far from it, of a quarter of its energy."""
    kx, _, domega = small_grid.bin_widths
    wave = partial(Components, [6 * kx], [0.0])
    on = np.sqrt(6 * kx)
    near = leakage.spectrum(wave([round(on / domega) * domega], [1.0], [0.0]), small_grid, "box")
    far = leakage.spectrum(wave([3 * on], [0.5], [0.0]), small_grid, "box")
    both = type(near)(near.grid, "box", near.i, near.j, near.values + far.values)
    at = partial(contrast.contrasts, wavenumbers=np.array([6 * kx]), velocities=np.zeros((1, 2)), water=DEEP)
    assert at(near) == [1e6]
    assert at(both)[0] == pytest.approx(4, rel=0.2)
    assert contrast.contrasts(near, np.array([6 * kx]), np.full((1, 2), np.nan), DEEP) == [None]
