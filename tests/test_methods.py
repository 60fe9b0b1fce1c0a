"""Water and Method: one place knows a law of dispersion, and no method is answered with another one's numbers."""

from __future__ import annotations

import ast
import inspect
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import leakref
from leakref import Grid, LeakrefError, SeaState, analyse, ensemble, fast, figures, leakage, leastsquares, nsp, runs
from leakref.cases import CASES
from leakref.certify.checks import criteria, exact, inputs
from leakref.certify.subject.inprocess import InProcess
from leakref.dispersion import DEEP, Water
from leakref.golden import ids, oracle
from leakref.methods import METHODS, Method
from leakref.planning import figures as planning
from leakref.shell import Note, Optimum, checked_wavenumbers, collect, shell_at

GRID = Grid((40, 44, 64), (0.8, 0.75, 0.9))
SEA = SeaState(direction=70, spread=60, length=5).components(3)
K = np.array([1.0, 1.4])
WAYS = {"windows": ("hann",), "methods": ("nsp", "fixed", "ls")}


def _fixed(spectrum, wavenumbers, *, water=DEEP, half_width=2.0, offset=0.0):
    """A method of its own: the same velocity always, at which another method never arrives."""
    k = checked_wavenumbers(wavenumbers)
    one = Optimum(np.array([7.0, 11.0 + offset]), 1.0, np.zeros(2), np.eye(2), 0, Note.NONE)
    return collect("fixed", k, [one for _ in k])


@pytest.fixture
def registered(monkeypatch):
    """A method registered under a name of its own."""
    record = Method("fixed", "Fixed", "the same whatever it is shown", _fixed, {"offset": 0.0})
    monkeypatch.setitem(METHODS, "fixed", record)
    criteria.expected.cache_clear()
    yield record
    criteria.expected.cache_clear()


def is_fixed(velocities):
    return np.array_equal(velocities, np.tile([7.0, 11.0], (len(velocities), 1)))


def test_chain_and_fast_path_answer_a_method_with_its_own_numbers(registered):
    spectrum = leakage.spectrum(SEA, GRID, "hann")
    assert is_fixed(analyse(spectrum, K, method="fixed", gravity=1.0).velocities)
    assert is_fixed(analyse(spectrum, K, method="fixed", search=False, peak_wavenumber=1.0, gravity=1.0).velocities)
    assert not is_fixed(analyse(spectrum, K, method="fixed", offset=1.0, gravity=1.0).velocities)
    found = fast.realize(SEA, GRID, K, **WAYS, gravity=1.0)
    assert list(found) == [("hann", "nsp"), ("hann", "fixed"), ("hann", "ls")]
    assert is_fixed(found["hann", "fixed"].velocities)
    alone = fast.realize(SEA, GRID, K, windows=("hann",), gravity=1.0)
    for method in ("nsp", "ls"):  # and the others are what they were
        assert np.array_equal(found["hann", method].velocities, alone["hann", method].velocities)


def test_ensembles_and_their_stored_parts_too(registered, tmp_path):
    c = replace(CASES["L-T"][0], length=5.0, duration=10.0)
    assert is_fixed(ensemble.realize(c, 0, methods=("fixed",))["box", "fixed"].velocities)
    for _ in range(2):  # the second time from the folder
        (e,) = runs.run([c], realizations=2, methods=("fixed",), folder=tmp_path)
        for one in e:
            assert (one.method, is_fixed(one.velocities[0])) == ("fixed", True)


def test_certify_holds_it_to_its_own_reference(registered):
    cube = inputs.sea(70.0, 60.0, grid=inputs.SEA)
    assert is_fixed(criteria.expected(cube, "hann", "fixed").velocities)
    own = np.hypot(*(criteria.expected(cube, "hann", "fixed").velocities - cube.truth).T)
    np.testing.assert_array_equal(criteria.tolerance(cube, "hann", "fixed"), cube.resolutions[1] + 2 * own)

    class Code:
        def describe(self):
            return {"can": {"extract": {"methods": ["fixed"], "windows": ["hann"]}}}

        def extract(self, surface, spacing, wavenumbers, *, window, method):
            assert method == "fixed"
            return np.tile([7.0, 11.0], (len(wavenumbers), 1))

    subject = InProcess(Code())
    assert criteria.in_the_mean(subject, cube, "hann", "fixed").over < 1  # off by what the reference errs by
    found, _ = criteria.ask(subject, cube, "hann", "fixed")
    beyond = exact.exactly(subject, cube, "hann", "fixed", found + 1e-3, found)
    np.testing.assert_allclose(beyond, np.hypot(1e-3, 1e-3) / exact.EXACT, rtol=1e-9)  # it has no score to be kinder


def test_golden_values_figures_and_plans_name_it_as_itself(registered, monkeypatch):
    row = ids.Seas(2, CASES["nsp-ls"], ("fixed",), "fixed")
    monkeypatch.setattr(ids, "SEAS", (*ids.SEAS, row))  # all that golden values need of it
    assert "ensemble-nsp-ls/hann-fixed" in ids.ids("ensembles")
    assert "realization-nsp-ls/fixed/0" in ids.ids("realizations")
    (e,) = runs.run([replace(CASES["L-T"][0], windows=("hann",))], realizations=2, methods=("fixed",))
    drawing = figures.result_figure(list(e), "")
    assert "Fixed" in {
        text.get_text()
        for legend in drawing.legends or [ax.get_legend() for ax in drawing.axes]
        if legend
        for text in legend.get_texts()
    }
    assert "NSP" not in str([text.get_text() for ax in drawing.axes for text in ax.texts])
    assert "METHODS[method].title" in inspect.getsource(planning)


@pytest.mark.parametrize(
    "ask",
    [
        lambda: analyse(leakage.spectrum(SEA, GRID, "hann"), K, method="polar", gravity=1.0),
        lambda: fast.realize(SEA, GRID, K, methods=("polar",), gravity=1.0),
        lambda: ensemble.realize(CASES["L-T"][0], 0, methods=("polar",)),
        lambda: list(runs.run([CASES["L-T"][0]], realizations=1, methods=("polar",))),
    ],
)
def test_a_method_that_nobody_registered_is_refused(ask):
    with pytest.raises((LeakrefError, KeyError), match="polar"):
        ask()


def test_records_say_what_their_methods_take():
    for name, record in METHODS.items():
        taken = inspect.signature(record.extract).parameters
        assert (record.id, record.extract.__module__.partition(".")[0]) == (name, "leakref")
        assert {n: taken[n].default for n in record.settings} == dict(record.settings)
        assert set(taken) == {"spectrum", "wavenumbers", "gravity", "water", "half_width", *record.settings}
    assert METHODS["nsp"].score is nsp.normalized_scalar_product
    assert METHODS["ls"].settings == {"threshold": leastsquares.THRESHOLD}


@pytest.mark.parametrize(
    "ask",
    [
        lambda: oracle.window("welch", oracle.mpf(1) / 3),
        lambda: oracle.closed_lobe("welch", 0.3),
        lambda: oracle.mean_square("welch"),
        lambda: oracle.kernel("welch", 1, 0.3, 8),
        lambda: oracle.lobe("welch", 0.3),
    ],
)
def test_the_oracle_refuses_a_window_that_it_does_not_know(ask):
    with pytest.raises(ValueError, match="no window named 'welch'"):
        ask()


# ---------------------------------------------------------------- water


class Shallow(Water):
    """Another law of dispersion, in a class of its own: long waves in a layer of depth 1/4, all as fast."""

    def frequency(self, wavenumber):
        return np.asarray(wavenumber, dtype=np.float64) / 2

    def phase_velocity(self, wavenumber):
        return np.full(np.shape(wavenumber), 0.5)

    def group_velocity(self, wavenumber):
        return self.phase_velocity(wavenumber)


@pytest.mark.parametrize("method", METHODS)
def test_another_water_goes_through_chain_and_fast_path_alike(method):
    sea = SeaState(direction=70, spread=60, length=5).components(3)
    k = np.hypot(sea.kx, sea.ky)
    waves = replace(sea, omega=Shallow(1.0).frequency(k) + 0.1 * sea.kx - 0.05 * sea.ky)
    plain = analyse(leakage.spectrum(waves, GRID, "hann"), K, water=Shallow(1.0), method=method, peak_wavenumber=1.0)
    twin = fast.realize(waves, GRID, K, windows=("hann",), methods=(method,), water=Shallow(1.0))["hann", method]
    np.testing.assert_allclose(twin.velocities, plain.velocities, atol=1e-11, rtol=0)
    assert twin.notes == plain.notes
    assert np.abs(plain.velocities - [0.1, -0.05]).max() < 0.05  # and it is the current
    deep = analyse(leakage.spectrum(waves, GRID, "hann"), K, method=method, gravity=1.0).velocities
    assert np.abs(deep - [0.1, -0.05]).max() > 0.2


@pytest.mark.parametrize("water", [9.81, "deep", object(), Water])
def test_what_is_no_water_is_refused_by_name(water):
    spectrum = leakage.spectrum(SEA, GRID, "hann")
    for call, ask in (
        ("analyse", lambda: analyse(spectrum, K, water=water)),
        ("nsp.extract", lambda: nsp.extract(spectrum, K, water=water)),
        ("leastsquares.extract", lambda: leastsquares.extract(spectrum, K, water=water)),
        ("realize", lambda: fast.realize(SEA, GRID, K, water=water)),
    ):
        with pytest.raises(LeakrefError, match=rf"^{call}: water = .*(no law of dispersion|is a class)"):
            ask()


def test_a_shell_knows_the_frequency_of_its_own_wavenumber():
    spectrum = leakage.spectrum(SEA, GRID, "hann")
    for water in (DEEP, Water(9.81), Shallow(1.0)):
        assert shell_at(spectrum, 1.4, water=water).frequency == water.frequency(1.4)


# who may write a law of dispersion: it itself, what was written a second time to hold it against, and planted mistakes
WITNESSES = {
    "dispersion.py",
    "golden/oracle.py",
    "golden/oraclewater.py",
    "certify/strength/variants.py",
    "certify/strength/fault.py",
    "certify/templates/python/adapter.py",
}
HOUSE = Path(leakref.__file__).parent


def laws(text: str) -> list[str]:
    """Roots of, or odd half powers of, something that is a wavenumber or gravity."""
    found = []
    for node in ast.walk(ast.parse(text)):
        under = None
        if isinstance(node, ast.Call) and ast.unparse(node.func).rpartition(".")[2] == "sqrt" and node.args:
            under = node.args[0]
        elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow):
            power = ast.unparse(node.right).strip("-()")
            under = node.left if power in ("0.5", "1.5", "1 / 2", "3 / 2") else None
        if under is not None:
            under = ast.Pass() if ast.unparse(under).startswith("DEEP.") else under
            squared = {id(n.left) for n in ast.walk(under) if isinstance(n, ast.BinOp) and isinstance(n.op, ast.Pow)}
            names = {
                n.id.strip("_").lower() for n in ast.walk(under) if isinstance(n, ast.Name) and id(n) not in squared
            }
            names |= {n.attr for n in ast.walk(under) if isinstance(n, ast.Attribute) and n.attr != "size"}
            if any(
                n in ("k", "k0", "g", "k_i", "size", "scale", "radius") or "gravity" in n or "wavenumber" in n
                for n in names
            ):
                found.append(ast.unparse(node))
    return found


def test_no_other_module_writes_a_law_of_dispersion():
    written = {
        path.relative_to(HOUSE).as_posix(): found
        for path in sorted(HOUSE.rglob("*.py"))
        if (found := laws(path.read_text(encoding="utf-8")))
    }
    assert written.keys() <= WITNESSES, {name: found for name, found in written.items() if name not in WITNESSES}
    assert len(written["dispersion.py"]) >= 3
    assert all(map(laws, ("w = np.sqrt(g * k)", "c = (self.gravity / wavenumber) ** 0.5", "e = k**-1.5")))
    assert not laws("r = np.sqrt(x**2 + y**2)")


def test_of_no_method_the_spectra_are_made_all_the_same(monkeypatch):
    """What they cost is timed so by `leakref bench`."""
    made = []
    monkeypatch.setattr(fast, "magnitudes", lambda *given: made.append(given) or {})
    assert fast.realize(SEA, GRID, K, methods=(), gravity=1.0) == {}
    assert len(made) == 1
