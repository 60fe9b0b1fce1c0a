"""Generators of random seas: right ones pass, each mistake is seen, and what they cannot be told is not asked."""

from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest
from strangers.seas import GENERATORS, Drawn, Gaussian

from leakref import LeakrefError, Water
from leakref.certify.checks import seameasures
from leakref.certify.checks.inputs import asked
from leakref.certify.checks.registry import CHECKS
from leakref.certify.checks.sea import asked_of
from leakref.certify.runner import certify, select
from leakref.certify.strength.diagnosis import explain
from leakref.certify.strength.faults import FAULTS, implementation
from leakref.certify.strength.study import BY_CHANCE
from leakref.certify.subject.declaration import Declaration
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.subject.seas import Sea
from leakref.certify.targets import connect
from leakref.certify.verdict import Unanswered, Verdict
from leakref.generator import Generator, random_sea
from leakref.grid import Grid

SEAS = [name for name, fault in FAULTS.items() if fault.family == "sea"]
SOME = ("sea-two-thirds-energy", "sea-from-for-to", "sea-current-sign", "sea-few-seeds", "sea-unrepeatable")
SMALL = Grid((20, 18, 12), (0.9, 1.0, 0.8))
ASKED = Sea(SMALL, 30.0, 90.0, 3.3, 4e-4, (0.1, -0.05), Water(1.0, 2.0))


def findings(code, *patterns, seed=1):
    subject = InProcess(code)
    return {f.id: f for f in (check(subject, case) for check, case in select(patterns or ("sea",), seed=seed))}


@pytest.mark.parametrize("make", [Generator, *GENERATORS.values()], ids=["own", *GENERATORS])
def test_right_generators_pass(make):
    found = findings(make())
    assert [f.message for f in found.values() if f.verdict not in (Verdict.PASS, Verdict.UNSUPPORTED)] == []
    unsupported = {name.partition("[")[0] for name, f in found.items() if f.verdict is Verdict.UNSUPPORTED}
    assert unsupported == ({"sea.amplitudes"} if make is Drawn else set())


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2, 8))
@pytest.mark.parametrize("make", [Generator, *GENERATORS.values()], ids=["own", *GENERATORS])
def test_right_generators_pass_whatever_the_seed(make, seed):
    assert not [f.message for f in findings(make(), seed=seed).values() if f.verdict is Verdict.FAIL]


def effect(name):
    ((check, case),) = select([FAULTS[name].killing_input])
    return check(InProcess(implementation(name)), case).over


@pytest.mark.parametrize("name", SOME)
def test_some_mistakes_are_seen(name):
    assert effect(name) >= BY_CHANCE


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in SEAS if name not in SOME])
def test_every_mistake_is_seen(name):
    assert effect(name) >= BY_CHANCE


def test_every_check_has_a_mistake_that_it_is_for():
    of_seas = {name for name in CHECKS if name.startswith("sea.")}
    assert {FAULTS[name].killing_input.partition("[")[0] for name in SEAS} == of_seas


def test_chance_alone_rejects_less_often_than_it_may():
    ((_, case),) = select(["sea.energy[peaked]"])
    subject = InProcess(Generator())
    with asked(subject, 1):
        sea = asked_of(subject, case)
    whole, rng, over = seameasures.own(sea), np.random.default_rng(1), []
    for _ in range(400):  # realisations of the sea that scatters most, against the mean of all of them
        some = rng.choice(seameasures.OWN, seameasures.COUNT, replace=False)
        part = seameasures.Measured({name: v[some] for name, v in whole.scalars.items()}, whole.bins, whole.frames)
        over += [seameasures.apart(part, whole, name) for name in ("energy", "width")]
        over.append(seameasures.added(whole.bins[some])[0])
    assert max(over) < 1  # once in sixty thousand is what it may be
    assert max(over) > 0.3  # and it is no wider than it need be
    assert seameasures.phase_limit(8.0) == pytest.approx(3.5, abs=0.5)


class Deaf:
    """Knows one sea, and makes it anew each time."""

    def __init__(self):
        self.number = 0

    def sea(self, shape, spacing, *, peak_wavenumber, peakedness, gravity):
        self.number += 1
        waves = random_sea(
            Grid(shape, spacing), self.number, variance=1.0, peak_wavenumber=peak_wavenumber, peakedness=peakedness
        )
        from leakref.synthesis import synthesize

        return synthesize(waves, *(Grid(shape, spacing).samples(axis) for axis in range(3)))


def test_what_it_cannot_be_told_is_not_asked():
    code = InProcess(Deaf())
    assert set(code.declaration.fixed) == {"energy", "direction", "spread", "current", "seed"}
    found = findings(Deaf(), *(f"sea.{name}[broad]" for name in ("energy", "spectrum", "motion", "realizations")))
    assert found["sea.energy[broad]"].message == "cannot be told the energy of a sea"
    judged = {name for name, f in found.items() if f.verdict is Verdict.PASS}
    assert judged == {"sea.spectrum[broad]", "sea.motion[broad]", "sea.realizations[broad]"}


def test_parameters_are_in_the_units_and_the_frame_that_are_declared():
    said = {"units": "si", "y": "down", "direction": "from", "can": {"sea": {}}}
    told = ASKED.parameters(Declaration.read(said), 5)
    k = 0.25
    assert told["peak_wavenumber"] == pytest.approx(k)
    assert told["height"] == pytest.approx(4 * np.sqrt(told["variance"]))
    assert told["height"] == pytest.approx(4 * 0.02 / k)
    assert told["peak_frequency"] == pytest.approx(np.sqrt(9.81 * k * np.tanh(2.0)))
    assert told["peak_period"] == pytest.approx(2 * np.pi / told["peak_frequency"])
    assert told["direction"] == pytest.approx(150.0)  # to 30 degrees upwards is to -30 downwards, and from 150
    assert told["current"] == pytest.approx(np.array([-0.1, -0.05]) * np.sqrt(9.81 / k))
    assert told["dx"] == pytest.approx(0.9 / k)
    off = np.linspace(-45, 45, 20001)
    weight = np.cos(np.pi * off / 90) ** 2
    assert told["deviation"] == pytest.approx(np.sqrt(np.sum(weight * off**2) / np.sum(weight)), rel=1e-6)


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (lambda shape: np.zeros(shape[:2]), "should be real"),
        (lambda shape: np.full(shape, np.nan), "not finite"),
        (lambda shape: np.zeros(shape), "without waves in the band"),
    ],
)
def test_what_is_no_sea_fails_in_words(answer, words):
    class Broken:
        def sea(self, shape, spacing, *, variance, peak_wavenumber):
            return answer(shape)

    ((check, case),) = select(["sea.energy[broad]"])
    finding = check(InProcess(Broken()), case)
    assert finding.verdict is Verdict.FAIL
    assert words in finding.message


def test_amplitudes_are_fixed_or_random():
    with pytest.raises(Unanswered, match="declares amplitudes = 'often', should be fixed or random"):
        Declaration.read({"can": {"sea": {"amplitudes": "often"}}})


class Fixed(Gaussian):
    def describe(self):
        return {**super().describe(), "can": {"sea": {"amplitudes": "fixed"}}}


def test_amplitudes_are_what_is_declared_of_them():
    found = findings(Fixed(), "sea.amplitudes[broad]")["sea.amplitudes[broad]"]
    assert found.verdict is Verdict.FAIL
    assert found.message.endswith("and its amplitudes are declared fixed")


def graded(code, *patterns):
    return certify("code", [nullcontext(InProcess(code))], select(patterns, profile="quick"), profile="quick")


def test_the_certificate_is_of_random_seas_only():
    found = graded(
        Drawn(), "sea.directions[broad]", "sea.energy[broad]", "signs.sea", "leakage.still[broad]", "synthesis.single"
    )
    assert found.grade_line == "sound, random seas only, 2 of 10 questions"
    assert found.counts == {"pass": 2, "unsupported": 8}
    assert (
        "random seas (deep water, no surface tension, with a peak at 25.1 m, on a uniform" in (found.scope()["words"])
    )


def test_a_wrong_sea_is_told_in_its_own_words():
    found = explain(graded(implementation("sea-two-thirds-energy"), "sea.energy[broad]"))
    assert found.grade == "rejected"
    assert found.explanation.startswith("its seas hold 0.667 of the energy asked for")


def test_a_code_that_makes_no_seas_is_not_asked():
    class Still:
        def extract(self, surface, spacing, wavenumbers):
            return np.zeros((len(wavenumbers), 2))

    assert {f.family for f in graded(Still(), "sea", "leakage.still[broad]").findings} == {"leakage"}


def test_a_generator_in_a_process_of_its_own():
    with connect("leakref.generator:generator") as session:
        made = session.sea(ASKED, 3)
        other = InProcess(Generator()).sea(ASKED, 3)
    assert np.allclose(made, other)
    turned = InProcess(Generator())
    turned.declaration = replace(turned.declaration, axes="tyx")
    with pytest.raises(Unanswered, match="eta has shape"):
        turned.sea(ASKED, 3)


def test_our_own_sea_holds_what_it_is_asked_for():
    waves = random_sea(SMALL, 1, variance=0.3, peak_wavenumber=1.0, direction=200.0, spread=50.0)
    assert waves.variance == pytest.approx(0.3)
    bins = np.stack([waves.kx / SMALL.bin_widths[0], waves.ky / SMALL.bin_widths[1]])
    assert np.allclose(bins, np.rint(bins))
    off = (np.degrees(np.arctan2(waves.ky, waves.kx)) - 200.0 + 180) % 360 - 180
    assert np.abs(off).max() <= 25
    again = random_sea(SMALL, 1, variance=0.3, peak_wavenumber=1.0, direction=200.0, spread=50.0)
    assert np.array_equal(waves.phase, again.phase)
    with pytest.raises(LeakrefError, match="no bin within"):
        random_sea(SMALL, 1, variance=1.0, peak_wavenumber=1.0, direction=10.0, spread=0.01)
