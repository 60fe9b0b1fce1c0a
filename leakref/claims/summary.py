"""The ledger in ten sentences, each of which follows from the verdict of the statement that it is about.

A sentence says what holds, not what the paper says: where the statement is not reproduced it is turned into its
contrary, and the numbers behind it follow in brackets, so that it can be quoted as it stands. Used by the page.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from leakref.claims.registry import OPEN, REPRODUCED, Finding

__all__ = ["SENTENCES", "summary"]

SENTENCES = {
    "A12": (
        "untapered videos of still water show currents of a tenth of the peak phase velocity and more, of the order of "
        "the group velocity where the spread is below 60 degrees",
        "untapered videos of still water do not show currents of a tenth of the peak phase velocity and more, of the "
        "order of the group velocity where the spread is below 60 degrees",
        "",
    ),
    "G2": (
        "a Hann window reduces the errors in nearly all seas",
        "a Hann window does not reduce the errors in nearly all seas",
        "seas",
    ),
    "A10": (
        "under a Hann window even seas with a spread of 15 degrees show mean currents below both velocity resolutions",
        "under a Hann window seas with a spread of 15 degrees do not show mean currents below both velocity "
        "resolutions alone",
        "shells",
    ),
    "A6": (
        "around the peak spurious currents are negligible in every sea",
        "around the peak spurious currents are not negligible in every sea",
        "shells",
    ),
    "A2": (
        "untapered, waves along an axis seem to run against a current at every wavenumber above the peak",
        "untapered, waves along an axis do not seem to run against a current at every wavenumber above the peak",
        "shells",
    ),
    "A16": (
        "in narrow seas the current across the waves is the soft component, the softer the narrower they are",
        "in narrow seas the current across the waves is not the soft component",
        "shells",
    ),
    "G1": (
        "the narrower the spectrum, in direction or in frequency, the larger are the errors at every wavenumber",
        "a narrower spectrum, in direction or in frequency, does not mean larger errors at every wavenumber",
        "shells",
    ),
    "R6": (
        "a larger area helps more than a longer video at every wavenumber",
        "a larger area does not help more than a longer video at every wavenumber",
        "shells",
    ),
    "U2": (
        "a current leaves the size of the errors what it is in still water",
        "a current does not leave the size of the errors what it is in still water",
        "shells",
    ),
    "N5": (
        "least squares are nowhere better than the normalized scalar product, for practical purposes",
        "least squares are not worse everywhere than the normalized scalar product",
        "shells",
    ),
}
"""Statements that a reader would quote, in the order of the argument: that it holds, that it does not, what is counted.
"""


def summary(findings: Sequence[Finding]) -> list[dict[str, Any]]:
    """`words` and `ids` of each sentence whose statement was evaluated."""
    found = {finding.claim.id: finding for finding in findings}
    return [
        {"words": _sentence(found[id].verdict, *texts, found[id].nearest.figure), "ids": [id]}
        for id, texts in SENTENCES.items()
        if id in found
    ]


def _sentence(verdict: str, holds: str, fails: str, counted: str, figure: Any) -> str:
    """With its numbers, but where a largest value decides: 1 of 1 would say nothing."""
    words = f"whether {holds} is left open" if verdict == OPEN else holds if verdict == REPRODUCED else fails
    numbers = _numbers(figure) if counted else None
    place = f"{'at' if counted == 'shells' else 'in'} {{}} {counted}"
    if numbers is None:
        evidence = ""
    elif numbers["shown"] == numbers["of"]:
        evidence = f" ({place.format('all {of}'.format(**numbers))})"
    else:
        there = place.format("{shown} of {of}".format(**numbers))
        evidence = f" (what the paper says holds {there}, the opposite {place.split()[0]} {numbers['contradicted']})"
    return words[0].upper() + words[1:] + evidence + "."


def _numbers(figure: Any) -> Mapping[str, int] | None:
    """At how many it is shown and contradicted; of a statement of parts, those of the first."""
    if not isinstance(figure, Mapping) or {"shown", "of"} <= figure.keys():
        return figure or None
    return next((part for part in figure.values() if isinstance(part, Mapping)), None)
