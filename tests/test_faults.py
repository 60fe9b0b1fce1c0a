"""Faults: each is what it says, really changes the chain, and shows on its killing input."""

import numpy as np
import pytest

from leakref import LeakrefError
from leakref.altered import Change
from leakref.certify.checks.registry import FAMILIES
from leakref.certify.runner import select
from leakref.certify.strength import beside
from leakref.certify.strength.fault import STAGES, Fault
from leakref.certify.strength.faults import FAULTS, implementation
from leakref.certify.strength.study import BY_CHANCE, DISTINCT, _over, fault_record
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.verdict import Verdict
from leakref.chain import reference
from leakref.generator import generator
from leakref.golden.sets import Golden

PINNED = (
    "negated-current",
    "flipped-x",
    "flipped-y",
    "exchanged-axes",
    "solve-sign-slip",
    "hard-coded-width",
    "extra-branch",
    "missing-negative-branch",
    "no-taper",
    "two-thirds-energy",
    "nan-as-number",
)
BRIEF = (
    "negated-current",
    "no-taper",
    "two-thirds-energy",
    "solve-sign-slip",
    "frequency-at-centre",
    "nan-as-number",
    "random-output",
    "state-kept",
    "input-altered",
    "gravity-hard-coded",
    "symmetric-taper",
    "hard-coded-width",
)


def test_the_list_is_long_enough_and_every_entry_is_in_order():
    assert len(FAULTS) >= 60
    assert set(PINNED) <= set(FAULTS)
    assert {fault.stage for fault in FAULTS.values()} == set(STAGES)
    assert {fault.family for fault in FAULTS.values()} == set(FAMILIES)
    for identifier, fault in FAULTS.items():
        assert fault.id == identifier == identifier.lower()
        assert bool(fault.changes) != bool(fault.instead), f"{identifier} is either a change or something else instead"
        assert fault.words[0].isalpha()
        assert not fault.words.endswith(".")
    assert len({fault.words for fault in FAULTS.values()}) == len(FAULTS)


def test_every_killing_input_is_a_finding_that_there_is():
    ids = {f"{check.id}[{case.id}]" for check, case in select()}
    assert {fault.id: fault.killing_input for fault in FAULTS.values() if fault.killing_input not in ids} == {}


def test_faults_that_golden_vectors_name_are_in_the_list():
    named = {name for entry in Golden().entries("vectors", "analytic") for name in entry.record.get("faults", ())}
    assert named
    assert named <= set(FAULTS)


@pytest.mark.parametrize("identifier", [i for i in FAULTS if FAULTS[i].changes])
def test_every_change_fits_the_chain(identifier):
    assert InProcess(implementation(identifier)).declaration.name == f"fault:{identifier}"


def test_a_change_that_no_longer_fits_is_refused(monkeypatch):
    stale = Fault("stale", "nsp", "signs", "a line that is gone", (Change("nsp", "no such line", "another"),))
    monkeypatch.setitem(FAULTS, "stale", stale)
    with pytest.raises(LeakrefError, match=r"occurs 0 times in nsp\.py"):
        implementation("stale")


def test_an_unknown_fault_is_refused():
    with pytest.raises(LeakrefError, match="no fault is called 'flipped-z'"):
        implementation("flipped-z")


@pytest.mark.parametrize("identifier", BRIEF)
def test_a_fault_exceeds_the_tolerance_of_its_killing_input_ten_times_and_the_reference_does_not(identifier):
    fault = FAULTS[identifier]
    record = fault_record(fault)
    assert record["killed_by"].startswith(f"{fault.family}.")
    assert record["effect_over_tolerance"] >= (BY_CHANCE if fault.family == "sea" else DISTINCT)
    ((check, case),) = [pair for pair in select() if f"{pair[0].id}[{pair[1].id}]" == fault.killing_input]
    right = generator if fault.family == "sea" else beside.every() if case.method else reference
    finding = check(InProcess(right), case)
    assert finding.verdict is not Verdict.UNSUPPORTED
    assert _over(finding) <= 1


@pytest.mark.slow
@pytest.mark.parametrize("identifier", [i for i in FAULTS if i not in BRIEF])
def test_all_the_others_too(identifier):
    test_a_fault_exceeds_the_tolerance_of_its_killing_input_ten_times_and_the_reference_does_not(identifier)


def test_where_the_chain_has_no_number_a_fault_has_null():
    surface, spacing = np.zeros((16, 14, 18)), (0.9, 1.0, 0.8)
    found = implementation("flipped-x").extract(surface, spacing, np.array([1.0]))
    assert np.ma.getmaskarray(found).all()
    assert np.isnan(implementation("nan-as-number").extract(surface, spacing, np.array([1.0]))).all()


def test_what_remembers_starts_afresh_each_time():
    rng = np.random.default_rng(3)
    one, two = rng.standard_normal((2, 20, 18, 24))
    first, second = implementation("state-kept"), implementation("state-kept")
    settings = ((0.9, 1.0, 0.8), np.array([1.2]))
    first.extract(one, *settings)
    assert not np.array_equal(first.extract(two, *settings), second.extract(two, *settings))
