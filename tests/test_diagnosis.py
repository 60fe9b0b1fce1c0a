"""What is wrong: the right fault is named, and what no fault explains is not guessed at."""

from __future__ import annotations

import numpy as np
import pytest

from leakref.certify.diagnosis import ENOUGH, departure, diagnose
from leakref.certify.faults import implementation
from leakref.certify.inprocess import InProcess
from leakref.certify.registry import chosen, judged
from leakref.chain import reference

SOME = ("signs.aligned", "recovery.pair[even-1]", "recovery.pair[odd-2]", "conformance.window", "conformance.surface",
        "behaviour.deterministic")


def wrong(code, *checks):
    """The findings of a code that fell short, and what it offers."""
    subject = InProcess(code)
    findings = judged(chosen(checks or SOME, profile="quick"), subject)
    return [f for f in findings if f.verdict in ("fail", "error")], subject.declaration.can, findings


@pytest.mark.parametrize("fault", ["exchanged-axes", "negated-current", "solve-sign-slip", "symmetric-taper"])
def test_the_planted_fault_is_named(fault):
    failed, can, _ = wrong(implementation(fault))
    said = diagnose(failed, can)
    assert failed
    assert fault in [one.fault for one in said.hypotheses]
    assert said.words.startswith("equals the reference with this fault")


def test_a_code_of_few_keywords_is_diagnosed_on_what_it_offers():
    def flipped(surface, spacing, wavenumbers, *, gravity, window, method):
        found = reference.extract(surface, spacing, wavenumbers, gravity=gravity, window=window, method=method)
        return found * [1, -1]

    failed, can, _ = wrong(flipped, "signs.aligned", "recovery.pair")
    best = diagnose(failed, can).hypotheses[0]
    assert best.fault == "flipped-y"
    assert best.digits > ENOUGH


@pytest.mark.parametrize(("matrix", "fault", "words"), [
    ([[0, 0.9], [0.9, 0]], "exchanged-axes", "x and y exchanged"), ([[-1, 0], [0, -1]], "negated-current", "negated"),
    ([[2.5, 0], [0, 2.5]], "factor", "times 2.5")])
def test_of_another_algorithm_what_is_common_is_named(matrix, fault, words):
    noise = np.random.default_rng(0)

    def other(surface, spacing, wavenumbers, *, gravity, window):
        found = reference.extract(surface, spacing, wavenumbers, gravity=gravity, window=window, method="nsp")
        return (found + 0.02 * noise.standard_normal(found.shape)) @ np.array(matrix).T

    failed, can, _ = wrong(other, "signs.aligned", "recovery.pair")
    (best,) = diagnose(failed, can).hypotheses
    assert best.fault == fault
    assert words in best.words
    assert best.digits < ENOUGH


def test_what_no_fault_explains_is_unexplained():
    def odd(surface, spacing, wavenumbers, *, gravity, window):
        k = np.asarray(wavenumbers)
        return np.column_stack([np.sin(50 * k), np.cos(70 * k)]) * float(np.std(surface))

    failed, can, _ = wrong(odd, "signs.aligned", "recovery.pair")
    said = diagnose(failed, can)
    assert failed
    assert said.hypotheses == ()
    assert said.words.startswith("unexplained")


def test_nothing_wrong_needs_no_words():
    failed, can, findings = wrong(reference)
    assert failed == []
    assert diagnose(failed, can).words == departure(findings) == ""


def test_the_first_stage_that_departs_is_named():
    _, _, findings = wrong(implementation("symmetric-taper"), "conformance.window", "conformance.surface")
    assert departure(findings) == "window"
