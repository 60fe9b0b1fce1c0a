"""The page of a certificate: everything hostile is text in it, and it needs nothing from elsewhere."""

from __future__ import annotations

import re
import shlex
import sys
from dataclasses import replace
from html.parser import HTMLParser
from xml.etree import ElementTree

import pytest
from markupsafe import escape

from leakref.certify import commands
from leakref.certify.certificate import Certificate
from leakref.certify.measures.bias import SEAS, bias, figure
from leakref.certify.report import badge, page
from leakref.certify.runner import select
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.verdict import Finding, Known, Verdict
from leakref.chain import reference

HOSTILE = "<script>alert(1)</script>\"'&{{ 7 * 7 }}"
SAID = {
    "name": HOSTILE,
    "version": HOSTILE,
    "units": "si",
    "axes": "xyt",
    "y": "up",
    "direction": "to",
    "fixed": [HOSTILE],
    "can": {"extract": {"methods": [HOSTILE], "windows": []}},
}
ARROWS = {
    "wavenumbers": [1.0, 2.0],
    "velocities": [[0.1, 0.2], [float("nan"), 0.0]],
    "should_be": [[0.1, 0.1]] * 2,
    "over": [3.0, 0.1],
}


class Elements(HTMLParser):
    """Tags, and what they refer to."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.references: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.references += [value or "" for name, value in attrs if name in ("src", "href")]


def certificate(**more) -> Certificate:
    names = [f"{c.id}[{case.id}]" for c, case in select(["signs", "shear"])]
    findings = [
        Finding(
            name,
            name.partition(".")[0],
            Verdict.FAIL,
            HOSTILE,
            3.5,
            12.0,
            HOSTILE,
            "eq:SJ",
            {"nsp": ARROWS} if n else ARROWS,
        )
        for n, name in enumerate(names)
    ]
    known = {names[0]: Known(names[0], HOSTILE, HOSTILE)}
    return Certificate(
        HOSTILE,
        "quick",
        "v1",
        SAID,
        findings,
        known,
        [{"fault": HOSTILE, "words": HOSTILE, "kind": kind} for kind in ("fault", "repair")],
        HOSTILE,
        "extract",
        **more,
    )


def test_hostile_words_are_text_and_nothing_comes_from_elsewhere():
    seen = Elements(page(certificate(), [{"title": HOSTILE, "words": HOSTILE, "data": "AAAA"}]))
    assert "script" not in seen.tags
    assert all(reference.startswith(("#", "data:image/png;base64,")) for reference in seen.references)
    assert {"details", "svg", "table", "img"} <= set(seen.tags)
    text = page(certificate())
    assert text.count("&lt;script&gt;") > 20
    assert "&amp;49" not in text  # nothing is evaluated twice
    assert "&amp;{{ 7 * 7 }}" in text


def test_every_finding_is_there_with_its_reason_and_a_picture():
    found = certificate()
    text = page(found)
    checks = {f"{c.id}[{case.id}]": c for c, case in select()}
    for finding in found.findings:
        assert finding.id in text
        assert checks[finding.id].tolerance.split(",")[0][:30].replace("'", "&#39;") in text
    assert text.count("<svg") == len(found.findings)
    assert text.count("<details open") == len({f.id.partition("[")[0] for f in found.wrong})
    assert "nan" not in "".join(re.findall(r"<line[^>]*>", text))


def test_three_hundred_findings_make_a_small_page():
    found = certificate()
    many = replace(found, findings=(list(found.findings) * 40)[:300])
    assert len(page(many).encode()) < 5e6


@pytest.mark.parametrize("findings", [[], None])
def test_the_badge_is_an_image_that_names_the_grade(findings):
    found = certificate() if findings is None else replace(certificate(), findings=findings)
    root = ElementTree.fromstring(badge(found))
    assert root.get("aria-label") == f"leakref: {found.grade_line}"


def test_bias_is_that_of_the_reference_for_the_reference_and_twice_it_where_errors_are_doubled():
    def doubled(surface, spacing, wavenumbers, *, gravity, window):
        return 2 * reference.extract(surface, spacing, wavenumbers, gravity=gravity, window=window, method="nsp")

    seas = [replace(SEAS["small"], wavenumbers=(2.0, 2.5))]
    (same,) = bias(InProcess(reference), seas, realizations=2, scales=(1.0,))
    assert same.ratio == pytest.approx(1.0, abs=1e-9)
    assert same.interval == pytest.approx((1.0, 1.0), abs=1e-9)
    (twice,) = bias(InProcess(doubled), seas, realizations=2, scales=(4.0,))
    assert twice.ratio == pytest.approx(2.0, abs=1e-9)  # in still water the error is the velocity
    assert twice.bias == pytest.approx(2 * twice.reference_bias, abs=1e-12)
    assert figure([same]).startswith(b"\x89PNG")


def test_sub_resolution_from_is_the_first_wavenumber_with_no_larger_error_above():
    (found,) = bias(
        InProcess(reference), [replace(SEAS["small"], wavenumbers=(2.0, 2.5))], realizations=2, scales=(1.0,)
    )
    small, large = found.resolutions[0] / 2, found.resolutions[0] * 2
    assert replace(found, bias=small).sub_resolution_from == 2.0
    assert replace(found, bias=large).sub_resolution_from is None
    mixed = large.copy()
    mixed[1] = small[1]
    assert replace(found, bias=mixed).sub_resolution_from == 2.5


def test_the_page_says_how_the_run_is_repeated():
    """By a target or by a program, with the seed, so that it can be pasted."""
    program = f"{sys.executable} -c 'import odd'"
    for asked, typed in (((None, program), shlex.join(["--command", program])), (("a b:c", None), "'a b:c'")):
        request = commands.Request(*asked, only=["signs.sea[to-22.5]"], seed="7")
        found = commands.named(certificate(seed=7), request)
        assert found.again == (
            f"leakref certify {typed} --only 'signs.sea[to-22.5]' --profile quick --golden 1 --seed 7"
        )
        assert escape(found.again) in page(found)
    assert "<pre></pre>" not in page(certificate())


def test_what_is_not_offered_is_a_line_a_family():
    found = certificate()
    beyond = [replace(f, verdict=Verdict.UNSUPPORTED) for f in found.findings if f.family == "shear"]
    said = page(replace(found, findings=[f for f in found.findings if f.family != "shear"] + beyond))
    assert len(beyond) > 1
    assert said.count(f"{len(beyond)} questions about what it does not offer") == 1
    assert not [f.id for f in beyond if f'<span class="id">{f.id}' in said]
    assert all(said.count(f"<code>{f.id}</code>") == 1 for f in beyond)


def test_what_was_not_tested_is_said_of_what_was_offered():
    """Of a window other depths are no news: no velocity was looked at."""
    whole, part = certificate(), certificate()
    part = replace(part, declaration={**part.declaration, "can": {"window": {"names": ["hann"]}}})
    assert "Other depths, surface tension" in page(whole)
    assert "Other depths" not in page(part)
    assert "Any velocity: no spectrum was searched for a current" in page(part)
