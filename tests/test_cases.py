"""The paper's table as data."""

import numpy as np
import pytest

from leakref import LeakrefError
from leakref.cases import CASES, Configuration, configurations

ALL = [c for members in CASES.values() for c in members]


def test_the_cases_are_those_of_the_paper():
    assert list(CASES) == ["nsp-ls", "theta0-dtheta", "gamma", "L-T", "U", "windows"]
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


def test_unknown_cases_are_refused_with_what_comes_close():
    with pytest.raises(LeakrefError, match=r"no case is called 'gamma/spread=16'.*gamma/spread=15"):
        configurations(["gamma/spread=16"])
    with pytest.raises(LeakrefError, match="nsp-ls"):
        configurations(["nonsense"])
    with pytest.raises(LeakrefError, match="spread"):
        Configuration("x", spread=-1)
    assert [c.id for c in configurations(["nsp-ls", "nsp-ls"])] == ["nsp-ls"]
