"""The chain with changed lines."""

import numpy as np
import pytest

import leakref
import leakref.shell
from leakref import LeakrefError
from leakref.altered import Change, altered

GRID = leakref.Grid((24, 20, 32), (0.9, 1.1, 0.5))


def surface():
    waves, _ = leakref.aligned_waves(GRID, [(3, 1, 6), (-2, 3, 7)], gravity=1.0)
    return leakref.synthesize(waves, *(GRID.samples(axis) for axis in range(3)))


def test_a_chain_with_no_change_is_the_chain():
    same = altered(()).chain.extract(surface(), GRID.spacing, [0.9], gravity=1.0)
    assert np.array_equal(same.velocities, leakref.extract(surface(), GRID.spacing, [0.9], gravity=1.0).velocities)


def test_a_change_acts_and_leaves_the_chain_alone():
    before = leakref.extract(surface(), GRID.spacing, [0.9], gravity=1.0).velocities
    narrower = Change("shell", "HALF_WIDTH = 2.0", "HALF_WIDTH = 1.5")
    other = altered((narrower, Change("nsp", "WIDTH = 4.0", "WIDTH = 5.0")))
    assert (other.shell.HALF_WIDTH, other.nsp.WIDTH) == (1.5, 5.0)
    assert other.nsp.Shell is other.shell.Shell is not leakref.shell.Shell
    assert np.abs(other.chain.extract(surface(), GRID.spacing, [0.9], gravity=1.0).velocities - before).max() > 1e-6
    assert np.array_equal(leakref.extract(surface(), GRID.spacing, [0.9], gravity=1.0).velocities, before)


def test_refusals_of_an_altered_chain_are_refusals():
    with pytest.raises(LeakrefError, match="no method named"):
        altered(()).chain.extract(surface(), GRID.spacing, [0.9], method="x", gravity=1.0)


@pytest.mark.parametrize(
    "change",
    [
        Change("nsp", "WIDTH = 4.1", "WIDTH = 5"),
        Change("nsp", "shell", "shell_"),
        Change("nsp", "WIDTH = 4.0", "WIDTH = 4.0"),
    ],
)
def test_a_change_that_does_not_fit_is_refused_before_anything_runs(change):
    with pytest.raises(LeakrefError, match=r"occurs \d+ times in nsp.py"):
        altered((change,))
