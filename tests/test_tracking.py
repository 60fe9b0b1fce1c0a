"""What is recorded of a version, and what is made of two: planted rises are seen, noise is not."""

from __future__ import annotations

import json
from dataclasses import replace
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import t as student
from scipy.stats import ttest_ind

from leakref import LeakrefError, runs
from leakref.cases import configurations
from leakref.certify.subject.inprocess import InProcess
from leakref.chain import reference
from leakref.sea import SeaState
from leakref.track import changes, history, tracking
from leakref.track.changes import ALPHA, ANSWERS, BANDS, LOST, MARGIN, POWER, compare, in_band
from leakref.track.timings import SLOWER, compare_timings, timings
from leakref.track.tracking import PAPER, Series, scene

R = 100
HISTORY = Path(__file__).parents[1] / "golden" / "history.jsonl"


def made(errors, *, case="some", window="hann", first=0, digest="d", resolution=0.1, k=None):
    errors = np.asarray(errors, dtype=float)
    k = np.linspace(0.4, 3.5, errors.shape[1]) if k is None else k
    return Series(case, digest, window, "nsp", k, np.full(k.size, resolution), first, errors)


def noise(seed=0, shape=(R, 32)):
    return np.random.default_rng(seed).rayleigh(0.02, shape)


def rows(found, verdict):
    return [c for c in found.changes if c.verdict == verdict]


# ------------------------------------------------------------ what is recorded


@pytest.fixture(scope="module")
def recorded():
    return tracking.measure_reference([scene("L-T/L=5,T=10")], range(3, 7))


def test_the_reference_is_recorded_as_its_ensembles_are(recorded):
    (c,) = configurations(["L-T/L=5,T=10"])
    for series, e in zip(recorded, next(iter(runs.run([c], realizations=7))), strict=True):
        assert series.key == (c.id, e.window, e.method)
        np.testing.assert_array_equal(series.errors, e.magnitudes[3:])
        np.testing.assert_array_equal(series.resolution, np.minimum(*e.resolutions))
        assert series.first == 3


def test_a_series_survives_its_record(recorded):
    errors = recorded[0].errors.copy()
    errors[1, 2], errors[:, 3] = np.nan, np.nan
    series = replace(recorded[0], errors=errors)
    kept = json.loads(json.dumps(series.record(), allow_nan=False))
    again = Series.read(kept)
    assert again.key == series.key
    assert again.digest == series.digest
    np.testing.assert_allclose(again.errors, errors, atol=0.5000001e-6, rtol=0)
    assert kept["errors"][1][2] is None
    assert kept["bias"][3] is None
    assert kept["count"][:4] == [4, 4, 3, 0]
    np.testing.assert_allclose(kept["bias"][0], errors[:, 0].mean(), atol=1e-8)
    np.testing.assert_allclose(kept["random"][0], errors[:, 0].std(ddof=1), atol=1e-8)


def test_with_a_current_the_error_is_that_of_the_vector():
    (c,) = configurations([PAPER[1]])
    assert c.speed == 0.15
    series = tracking.measure_reference([scene(c.id)], range(1))
    e = next(iter(runs.run([c], realizations=1)))[0]
    np.testing.assert_allclose(series[0].errors[0], np.hypot(*(e.velocities[0] - [0.0, 0.15]).T), atol=1e-15)


def test_a_case_is_known_by_what_is_shown(monkeypatch):
    before = {name: scene(name).digest for name in ("broad", "following", "narrow", "nsp-ls")}
    assert len(set(before.values())) == 4
    assert {name: scene(name).digest for name in before} == before
    monkeypatch.setattr("leakref.sea.INPUT_SPACING", 0.3410001)
    assert scene("nsp-ls").digest != before["nsp-ls"]


def test_rounding_does_not_make_another_case(monkeypatch):
    before = scene("nsp-ls").digest
    exact = SeaState.components

    def rounded(self, realization):
        waves = exact(self, realization)
        return replace(waves, omega=waves.omega * (1 + 4e-16), amplitude=waves.amplitude * (1 - 4e-16))

    monkeypatch.setattr(SeaState, "components", rounded)
    assert scene("nsp-ls").digest == before


def test_the_second_realization_counts_too(monkeypatch):
    before = scene("nsp-ls").digest
    exact = SeaState.components

    def other(self, realization):
        waves = exact(self, realization)
        return replace(waves, phase=waves.phase + 1e-3 * (realization == 1))

    monkeypatch.setattr(SeaState, "components", other)
    assert scene("nsp-ls").digest != before


def test_cases_that_are_several_or_none_are_refused():
    with pytest.raises(LeakrefError, match="has 9 configurations"):
        scene("L-T")
    with pytest.raises(LeakrefError, match="no case is called"):
        scene("nonsense")


class Declining:
    """The reference's answers, none below k = 1 and none at all for the second cube."""

    calls = 0

    def describe(self):
        return {"can": {"extract": {"methods": ["nsp"], "windows": ["hann"]}}}

    def extract(self, surface, spacing, wavenumbers, *, gravity, window, method):
        Declining.calls += 1
        if Declining.calls == 2:
            raise RuntimeError("no idea")
        found = reference.extract(surface, spacing, wavenumbers, gravity=gravity, window=window, method=method)
        return [None if k < 1 else row.tolist() for k, row in zip(wavenumbers, found, strict=True)]


def test_any_target_is_shown_the_same_seas_and_what_it_declines_is_kept_so():
    own, said = tracking.measure(InProcess(Declining()), [scene("following")], range(3))
    theirs = {one.key: one for one in tracking.measure_reference([scene("following")], range(3))}
    (one,) = own
    assert one.key == ("following", "hann", "nsp")
    assert one.digest == theirs[one.key].digest
    np.testing.assert_allclose(one.errors[[0, 2], 1:], theirs[one.key].errors[[0, 2], 1:], atol=1e-9)
    assert np.isnan(one.errors[:, 0]).all()
    assert np.isnan(one.errors[1]).all()
    assert said == ["following, hann, nsp: no answer in 1 of 3 realisations; the first time: RuntimeError: no idea"]


def test_a_target_that_answers_nothing_has_no_series():
    def nothing(surface, spacing, wavenumbers):
        raise RuntimeError("no idea")

    own, said = tracking.measure(InProcess(nothing), [scene("small")], range(2))
    assert own == []
    assert len(said) == 2  # raw and tapered


def test_the_source_is_known_by_its_contents(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    package = tmp_path / "somepackage"
    (package / "deep").mkdir(parents=True)
    for name in ("__init__.py", "deep/__init__.py", "deep/code.py"):
        (package / name).write_text("x = 1\n")
    (package / "notes.txt").write_text("no source")
    (tmp_path / "data.csv").write_text("1")
    first = tracking.source_of("somepackage.deep.code:x")
    assert first["of"] == "__init__.py, __init__.py, code.py"
    (package / "notes.txt").write_text("changed")
    assert tracking.source_of("somepackage:y") == first
    (package / "deep" / "code.py").write_text("x = 2\n")
    changed = tracking.source_of("somepackage:y")
    assert changed["sha256"] != first["sha256"]
    assert tracking.source_of("somepackage:y", [Path("data.csv")])["sha256"] != changed["sha256"]
    program = tracking.source_of_program(["sh", "data.csv", "--fast"])
    assert program["of"].endswith("data.csv")
    (tmp_path / "data.csv").write_text("2")
    assert tracking.source_of_program(["sh", "data.csv", "--fast"])["sha256"] != program["sha256"]
    with pytest.raises(LeakrefError, match="cannot be read"):
        tracking.source_of_program(["sh"], [Path("nothing")])
    reference_source = tracking.source_of_reference()["sha256"]
    assert reference_source == runs.source_digest()
    assert len({reference_source, *(tracking.source_of(f"fault:{x}")["sha256"] for x in "ab")}) == 3


def test_an_entry_says_what_it_was_measured_with():
    found = tracking.fields("v", "reference", reference.describe(), {"sha256": "s"}, [made(noise())])
    assert found["decisions"]["D3"].startswith("Yes, with a margin")
    assert {"platform", "python", "numpy", "scipy", "leakref", "recorded", "source", "measurements"} <= set(found)


# ------------------------------------------------------------ what is made of two


def test_a_rise_of_5_percent_of_the_resolution_in_one_band_is_seen_and_nothing_else():
    """In whichever band, in pairs of a hundred realisations; evenly, and as scattered as an exponential."""
    before = made(noise())
    for number, (low, high) in enumerate(BANDS):
        inside = in_band(before.wavenumbers, low, high)
        for rise in (np.ones((R, 32)), np.random.default_rng(number).exponential(1.0, (R, 32))):
            after = replace(before, errors=before.errors + np.where(inside, 0.05 * 0.1 * rise, 0))
            found = compare([before], [after])
            assert found.status == 1
            assert {c.band for c in found.worse if not c.single} == {f"{low:g} to {high:g}"}
            assert {k for c in found.worse for k in c.wavenumbers} <= set(before.wavenumbers[inside])
            back = compare([after], [before])
            assert back.status == 0
            assert len(rows(back, "better")) == len(found.worse)


def test_a_planted_change_of_the_reference_is_seen(monkeypatch):
    """In the chain itself: velocities longer in one band, so that its mean error rises by 5 % of the resolution."""
    before = tracking.measure_reference([scene("broad")], range(R))
    (hann,) = [one for one in before if one.key == ("broad", "hann", "nsp")]
    inside = in_band(hann.wavenumbers, 1.2, 2.0)
    longer = 1 + 0.05 * hann.resolution[inside].mean() / hann.bias[inside].mean()
    exact = tracking.fast.realize

    def altered(waves, grid, k, **settings):
        found = exact(waves, grid, k, **settings)
        one = found["hann", "nsp"]
        factor = np.where(in_band(k, 1.2, 2.0), longer, 1.0)[:, None]
        return {**found, ("hann", "nsp"): replace(one, velocities=one.velocities * factor)}

    monkeypatch.setattr(tracking.fast, "realize", altered)
    found = compare(before, tracking.measure_reference([scene("broad")], range(R)))
    assert found.status == 1
    assert {(c.window, c.method) for c in found.worse} == {("hann", "nsp")}
    (band,) = [c for c in found.worse if not c.single]
    assert band.band == "1.2 to 2"
    assert band.change == pytest.approx(0.05 * band.resolution, rel=1e-3)
    assert band.interval[0] < band.change < band.interval[1]


def test_what_did_not_change_is_equal():
    one = made(noise())
    found = compare([one], [one])
    assert found.status == 0
    assert len(rows(found, "equal")) == len(found.changes) == 32 + 4 + 1
    rounded = replace(one, errors=np.round(one.errors, 6))
    assert len(rows(compare([one], [rounded]), "equal")) == 37


def test_few_realizations_decide_nothing_and_that_is_no_success():
    a, b = made(noise(1, (3, 32))), made(noise(2, (3, 32)))
    found = compare([a], [b])
    assert {c.verdict for c in found.changes if c.band != ANSWERS} == {"undecided"}
    one = compare([made(noise(1, (1, 32)))], [made(noise(2, (1, 32)))])
    assert {c.verdict for c in one.changes} == {"undecided"}
    assert one.status == 3
    assert one.changes[0].interval == (-np.inf, np.inf)
    assert compare([a], []).status == compare([], []).status == 3


def test_cases_that_are_not_the_same_are_never_compared_and_that_is_said():
    a, b = made(noise(1)), made(noise(1) + 1, digest="e")
    found = compare([a], [b])
    assert found.changes == ()
    assert found.status == 3
    assert "not compared" in found.unlike[0]
    other = made(noise(3), case="other")
    with_other = compare([a, other], [b, other])
    assert {c.case for c in with_other.changes} == {"other"}
    assert with_other.status == 3  # part of what was watched is not any more
    worse = compare([a, other], [b, replace(other, errors=other.errors + 1)])
    assert worse.status == 1
    alone = compare([a, other], [other])
    assert alone.status == 0
    assert alone.alone == ("some, hann, nsp: not compared, only the first has it",)


def test_common_realizations_are_paired_and_others_are_two_samples():
    common = noise(1, (150, 32))
    a, b = made(common[:100]), made(common[50:] + 0.001, first=50)
    found = compare([a], [b])
    assert {(c.paired, c.count) for c in found.changes} == {(True, 50)}
    assert found.changes[0].change == pytest.approx(0.001, abs=1e-9)
    c = made(common[50:], first=100)
    two = compare([a], [c])
    assert {(one.paired, one.count) for one in two.changes} == {(False, 100)}
    assert two.changes[0].change == pytest.approx(common[50:, 0].mean() - common[:100, 0].mean(), abs=1e-12)
    assert two.changes[0].smallest > 5 * found.changes[0].smallest


def test_velocities_that_are_declined_are_no_improvement():
    before = made(noise())
    errors = before.errors.copy()
    errors[errors > np.quantile(errors, 0.8)] = np.nan
    found = compare([before], [replace(before, errors=errors)])
    assert [c.band for c in found.worse] == [ANSWERS]
    assert found.worse[0].change == pytest.approx(0.2, abs=1e-6)
    assert not rows(found, "better")
    none = compare([before], [replace(before, errors=np.full_like(errors, np.nan))])
    assert [c.band for c in none.worse] == [ANSWERS]
    few = before.errors.copy()
    few[::50, 3] = np.nan
    assert compare([before], [replace(before, errors=few)]).status == 0
    assert LOST > 0.01


def test_intervals_of_a_run_hold_together(monkeypatch):
    """With a fifth instead of a hundredth: of 200 runs without a change that many may miss and no more, and hardly
    fewer, or nothing would be seen; three standard deviations of the binomial."""
    monkeypatch.setattr(changes, "ALPHA", 0.2)
    rng = np.random.default_rng(11)
    missed = alarms = 0
    for _ in range(200):
        a, b = (made(rng.rayleigh(0.02, (30, 32))) for _ in range(2))
        found = compare([a], [b])
        missed += any(c.interval[0] > 0 or c.interval[1] < 0 for c in found.changes)
        alarms += bool(found.worse)
    assert 0.1 * 200 <= missed <= 0.2 * 200 + 3 * np.sqrt(200 * 0.2 * 0.8)
    assert 0 < alarms < 0.75 * missed  # on one side only, and beyond the margin


def test_the_smallest_change_that_is_stated_is_seen_as_often_as_stated():
    """Independent normal differences: within five standard deviations of the binomial, less a little for the
    approximation."""
    rng = np.random.default_rng(12)
    trials, seen = 300, 0
    size = compare([made(rng.normal(1, 0.02, (R, 1)))], [made(rng.normal(1, 0.02, (R, 1)))]).changes[0].smallest
    for _ in range(trials):
        a, b = made(rng.normal(1, 0.02, (R, 1))), made(rng.normal(1 + size, 0.02, (R, 1)))
        seen += compare([a], [b]).changes[0].verdict == "worse"
    off = 5 * np.sqrt(trials * POWER * (1 - POWER))
    assert abs(seen - trials * POWER) < off


def test_the_intervals_are_those_of_student_divided_by_bonferroni():
    a, b = made(noise(1)), made(noise(2))
    found = compare([a, replace(a, window="box")], [b, replace(b, window="box")]).changes
    single = next(c for c in found if c.single)
    d = b.errors[:, 0] - a.errors[:, 0]
    reach = student.isf(ALPHA / 2 / 64 / 2, R - 1) * d.std(ddof=1) / np.sqrt(R)
    assert single.interval == pytest.approx((d.mean() - reach, d.mean() + reach), abs=1e-9)
    band = next(c for c in found if c.band == "0.4 to 0.8")
    d = (b.errors - a.errors)[:, in_band(a.wavenumbers, 0.4, 0.8)].mean(axis=1)
    reach = student.isf(ALPHA / 2 / 10 / 2, R - 1) * d.std(ddof=1) / np.sqrt(R)
    assert band.interval == pytest.approx((d.mean() - reach, d.mean() + reach), abs=1e-9)
    assert band.margin == pytest.approx(MARGIN * 0.1)


def test_two_samples_are_compared_as_by_welch():
    rng = np.random.default_rng(4)
    a, b = made(rng.normal(1, 0.3, (8, 1))), made(rng.normal(1, 0.01, (40, 1)), first=8)
    single = compare([a], [b]).changes[0]
    theirs = ttest_ind(b.errors[:, 0], a.errors[:, 0], equal_var=False).confidence_interval(1 - ALPHA / 2)
    assert single.interval == pytest.approx((theirs.low, theirs.high), rel=1e-6)


def test_bands_cover_every_wavenumber_once():
    k = np.round(np.arange(4, 36) * 0.1, 10)
    assert (sum(in_band(k, *band).astype(int) for band in BANDS) == 1).all()
    assert in_band(k * (1 + 1e-12), 0.8, 1.2).tolist() == in_band(k * (1 - 1e-12), 0.8, 1.2).tolist()


@pytest.mark.parametrize(
    ("interval", "said"),
    [
        ((0.2, 0.3), "worse"),
        ((-0.3, -0.2), "better"),
        ((-0.1, 0.1), "equal"),
        ((0.05, 0.2), "undecided"),
        ((-0.2, 0.2), "undecided"),
        ((-np.inf, np.inf), "undecided"),
    ],
)
def test_verdicts(interval, said):
    assert changes.verdict(*interval, 0.1) == said


def test_a_margin_of_nothing_is_refused():
    with pytest.raises(LeakrefError, match="margin"):
        compare([], [], margin=0.0)


# ------------------------------------------------------------ timings


def benchmarks(**medians):
    return {
        "benchmarks": [
            {
                "fullname": f"tests/test_some.py::{name}",
                "stats": {"median": median, "iqr": 0.01 * median, "rounds": rounds},
            }
            for name, (median, rounds) in medians.items()
        ]
    }


def test_timings_are_ratios_to_a_workload_of_the_same_run():
    a = timings(benchmarks(fft=(0.1, 50), chain=(0.5, 50), once=(1.0, 1)), "fft")
    b = timings(benchmarks(fft=(0.2, 50), chain=(1.0, 50), once=(2.0, 1)), "fft")  # a machine half as fast
    assert a["ratios"]["tests/test_some.py::chain"]["ratio"] == pytest.approx(5.0)
    first, second = compare_timings(a, b)
    assert (first["change"], first["verdict"]) == (pytest.approx(0.0), "equal")
    assert second["verdict"] == "undecided"  # one round has no spread
    c = timings(benchmarks(fft=(0.2, 50), chain=(1.0 * (1 + 2 * SLOWER), 50)), "fft")
    assert [row["verdict"] for row in compare_timings(a, c)] == ["slower"]
    assert [row["verdict"] for row in compare_timings(c, a)] == ["faster"]
    assert compare_timings(a, None) == compare_timings(a, {**a, "yardstick": "another"}) == []


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({}, "no JSON of pytest-benchmark"),
        (benchmarks(x=(0.0, 5)), "division"),
        (benchmarks(x=(1.0, 5)), "0 benchmarks are called 'fft'"),
    ],
)
def test_bad_timings_are_refused(given, said):
    with pytest.raises(LeakrefError, match=said):
        timings(given, "fft")


# ------------------------------------------------------------ what is committed


def test_the_committed_share_of_alarms_is_as_declared():
    kept = json.loads(resources.files("leakref._golden").joinpath("tracking.json").read_text(encoding="utf-8"))
    assert kept["declared"] == {"alarms": ALPHA / 2, "misses": ALPHA}
    for name in ("unpaired", "paired", "all"):
        row = kept[name]
        assert row["share"] == row["alarms"] / row["comparisons"]
        assert row["interval"][0] <= row["share"] <= row["interval"][1]
        assert row["share"] <= ALPHA / 2
    assert kept["all"]["comparisons"] == kept["unpaired"]["comparisons"] + kept["paired"]["comparisons"] >= 2000
    assert kept["all"]["share_of_misses"] <= ALPHA
    assert kept["unpaired"]["interval_of_misses"][0] <= ALPHA  # 1.1 %: not significantly more than declared
    assert all(row["seen"] == row["trials"] for row in kept["planted"] if row["rise"] == "even")
    assert {row["band"] for row in kept["planted"]} == {f"{low:g} to {high:g}" for low, high in BANDS}


def test_the_null_study_counts_what_it_says(monkeypatch):
    """Alarms where every comparison is one, and none where none is."""
    from leakref.track import falsealarms

    rng = np.random.default_rng(1)
    series = [made(noise())]
    quiet = [[falsealarms._halves(series, rng) for _ in range(3)]] * 2
    image = [replace(series[0], errors=noise(7))]
    quiet += [[falsealarms._by_lot(series, image, rng) for _ in range(3)]]
    assert vars(falsealarms._tally(quiet)) == {"runs": 9, "alarms": 0, "misses": 0, "configurations": 3, "alarmed": 0}
    loud = compare(series, [replace(series[0], errors=series[0].errors + 1)])
    assert vars(falsealarms._tally([[loud, quiet[0][0]], quiet[0]])) == {
        "runs": 5,
        "alarms": 1,
        "misses": 1,
        "configurations": 2,
        "alarmed": 1,
    }
    halves = falsealarms._halves(series, rng)
    assert {c.paired for c in halves.changes} == {False}
    assert {c.count for c in halves.changes} == {R // 2}


def test_the_committed_history_is_whole_and_of_these_cases():
    kept = history.read(HISTORY)
    assert kept.faults == ()
    last = kept.entry("last")
    assert {one["case"]: one["case_sha256"] for one in last.record["measurements"]} == {
        name: scene(name).digest for name in PAPER
    }
    assert {len(one["errors"]) for one in last.record["measurements"]} == {R}


def test_the_committed_history_is_reproduced():
    """A few realisations of what CI compares in full."""
    kept = history.read(HISTORY).entry("last")
    before = {one.key: one for one in map(Series.read, kept.record["measurements"])}
    for one in tracking.measure_reference([scene(PAPER[0])], range(2)):
        both = np.isfinite(one.errors)
        np.testing.assert_allclose(one.errors[both], before[one.key].errors[:2][both], atol=1.1e-6)
