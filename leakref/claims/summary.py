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
        "untapered videos of still water can show currents of a tenth of the peak phase velocity and more, of the "
        "order of the group velocity where the spread is below 60 degrees",
        "untapered videos of still water cannot show currents of a tenth of the peak phase velocity and more, of the "
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
        "comparisons",
    ),
    "A6": (
        "also untapered, the mean spurious current about the peak is negligible in still water",
        "untapered, the mean spurious current about the peak is not always negligible in still water",
        "comparisons",
    ),
    "A2": (
        "untapered, narrow waves along an axis seem to run against a current at every wavenumber above the peak",
        "untapered, narrow waves along an axis do not seem to run against a current at every wavenumber above the peak",
        "comparisons",
    ),
    "A16": (
        "in narrow seas the current across the waves is the soft component, the softer the narrower they are",
        "in narrow seas the current across the waves is not the soft component",
        "comparisons",
    ),
    "G1": (
        "untapered, the narrower the spectrum, the larger are the errors at every wavenumber",
        "untapered, a narrower spectrum does not mean larger errors at every wavenumber",
        "comparisons",
    ),
    "R6": (
        "under a Hann window a larger area helps more than a longer video at every wavenumber",
        "under a Hann window a larger area does not help more than a longer video at every wavenumber",
        "comparisons",
    ),
    "U2": (
        "untapered, a current leaves the size of the errors what it is in still water, at every wavenumber",
        "untapered, a current does not leave the size of the errors what it is in still water, at every wavenumber",
        "comparisons",
    ),
    "N5": (
        "in untapered videos least squares are nowhere better than the normalized scalar product",
        "in untapered videos least squares are not worse everywhere than the normalized scalar product",
        "comparisons",
    ),
}
"""Statements that a reader would quote, in the order of the argument: that it holds, that it does not, what is counted.
"""


def summary(findings: Sequence[Finding]) -> list[dict[str, Any]]:
    """`words` and `ids` of each sentence whose statement was evaluated."""
    found = {finding.claim.id: finding for finding in findings}
    return [{"words": _sentence(found[id], *texts), "ids": [id]} for id, texts in SENTENCES.items() if id in found]


def _sentence(finding: Finding, holds: str, fails: str, counted: str) -> str:
    """With its numbers, part by part, but where a largest value decides: 1 of 1 would say nothing."""
    verdict, figure = finding.verdict, finding.nearest.figure
    words = f"whether {holds} is left open" if verdict == OPEN else holds if verdict == REPRODUCED else fails
    parts = [f"{name.replace('_', ' ')}, {_told(figure[name], counted)}" for name in finding.nearest.parts]
    told = "; ".join(parts or [_told(figure, counted)])
    whose = "" if verdict == REPRODUCED else "the paper's statement: "
    return words[0].upper() + words[1:] + (f" ({whose}{told})" if counted else "") + "."


def _told(numbers: Mapping[str, int], counted: str) -> str:
    """In how many of what is counted it is shown and contradicted."""
    shown, against, of = (numbers[name] for name in ("shown", "contradicted", "of"))
    return (
        f"shown in all {of} {counted}"
        if shown == of
        else f"shown in {shown} of {of} {counted}, contradicted in {against or 'none'}"
    )
