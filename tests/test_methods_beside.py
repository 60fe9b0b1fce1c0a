"""Methods beside the paper's in commands, figures and certify: there for whoever asks, and for nobody else."""

from __future__ import annotations

import json

import numpy as np
import pytest

from leakref import LeakrefError, chain, figures, runs
from leakref.cases import configurations
from leakref.certify.checks.conformance import MORE
from leakref.certify.runner import run_check, select
from leakref.certify.strength import beside
from leakref.certify.strength.diagnosis import diagnose
from leakref.certify.strength.faults import FAULTS, implementation
from leakref.certify.strength.study import DISTINCT, fault_record
from leakref.certify.strength.variants import implementation as variant
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.subject.named import Named
from leakref.certify.verdict import Verdict
from leakref.cli.base import methods_named
from leakref.methods import DEFAULT, METHODS
from leakref.paper import reproduce
from leakref.planning.plan import Campaign, plan
from leakref.track import tracking

SMALL = "L-T/L=5,T=10"


def declaring(*methods):
    return InProcess(Named(chain.reference, "", **beside.offering(methods)))


# ---------------------------------------------------------------- commands and figures


def test_a_list_of_methods_is_read_and_checked():
    assert methods_named("nsp, pcs,nsp", "reproduce") == ("nsp", "pcs")
    with pytest.raises(LeakrefError, match=r"reproduce: no method named 'polar'.*nsp-grid"):
        methods_named("nsp,polar", "reproduce")


def test_reproduce_has_the_methods_that_are_asked_for(tmp_path):
    how = {"realizations": 2, "route": "B", "json": False, "figures": True}
    assert reproduce.run([SMALL], out=tmp_path, methods=("nsp", "pcs", "nsp-grid"), **how)
    said = json.loads((tmp_path / "reproduce.json").read_text())
    assert {row["method"] for row in said["cases"]} == {"nsp", "pcs", "nsp-grid"}
    assert (tmp_path / "L-T_L5,T10_hann_pcs.csv".replace(",", "_")).is_file()
    assert [path.name for path in sorted(tmp_path.glob("figure_*.png"))] == ["figure_L-T.png"]


def test_six_methods_on_each_other_can_be_told_apart():
    """A colour, a sign and a place for the signs for each, so that none is hidden by one that is drawn later."""
    found = next(runs.run(configurations([SMALL]), realizations=2, methods=tuple(METHODS)))
    drawing = figures.result_figure(found, "")
    lines = [line for line in drawing.axes[0].lines if line.get_label() in {m.title for m in METHODS.values()}]
    assert len(lines) == len(METHODS)
    assert len({(line.get_color(), line.get_marker(), line.get_markevery()) for line in lines}) == len(lines)
    few = figures.result_figure([e for e in found if e.method in DEFAULT], "")
    assert {line.get_marker() for line in few.axes[0].lines} <= {"", "None"}  # as it was


def test_plan_has_them_beside_the_two_that_the_advice_rests_on():
    campaign = Campaign(field_of_view=(60.0, 60.0), duration=15.0, peak_wavelength=15.0)
    found = plan(campaign, 2, methods=("pcs",))
    assert {method for _, method in found.ways} == {*DEFAULT, "pcs"}
    assert {method for _, method in plan(campaign, 2).ways} == {*DEFAULT}


def test_track_records_them_of_the_reference():
    series = tracking.measure_reference([tracking.scene("small")], range(2), methods=("pcs", "nsp-adaptive"))
    assert {one.method for one in series} == {"pcs", "nsp-adaptive"}


# ---------------------------------------------------------------- certify


def test_who_declares_none_of_them_is_asked_what_was_asked_before():
    asked = [case for _, case in select(profile="full") if case.method]
    assert {case.method for case in asked} == set(MORE)
    for check, case in select(profile="full"):
        if case.method:
            assert check(declaring(*DEFAULT), case).verdict is Verdict.UNSUPPORTED
            break
    ids = {f"{check.id}[{case.id}]" for check, case in select(profile="full") if not case.method}
    assert not [name for name in ids if any(method in name for method in MORE)]


@pytest.mark.parametrize("method", MORE)
def test_who_declares_one_is_held_to_its_golden_values(method):
    finding = run_check(f"conformance.extract[{method}-swell]", declaring(method))
    assert finding.verdict is Verdict.PASS
    assert finding.digits > 12
    other = Named(chain.reference, "", **beside.offering([method]))
    other.extract = lambda *cube, method, **how: chain.reference.extract(*cube, method="ls", **how)
    finding = run_check(f"conformance.extract[{method}-swell]", InProcess(other))
    assert finding.verdict is Verdict.FAIL


def test_the_reference_with_all_methods_is_right():
    for name in ("signs.sea[to-22.5]", "recovery.pair[even-1]", "conformance.sea[edges-hann-pcs]"):
        finding = run_check(name, InProcess(variant("every-method")))
        assert finding.verdict is Verdict.PASS, finding.message


def test_each_has_faults_of_its_own():
    for method in MORE:
        own = [fault for fault in beside.FAULTS if fault.methods == (method,)]
        assert len(own) >= 5
        assert all(fault.stage == method and FAULTS[fault.id] == fault for fault in own)


@pytest.mark.parametrize(
    "fault",
    [
        pytest.param(f.id, marks=() if f.id in {"pcs-sign", "adaptive-twice"} else pytest.mark.slow)
        for f in beside.FAULTS
    ],
)
def test_its_family_kills_a_fault_and_its_killing_input_shows_it_plainly(fault):
    record = fault_record(FAULTS[fault])
    assert record["killed_by"]
    assert record["effect_over_tolerance"] >= DISTINCT


def test_a_fault_of_a_method_is_named_in_a_code_that_declares_it():
    names = ("recovery.pair[even-1]", "conformance.extract[pcs-swell]", "conformance.extract[pcs-bare]")
    findings = [run_check(name, InProcess(implementation("pcs-unit-vectors"))) for name in names]
    declared = InProcess(implementation("pcs-unit-vectors")).declaration.record()
    found = diagnose(findings, declared)
    assert found.hypotheses[0].fault == "pcs-unit-vectors"
    assert np.isfinite(found.hypotheses[0].digits)
