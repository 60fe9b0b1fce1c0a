"""What is said of an implementation: verdicts, findings, why there may be no answer, and failures that are known.

All of certify speaks in these terms, and this module imports none of it. Words of a program under test pass through
`printable` before they are shown anywhere.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any

from leakref._base import LeakrefError, refusal

__all__ = ["WRONG", "Absent", "Finding", "Known", "Refused", "Unanswered", "Verdict", "printable", "read_known"]


def printable(text: Any, longest: int = 300) -> str:
    """Words of a program that is not trusted, on one line, without control characters and marks of direction, cut.

    `longest` is in characters of the result; what is cut ends in three dots.
    """
    line = "".join(c if c.isprintable() else " " for c in str(text)[: 4 * longest])
    line = " ".join(line.split())
    return line if len(line) <= longest else line[: longest - 3] + "..."


class Verdict(StrEnum):
    """Of one check on one case.

    PASS and FAIL are of a number that was compared, or of a behaviour that was looked at. A time-out is a run that gave
    no answer within its limit; the program is then ended and started again. Its words are those in the JSON.
    """

    PASS = "pass"
    FAIL = "fail"
    MISSING = "missing"
    "it was asked and declined every number that the check is about"
    UNSUPPORTED = "unsupported"
    "it does not offer what the check is about"
    ERROR = "error"
    "it raised, crashed, or broke the protocol"
    TIMEOUT = "timeout"


WRONG = (Verdict.FAIL, Verdict.ERROR, Verdict.TIMEOUT)
"""What speaks against an implementation."""


@dataclass(frozen=True)
class Finding:
    """One check on one case. `digits` of agreement where a number was compared; `repro` shows how to see it again.

    `figures` are the numbers behind the message, by name, for reports and for the study of the suite's strength; `over`
    is the error over the tolerance: above 1 it fails. `calls` are the answers if it did not pass, for the diagnosis.

    - `id`: `family.check[case]`; `family`: a key of `FAMILIES`; `label`: the paper's equation, or `protocol`.
    - `message`: what was found, beside what should have been, in words.
    - `digits`: None where nothing is compared digit by digit.
    - `over`: None where there was no number; NaN counts as a failure.
    - `repro`: a command line with TARGET in the place of the target.
    - `figures`: arrays or dictionaries of them; they are not in the JSON.
    - `calls`: `Call` objects, in the order asked; empty if it passed.
    """

    id: str
    family: str
    verdict: Verdict
    message: str
    digits: float | None = None
    over: float | None = None
    repro: str = ""
    label: str = ""
    figures: dict[str, Any] = field(default_factory=dict)
    calls: tuple[Any, ...] = field(default=(), repr=False)

    def record(self) -> dict[str, Any]:
        """As in the JSON of `leakref certify` (guide protocol, section 14).

        `figures` and `calls` are left out: they are large, and for reports and the diagnosis only.
        """
        return {
            "id": self.id,
            "family": self.family,
            "verdict": str(self.verdict),
            "message": self.message,
            "digits": self.digits,
            "over": self.over,
            "repro": self.repro,
            "label": self.label,
        }


class Unanswered(Exception):
    """An implementation gave no answer that could be judged: the verdict for the check that asked.

    Whatever of the message is in its own words can be printed anywhere.

    - `verdict`: `unsupported`, `missing`, `fail`, `error` or `timeout`.
    - `message`: one line of at most 1500 characters, cleaned by `printable`.

    It is raised by subjects and by checks, and turned into a finding in one place, `Check.__call__`.
    """

    def __init__(self, verdict: Verdict, message: str) -> None:
        self.verdict, self.message = verdict, printable(message, 1500)
        super().__init__(self.message)


class Refused(Unanswered):
    """It declares what was asked of it and says that it will not: missing."""

    def __init__(self, message: str) -> None:
        super().__init__(Verdict.MISSING, f"refused: {message}")


class Absent(Unanswered):
    """A question that nobody has answered, as in an examination that was left off: missing in the end.

    Until then it is not taken for a refusal, which may be the right answer, or lead to another question: as one of what
    is not offered it ends the check that asked.
    """

    def __init__(self, message: str) -> None:
        super().__init__(Verdict.UNSUPPORTED, message)


@dataclass(frozen=True)
class Known:
    """A failure that is known: why it is accepted for now, and where it is being dealt with.

    - `id`: of the finding, `family.check[case]`.
    - `reason`: in words, never empty.
    - `issue`: where it is tracked, an address or a number; from a file never empty, from `parametrize_with_checks`
      maybe.

    A failure that is listed here counts in the grade as any other, and not in the exit status. One that is listed and
    passes makes the list stale, and the certificate not `ok`.
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
