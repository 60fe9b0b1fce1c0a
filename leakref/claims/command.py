"""`leakref claims`: the statements evaluated, as a table, as JSON and as pictures.

It evaluates (`evaluate`), prints (`table`) and writes. The verdict of a claim is `registry.Finding`'s; a statement of
the paper that is not reproduced is a result, and so the command succeeds. Ensembles come from `evidence`, resumed from
the folder that `leakref reproduce` uses as well.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from leakref import runs
from leakref._output import console, dump, envelope, folder, progress_bar
from leakref._tables import Table
from leakref.claims.evidence import Evidence
from leakref.claims.registry import NOT_REPRODUCED, OPEN, REPRODUCED, Finding, select
from leakref.claims.stored import write

__all__ = ["evaluate", "run", "table"]

_COLOURS = {REPRODUCED: "green", NOT_REPRODUCED: "red", OPEN: "yellow"}


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
    ids: Sequence[str],
    *,
    realizations: int,
    place: Path,
    workers: int,
    figures: bool,
    out: Path | None,
    json: bool,
    readings: bool = False,
) -> bool:
    """Evaluate, print, write; True: a claim that is not reproduced is a result, not a failure.

    With `out`, a folder, the findings are written there as a page to be read, `claims.html`, and as JSON, a claim a
    line, as in `golden/claims.json`; with `figures` a picture of every reading of each goes to `place`. `readings`
    prints every reading of a claim, not the nearest alone.
    """
    findings = evaluate(ids, realizations=realizations, place=place, workers=workers)
    result = envelope("claims", True, realizations=realizations, claims=[finding.record() for finding in findings])
    if out is not None:
        from leakref.claims.page import write_page

        write(folder(out) / "claims.json", result, ("claims",))
        console().print(f"[dim]{write_page(findings, realizations, out)}[/dim]", soft_wrap=True)
    if figures:
        from leakref.claims.pictures import draw

        paths = [path for finding in findings for path in draw(finding, place)]
        console().print(f"[dim]{len(paths)} pictures in {place}[/dim]")
    if json:
        print(dump(result))
    else:
        Console().print(table(findings, realizations))
        for finding in findings if len(findings) <= 3 or readings else ():  # a few: what is behind them
            for part in _behind(finding, readings):
                Console().print(part)
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

    A row a claim, with the figure of its nearest reading.
    """
    result = Table(
        title=f"The paper's claims, {realizations} realisations",
        caption_justify="left",
        caption="The verdict is that of the reading nearest to the words; firm: all others say the same, else on what "
        "it turns. Figure: shells where it is shown beyond two standard errors / shells, those against it, mean "
        "margin. `leakref claims ID` shows what is behind it",
    )
    for name in ("id", "claim", "verdict", "firm", "figure"):
        result.add_column(name)
    for finding in findings:
        parts = [f"{name}: [{_COLOURS[verdict]}]{verdict}[/]" for name, verdict in finding.parts.items()]
        apart = parts if len(set(finding.parts.values())) > 1 else []
        result.add_row(
            finding.claim.id,
            finding.claim.words,
            "\n".join([f"[{_COLOURS[finding.verdict]}]{finding.verdict}[/]", *apart]),
            "yes" if finding.robust else f"no: {', '.join(finding.depends_on) or 'open'}",
            _short(finding.nearest.figure),
        )
    return result


_ANSWERS = {True: "[green]yes[/]", False: "[red]no[/]", None: "[yellow]open[/]"}


def _behind(finding: Finding, every: bool) -> Iterator[Table | str]:
    """The nearest reading of one claim, where it holds, and the others: each, or how many say what."""
    claim = finding.claim
    head = Table(title=f"{claim.id} ({claim.label}): {finding.verdict}", caption=claim.test, caption_justify="left")
    for name in ("reading", "holds", "figure"):
        head.add_column(name)
    for reading in finding.readings if every else finding.readings[:1]:
        head.add_row(reading.words, _ANSWERS[reading.holds], _short(reading.figure))
    yield head
    if finding.where:
        where = Table(title="Where, by k / k0", title_justify="left")
        for name in ("part", "sea", "shown", "contradicted", "open"):
            where.add_column(name)
        for line in finding.where:
            where.add_row(*(line.get(name, "") for name in ("part", "sea", "shown", "contradicted", "open")))
        yield where
    if finding.would_decide:
        yield f"What would decide it: {finding.would_decide}."
    others = finding.readings[1:]
    if others and not every:
        counts = [
            f"{sum(r.holds is answer for r in others)} {words}"
            for answer, words in ((True, "hold"), (False, "do not"), (None, "open"))
        ]
        turns = f"; it turns on {', '.join(finding.depends_on)}" if finding.depends_on else ""
        yield f"{len(others)} other readings: {', '.join(counts)}{turns}. --readings shows them."
