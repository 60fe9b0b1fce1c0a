"""`leakref claims --decisions`: how far each decision moves the velocities, as a table, as JSON and as a figure.

What is kept in `golden/decisions.json` is printed unless it is to be computed, which takes long. The study and the
judging are `shifts`'; here are the table, the record and the figure's call.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from leakref import LeakrefError, runs
from leakref._output import console, dump, envelope, folder, progress_bar
from leakref._tables import Table
from leakref.claims import CLAIMS
from leakref.claims.registry import position
from leakref.claims.shifts import MOVED, Shifts, moving, rejudged, study, summary
from leakref.claims.stored import stored_decisions, write
from leakref.claims.variants import CONFIGURATIONS, NONE, VARIANTS, Variant
from leakref.decisions import DECISIONS

__all__ = ["computed", "run", "table"]

_ALL = "all"


def computed(*, realizations: int, judged: int, place: Path, workers: int, full: bool) -> dict[str, Any]:
    """The study of all variants, and the claims under those that move a velocity by more than 10 % of a resolution.

    With `realizations` of each configuration for the study and `judged` for the claims. `full`: every claim; else those
    that need no other configurations than the eight. Both go on where they stopped. Under `decisions` each has its
    question, the reference's answer, the claims that turn and its variants with a row for each sea, window and method;
    under `claims` what became of each claim under each variant.
    """
    parts = folder(place) / "parts"
    with runs.pool(workers) as executor:
        with progress_bar("realisations", realizations * len(CONFIGURATIONS)) as step:
            found = study(realizations=realizations, folder=parts, executor=executor, after_each=step)
        variants = moving(found)
        with progress_bar("claims", len(CLAIMS)) as step:
            claims = rejudged(
                variants,
                list(CLAIMS.values()),
                realizations=judged,
                folder=parts,
                executor=executor,
                ids=None if full else CONFIGURATIONS,
                after_each=step,
            )
    return envelope(
        "claims",
        True,
        realizations=realizations,
        judged_realizations=judged,
        configurations=CONFIGURATIONS,
        full=full,
        decisions=[_decision(id, found, variants, claims) for id in DECISIONS],
        claims=claims,
    )


def _decision(
    id: str, found: dict[str, list[list[Shifts]]], judged: Sequence[Variant], claims: Sequence[dict[str, Any]]
) -> dict[str, Any]:
    """A decision with its variants, their rows, and the claims that turn under any of them."""
    decision = DECISIONS[id]
    variants = [
        {"id": v.id, "words": v.words, "paired": v.paired, "claims_judged": v in judged, "rows": _rows(found[v.id])}
        for v in VARIANTS.values()
        if v.decision == id
    ]
    turned = sorted({claim["id"] for claim in claims if claim["decision"] == id and claim["flipped"]}, key=position)
    return {
        "id": id,
        "question": decision.question,
        "reference": decision.reference,
        "no_effect": NONE.get(id),
        "claims_that_turn": turned,
        "variants": variants,
    }


def _rows(cases: list[list[Shifts]]) -> list[dict[str, Any]]:
    """A row for all configurations together and one for each, for every method and window."""
    kinds: dict[tuple[str, str], list[Shifts]] = {}
    for one in cases:
        for shifts in one:
            kinds.setdefault((shifts.reference.method, shifts.reference.window), []).append(shifts)
    return [
        row
        for members in kinds.values()
        for row in (summary(members, _ALL), *(summary([s], s.reference.configuration.id) for s in members))
    ]


def run(
    ids: Sequence[str],
    *,
    realizations: int,
    judged: int,
    place: Path,
    workers: int,
    figures: bool,
    out: Path | None,
    full: bool,
    json: bool,
) -> bool:
    """Print what is kept in golden/, or with `out` or `full` compute it; True: an effect is a result, not a failure.

    `ids` of decisions: only those are shown. Raises LeakrefError for an unknown one.
    """
    unknown = [id for id in ids if id.upper() not in DECISIONS]
    if unknown:
        raise LeakrefError("claims", f"no decision is called {unknown[0]!r}", f"choose from {', '.join(DECISIONS)}")
    wanted = {id.upper() for id in ids} or set(DECISIONS)
    fresh = full or out is not None
    result = (
        computed(realizations=realizations, judged=judged, place=place, workers=workers, full=full)
        if fresh
        else stored_decisions()
    )
    if out is not None:
        write(out, result, ("decisions", "claims"))
    result = {
        **result,
        "decisions": [record for record in result["decisions"] if record["id"] in wanted],
        "claims": [record for record in result["claims"] if record["decision"] in wanted],
    }
    if figures:
        from leakref.claims.pictures import decisions_figure
        from leakref.figures import save

        paths = save(decisions_figure(result), folder(place) / "decisions")
        console().print(f"[dim]{', '.join(map(str, paths))}[/dim]")
    if json:
        print(dump(result))
    else:
        for part in table(result):
            Console().print(part)
    return True


def _number(spread: dict[str, Any], unit: str, which: str) -> str:
    """In two digits; what is below rounding as 0."""
    if not spread["shells"]:
        return "-"
    value = spread[unit][which]
    return "0" if value < (MOVED if unit == "c0" else 1e-7) else f"{value:.2g}"


def _cells(row: dict[str, Any]) -> list[str]:
    """Median, 95th percentile and largest in `c0`, and the largest over the resolution, red from a tenth on."""
    spread = row["unflagged"]
    share = _number(spread, "resolution", "largest")
    return [
        *(_number(spread, "c0", which) for which in ("median", "p95", "largest")),
        f"[red]{share}[/red]" if share not in ("0", "-") and float(share) > 0.1 else share,
    ]


def table(result: dict[str, Any]) -> list[Table]:
    """The shifts over all configurations, a row for each variant, method and window; and the claims that turn."""
    count, seas = result["realizations"], len(result["configurations"])
    shown = Table(
        title=f"Velocities if a decision is taken otherwise: {count} realisations of {seas} seas",
        caption="|c' - c| in c0 over shells without a note: median, 95th percentile, largest; the largest "
        "over the smaller velocity resolution (red: over 10 %); change of the mean error with its "
        "standard error. 0: below 1e-9. Italic: other waves, so that only the mean can be compared",
        caption_justify="left",
    )
    for name in ("", "instead", "method", "window"):
        shown.add_column(name)
    for name in ("median", "95 %", "largest", "share", "mean error", "no number"):
        shown.add_column(name, justify="right")
    for record in result["decisions"]:
        if record["no_effect"]:
            shown.add_row(record["id"], f"[dim]no velocity moves: {record['no_effect']}[/dim]")
        for variant in record["variants"]:
            words = variant["words"] if variant["paired"] else f"[italic]{variant['words']}[/italic]"
            for n, row in enumerate(row for row in variant["rows"] if row["case"] == _ALL):
                change = row["bias_change"]
                mean = f"{change['mean']:+.1e} ± {change['standard_error']:.0e}" if change else ""
                shown.add_row(
                    record["id"] if n == 0 else "",
                    words if n == 0 else "",
                    row["method"],
                    row["window"],
                    *_cells(row),
                    mean,
                    str(row["lost"] or ""),
                )
        shown.add_section()
    return [shown, _turned(result)]


def _turned(result: dict[str, Any]) -> Table:
    """By variant the claims of which a reading turns, and how many readings; in bold if the verdict is another then."""
    judged, variants = ({claim[key] for claim in result["claims"]} for key in ("id", "variant"))
    shown = Table(
        title=f"Claims that turn ({len(judged)} claims under {len(variants)} variants, "
        f"{result['judged_realizations']} realisations each)",
        caption_justify="left",
        caption="How many readings turn, of all: held and do not, or the reverse; bold: the verdict is "
        "another then (what golden/ keeps was judged before verdicts went by the nearest reading). "
        "Judged are the variants that move some velocity by more than 10 % of the "
        "smaller resolution, and "
        + (
            "all claims about velocities"
            if result["full"]
            else "the claims that need only these seas: " + ", ".join(sorted(judged, key=position))
        ),
    )
    for name in ("", "instead", "claims"):
        shown.add_column(name)
    for variant in (v for v in VARIANTS.values() if v.id in variants):
        turned = [_share(claim) for claim in result["claims"] if claim["variant"] == variant.id and claim["flipped"]]
        shown.add_row(variant.decision, variant.words, ", ".join(turned) or "[dim]none[/dim]")
    return shown


def _share(claim: dict[str, Any]) -> str:
    """The claim and how many of its readings turn, in bold if its verdict is another then."""
    words = f"{claim['id']} {len(claim['flipped'])}/{claim['readings']}"
    return words if claim["before"] == claim["verdict"] else f"[bold]{words}[/bold]"
