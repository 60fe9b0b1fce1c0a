"""The certificate: what all findings together say of an implementation, as a grade, an exit status and files.

A certificate is made once, by `runner.certify`, and never changed: diagnosis and bias make a new one by
`dataclasses.replace`. Grade, exit status and the list of what is wrong are computed from the findings whenever they are
asked for, so that they cannot disagree with them. The module also reads the list of known failures, and writes the
certificate as JSON and as JUnit XML; the page and the badge are in `report`. It runs no check.
"""

from __future__ import annotations

import re
import tomllib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import resources
from json import loads
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from leakref._base import LeakrefError, refusal
from leakref._output import envelope, plain
from leakref.certify.checks.registry import FAMILIES
from leakref.certify.verdict import WRONG, Finding, Verdict

__all__ = ["CONFORMANT", "REJECTED", "SOUND", "Certificate", "Known", "junit", "read_known", "schema"]

CONFORMANT, SOUND, REJECTED = "conformant", "sound", "rejected"  # grades
"""The grades, as they stand in the JSON and on the page; a certificate by which nothing could be judged has none."""


@dataclass(frozen=True)
class Known:
    """A failure that is known: why it is accepted for now, and where it is being dealt with.

    - `id`: of the finding, `family.check[case]`.
    - `reason`: in words, never empty.
    - `issue`: where it is tracked, an address or a number; from a file never empty, from `parametrize_with_checks`
      maybe.

    A failure that is listed here does not count against the grade. One that is listed and passes makes the list stale,
    and the certificate not `ok`.
    """

    id: str
    reason: str
    issue: str


def read_known(path: Path) -> dict[str, Known]:
    """Known failures by finding id from a TOML file with lines `"id" = {reason = "...", issue = "..."}`.

    Raises LeakrefError for anything else.

    That is a file that cannot be read, is not TOML or not UTF-8, and an entry that lacks one of the two, has anything
    else, or has either of them blank. Ids are not looked up here: `runner.certify` refuses those that no check has.
    """
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise refusal("certify", f"{path} cannot be read ({error.strerror})", "give a TOML file", error) from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise LeakrefError(
            "certify",
            f"{path} is not TOML ({error})",
            'write lines such as "recovery.pair[...]" = {reason = "...", issue = "..."}',
        ) from None
    found = {}
    for identifier, row in table.items():
        given = row if isinstance(row, Mapping) else {}
        if set(given) != {"reason", "issue"} or not all(isinstance(v, str) and v.strip() for v in given.values()):
            raise LeakrefError(
                "certify",
                f"{path}: the entry {identifier!r} should have a reason and an issue, both in words",
                'write "id" = {reason = "...", issue = "..."}',
            )
        found[identifier] = Known(identifier, given["reason"], given["issue"])
    return found


@dataclass(frozen=True, eq=False)
class Certificate:
    """All findings of one run over a `target`, with its `declaration` as printed on it.

    `known` are the failures that were said to be known; `diagnosis` the faults of the reference that reproduce the
    failures, best first, with an `explanation` in words; `departs_at` the first stage that goes its own way. `bias`
    says how biased it is, sea by sea (full profile; `leakref.certify.bias`).

    - `target`: what was judged, as on the command line.
    - `profile`: `quick` or `full`; `golden`: the golden set compared with, such as `v1`.
    - `declaration`: what the code says of itself, as `Declaration.record` gives it.
    - `findings`: one for each check and case, in the order of the families, whatever order they were found in.
    - `known`: by finding id; `diagnosis`: records of `Hypothesis`, empty where nothing fell short or nothing explains
      it.
    - `departs_at`: `window`, `synthesize`, `spectrum` or `extract`, or empty.
    - `bias`: records of `Bias`, empty in the quick profile and where no velocities are offered.
    - `seconds`: wall time of the run.
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
    seconds: float = 0.0

    @property
    def counts(self) -> dict[str, int]:
        """How many findings there are of each verdict.

        Keys are the words of the verdicts (`pass`, `fail`, ...); those that do not occur are left out.
        """
        return dict(Counter(str(f.verdict) for f in self.findings))

    @property
    def judged(self) -> list[Finding]:
        """Findings that say something of the implementation.

        That is all but those of the verdict `unsupported`: what it does not offer speaks neither for nor against it.
        """
        return [f for f in self.findings if f.verdict is not Verdict.UNSUPPORTED]

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

        One that declines every number (`missing`) is not among them, but counts in `grade`.
        """
        return [f for f in self.findings if f.verdict in WRONG]

    @property
    def unexpected(self) -> list[Finding]:
        """Those of them that are not known."""
        return [f for f in self.wrong if f.id not in self.known]

    @property
    def grade(self) -> str | None:
        """Conformant, sound or rejected (guide protocol, section 12); None if nothing could be judged.

        Sound: nothing outside conformance is wrong, and no family was declined as a whole. Conformant: besides, nothing
        in conformance is wrong or declined, and something was compared with golden values. A failure that is known is
        a failure: a list of them changes the exit status and nothing else.

        One that offers nothing but what conformance compares is rejected where it is not conformant, since nothing else
        speaks for it.
        """
        return self._graded(self.wrong)

    def _graded(self, wrong: Sequence[Finding]) -> str | None:
        """The grade, if no more than that was wrong."""
        if not any(f.verdict is not Verdict.MISSING for f in self.judged):
            return None
        if any(f.family != "conformance" for f in wrong) or self._declined():
            return REJECTED
        golden = [f for f in self.judged if f.family == "conformance"]
        complete = golden and not wrong and all(f.verdict is not Verdict.MISSING for f in golden)
        if complete:
            return CONFORMANT
        beyond = any(f.family != "conformance" for f in self.judged)
        return SOUND if beyond else REJECTED  # one that offers nothing else has only the golden values to go by

    def _declined(self) -> list[str]:
        """Families in which it was asked for numbers and gave none. Conformance is left out: a code may decline golden
        values and still be sound.
        """
        verdicts: dict[str, set[Verdict]] = {}
        for f in self.judged:
            verdicts.setdefault(f.family, set()).add(f.verdict)
        return [family for family, seen in verdicts.items() if seen == {Verdict.MISSING} and family != "conformance"]

    @property
    def ok(self) -> bool:
        """Conformant or sound but for what is known, and the list of known failures is up to date."""
        return self._graded(self.unexpected) in (CONFORMANT, SOUND) and not self.stale

    @property
    def status(self) -> int:
        """Exit status: 0 holds, 1 fell short, 3 could not judge.

        These are the exit statuses of `leakref certify`. It is 3 only where no finding was judged as anything but
        `missing`.
        """
        return 3 if self.grade is None else 0 if self.ok else 1

    def record(self) -> dict[str, Any]:
        """The JSON of `leakref certify` (guide protocol, section 14); its schema is `schema()`. All values are plain
        JSON: NaN and what is infinite have become null, arrays lists.
        """
        known = [
            {"id": k.id, "reason": k.reason, "issue": k.issue, "stale": k in self.stale} for k in self.known.values()
        ]
        result: dict[str, Any] = plain(
            envelope(
                "certify",
                self.ok,
                target=self.target,
                grade=self.grade,
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
                known=known,
            )
        )
        return result

    def families(self) -> list[tuple[str, dict[str, int]]]:
        """Counts of verdicts of each family that was run. They come in the order of `FAMILIES`, each with a count for
        every verdict that occurs in it.
        """
        return [
            (family, dict(Counter(str(f.verdict) for f in self.findings if f.family == family)))
            for family in FAMILIES
            if any(f.family == family for f in self.findings)
        ]


def schema() -> dict[str, Any]:
    """The JSON schema (draft 2020-12) of what `leakref certify --json` prints.

    It is the file `certificate.schema.json` that is shipped with the package; a test holds `Certificate.record` to it.
    """
    text = resources.files("leakref.certify").joinpath("certificate.schema.json").read_text(encoding="utf-8")
    return dict(loads(text))


_NOT_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def junit(certificate: Certificate) -> str:
    """JUnit XML: a suite for each family, a case for each finding; unsupported and known ones are skipped.

    A failure is a `failure`, an error or a time-out an `error`. Each stale known failure is a failed case in a suite of
    its own, so that a CI that reads only this file turns red as the exit status does. Returned is the whole text of the
    file, with its XML declaration; characters that XML does not allow are replaced.
    """
    root = ElementTree.Element("testsuites", name=_clean(f"leakref certify {certificate.target}"))
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
