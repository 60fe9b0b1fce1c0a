"""Failures that are known: what an entry of their list is, and reading it from a file."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from leakref._base import LeakrefError, refusal

__all__ = ["Known", "read_known"]


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
