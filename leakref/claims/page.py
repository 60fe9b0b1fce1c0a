"""The ledger as one page: by section of the paper, each statement with its verdict, how firm it is, and where.

Everything on it comes from the findings: the page computes nothing and is readable without scripts, on paper too. Used
by `leakref claims --out`.
"""

from __future__ import annotations

from base64 import b64encode
from collections import Counter
from collections.abc import Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from leakref import __version__
from leakref._output import template, write_whole
from leakref.claims.pictures import where_figure
from leakref.claims.registry import NOT_REPRODUCED, UNTOLD, Finding
from leakref.claims.summary import summary

__all__ = ["SECTIONS", "page", "write_page"]

SECTIONS = {
    "abstract": "Abstract",
    "Introduction": "Introduction",
    "sec:leakage": "Spectral leakage and windowing",
    "sec:NSP_and_leakage": "The normalized scalar product method and spectral leakage",
    "sec:DSV_example": "Results: the effect of windowing",
    "sec:angwidth": "Results: mean propagation direction and angular spread",
    "sec:peakedness": "Results: peakedness",
    "sec:resolution": "Results: resolutions",
    "sec:current": "Results: a background current",
    "sec:conclusions": "Conclusions",
    "app:window_comparison": "Appendix: comparison of window functions",
    "app:numdetails": "Appendix: details of numerical implementation",
    "sec:LSvsNSP": "Appendix: NSP and a basic LS algorithm",
}
"""Sections of the paper by label, in its order."""


def page(findings: Sequence[Finding], realizations: int) -> str:
    """The text of the page, with every picture inside. A claim stands in the first section that its label names."""
    sections = {
        label: [_row(finding) for finding in findings if finding.claim.label.partition(",")[0] == label]
        for label in SECTIONS
    }
    return template("claims.html").render(
        sections=[(SECTIONS[label], rows) for label, rows in sections.items() if rows],
        counts=Counter(finding.verdict for finding in findings),
        robust=sum(finding.robust for finding in findings),
        nearly=sum(finding.verdict == NOT_REPRODUCED and _at_most_shells(finding) for finding in findings),
        summary=summary(findings),
        realizations=realizations,
        version=__version__,
    )


def write_page(findings: Sequence[Finding], realizations: int, place: Path) -> Path:
    """Write `claims.html` to the folder `place`; the path is returned."""
    text = page(findings, realizations)
    return write_whole(place / "claims.html", lambda path: path.write_text(text, encoding="utf-8"))


def _at_most_shells(finding: Finding) -> bool:
    """Every part is shown at over half of its shells.

    It is what a reader should know of a statement that is not reproduced because a few wavenumbers are against it.
    """
    tallies = finding.nearest.tallies.values()
    return bool(tallies) and all(tally.most for tally in tallies)


def _counts(finding: Finding) -> list[str]:
    """Of each part at how many shells, or seas, it is shown, and at how many contradicted."""
    tallies = finding.nearest.tallies
    return [
        f"{name.replace('_', ' ')}: " * (len(tallies) > 1) + _counted(tally.figure) for name, tally in tallies.items()
    ]


def _place(line: Mapping[str, str], parts: Mapping[str, str]) -> str:
    """A line of `Finding.where`: part, sea, and the wavenumbers at which it is shown, contradicted and open."""
    name = ", ".join(filter(None, (line["part"] if parts else "", line["sea"])))
    states = [f"{state} {line[state]}" for state in ("shown", "contradicted", "open") if state in line]
    return f"{name or 'all'}: {'; '.join(states)}"


def _row(finding: Finding) -> Mapping[str, Any]:
    """What the page says of one claim. The readings that say the same stand together."""
    claim, answers = finding.claim, {True: "holds", False: "does not hold", None: "open"}
    others = {words: [r.words for r in finding.readings[1:] if r.holds is answer] for answer, words in answers.items()}
    return {
        "id": claim.id,
        "words": claim.words,
        "test": claim.test,
        "verdict": finding.verdict,
        "kind": {"reproduced": "conformant", "not reproduced": "rejected"}.get(finding.verdict, "unjudged"),
        "robust": finding.robust,
        "counts": _counts(finding),
        "turns": [choice for choice in finding.depends_on if choice != UNTOLD],
        "open_too": UNTOLD in finding.depends_on,
        "would_decide": finding.would_decide,
        "parts": finding.parts,
        "reading": finding.nearest.words,
        "figure": _figures(finding.nearest.figure),
        "where": [_place(line, finding.parts) for line in finding.where],
        "others": {words: some for words, some in others.items() if some},
        "picture": _encoded(where_figure(finding)),
    }


def _figures(figure: Any, name: str = "") -> list[tuple[str, str]]:
    """A figure as lines of a name and a number, nested ones with their names joined."""
    if isinstance(figure, Mapping):
        if {"shown", "of"} <= set(figure):
            lines = [(name or "comparisons", _counted(figure))]
            rest = {
                {"lacking_numbers": "of which some realisations have no number"}.get(k, k): v
                for k, v in figure.items()
                if k not in ("shown", "contradicted", "of", "mean_margin")
            }
            return lines + _figures(rest, name)
        return [line for key, value in figure.items() for line in _figures(value, f"{name}: {key}" if name else key)]
    return [(name.replace("_", " "), ", ".join(map(str, figure)) if isinstance(figure, list) else str(figure))]


def _counted(figure: Mapping[str, Any]) -> str:
    """Counts of comparisons in words."""
    return f"{figure['shown']} of {figure['of']}" + (f", {n} against" if (n := figure["contradicted"]) else "")


def _encoded(drawing: Figure) -> str:
    """As PNG in base64."""
    kept = BytesIO()
    drawing.savefig(kept, format="png", dpi=110)
    return b64encode(kept.getvalue()).decode("ascii")
