"""The ledger in ten sentences, each of which follows from the verdict of the statement that it is about."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from leakref.claims.registry import NOT_REPRODUCED, OPEN, REPRODUCED, Finding

__all__ = ["SENTENCES", "summary"]

SENTENCES = {
    "A12": "untapered videos of still water show currents of a significant fraction of the peak phase velocity",
    "G2": "a Hann window reduces the errors in nine of ten seas",
    "A10": "under a Hann window even the narrowest seas show mean currents below both velocity resolutions alone",
    "A6": "around the peak spurious currents are negligible",
    "A2": "untapered, waves along an axis seem to meet a current against them at all wavenumbers above the peak",
    "A16": "in narrow seas the current across the waves is the soft component",
    "G1": "the narrower the spectrum, in direction or in frequency, the larger the errors at every wavenumber",
    "R6": "a larger area helps more than a longer video at every wavenumber",
    "U2": "a current leaves the size of the errors what it is in still water",
    "N5": "least squares are nowhere better than the normalized scalar product, for practical purposes",
}
"""Statements that a reader would quote, in the order of the argument."""
_SAID = {
    REPRODUCED: "It holds that {}",
    NOT_REPRODUCED: "It does not hold that {}",
    OPEN: "It is open, for the scatter of so many seas, whether {}",
}


def summary(findings: Sequence[Finding]) -> list[dict[str, Any]]:
    """`words` and `ids` of each sentence whose statement was evaluated."""
    found = {finding.claim.id: finding for finding in findings}
    return [
        {"words": _SAID[found[id].verdict].format(clause) + _counted(found[id].nearest.figure) + ".", "ids": [id]}
        for id, clause in SENTENCES.items()
        if id in found
    ]


def _counted(figure: Any) -> str:
    """At how many shells, or seas, it is shown and contradicted; of a statement of parts, of the first."""
    if isinstance(figure, Mapping) and {"shown", "of"} <= set(figure):
        return f": shown in {figure['shown']} of {figure['of']} comparisons, contradicted in {figure['contradicted']}"
    parts = [part for part in figure.values() if isinstance(part, Mapping)] if isinstance(figure, Mapping) else []
    return _counted(parts[0]) if parts else ""
