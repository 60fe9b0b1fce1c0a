"""`leakref claims`: the statements evaluated, as a table, as JSON and as pictures.

It evaluates (`evaluate`), prints (`table`) and writes. The verdict of a claim is `registry.Finding`'s; a statement of
the paper that is not reproduced is a result, and so the command succeeds. Ensembles come from `evidence`, resumed from
the folder that `leakref reproduce` uses as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from leakref import runs
from leakref._output import console, dump, envelope, folder, progress_bar
from leakref._tables import Table
from leakref.claims.evidence import Evidence
from leakref.claims.registry import DEPENDS, NOT_REPRODUCED, REPRODUCED, Finding, select
from leakref.claims.stored import write

__all__ = ["evaluate", "run", "table"]

_COLOURS = {REPRODUCED: "green", NOT_REPRODUCED: "red", DEPENDS: "yellow"}


def evaluate(
    ids: Sequence[str] = (), *, realizations: int = 100, place: Path | None = None, workers: int = 1
) -> list[Finding]:
    """The claims named (default: all), on ensembles kept in `place` and shared with `leakref reproduce --out`. In the
    order of the paper's list. With `workers` processes. Raises LeakrefError for an unknown id, and for fewer than two
    realisations.
    """
    claims = select(ids)
    with progress_bar("claims", len(claims)) as step, runs.pool(workers) as executor:
        evidence = Evidence(realizations, place and folder(place) / "parts", executor)
        findings = []
        for claim in claims:
            findings.append(claim.judge(evidence))
            step()
    return findings


def run(
    ids: Sequence[str], *, realizations: int, place: Path, workers: int, figures: bool, out: Path | None, json: bool
) -> bool:
    """Evaluate, print, write; True: a claim that is not reproduced is a result, not a failure.

    With `out` the findings are written there, a claim a line, as in `golden/claims.json`; with `figures` a picture of
    each goes to `place`.
    """
    findings = evaluate(ids, realizations=realizations, place=place, workers=workers)
    result = envelope("claims", True, realizations=realizations, claims=[finding.record() for finding in findings])
    if out is not None:
        write(out, result, ("claims",))
    if figures:
        from leakref.claims.pictures import draw

        paths = [path for finding in findings for path in draw(finding, place)]
        console().print(f"[dim]{len(paths)} pictures in {place}[/dim]")
    if json:
        print(dump(result))
    else:
        Console().print(table(findings, realizations))
        for finding in findings if len(findings) <= 3 else ():  # a few: all that is behind them
            Console().print(_readings(finding))
    return True


def _short(figure: Any) -> str:
    """A figure in a few characters: counts of shells as `shown / of`."""
    if isinstance(figure, dict) and {"shown", "of"} <= set(figure):
        against = f", {figure['contradicted']} against" if figure["contradicted"] else ""
        counted = ("shown", "contradicted", "of", "mean_margin")
        rest = {key: value for key, value in figure.items() if key not in counted}
        margin = "" if figure["mean_margin"] is None else f", {figure['mean_margin']:+.3g}"
        return f"{figure['shown']}/{figure['of']}{against}{margin}" + (f"; {_short(rest)}" if rest else "")
    if isinstance(figure, dict):
        return "; ".join(f"{key.replace('_', ' ')} {_short(value)}" for key, value in figure.items())
    return str(figure)


def table(findings: Sequence[Finding], realizations: int) -> Table:
    """Verdict and figure of each claim.

    A row a claim, with the figure of its first reading, which is the nearest to the words.
    """
    result = Table(
        title=f"The paper's claims, {realizations} realisations",
        caption_justify="left",
        caption="figure: shells where it is shown beyond two standard errors / shells, those against it, "
        "mean "
        "margin; of the first reading. `leakref claims ID` shows all readings",
    )
    for name in ("id", "claim", "verdict", "readings", "figure"):
        result.add_column(name)
    for finding in findings:
        holding = sum(reading.holds is True for reading in finding.readings)
        said = f": {', '.join(finding.depends_on)}" if finding.verdict == DEPENDS else ""
        result.add_row(
            finding.claim.id,
            finding.claim.words,
            f"[{_COLOURS[finding.verdict]}]{finding.verdict}[/]{said}",
            f"{holding}/{len(finding.readings)}",
            _short(finding.readings[0].figure),
        )
    return result


def _readings(finding: Finding) -> Table:
    """All readings of one claim, with their answers and figures."""
    claim = finding.claim
    result = Table(title=f"{claim.id} ({claim.label}): {finding.verdict}", caption=claim.test, caption_justify="left")
    for name in ("reading", "holds", "figure"):
        result.add_column(name)
    for reading in finding.readings:
        answer = {True: "[green]yes[/]", False: "[red]no[/]", None: "[yellow]open[/]"}[reading.holds]
        result.add_row(reading.words, answer, _short(reading.figure))
    return result
