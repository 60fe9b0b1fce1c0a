"""The certificate: what all findings together say of an implementation, as a grade, an exit status and files.

A certificate is made once, by `runner.certify`, and never changed: diagnosis and bias make a new one by
`dataclasses.replace`. Grade, exit status and the list of what is wrong are computed from the findings whenever they are
asked for, so that they cannot disagree with them. The module also writes the certificate as JSON and as JUnit XML; the
page and the badge are in `report`. It runs no check.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import resources
from json import loads
from typing import Any
from xml.etree import ElementTree

import numpy as np

from leakref._output import envelope, plain
from leakref.certify.checks.draw import PUBLISHED
from leakref.certify.checks.registry import FAMILIES
from leakref.certify.subject.declaration import Declaration
from leakref.certify.subject.frames import OWN, waves_in_words
from leakref.certify.verdict import WRONG, Finding, Known, Verdict
from leakref.dispersion import Water
from leakref.scope import current_words, seas_words, water_words

__all__ = ["CONFORMANT", "MUST", "NO_GRADE", "REJECTED", "SOUND", "Certificate", "junit", "schema"]

CONFORMANT, SOUND, REJECTED = "conformant", "sound", "rejected"  # grades
"""The grades, as they stand in the JSON and on the page; a certificate by which nothing could be judged has none."""
NO_GRADE = "no grade"
"""What stands in the place of a grade, for people."""
MUST = ("signs", "recovery", "leakage")
"""Of each of these families a code that measures velocities must have answered half of what its declaration admits."""


@dataclass(frozen=True, eq=False)
class Certificate:
    """All findings of one run over a `target`, with its `declaration` as printed on it.

    `known` are the failures that were said to be known; `diagnosis` the faults of the reference that reproduce the
    failures, best first, with an `explanation` in words; `departs_at` the first stage that goes its own way. `bias` and
    `stress` say how large its errors are, also of poor sensors (full profile; `leakref.certify.measures`).

    - `target`: as on the command line; `profile`: `quick` or `full`; `golden`: the set compared with, such as `v1`.
    - `declaration`: what the code says of itself, as `Declaration.record` gives it.
    - `findings`: one for each check and case, in the order of the families, whatever order they were found in.
    - `known`: by finding id; `diagnosis`: records of `Hypothesis`, empty where nothing fell short or nothing explains
      it.
    - `departs_at`: `window`, `synthesize`, `spectrum` or `extract`, or empty.
    - `bias`, `stress`: their records, empty in the quick profile and where no velocities are offered.
    - `seconds`: wall time of the run; `date`: when it ended, in UTC.
    - `seed`: of the questions that are drawn (`checks.draw`); `only`: the patterns by which some were chosen, if any.
    - `methods`: those it was judged by; `alike`: those of the reference as which it answers a broad sea; `scales`: the
      peak wavenumbers at which it answered; `waters`: in which it did, scaled, each with such a scale; `fastest`: the
      strongest current it was asked for, in c0; `handled`: the samples of all cubes times wavenumbers, what the judging
      cost.
    - `cut_short`: where the run was interrupted, in words, empty if it came to its end; `unasked`: how many questions
      were left then.
    - `again`: the command that repeats the run; empty where it was not run by one.
    - `examination`: of one by files the digests of questions and answers, and their numbers; empty of a code that ran.
    """

    target: str
    profile: str
    golden: str
    declaration: Mapping[str, Any]
    findings: Sequence[Finding]
    known: Mapping[str, Known] = field(default_factory=dict)
    diagnosis: Sequence[Mapping[str, Any]] = ()
    explanation: str = ""
    departs_at: str = ""
    bias: Sequence[Mapping[str, Any]] = ()
    stress: Sequence[Mapping[str, Any]] = ()
    seconds: float = 0.0
    date: str = ""
    seed: int = PUBLISHED
    only: Sequence[str] = ()
    methods: Sequence[str] = ()
    alike: Sequence[str] = ()
    scales: Sequence[float] = ()
    waters: Sequence[tuple[Water, float]] = ()
    fastest: float = 0.0
    handled: float = 0.0
    cut_short: str = ""
    unasked: int = 0
    again: str = ""
    examination: Mapping[str, Any] = field(default_factory=dict)

    @property
    def counts(self) -> dict[str, int]:
        """How many findings there are of each verdict that occurs, by its word (`pass`, `fail`, ...)."""
        return dict(Counter(str(f.verdict) for f in self.findings))

    @property
    def judged(self) -> list[Finding]:
        """Findings that say something of the implementation.

        That is all but `unsupported`, what it does not offer, and `missing`, what it offers and did not answer.
        """
        return [f for f in self.findings if f.verdict not in (Verdict.UNSUPPORTED, Verdict.MISSING)]

    @property
    def coverage(self) -> dict[str, int]:
        """How many questions were asked, judged, missing and unsupported; it stands beside the grade everywhere."""
        counts = self.counts
        return {
            "asked": len(self.findings),
            "judged": len(self.judged),
            **{str(v): counts.get(str(v), 0) for v in (Verdict.MISSING, Verdict.UNSUPPORTED)},
        }

    @property
    def thin(self) -> list[tuple[str, int, int]]:
        """Families of which less than half was judged of what the declaration admits: their name, judged, admitted.

        Looked at are those of `MUST`; for a code that offers no velocities, all that were asked. Where nothing of the
        signs could be asked that is too little as well: nobody knows then which way its velocities point.
        """
        found = []
        for family in MUST if self.offers("extract") else FAMILIES:
            asked = [f for f in self.findings if f.family == family]
            admitted = [f for f in asked if f.verdict is not Verdict.UNSUPPORTED]
            judged = sum(f.verdict is not Verdict.MISSING for f in admitted)
            if 2 * judged < len(admitted) or (family == "signs" and self.offers("extract") and asked and not admitted):
                found.append((family, judged, len(admitted)))
        return found

    @property
    def set_number(self) -> int:
        """Of the golden set."""
        return int(self.golden.removeprefix("v"))

    def offers(self, stage: str) -> bool:
        """Whether its declaration offers a stage."""
        return stage in self.declaration.get("can", {})

    @property
    def stale(self) -> list[Known]:
        """Known failures that were looked for and did not fail: the list is out of date, which is an error.

        One whose check was not run, or could not be judged, is not stale: nothing is known of it in this run.
        """
        verdicts = {f.id: f.verdict for f in self.findings}
        return [one for one in self.known.values() if verdicts.get(one.id) is Verdict.PASS]

    @property
    def wrong(self) -> list[Finding]:
        """Failures, errors and time-outs, known or not. They decide the grade and are what the diagnosis tries to
        explain.

        What was declared and then refused (`missing`) is not among them, but counts in `grade`.
        """
        return [f for f in self.findings if f.verdict in WRONG]

    @property
    def unexpected(self) -> list[Finding]:
        """Those of them that are not known."""
        return [f for f in self.wrong if f.id not in self.known]

    @property
    def grade(self) -> str | None:
        """Conformant, sound or rejected (guide protocol, section 12); None if too little could be judged.

        Rejected: something outside conformance is wrong. None: nothing is, but less than half of a family of `MUST` was
        judged, or nothing at all, or the run was cut short. Conformant: all that was declared was answered, all of it
        conforms, and something was compared with golden values. Sound: the others. A failure that is known is a
        failure: a list of them changes the exit status and nothing else.

        One that offers nothing but what conformance compares is rejected where something there is wrong, since nothing
        else speaks for it.
        """
        return self._graded(self.wrong)

    def _graded(self, wrong: Sequence[Finding]) -> str | None:
        """The grade, if no more than that was wrong."""
        beyond = any(f.family != "conformance" for f in self.judged)
        if any(f.family != "conformance" for f in wrong) or (wrong and not beyond):
            return REJECTED
        if not self.judged or self.thin or self.unasked:
            return None
        compared = any(f.family == "conformance" for f in self.judged)
        return CONFORMANT if compared and not wrong and not self.coverage["missing"] else SOUND

    @property
    def ok(self) -> bool:
        """Conformant or sound but for what is known, and the list of known failures is up to date."""
        return self._graded(self.unexpected) in (CONFORMANT, SOUND) and not self.stale

    @property
    def status(self) -> int:
        """Exit status: 0 holds, 1 fell short, 3 could not judge.

        These are the exit statuses of `leakref certify`. It is 3 where there is no grade.
        """
        return 3 if self.grade is None else 0 if self.ok else 1

    def record(self) -> dict[str, Any]:
        """The JSON of `leakref certify` (guide protocol, section 14); its schema is `schema()`. All values are plain
        JSON: NaN and what is infinite have become null, arrays lists.
        """
        known = [
            {"id": k.id, "reason": k.reason, "issue": k.issue, "stale": k in self.stale} for k in self.known.values()
        ]
        said = envelope(
            "certify",
            self.ok,
            target=self.target,
            grade=self.grade,
            grade_line=self.grade_line,
            coverage=self.coverage,
            scope=self.scope(),
            seed=self.seed,
            date=self.date,
            complete=not self.cut_short,
            cut_short=self.cut_short,
            profile=self.profile,
            golden=self.golden,
            declaration=self.declaration,
            counts=self.counts,
            seconds=round(self.seconds, 2),
            findings=[f.record() for f in self.findings],
            diagnosis=list(self.diagnosis),
            explanation=self.explanation,
            departs_at=self.departs_at,
            bias=list(self.bias),
            stress=list(self.stress),
            known=known,
            examination=self.examination,
        )
        return dict(plain(said))

    @property
    def grade_line(self) -> str:
        """The grade with what it rests on, as in "conformant, window only, 3 of 124 questions"."""
        stages = list(self.declaration.get("can", {}))
        words = [self.grade or NO_GRADE]
        if stages and not self.offers("extract"):
            words.append(f"{' and '.join('random seas' if one == 'sea' else one for one in stages)} only")
        if waves := waves_in_words(Declaration.read(self.declaration)):
            words.append(f"in {waves}")
        if self.only:
            words.append(f"asked only {', '.join(self.only)}")
        words += ["by examination"] if self.examination else []
        if known := len(self.wrong) - len(self.unexpected):
            words.append(f"known: {known}")
        return ", ".join([*words, f"{len(self.judged)} of {len(self.findings)} questions"])

    def scope(self) -> dict[str, Any]:
        """What the questions covered, for the JSON; `words` say it for a reader.

        Lengths and speeds are in metres and m/s for a code in SI, else in units of `1 / k0` and `c0`.
        """
        declared = Declaration.read(self.declaration)
        si, usual = declared.units == "si", declared.scales()
        waves = sorted(float(2 * np.pi * usual.length / scale) for scale in self.scales)
        shown = [(water, declared.scales(scale)) for water, scale in self.waters]
        ripples = [(water.to_units(units), units.length) for water, units in shown if water.surface_tension > _FELT]
        felt = np.inf if "depth" in declared.water and "depth" not in declared.told else _DEEP
        usual_ones = [(water, units) for water, units in shown if water.surface_tension < _FELT]
        depths = sorted(float(water.depth * units.length) for water, units in usual_ones if water.depth < felt)
        deep = len(depths) < len(usual_ones)
        found = {
            "depth": "deep" if not depths else "deep and finite" if deep or depths[0] < depths[-1] else depths[0],
            "depths": [depths[0], depths[-1]] if depths else [],
            "surface_tension": max((float(water.surface_tension) for water, _ in ripples), default=0.0),
            "ripples": 2 * np.pi * min((length for _, length in ripples), default=0.0),
            "units": ("m", "m/s") if si else ("1/k0", "c0"),
            "peak_wavelength": 2 * np.pi * usual.length,
            "peak_wavelengths": [waves[0], waves[-1]] if waves else [],
            "fastest_current": self.fastest * usual.velocity,
            "stages": list(self.declaration.get("can", {})),
            "methods": list(self.methods),
            "windows": list(declared.windows) if self.offers("extract") else [],
            "golden": self.golden,
            "seed": self.seed,
            "only": list(self.only),
        }
        return {**found, "words": _in_words(found, si)}

    def families(self) -> list[tuple[str, dict[str, int]]]:
        """Counts of verdicts of each family that was run. They come in the order of `FAMILIES`, each with a count for
        every verdict that occurs in it.
        """
        return [
            (family, dict(Counter(str(f.verdict) for f in self.findings if f.family == family)))
            for family in FAMILIES
            if any(f.family == family for f in self.findings)
        ]


def _in_words(scope: Mapping[str, Any], si: bool) -> str:
    """The scope for a reader: which water, waves and currents, and what was asked of the code in them."""
    asked = [
        f"{name}s {', '.join(values)}" if len(values) > 1 else f"{name} {values[0]}"
        for name, values in (("window", scope["windows"]), ("method", scope["methods"]))
        if values
    ]
    if scope["methods"] == [OWN]:
        asked[-1] = "no method named, so held to no digits (declare nsp or ls to be)"
    unit = scope["units"][1] + " (c0: sqrt(g / k0))" * (not si)
    current = current_words(scope["fastest_current"], unit, "uniform or changing with depth, ")
    water = water_words(
        scope["depths"],
        scope["surface_tension"],
        deep=scope["depth"] == "deep and finite",
        unit="m" if si else "/ k0",
        felt=f"up to {scope['surface_tension']:.2g}"
        + (f" m3/s2 (waves of {scope['ripples']:.2g} m)" if si else " g / k0^2"),
    )
    if not scope["peak_wavelengths"]:
        seas = seas_words(water, scope["peak_wavelength"] if si else None, scope["fastest_current"], unit)
        stages = [seas if name == "sea" else name for name in scope["stages"]]
        return f"No velocity was judged; offered: {', '.join(stages) or 'nothing'}."
    short, long = scope["peak_wavelengths"]
    if si:
        waves, other = f"linear waves {scope['peak_wavelength']:.3g} m long", f"{short:.3g} to {long:.3g} m"
    else:
        waves, other = (
            "linear waves in scaled units",
            f"{short / 2 / np.pi:.2g} to {long / 2 / np.pi:.2g} times as long",
        )
    waves += f" (in the family scale {other})" * (short < long)
    return f"{water}, {waves}, {current}; {'; '.join(asked)}."


def schema() -> dict[str, Any]:
    """The JSON schema (draft 2020-12) of what `leakref certify --json` prints.

    It is the file `certificate.schema.json` that is shipped with the package; a test holds `Certificate.record` to it.
    """
    return dict(loads(resources.files("leakref.certify").joinpath("certificate.schema.json").read_text("utf-8")))


_DEEP = 19.0  # k0 h from which tanh(k0 h) is 1 to the last bit
_FELT = 1e-3  # S k0^2 / g above which waves are shown for their surface tension
_NOT_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def junit(certificate: Certificate) -> str:
    """JUnit XML: a suite for each family, a case for each finding; unsupported and known ones are skipped.

    A failure is a `failure`, an error or a time-out an `error`. The first suite holds the grade, which fails where the
    exit status is not 0, so that a CI that reads only this file turns red as well; each stale known failure is a failed
    case in a suite of its own. Scope, coverage and seed are properties of the first suite. Returned is the whole text
    of the file, with its XML declaration; characters that XML does not allow are replaced.
    """
    root = ElementTree.Element("testsuites", name=_clean(f"leakref certify {certificate.target}"))
    failed = str(int(certificate.status != 0))
    suite = ElementTree.SubElement(root, "testsuite", name="grade", tests="1", failures=failed)
    properties = ElementTree.SubElement(suite, "properties")
    for name, value in (
        ("grade", certificate.grade_line),
        *certificate.coverage.items(),
        ("scope", certificate.scope()["words"]),
        ("seed", certificate.seed),
        *((f"examination {name}", value) for name, value in certificate.examination.items()),
    ):
        ElementTree.SubElement(properties, "property", name=name, value=_clean(str(value)))
    case = ElementTree.SubElement(suite, "testcase", classname="leakref.grade", name=_clean(certificate.grade_line))
    if certificate.status:
        ElementTree.SubElement(case, "failure", message=f"exit status {certificate.status}")
    for family, _ in certificate.families():
        found = [f for f in certificate.findings if f.family == family]
        suite = ElementTree.SubElement(root, "testsuite", name=family, tests=str(len(found)))
        count: Counter[str] = Counter()
        for f in found:
            case = ElementTree.SubElement(suite, "testcase", classname=f"leakref.{family}", name=_clean(f.id))
            outcome, attributes = _outcome(f, certificate)
            if outcome:
                count[outcome] += 1
                ElementTree.SubElement(case, outcome, attributes).text = _clean(f"{f.message}\n{f.repro}")
        for name, outcome in (("failures", "failure"), ("errors", "error"), ("skipped", "skipped")):
            suite.set(name, str(count[outcome]))
    for known in certificate.stale:
        suite = ElementTree.SubElement(root, "testsuite", name="known failures", tests="1", failures="1")
        case = ElementTree.SubElement(suite, "testcase", classname="leakref.known", name=_clean(known.id))
        ElementTree.SubElement(case, "failure", message="no longer fails: take it off the list")
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _outcome(f: Finding, certificate: Certificate) -> tuple[str, dict[str, str]]:
    """The element of JUnit that a finding becomes, empty for a pass, and its attributes."""
    if f.verdict is Verdict.PASS:
        return "", {}
    if f.verdict in (Verdict.UNSUPPORTED, Verdict.MISSING):
        return "skipped", {"message": str(f.verdict)}
    if f.id in certificate.known:
        return "skipped", {"message": _clean(f"known: {certificate.known[f.id].reason}")}
    return ("failure" if f.verdict is Verdict.FAIL else "error"), {"message": str(f.verdict)}


def _clean(text: str) -> str:
    """Without the characters that XML cannot hold, whatever an implementation has printed."""
    return _NOT_XML.sub("\ufffd", text)
