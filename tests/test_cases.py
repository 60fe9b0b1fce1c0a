"""The paper's table as data."""

from dataclasses import replace

import numpy as np
import pytest

from leakref import LeakrefError
from leakref.cases import ASSUMED_DEEP, CASES, PAPER_CASES, Configuration, configurations
from leakref.dispersion import DEEP, Water

ALL = [c for members in CASES.values() for c in members]


def test_the_cases_are_those_of_the_paper():
    assert list(PAPER_CASES) == ["nsp-ls", "theta0-dtheta", "gamma", "L-T", "U", "windows"]
    assert list(CASES) == [*PAPER_CASES, "depth"]
    assert {c.water for members in PAPER_CASES.values() for c in members} == {DEEP}
    assert len({c.id for c in ALL}) == len(ALL)
    assert "gamma/spread=15,peakedness=7" in {c.id for c in ALL}
    (base,) = CASES["nsp-ls"]
    assert (base.direction, base.spread, base.peakedness) == (75, 60, 3.3)
    assert (base.length, base.duration, base.speed) == (10, 20, 0)
    assert {c.direction for c in CASES["gamma"]} == {60}
    assert {(c.length, c.duration) for c in CASES["L-T"]} == {(a, b) for a in (5, 10, 20) for b in (10, 20, 80)}
    assert {c.rotation for c in CASES["U"]} == {0, 30}
    assert max(c.speed for c in CASES["U"]) == 0.15
    assert all({"box", "hann"} <= set(c.windows) for c in ALL)


@pytest.mark.parametrize("c", ALL, ids=lambda c: c.id)
def test_an_id_names_its_configuration_and_its_grid_is_that_of_the_paper(c):
    assert configurations([c.id]) == [c]
    assert c.grid.shape == (28 * c.length, 28 * c.length, 14 * c.duration)
    dk = 1 / c.length
    np.testing.assert_allclose(c.wavenumbers, np.arange(np.ceil(0.4 / dk), np.floor(3.5 / dk) + 1) * dk, rtol=1e-14)


def test_a_rotated_configuration_is_the_same_sea_and_current_turned():
    still, turned = (
        next(c for c in CASES["U"] if (c.rotation, c.speed, c.current_direction) == (angle, 0.15, -90))
        for angle in (0, 30)
    )
    a, b = still.components(3), turned.components(3)
    np.testing.assert_allclose(b.kx + 1j * b.ky, (a.kx + 1j * a.ky) * np.exp(1j * np.pi / 6), atol=1e-14)
    np.testing.assert_array_equal(a.omega, b.omega)
    np.testing.assert_allclose(turned.current, 0.15 * np.array([np.cos(np.pi / 3), -np.sin(np.pi / 3)]), atol=1e-15)
    # its frequencies follow from the turned current, so that the truth is the truth
    shift = b.omega - np.sqrt(np.hypot(b.kx, b.ky))
    np.testing.assert_allclose(shift, b.kx * turned.current[0] + b.ky * turned.current[1], atol=1e-14)
    # at the centre of the domain both show the same water
    centre = np.array(still.grid.lengths[:2]) / 2
    t = np.linspace(0, 100, 7)[:, None]
    at_centre = [
        np.sum(s.amplitude * np.cos(s.kx * centre[0] + s.ky * centre[1] - s.omega * t + s.phase), axis=1)
        for s in (a, b)
    ]
    np.testing.assert_allclose(*at_centre, atol=1e-11)


def test_case_depth_is_the_paper_s_own_sea_over_a_bottom():
    """The same domain, lattice and phases (decision D31): only the water is another."""
    assert [c.id for c in CASES["depth"]] == ["depth/kh=0.7", "depth/kh=1", "depth/kh=1.5", "depth/kh=2"]
    (own,) = configurations(["theta0-dtheta/direction=90,spread=60"])
    deep = own.components(0)
    for c in CASES["depth"]:
        assert replace(c, case=own.case, depth=np.inf, varied=own.varied) == own
        assert c.water == c.measured_in == Water(1.0, depth=c.depth)
        over = c.components(0)  # at some of the longest there is no energy left, or none in deep water
        shared = {(x, y): w for x, y, w in zip(deep.kx, deep.ky, zip(deep.omega, deep.phase, strict=True), strict=True)}
        both = [n for n, at in enumerate(zip(over.kx, over.ky, strict=True)) if at in shared]
        assert len(both) > 0.99 * deep.kx.size
        omega, phase = np.array([shared[over.kx[n], over.ky[n]] for n in both]).T
        np.testing.assert_array_equal(over.phase[both], phase)
        kh = np.hypot(over.kx, over.ky)[both] * c.depth
        np.testing.assert_allclose(over.omega[both], omega * np.sqrt(np.tanh(kh)), rtol=1e-14)


def test_the_same_seas_taken_for_deep_are_configurations_of_their_own():
    for c, known in zip(ASSUMED_DEEP, CASES["depth"], strict=True):
        assert (c.id, c.water, c.measured_in) == (f"{known.id},assumed=deep", known.water, DEEP)
        assert configurations([c.id]) == [c]
    assert not set(ASSUMED_DEEP) & set(configurations(["depth"]))
    assert replace(CASES["depth"][0], assumed=Water(1.0, depth=3.0)).id == "depth/kh=0.7,assumed=3"


def test_unknown_cases_are_refused_with_what_comes_close():
    with pytest.raises(LeakrefError, match=r"no case is called 'gamma/spread=16'.*gamma/spread=15"):
        configurations(["gamma/spread=16"])
    with pytest.raises(LeakrefError, match="nsp-ls"):
        configurations(["nonsense"])
    with pytest.raises(LeakrefError, match="spread"):
        Configuration("x", spread=-1)
    assert [c.id for c in configurations(["nsp-ls", "nsp-ls"])] == ["nsp-ls"]
