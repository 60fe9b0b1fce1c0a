"""The study of the suite's strength, itself studied: it must see what survives, what is rejected, what is stale."""

import json
from importlib import resources

import numpy as np
import pytest
from scipy.stats import binomtest

from leakref.altered import Change
from leakref.certify.checks.registry import CHECKS, FAMILIES
from leakref.certify.checks.statistics import excess, share
from leakref.certify.runner import select
from leakref.certify.strength import alarms, faults, study
from leakref.certify.strength.alarms import false_alarms
from leakref.certify.strength.fault import Fault
from leakref.certify.strength.faults import FAULTS
from leakref.certify.strength.study import Job, classes, compute, fault_record, problems
from leakref.certify.strength.variants import VARIANTS

FEW = (Job("fault", "two-thirds-energy"), Job("fault", "nan-as-number"))


@pytest.fixture
def few(monkeypatch):
    """A study of two quick faults and nothing else."""
    monkeypatch.setattr(study, "jobs", lambda *, full=False: list(FEW))


def test_a_fault_that_changes_nothing_is_reported_as_surviving(monkeypatch):
    idle = Fault(
        "idle",
        "nsp",
        "synthesis",
        "nothing is wrong",
        (Change("nsp", "_FEW = 8", "_FEW = 9"),),
        killing_input=FAULTS["two-thirds-energy"].killing_input,
    )
    monkeypatch.setitem(FAULTS, "idle", idle)
    record = fault_record(idle)
    assert record["killed_by"] is None
    assert record["effect_over_tolerance"] <= 1
    assert set(record["over"]) == {f"{c.id}[{case.id}]" for c, case in select(["synthesis"])}
    monkeypatch.setattr(study, "jobs", lambda *, full=False: [Job("fault", "idle")])
    found = study.study()
    assert [r["killed_by"] for r in found["faults"]] == [None]
    assert found["problems"] == ["the fault idle survives the checks of synthesis"]


def test_a_wrong_code_among_the_variants_is_reported_as_rejected(monkeypatch):
    monkeypatch.setattr(study, "jobs", lambda *, full=False: [Job("variant", "si")])
    monkeypatch.setattr(study, "select", lambda **of: select(["signs", "recovery.pair"], **of))
    record = study.variant_record("si", make=lambda identifier: faults.implementation("flipped-x"))
    assert {name.partition(".")[0] for name in record["wrong"]} >= {"signs", "recovery"}
    monkeypatch.setattr(study, "compute", lambda job: record)
    found = study.study()
    assert found["variants"][0]["rejected"] == found["variants"][0]["runs"] == 1
    assert found["problems"][0].startswith("the variant si was rejected 1 times in 1 runs, by ")


def test_too_small_an_effect_and_a_sound_fault_rejected_are_problems():
    row = {
        "id": "x",
        "killed_by": "signs.a[b]",
        "effect_over_tolerance": 9.0,
        "witness": "signs.a[b]",
        "family": "conformance",
        "kills": {"conformance": 9.0, "signs": 2.0},
    }
    said = problems(
        {
            "faults": [row],
            "variants": [],
            "families": [{"family": "scale", "meant": 0, "only": []}],
            "false_alarms": {"nominal": 1e-3, "at_margin": {"rate": 0.1, "interval": [0.09, 0.11]}},
        }
    )
    assert [line.split()[0] for line in said] == ["the", "the", "no", "false"]
    assert "9.0 times" in said[0]
    assert "signs rejects it" in said[1]


@pytest.mark.parametrize("family", FAMILIES)
def test_a_family_switched_off_lets_the_faults_meant_for_it_live(family, monkeypatch):
    fault = next(fault for fault in FAULTS.values() if fault.family == family)
    monkeypatch.setattr(study, "select", lambda **of: [p for p in select(**of) if p[0].family != family])
    record = fault_record(fault)
    assert record["killed_by"] is None
    said = problems({"faults": [{**record, "kills": study._kills(record)}], "variants": []})
    assert said == [f"the fault {fault.id} survives the checks of {family}"]


def test_the_study_goes_on_where_it_stopped(few, tmp_path, monkeypatch):
    first = study.study(work=tmp_path)
    stored = sorted(path.name for path in tmp_path.rglob("*.json"))
    assert stored == ["fault-nan-as-number.json", "fault-two-thirds-energy.json"]
    monkeypatch.setattr(study, "compute", lambda job: pytest.fail("computed again"))
    assert study.study(work=tmp_path) == first
    whole = next(tmp_path.rglob("fault-nan*.json"))
    whole.write_text(whole.read_text(encoding="utf-8")[:-20], encoding="utf-8")  # torn
    monkeypatch.setattr(study, "compute", compute)
    assert study.study(work=tmp_path) == first
    other = next(tmp_path.rglob("fault-two*.json"))
    for harm in (
        lambda text: text.replace('"effect_over_tolerance": ', '"effect_over_tolerance": 1'),
        lambda _: whole.read_text(encoding="utf-8"),
    ):
        text = other.read_text(encoding="utf-8")
        other.write_text(harm(text), encoding="utf-8")  # edited, and another's
        assert other.read_text(encoding="utf-8") != text
        assert study.study(work=tmp_path) == first


def test_another_source_is_another_place(tmp_path, monkeypatch):
    path = FEW[0].path(tmp_path)
    monkeypatch.setattr(study, "source_digest", lambda: "0" * 64)
    assert FEW[0].path(tmp_path) != path


def test_workers_and_their_order_change_nothing(few):
    from leakref.runs import pool

    alone = study.study()
    with pool(2) as executor:
        assert study.study(executor=executor) == alone


def test_all_that_is_to_do_is_done_once():
    todo = study.jobs(full=True)
    assert len(set(todo)) == len(todo)
    assert sum(job.kind == "variant" and job.seed is not None for job in todo) == study.SEEDS == 1000
    assert {job.id for job in todo if job.kind == "variant" and job.seed is not None} == set(VARIANTS)
    assert {job.id for job in todo if job.kind == "fault"} == set(FAULTS)


@pytest.mark.parametrize(("seed", "asked"), [(None, 3), (5, 3), (500, 1)])
def test_a_seed_asks_what_a_run_draws_and_the_first_of_each_variant_more(monkeypatch, seed, asked):
    """The statistical check has a count of its own, and what a run does not draw is tried once for each."""
    few = [select([name], profile="quick")[0] for name in ("signs.aligned", "leakage.bias", "shear.profile")]
    monkeypatch.setattr(study, "select", lambda **_: few)
    record = study.variant_record("si", seed)
    assert (record["checks"], record["wrong"]) == (asked, {})


def test_classes_are_faults_with_the_same_effects():
    records = [
        {"id": name, "over": {"a": a, "b": b}}
        for name, a, b in (("one", 5.0, 0.0), ("two", 5.001, 0.001), ("three", 5.2, 0.0), ("four", 5.0, 3.0))
    ]
    assert classes(records) == [["one", "two"]]


def test_the_null_resampling_uses_the_statistic_of_the_check():
    rng = np.random.default_rng(1)
    d, margin, alpha = 0.02 * rng.standard_normal(6) + 0.03, 0.01, share(2)
    test = excess(d, margin, alpha)
    by_hand = margin + alarms.student.isf(alpha, 5) * d.std(ddof=1) / np.sqrt(6)
    assert test.limit == pytest.approx(by_hand, rel=1e-12)


def test_false_alarms_of_well_behaved_errors_are_at_their_nominal_rate_at_most():
    select()
    rng = np.random.default_rng(4)
    names = alarms.seas()
    errors = {
        name: {
            "nsp": 0.05 + 0.01 * rng.standard_normal(100),
            "ls": 0.08 + 0.02 * rng.standard_normal(100),
            "resolution": 0.04,
        }
        for name in names
    }
    found = false_alarms(errors, 40_000)
    assert found["tests"] == 2 * len(CHECKS["leakage.bias"].cases)
    assert found["at_margin"]["interval"][0] <= 1e-3
    assert found["at_margin"]["interval"][1] <= 3e-3
    assert found["as_good"]["alarms"] <= found["at_margin"]["alarms"]
    assert false_alarms(errors, 40_000) == found


def test_a_statistic_that_alarms_too_often_is_seen():
    said = problems(
        {"faults": [], "variants": [], "false_alarms": {"nominal": 1e-3, "at_margin": alarms.rate_of(300, 100_000)}}
    )
    assert said == ["false alarms are at 3.0e-03, above 0.001"]
    interval = binomtest(300, 100_000).proportion_ci(method="exact")
    assert alarms.rate_of(300, 100_000)["interval"] == [interval.low, interval.high]


def test_the_committed_result_is_of_this_list_and_holds():
    record = json.loads(resources.files("leakref._golden").joinpath("strength.json").read_text(encoding="utf-8"))
    assert record["full"]
    assert record["problems"] == []
    assert {r["id"]: (r["family"], r["witness"]) for r in record["faults"]} == {
        name: (fault.family, fault.killing_input) for name, fault in FAULTS.items()
    }
    assert all(r["killed_by"].partition(".")[0] == r["family"] for r in record["faults"])
    for r in record["faults"]:
        assert r["effect_over_tolerance"] >= (study.BY_CHANCE if r["family"] == "sea" else study.DISTINCT)
    assert record["sea_alarms"]["rate"] <= record["sea_alarms"]["nominal"]
    assert {v["id"]: v["rejected"] for v in record["variants"]} == dict.fromkeys(VARIANTS, 0)
    assert sum(v["runs"] for v in record["variants"]) == study.SEEDS + len(VARIANTS)
    alarms = record["false_alarms"]
    assert alarms["resamplings"] >= 10_000
    assert alarms["at_margin"]["rate"] <= alarms["nominal"]


def test_the_command_writes_prints_and_says_so(few, tmp_path, capsys):
    status = study.run(out=tmp_path, workers=1, json=True)
    printed = json.loads(capsys.readouterr().out)
    written = json.loads((tmp_path / "strength.json").read_text(encoding="utf-8"))
    assert status == 0
    assert printed["ok"]
    assert printed["schema"] == "leakref/strength/1"
    for record in (printed, written):
        assert [row["id"] for row in record["faults"]] == [job.id for job in FEW]
    assert {"id", "killed_by", "effect_over_tolerance"} <= set(printed["faults"][0])
    assert study.run(out=tmp_path, workers=1) == 0
    assert "two-thirds-energy" in capsys.readouterr().out
