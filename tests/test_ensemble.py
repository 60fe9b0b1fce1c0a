"""Realisations and their statistics."""

import numpy as np
import pytest

from leakref import LeakrefError, Note, ensemble, runs
from leakref.cases import Configuration

SMALL = Configuration("small", direction=60, spread=45, length=2, duration=4)


@pytest.fixture(scope="module")
def found():
    return {(e.window, e.method): e for e in next(runs.run([SMALL], realizations=3))}


def test_an_ensemble_holds_every_realisation_in_order(found):
    assert set(found) == {(w, m) for w in ("box", "hann") for m in ("nsp", "ls")}
    for number in (0, 2):
        alone = ensemble.realize(SMALL, number)
        for key, e in found.items():
            np.testing.assert_array_equal(e.velocities[number], alone[key].velocities)
            assert [Note(int(value)) for value in e.notes[number]] == list(alone[key].notes)


def test_both_routes_give_the_same_ensemble(found):
    for e in next(runs.run([SMALL], realizations=2, route="A", methods=["nsp"])):
        plain = e.notes == 0
        difference = np.abs(e.velocities - found[e.window, e.method].velocities[:2])[plain]
        assert plain.any()
        assert difference.max() < 1e-11  # c0: what a rounding of F moves in shells without a note


def test_statistics_by_hand_and_without_those_that_have_no_number():
    velocities = np.array([[[3.0, 4.0], [1.0, 0.0]], [[0.0, 1.0], [np.nan, np.nan]], [[0.0, -3.0], [3.0, 0.0]]])
    notes = np.array([[0, 8], [1, 16], [9, 0]])
    e = ensemble.Ensemble(SMALL, "box", "nsp", np.array([1.0, 2.0]), velocities, notes)
    np.testing.assert_array_equal(e.count, [3, 2])
    np.testing.assert_allclose(e.bias, [3.0, 2.0])
    np.testing.assert_allclose(e.random, [2.0, np.sqrt(2)])
    np.testing.assert_allclose(e.standard_error, [2 / np.sqrt(3), 1.0])
    np.testing.assert_allclose(e.mean, [[1.0, 2 / 3], [2.0, 0.0]])
    np.testing.assert_array_equal(e.noted(Note.FLAT), [1, 1])
    np.testing.assert_allclose(e.resolutions, [[0.25, 0.125], [0.25, 0.5 * 0.5 * 2**-1.5]])
    record = e.record()
    assert {
        "case",
        "window",
        "method",
        "wavenumbers",
        "bias",
        "random",
        "mean",
        "standard_error",
        "resolution_frequency",
        "resolution_wavenumber",
    } <= set(record)
    assert set(record["flagged"]) == {"another-basin", "flat", "no-signal"}


def test_one_realisation_has_no_random_part():
    (e,) = [e for e in next(runs.run([SMALL], realizations=1, methods=["ls"])) if e.window == "hann"]
    assert np.isnan(e.random).all()
    assert np.isfinite(e.bias).all()


def test_no_realisations_are_refused():
    with pytest.raises(LeakrefError, match="at least one"):
        next(runs.run([SMALL], realizations=0))
