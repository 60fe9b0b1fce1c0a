"""Running the checks over an implementation, in several processes of it at once, to a certificate.

Sessions take checks from one queue, each as soon as it is free, so that a slow check does not hold up the others; the
findings are put back into the order of the checks. One session always runs in the calling thread. `select` decides
which checks and cases are asked, and is the only place that knows profiles and patterns. Whether an answer is right is
for the checks, and what all of it amounts to for the certificate.

The whole of it in Python, without a process of its own and without limits:

    session = nullcontext(InProcess(implementation))
    found = certify("mine", [session], select(["signs"], profile="quick"), profile="quick")
    print(found.grade, [finding.message for finding in found.wrong])
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from dataclasses import replace
from datetime import UTC, datetime
from fnmatch import fnmatchcase
from queue import Empty, SimpleQueue
from threading import Event
from time import perf_counter

from leakref._base import LeakrefError
from leakref.certify import checks
from leakref.certify.certificate import Certificate
from leakref.certify.checks import conformance
from leakref.certify.checks.draw import DRAWN, PUBLISHED, Draw
from leakref.certify.checks.registry import FAMILIES, Case, Check
from leakref.certify.subject.frames import Subject
from leakref.certify.verdict import Finding, Known, Verdict

__all__ = ["CutShort", "certify", "run_check", "run_checks", "select"]

Pair = tuple[Check, Case]


class CutShort(KeyboardInterrupt):
    """A run that was interrupted, with the `certificate` of what it had found by then."""

    def __init__(self, certificate: Certificate) -> None:
        super().__init__(certificate.cut_short)
        self.certificate = certificate


def certify(
    target: str,
    subjects: Sequence[AbstractContextManager[Subject]],
    checks: Sequence[Pair],
    *,
    profile: str,
    golden: int = conformance.NEWEST,
    seed: int = PUBLISHED,
    only: Sequence[str] = (),
    known: Mapping[str, Known] | None = None,
    after_each: Callable[[Finding], object] = lambda finding: None,
) -> Certificate:
    """Run `checks` over an implementation and say what they amount to.

    `subjects` are as many independent sessions with it as shall work side by side. The findings are in the order of the
    checks, whichever session made them. Raises LeakrefError for a known failure that is no check's id.

    `checks` are pairs from `select`. `profile`, `golden`, `seed` and `only` are only written down: they have been
    applied by `select`.
    `after_each` is called with every finding, from the thread that made it, as soon as it is there. A code that has
    altered its input in a session where no check looked for it afterwards gets one more finding,
    `behaviour.input[whole-run]`.

    Whatever a session raises on entry is passed on (`ProcessSubject`: LeakrefError, HarnessBroken), as is the
    RuntimeError of `run_checks`. Then, and when it is interrupted, the queue is emptied and every session is ended at
    once; a KeyboardInterrupt becomes CutShort once there is a session.
    """
    known = dict(known or {})
    ids = {identifier for check, _ in select(golden=golden) for identifier, _ in check.ids()}
    if unknown := sorted(set(known) - ids):
        raise LeakrefError(
            "certify",
            f"the known failure {unknown[0]!r} is none of the {len(ids)} there are",
            "correct the id; `leakref certify --list` prints all",
        )
    start = perf_counter()
    waiting: SimpleQueue[int] = SimpleQueue()
    found: dict[int, Finding] = {}
    ended = Event()  # what a session that was ended says of the code is no finding

    def work(subject: Subject) -> None:
        for number in _taken(waiting):
            (finding,) = run_checks([checks[number]], subject)
            if not ended.is_set():
                found[number] = finding
                after_each(finding)

    opened: list[Subject] = []

    def asked(subject: Subject) -> list[int]:
        """Of the checks. What a code that knows one water only, makes no seas, or lacks a method, is not asked does not
        stand on its certificate.
        """
        seas, own = subject.offers("sea"), subject.declaration.methods
        return [
            n
            for n, (c, case) in enumerate(checks)
            if (not case.water or subject.told)
            and (seas or c.stage != "sea")
            and (not case.method or case.method in own)
        ]

    def open_and_work(session: AbstractContextManager[Subject]) -> None:
        with session as subject:
            opened.append(subject)
            work(subject)

    def made(cut_short: str = "") -> Certificate:
        subject = opened[0]
        return Certificate(
            target,
            profile,
            f"v{golden}",
            subject.declaration.record(),
            [found[number] for number in sorted(found)] + ([] if cut_short else _left_over(opened)),
            known,
            seconds=perf_counter() - start,
            date=datetime.now(UTC).isoformat(timespec="seconds"),
            seed=seed,
            only=only,
            methods=subject.methods if subject.offers("extract") else (),
            alike=sorted(subject.alike or ()),
            scales=sorted({scale for one in opened for scale in one.scales}),
            waters=sorted({water for one in opened for water in one.waters}, key=str),
            fastest=max(one.fastest for one in opened),
            handled=sum(one.handled for one in opened),
            cut_short=cut_short,
            unasked=len(asked(subject)) - len(found),
        )

    first, *others = subjects
    try:
        with first as subject, ThreadPoolExecutor(max(1, len(others))) as threads:
            opened.append(subject)
            for number in asked(subject):
                waiting.put(number)
            try:
                beside = [threads.submit(open_and_work, session) for session in others]
                work(subject)
                for done in beside:
                    done.result()
            except BaseException:
                ended.set()
                deque(_taken(waiting), maxlen=0)
                for session in subjects:
                    getattr(session, "interrupt", bool)()  # what they are at is not waited for
                raise
    except KeyboardInterrupt:
        if not opened:
            raise
        left = f"interrupted after {len(found)} of {len(asked(opened[0]))} questions"
        raise CutShort(made(left)) from None
    return made()


def _left_over(subjects: Sequence[Subject]) -> list[Finding]:
    """What an implementation did to its input in a session in which no check has looked for it since. Such violations
    are noted by the session and read by a check of behaviour; those after the last such check would be lost.
    """
    done = list(dict.fromkeys(violation for subject in subjects for violation in subject.violations))
    return (
        [
            Finding(
                "behaviour.input[whole-run]",
                "behaviour",
                Verdict.FAIL,
                "; ".join(done),
                label="protocol",
                repro="leakref certify TARGET --only behaviour --keep FOLDER",
            )
        ]
        if done
        else []
    )


def _taken(waiting: SimpleQueue[int]) -> Iterator[int]:
    """Numbers from the queue until it is empty: sessions that end early leave theirs to the others."""
    while True:
        try:
            yield waiting.get_nowait()
        except Empty:
            return


def select(
    patterns: Sequence[str] = (), *, profile: str = "full", golden: int = conformance.NEWEST, seed: int = PUBLISHED
) -> list[tuple[Check, Case]]:
    """Checks and cases whose id, check or family matches one of the patterns (default: all) in a profile.

    Conformance is to golden set number `golden`; the families of `draw.DRAWN` ask the questions of `seed`. Raises
    LeakrefError for a pattern that matches nothing in any profile, and for what is no seed.

    A pattern is an id (`recovery.pair[...]`), a check (`recovery.pair`), a family (`recovery`), or one of the first two
    with `*` and `?`; brackets in it stand for themselves. `profile` `full` means every case, anything else those marked
    quick. The pairs returned are in the order of `FAMILIES`, and may be none where a pattern matches only cases of the
    other profile.
    """
    Draw(seed)  # refused here if it is none
    order, every = {family: n for n, family in enumerate(FAMILIES)}, checks.load()
    if golden != conformance.NEWEST:
        every = {**every, **conformance.of_set(golden)}
    found = [
        (identifier, c, case)
        for c in sorted(every.values(), key=lambda c: order[c.family])
        for identifier, case in c.ids()
    ]

    def matches(pattern: str, identifier: str, c: Check) -> bool:
        if not {"*", "?"}.intersection(pattern):
            return pattern in (identifier, c.id, c.family)
        return any(fnmatchcase(name, pattern.replace("[", "[[]")) for name in (identifier, c.id))

    for pattern in patterns:
        if not any(matches(pattern, identifier, c) for identifier, c, _ in found):
            raise LeakrefError(
                "checks",
                f"no check is called {pattern!r}",
                f"families are {', '.join(FAMILIES)}; `leakref certify --list` prints all ids",
            )
    return [
        (c, replace(case, seed=seed) if c.family in DRAWN else case)
        for identifier, c, case in found
        if (profile == "full" or case.quick)
        and (not patterns or any(matches(pattern, identifier, c) for pattern in patterns))
    ]


def run_check(identifier: str, subject: Subject) -> Finding:
    """One check on one case by the id of its finding.

    Raises LeakrefError for what is not the id of one finding.
    """
    (c, case), *others = select([identifier])
    if others:
        raise LeakrefError("run_check", f"{identifier!r} names {1 + len(others)} findings", "give the id of one")
    return c(subject, case)


def run_checks(
    pairs: Sequence[tuple[Check, Case]],
    subject: Subject,
    after_each: Callable[[Finding], object] = lambda finding: None,
) -> list[Finding]:
    """All findings. A fault of a check itself is not the implementation's: it is raised, with the id.

    `after_each` is called with every finding. LeakrefError, OSError and MemoryError are those of the harness and are
    passed on as they are; any other exception of a check becomes a RuntimeError that names the check. An exception of
    the implementation never gets here: it is a finding with the verdict `error`.
    """
    findings = []
    for c, case in pairs:
        try:
            finding = c(subject, case)
        except (LeakrefError, OSError, MemoryError):  # of the harness, such as a disk that is full
            raise
        except Exception as error:
            raise RuntimeError(f"check {c.id}[{case.id}] is broken: {type(error).__name__}: {error}") from error
        findings.append(finding)
        after_each(finding)
    return findings
