"""What findings amount to: grades, known failures, exit status, JSON by its schema, JUnit."""

from __future__ import annotations

from dataclasses import replace
from xml.etree import ElementTree

import jsonschema
import pytest

from leakref import LeakrefError
from leakref.certify.certificate import Certificate, Known, junit, read_known, schema
from leakref.certify.report import badge, sentence
from leakref.certify.verdict import Finding, Verdict

PASS, FAIL, MISSING, UNSUPPORTED, ERROR, TIMEOUT = Verdict
SAID = {"name": "x", "version": "1", "units": "si", "axes": "xyt", "y": "up", "direction": "to", "fixed": [], "can": {}}


def finding(family: str, verdict: Verdict, name: str = "a", **more: object) -> Finding:
    return Finding(f"{family}.check[{name}]", family, verdict, f"{verdict} it is", **more)  # type: ignore[arg-type]


def certificate(*findings: Finding, known: tuple[str, ...] = ()) -> Certificate:
    return Certificate("a:b", "quick", "v1", SAID, list(findings), {i: Known(i, "a reason", "an issue") for i in known})


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
        ((GOLDEN, SIGN, finding("signs", MISSING, "b")), "conformant", 0),
        ((GOLDEN, SIGN, finding("shear", MISSING)), "rejected", 1),
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
    assert sentence(excused) == "1 of 3 findings are wrong, known: 1."
    assert ">rejected<" in badge(excused)
    assert badge(excused) == badge(certificate(GOLDEN, bad, SIGN))
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
    signs = suites["signs"]
    assert [signs.get(n) for n in ("tests", "failures", "errors", "skipped")] == ["3", "1", "1", "0"]
    assert suites["scale"].get("skipped") == suites["shear"].get("skipped") == "1"
    assert suites["known failures"].get("failures") == "1"  # conformance passes, though it is listed
    failure = signs.find("testcase[@name='signs.check[b]']/failure")
    assert failure is not None
    assert "<script>" in str(failure.text)
    assert "<script>" not in text


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
