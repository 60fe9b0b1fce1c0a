"""Decisions: every variant is what it says in both chains, and its effect is counted as it should be."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from importlib.resources import files
from itertools import product

import numpy as np
import pytest

from leakref import LeakrefError, fast
from leakref.altered import altered
from leakref.cases import PAPER_CASES, Configuration
from leakref.certify.runner import select
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.subject.named import Named
from leakref.certify.verdict import WRONG
from leakref.claims import CLAIMS, decisionscommand, shifts
from leakref.claims.registry import Claim
from leakref.claims.samples import bias
from leakref.claims.shifts import Shifts, moving, rejudged, study, velocities
from leakref.claims.stored import stored_decision, stored_decisions, turned
from leakref.claims.variants import CONFIGURATIONS, NONE, VARIANTS
from leakref.claims.words import above, every
from leakref.decisions import DECISIONS, PRACTICE, SLIPS
from leakref.dispersion import DEEP, velocity_resolutions
from leakref.ensemble import Ensemble
from leakref.explain import explain
from leakref.methods import DEFAULT, METHODS
from leakref.shell import Note

SMALL = Configuration(
    "small",
    direction=60,
    spread=45,
    length=3,
    duration=5,
    speed=0.1,
    current_direction=20,
    rotation=30,
    windows=("box", "hann", "kaiser-bessel"),
)
QUICK = {
    "edge-bins-out",
    "cut-at-3",
    "threshold-of-amplitude",
    "encounter-frequency",
    "other-sense",
    "about-corner",
    "symmetric-hann",
    "kaiser-2-pi",
    "ls-early-stop",
}  # nothing to compile
SOME = {"symmetric-hann", "cut-at-3", "both-halves", "polar-measure"}
"""A few of those that take long; all of them by night."""
CASE = "L-T/L=5,T=10"
ACTS_NOT = {
    "large-simplex",
    "newton-from-rest",
    "unit-by-shell",
    "lattice-of-0.05",
}  # on this sea: they all climb the same hill


@pytest.fixture(scope="module")
def reference():
    return fast.realize(
        SMALL.components(0),
        SMALL.grid,
        SMALL.wavenumbers,
        windows=SMALL.windows,
        methods=tuple(METHODS),
        search=False,
        gravity=1.0,
    )


def literal(variant, configuration):
    """What the altered literal chain gives, by surface and FFT, (w, m, n, 2)."""
    chain = variant.chain
    own = chain.cases.Configuration(**asdict(configuration))
    windows = tuple(name for name in configuration.windows if name in variant.windows)
    spectra = chain.chain.transform(own.components(0), own.grid, windows, route="A")
    return np.array(
        [
            [
                chain.chain.analyse(s, own.wavenumbers, method=m, search=False, gravity=1.0).velocities
                for m in variant.methods
            ]
            for s in spectra
        ]
    )


@pytest.mark.parametrize(
    "id",
    [
        id if id in QUICK else pytest.param(id, marks=pytest.mark.slow if id in SOME else pytest.mark.night)
        for id, variant in VARIANTS.items()
        if not variant.setting.resampled
    ],
)
def test_a_variant_is_the_same_in_the_compiled_and_in_the_literal_chain(id, reference):
    variant = VARIANTS[id]
    found, wanted = velocities(variant, SMALL, 0), literal(variant, SMALL)
    wanted = wanted[:, :, :: 2 if id == "denser-shells" else 1]
    stop = 1e-7 if id == "ls-by-simplex" else 1e-11  # which ends within 1e-8 of the minimum, by other paths
    np.testing.assert_allclose(found, wanted, rtol=0, atol=stop)  # NaN where the other has it
    plain = np.array(
        [[reference[w, m].velocities for m in variant.methods] for w in SMALL.windows if w in variant.windows]
    )
    off = np.hypot(*np.moveaxis(wanted - plain, -1, 0))
    acts = id not in {"denser-shells", "printed-amplitudes", "ls-by-simplex"} | ACTS_NOT
    assert (np.nanmax(off) > 1e-7 or np.isnan(off).any()) == acts


def test_every_decision_has_a_variant_or_a_reason_for_none():
    assert {v.decision for v in VARIANTS.values()} | set(NONE) == set(DECISIONS)
    assert not {v.decision for v in VARIANTS.values()} & set(NONE)
    known = {c.id for members in PAPER_CASES.values() for c in members}
    assert set(CONFIGURATIONS) <= known
    assert len(set(CONFIGURATIONS)) == 8
    for variant in VARIANTS.values():
        assert set(variant.configurations) <= set(CONFIGURATIONS)


def test_the_reasons_for_no_effect_are_true():
    grids = [c.grid for members in PAPER_CASES.values() for c in members]
    assert all(grid.bin_widths[0] == grid.bin_widths[1] for grid in grids)  # D20
    assert all(3.5 + 2 * grid.wavenumber_resolution < 0.6 * grid.nyquist[0] for grid in grids)  # D24
    assert {c.water for members in PAPER_CASES.values() for c in members} == {DEEP}  # D26 to D31
    values = np.random.default_rng(1).normal(1, 0.1, (100, 3, 2))
    e = ensemble(values)
    assert e.random / np.std(e.magnitudes, axis=0) == pytest.approx(np.sqrt(100 / 99))  # D12, 0.5 %


# ---- statistics, on shifts that are known


def ensemble(values, notes=None, **parameters):
    one = Configuration("made-up", windows=("box",), **parameters)
    values = np.asarray(values, dtype=float)
    notes = np.zeros(values.shape[:2], dtype=np.int64) if notes is None else np.asarray(notes)
    return Ensemble(one, "box", "nsp", one.wavenumbers[: values.shape[1]], values, notes)


def test_shifts_are_distances_and_flagged_shells_stand_apart():
    before = np.zeros((3, 2, 2))
    after = before.copy()
    after[:, 0, 0], after[0, 1], after[1, 1] = 0.3, (3.0, 4.0), np.nan
    s = Shifts(VARIANTS["edge-bins-out"], ensemble(before, [[0, Note.FLAT.value]] * 3), after)
    np.testing.assert_allclose(s.moved[:, 0], 0.3)
    assert s.moved[0, 1] == 5
    row = shifts.summary([s], "one")
    assert row["lost"] == 1
    assert row["unflagged"]["shells"] == row["unflagged"]["moved"] == 3
    assert row["unflagged"]["c0"] == {"median": 0.3, "p95": 0.3, "largest": 0.3}
    assert row["unflagged"]["resolution"]["largest"] == pytest.approx(
        0.3 / min(r[0] for r in ensemble(before).resolutions), rel=0.01
    )
    assert row["flagged"]["shells"] == 2
    assert row["flagged"]["moved"] == 1
    assert row["flagged"]["c0"] == {"median": 2.5, "p95": 4.75, "largest": 5}


def test_the_change_of_the_error_is_paired_and_against_the_current():
    noise = np.random.default_rng(2).normal(0, 1, (5, 3, 1)) * np.array([0, 0.01])
    before = ensemble(np.array([0, 0.3]) + noise, speed=0.1, current_direction=90.0)
    row = shifts.summary([Shifts(VARIANTS["edge-bins-out"], before, np.array([0, 0.35]) + noise)], "one")
    assert row["bias_change"]["mean"] == pytest.approx(0.05)
    assert row["bias_change"]["standard_error"] < 1e-12
    assert (
        shifts.summary([Shifts(VARIANTS["edge-bins-out"], before, np.full((5, 3, 2), np.nan))], "one")["bias_change"]
        is None
    )


def test_a_sea_turned_the_other_way_is_turned_back_before_it_is_compared():
    c, s = np.cos(np.radians(30)), np.sin(np.radians(30))
    there, back = np.array([[[c, s]]]), np.array([[[c, -s]]])  # (1, 0) turned by 30 degrees either way
    before = ensemble(there, rotation=30.0, speed=1.0)
    np.testing.assert_allclose(Shifts(VARIANTS["other-sense"], before, back).moved, 0, atol=1e-15)
    np.testing.assert_allclose(Shifts(VARIANTS["about-corner"], before, back).moved, 1)
    np.testing.assert_allclose(Shifts(VARIANTS["other-sense"], before, back).better.values, 0, atol=1e-15)


def test_what_moves_is_paired_not_flagged_and_beyond_a_tenth_of_the_resolution():
    before, notes = np.zeros((2, 2, 2)), [[0, Note.FLAT.value]] * 2
    limit = 0.1 * float(min(r[0] for r in ensemble(before).resolutions))

    def found(id, first, second):
        after = before.copy()
        after[:, 0, 0], after[:, 1, 0] = first, second
        return moving({id: [[Shifts(VARIANTS[id], ensemble(before, notes), after)]]})

    assert found("edge-bins-out", 1.01 * limit, 0) == [VARIANTS["edge-bins-out"]]
    assert found("edge-bins-out", 0.99 * limit, 1) == []
    assert found("other-phases", 1, 1) == []
    assert found("edge-bins-out", np.nan, 1) == []


# ---- the study and the claims under it


@pytest.fixture
def eight(monkeypatch):
    """The small sea as if it were one of the eight."""
    monkeypatch.setattr(shifts, "configurations", lambda ids: [SMALL])
    return replace(VARIANTS["both-halves"], configurations=(SMALL.id,)), replace(
        VARIANTS["edge-bins-out"], configurations=(SMALL.id,), realizations=1
    )


def test_a_study_is_kept_and_resumed(eight, tmp_path, monkeypatch):
    first = study(eight, realizations=2, folder=tmp_path)
    assert [s.reference.window for s in first["both-halves"][0]] == ["box", "hann"]
    assert [s.moved.shape[0] for s in (first["both-halves"][0][0], first["edge-bins-out"][0][0])] == [2, 1]
    own = np.array([velocities(eight[0], SMALL, number)[1, 0] for number in range(2)])
    hann = first["both-halves"][0][1]
    np.testing.assert_allclose(hann.moved, np.hypot(*np.moveaxis(own - hann.reference.velocities, -1, 0)), rtol=1e-12)
    assert np.median(hann.moved) > 0.1
    monkeypatch.setattr(shifts, "velocities", None)  # a second time nothing is computed
    again = study(eight, realizations=2, folder=tmp_path)
    np.testing.assert_array_equal(again["both-halves"][0][1].moved, hann.moved)


def test_claims_that_turn_are_found_and_others_left_out(tmp_path):
    def claim(id, method, limit, configuration=SMALL):
        def predicate(see):
            yield from every({}, large=above(bias(see(configuration, "hann", method)), limit))

        return Claim(id, "", "", "", predicate)

    bare = Claim("window", "", "", "", lambda see: every({}, good=above(bias(ensemble(np.ones((2, 1, 2)))))))
    claims = [
        claim("turns", "ls", 0.3),
        claim("stays", "nsp", 1e-6),
        bare,
        claim("elsewhere", "ls", 0.3, replace(SMALL, varied=("spread",))),
    ]
    found = rejudged([VARIANTS["both-halves"]], claims, realizations=3, folder=tmp_path, executor=None, ids=[SMALL.id])
    assert [(one["id"], len(one["flipped"])) for one in found] == [("turns", 1), ("stays", 0)]
    assert found[0]["decision"] == "D19"
    assert (found[0]["before"], found[0]["verdict"]) == ("not reproduced", "reproduced")


# ---- what is kept, and as a command


AS_CODE = [v for v in VARIANTS.values() if v.changes and not {c.module for c in v.changes} <= {"sea", "cases"}]


@pytest.mark.parametrize(
    "variant",
    [pytest.param(v, marks=pytest.mark.slow if v.id in SOME else pytest.mark.night, id=v.id) for v in AS_CODE],
)
def test_another_right_choice_is_never_rejected_and_a_slip_is(variant):
    """As the chain of somebody who has decided otherwise; what only conformance sees leaves it sound."""
    code = InProcess(Named(altered(variant.changes).chain.reference, variant.id))
    wrong = [f for f in (c(code, case) for c, case in select(profile="quick")) if f.verdict in WRONG]
    rejecting = {f.id: f.message for f in wrong if f.family != "conformance"}
    assert bool(rejecting) == (variant.id in SLIPS), rejecting


def test_slips_are_variants_that_there_are():
    assert set(SLIPS) < set(VARIANTS)
    assert all(reason and not reason.endswith(".") for reason in SLIPS.values())


def test_what_the_co_authors_code_does_stands_beside_the_decisions_that_it_takes():
    assert set(PRACTICE) < set(DECISIONS)
    assert all(words.endswith(".") for words in PRACTICE.values())
    assert explain("D2")["co_author"] == PRACTICE["D2"]
    assert "co_author" not in explain("D1")


def test_what_is_kept_covers_every_variant_on_every_sea():
    kept = stored_decisions()
    assert [record["id"] for record in kept["decisions"]] == list(DECISIONS)
    assert kept["configurations"] == list(CONFIGURATIONS)
    rows = {
        (v["id"], row["case"], row["method"], row["window"]): row
        for record in kept["decisions"]
        for v in record["variants"]
        for row in v["rows"]
    }
    assert {id for id, *_ in rows} == set(VARIANTS)
    for v in VARIANTS.values():
        for case, method, window in product(("all", *v.configurations), v.methods, v.windows):
            assert rows[v.id, case, method, window]["realizations"] == min(20, v.realizations)
    for id in ("denser-shells", "printed-amplitudes"):  # by construction
        assert all(row["unflagged"]["moved"] == 0 for (v, *_), row in rows.items() if v == id)
    assert stored_decision("D4")["question"] == DECISIONS["D4"].question
    assert stored_decision("D99") is None
    for record in kept["decisions"]:
        decision = DECISIONS[record["id"]]
        assert (record["question"], record["reference"]) == (decision.question, decision.reference)
        assert all(v["words"] == VARIANTS[v["id"]].words for v in record["variants"])
        assert all(record["id"] in {row["decision"] for row in turned(claim)} for claim in record["claims_that_turn"])
    assert turned("W1") == []


def test_what_is_kept_judges_every_claim_about_velocities_under_every_variant_that_matters():
    kept = stored_decisions()
    judged = {v["id"] for record in kept["decisions"] for v in record["variants"] if v["claims_judged"]}
    of_others = {"W1", "W2", "W3", "W4", "W5", "W6", "W8", "W10", "N6", "A16", "B1"}
    found = {(claim["id"], claim["variant"]) for claim in kept["claims"]}
    assert kept["full"]
    assert found == set(product(set(CLAIMS) - of_others, judged))
    for v in (v for record in kept["decisions"] for v in record["variants"] if VARIANTS[v["id"]].paired):
        rows = [row["unflagged"] for row in v["rows"] if row["case"] == "all" and row["unflagged"]["shells"]]
        matters = max((row["resolution"]["largest"] for row in rows), default=0) > 0.1
        of_paper = {*VARIANTS[v["id"]].methods} <= {*DEFAULT}
        assert (v["id"] in judged) == (matters and of_paper and not VARIANTS[v["id"]].setting.resampled), v["id"]


def test_the_guide_says_which_verdicts_turn():
    claims = stored_decisions()["claims"]
    turning = {c["id"]: c["decision"] for c in claims if c["flipped"] and c["before"] != c["verdict"]}
    text = " ".join(files("leakref").joinpath("guide", "decisions.md").read_text(encoding="utf-8").split())
    counted = [len({c[of] for c in claims if c["flipped"] or of != "id"}) for of in ("id", "variant")]
    assert sorted(turning) == ["G7", "N1", "N3", "N5", "U8"]
    assert all(f"{id} (" in text for id in turning)
    assert f"Of {len({c['id'] for c in claims})} statements" in text
    assert f"under the {counted[1]} variants that matter, {counted[0]} have a reading that turns" in text


FINEST = min(
    float(
        min(
            map(
                np.min,
                velocity_resolutions(
                    c.wavenumbers, c.grid.wavenumber_resolution, c.grid.frequency_resolution, water=DEEP
                ),
            )
        )
    )
    for c in PAPER_CASES["L-T"]
)
PRECISION = 2e-11  # c0: the difference of two velocities, each of which another processor rounds within 1e-11


def unlike(found, kept, precision=PRECISION, at=""):
    """Where two rows differ by more than the precision of velocities and the three digits that are kept, in words."""
    if isinstance(kept, dict) and set(found) == set(kept):
        for key, value in kept.items():
            finer = precision / FINEST if key == "resolution" else precision
            yield from unlike(found[key], value, finer, f"{at} {key}")
    elif isinstance(kept, float) and isinstance(found, float):
        last = 10.0 ** (np.floor(np.log10(max(abs(kept), abs(found)) or 1.0)) - 2)  # may go either way
        if not abs(found - kept) <= precision + last * 1.001:
            yield f"{at}: {found}, should be {kept}"
    elif found != kept:
        yield f"{at}: {found}, should be {kept}"


@pytest.mark.stored
def test_what_is_kept_is_found_again():
    """The cheapest of the eight seas, and the variants for which nothing need be compiled."""
    ids = ("edge-bins-out", "cut-at-3", "threshold-of-amplitude", "threshold-of-all")
    found = study([VARIANTS[id] for id in ids], (CASE,))
    kept = {
        (v["id"], row["window"], row["method"]): row
        for record in stored_decisions()["decisions"]
        for v in record["variants"]
        for row in v["rows"]
        if row["case"] == CASE
    }
    for id in ids:
        for s in found[id][0]:
            row, before = shifts.summary([s], CASE), kept[id, s.reference.window, s.reference.method]
            margin = int((np.abs(s.moved - shifts.MOVED) <= PRECISION).sum())  # which may count as moved or not
            assert abs(row["unflagged"].pop("moved", 0) - before["unflagged"].pop("moved", 0)) <= margin
            assert list(unlike(row, before)) == [], id


@pytest.mark.parametrize("by", [1.012, -1, np.nan])
def test_another_number_would_be_found(by):
    row = next(
        row
        for record in stored_decisions()["decisions"]
        for v in record["variants"]
        for row in v["rows"]
        if row["unflagged"]["shells"] and row["unflagged"]["c0"]["largest"] > 1e-6
    )
    other = json.loads(json.dumps(row))
    other["unflagged"]["c0"]["largest"] *= by
    assert list(unlike(row, row)) == []
    assert len(list(unlike(other, row))) == 1
    other = json.loads(json.dumps(row)) | {"lost": row["lost"] + 1}
    assert len(list(unlike(other, row))) == 1


def test_command_shows_what_is_kept(capsys, tmp_path):
    arguments = {"realizations": 20, "judged": 20, "place": tmp_path, "workers": 1, "full": False, "out": None}
    assert decisionscommand.run(["d4"], figures=True, json=True, **arguments)
    shown = json.loads(capsys.readouterr().out)
    assert shown["schema"] == "leakref/claims/1"
    assert [record["id"] for record in shown["decisions"]] == ["D4"]
    assert all(claim["decision"] == "D4" for claim in shown["claims"])
    assert {path.name for path in tmp_path.iterdir()} == {"decisions.png", "decisions.svg"}
    decisionscommand.run([], figures=False, json=False, **arguments)
    text = capsys.readouterr().out
    assert "D25" in text
    assert "Claims that turn" in text
    with pytest.raises(LeakrefError, match="no decision is called 'A4'"):
        decisionscommand.run(["A4"], figures=False, json=False, **arguments)
