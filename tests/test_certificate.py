"""What findings amount to: grades, known failures, exit status, JSON by its schema, JUnit."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from threading import Event
from xml.etree import ElementTree

import jsonschema
import pytest

from leakref import LeakrefError
from leakref.certify.certificate import Certificate, junit, schema
from leakref.certify.report import badge, sentence
from leakref.certify.runner import CutShort, certify, select
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.verdict import Finding, Known, Unanswered, Verdict, read_known
from leakref.chain import reference

PASS, FAIL, MISSING, UNSUPPORTED, ERROR, TIMEOUT = Verdict
SAID = {"name": "x", "version": "1", "units": "si", "axes": "xyt", "y": "up", "direction": "to", "fixed": []}
EXTRACT, WINDOW = {"can": {"extract": {}}}, {"can": {"window": {"names": ["hann"]}}}


def finding(family: str, verdict: Verdict, name: str = "a", **more: object) -> Finding:
    return Finding(f"{family}.check[{name}]", family, verdict, f"{verdict} it is", **more)


def certificate(*findings: Finding, known: tuple[str, ...] = (), can: dict = EXTRACT, **more: object) -> Certificate:
    excused = {i: Known(i, "a reason", "an issue") for i in known}
    return Certificate("a:b", "quick", "v1", {**SAID, **can}, list(findings), excused, **more)


def some(family: str, judged: int, missing: int) -> list[Finding]:
    return [finding(family, PASS if n < judged else MISSING, f"{n}") for n in range(judged + missing)]


GOLDEN, SIGN = finding("conformance", PASS), finding("signs", PASS)


@pytest.mark.parametrize(
    ("findings", "grade", "status"),
    [
        ((GOLDEN, SIGN), "conformant", 0),
        ((GOLDEN,), "conformant", 0),
        ((SIGN,), "sound", 0),
        ((finding("conformance", FAIL), SIGN), "sound", 0),
        ((finding("conformance", ERROR), SIGN), "sound", 0),
        ((finding("conformance", MISSING), GOLDEN, SIGN), "sound", 0),
        ((finding("conformance", UNSUPPORTED), GOLDEN, SIGN), "conformant", 0),
        ((finding("conformance", FAIL),), "rejected", 1),
        ((GOLDEN, finding("signs", FAIL)), "rejected", 1),
        ((GOLDEN, finding("signs", ERROR)), "rejected", 1),
        ((GOLDEN, finding("signs", TIMEOUT)), "rejected", 1),
        ((GOLDEN, SIGN, finding("signs", MISSING, "b")), "sound", 0),  # with anything missing at most sound
        ((GOLDEN, SIGN, finding("shear", MISSING)), "sound", 0),
        ((GOLDEN, *some("signs", 3, 4)), None, 3),  # less than half of it was answered
        ((GOLDEN, SIGN, *some("recovery", 0, 1)), None, 3),
        ((GOLDEN, SIGN, *some("leakage", 4, 5)), None, 3),
        ((GOLDEN, SIGN, *some("leakage", 4, 4)), "sound", 0),
        ((GOLDEN, SIGN, *some("currents", 1, 9)), "sound", 0),  # of other families no least is asked
        ((GOLDEN, finding("scale", FAIL), *some("signs", 3, 4)), "rejected", 1),  # what is wrong is wrong
        ((), None, 3),
        ((finding("signs", UNSUPPORTED), finding("conformance", UNSUPPORTED)), None, 3),
        ((finding("signs", MISSING),), None, 3),
    ],
)
def test_the_grade_follows_from_the_findings(findings, grade, status):
    found = certificate(*findings)
    assert (found.grade, found.status, found.ok) == (grade, status, status == 0)


def test_a_known_failure_changes_the_exit_status_alone_and_one_that_passes_is_an_error():
    bad = finding("signs", FAIL, "bad")
    assert certificate(GOLDEN, bad).status == 1
    excused = certificate(GOLDEN, bad, SIGN, known=(bad.id,))
    assert (excused.grade, excused.status, excused.ok) == ("rejected", 0, True)
    assert (excused.wrong, excused.unexpected) == ([bad], [])
    assert sentence(excused) == "1 of 3 answers is wrong."
    assert excused.grade_line == "rejected, known: 1, 3 of 3 questions"
    red = badge(certificate(GOLDEN, bad, SIGN)).partition('fill="#b3261e"')[1]
    assert red
    assert red in badge(excused)
    assert "rejected, known: 1" in badge(excused)
    two = certificate(GOLDEN, bad, finding("scale", FAIL), known=(bad.id,))
    assert (two.grade, two.status) == ("rejected", 1)
    off = finding("conformance", FAIL, "off")
    other = certificate(off, SIGN, known=(off.id,))
    assert (other.grade, other.status) == ("sound", 0)  # a known difference is a difference
    better = certificate(GOLDEN, replace(bad, verdict=PASS), known=(bad.id,))
    assert (better.grade, better.status, better.ok) == ("conformant", 1, False)
    assert [one.id for one in better.stale] == [bad.id]
    other = certificate(GOLDEN, SIGN, known=("shear.not-run[x]",))  # a quick run says nothing of it
    assert other.status == 0


def test_who_offers_no_velocities_is_graded_as_that_and_no_more():
    own = [finding("conformance", PASS, "hann"), finding("conformance", UNSUPPORTED, "nsp")]
    found = certificate(*own, finding("signs", UNSUPPORTED), finding("leakage", UNSUPPORTED), can=WINDOW)
    assert (found.grade, found.status) == ("conformant", 0)
    assert found.grade_line == "conformant, window only, 1 of 4 questions"
    assert f">{found.grade_line}<" in badge(found)
    assert found.coverage == {"asked": 4, "judged": 1, "missing": 0, "unsupported": 3}
    assert found.scope()["words"] == "No velocity was judged; offered: window."
    refused = [finding("conformance", PASS, "hann"), *some("synthesis", 1, 2)]
    two = certificate(*refused, can={"can": {"window": {}, "synthesize": {}}})
    assert (two.grade, two.status) == (None, 3)  # half of what it offers, of each family
    assert two.grade_line == "no grade, window and synthesize only, 2 of 4 questions"
    assert "1 of 3 in synthesis" in sentence(two)


def test_the_grade_of_some_checks_says_so():
    found = certificate(SIGN, only=("signs", "scale.peak"))
    assert (found.grade, found.status) == ("sound", 0)
    assert found.grade_line == "sound, asked only signs, scale.peak, 1 of 1 questions"
    assert "compared with no golden value" in sentence(found)


def test_the_scope_is_what_was_answered():
    si = replace(certificate(SIGN, methods=("nsp",), scales=(0.0625, 1.0, 4.0), fastest=0.75), seed=5)
    assert si.scope()["peak_wavelengths"] == pytest.approx([2 * 3.141592653589793 / 0.25 / 4, 16 * 25.132741228718345])
    assert si.scope()["fastest_current"] == pytest.approx(0.75 * (9.81 / 0.25) ** 0.5)
    assert si.scope()["words"] == (
        "Deep water, no surface tension, linear waves 25.1 m long (in the family scale 6.28 to 402 m), "
        "one current in the picture, uniform or changing with depth, of 4.7 m/s at most; windows box, hann; method nsp."
    )
    assert (si.scope()["seed"], si.scope()["golden"], si.scope()["depth"]) == (5, "v1", "deep")
    scaled = replace(si, declaration={**si.declaration, "units": "scaled"}, methods=("own",), scales=(1.0,))
    assert "of 0.75 c0 (c0: sqrt(g / k0)) at most" in scaled.scope()["words"]
    assert scaled.scope()["words"].endswith("; no method named, so held to no digits (declare nsp or ls to be).")


def test_what_was_cut_short_has_no_grade_and_says_so():
    part = certificate(GOLDEN, SIGN, cut_short="interrupted after 2 of 9 questions", unasked=7)
    record = part.record()
    assert (part.grade, part.status, record["complete"]) == (None, 3, False)
    assert record["cut_short"] in sentence(part)
    wrong = certificate(GOLDEN, finding("signs", FAIL), cut_short="interrupted after 2 of 9 questions", unasked=7)
    assert wrong.grade == "rejected"  # whatever the rest would have been
    late = certificate(GOLDEN, SIGN, cut_short="interrupted when all had been asked")
    assert (late.grade, late.record()["complete"]) == ("conformant", False)
    assert certificate(GOLDEN, SIGN).record()["complete"] is True


def test_the_record_follows_its_schema():
    found = certificate(
        GOLDEN,
        finding("signs", FAIL, over=float("inf"), digits=3.2),
        finding("scale", UNSUPPORTED),
        known=("signs.check[a]",),
    )
    record = found.record()
    check = jsonschema.Draft202012Validator(schema())
    check.validate(record)
    assert record["counts"] == {"pass": 1, "fail": 1, "unsupported": 1}
    assert record["findings"][1]["over"] is None  # infinity is not JSON
    for broken in (
        {**record, "grade": "fine"},
        {**record, "findings": [{**record["findings"][0], "verdict": "ok"}]},
        {k: v for k, v in record.items() if k != "diagnosis"},
    ):
        assert not check.is_valid(broken)


def test_junit_counts_what_failed_and_escapes_what_was_printed():
    hostile = finding("signs", FAIL, "b")
    hostile = replace(hostile, message="<script>alert(1)</script> & \x00\x1b[31m \ud800")
    found = certificate(
        GOLDEN,
        SIGN,
        hostile,
        finding("signs", ERROR, "c"),
        finding("scale", MISSING),
        finding("shear", FAIL),
        known=("shear.check[a]", "conformance.check[a]"),
    )
    text = junit(found)
    text.encode("utf-8")
    root = ElementTree.fromstring(text.partition("?>")[2])
    suites = {s.get("name"): s for s in root}
    assert suites["grade"].get("failures") == "1"
    assert {p.get("name") for p in suites["grade"].iter("property")} >= {"grade", "judged", "missing", "scope", "seed"}
    signs = suites["signs"]
    assert [signs.get(n) for n in ("tests", "failures", "errors", "skipped")] == ["3", "1", "1", "0"]
    assert suites["scale"].get("skipped") == suites["shear"].get("skipped") == "1"
    assert suites["known failures"].get("failures") == "1"  # conformance passes, though it is listed
    failure = signs.find("testcase[@name='signs.check[b]']/failure")
    assert failure is not None
    assert "<script>" in str(failure.text)
    assert "<script>" not in text


def test_junit_is_red_where_there_is_no_grade():
    """A CI that reads only this file sees the exit status."""
    for found, failed in ((certificate(GOLDEN, SIGN), "0"), (certificate(GOLDEN, *some("signs", 0, 3)), "1")):
        root = ElementTree.fromstring(junit(found).partition("?>")[2])
        assert root.find("testsuite[@name='grade']").get("failures") == failed
        assert sum(int(s.get("failures")) for s in root) == int(failed)


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("no toml", "is not TOML"),
        ('"a" = "why"', "should have a reason and an issue"),
        ('"a" = {reason = "x"}', "should have a reason and an issue"),
        ('"a" = {reason = " ", issue = "y"}', "should have a reason and an issue"),
        ('"a" = {reason = "x", issue = 3}', "should have a reason and an issue"),
    ],
)
def test_a_list_of_known_failures_is_read_strictly(tmp_path, text, fault):
    path = tmp_path / "known.toml"
    path.write_text(text)
    with pytest.raises(LeakrefError, match=fault):
        read_known(path)


def test_known_failures_carry_their_reason(tmp_path):
    path = tmp_path / "known.toml"
    path.write_text('"signs.sea[x]" = {reason = "rows count downwards", issue = "example.org/7"}\n')
    assert read_known(path) == {"signs.sea[x]": Known("signs.sea[x]", "rows count downwards", "example.org/7")}
    with pytest.raises(LeakrefError, match="cannot be read"):
        read_known(tmp_path / "none.toml")


class Endless(InProcess):
    """Answers nothing until it is ended, and then, as a program that was killed, wrongly."""

    def __init__(self, asked: Event) -> None:
        super().__init__(reference)
        self.asked, self.ended = asked, Event()

    def _work(self, *given):
        self.asked.set()
        assert self.ended.wait(60)
        self.violations.append("left a file where none should be")
        raise Unanswered(Verdict.ERROR, "is not asked any more")

    def __enter__(self):
        return self

    def __exit__(self, *error):
        pass

    def interrupt(self):
        self.ended.set()


def test_what_a_session_does_that_was_ended_is_not_held_against_the_code():
    asked = Event()

    def impatient(found):
        assert asked.wait(60)  # the other session is at a check
        raise KeyboardInterrupt

    pairs = select(["signs.aligned"], profile="quick")
    with pytest.raises(CutShort) as cut:
        certify(
            "code", [nullcontext(InProcess(reference)), Endless(asked)], pairs, profile="quick", after_each=impatient
        )
    part = cut.value.certificate
    assert [f.verdict for f in part.findings] == [PASS]
    assert (part.grade, part.unasked, part.cut_short) == (None, 3, "interrupted after 1 of 4 questions")
