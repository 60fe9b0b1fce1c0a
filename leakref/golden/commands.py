"""What `leakref golden ...` prints.

Each function is one action: it calls `linting`, `verifying` or `making`, and prints a table or an envelope in JSON.
Exit statuses come from here (`run_verify`) or are made of a bool by `leakref.cli`. A set that was changed is never
computed against: by wrong numbers nothing can be judged.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from leakref import LeakrefError
from leakref._output import console, dump, envelope, folder, progress_bar
from leakref._tables import Table
from leakref.golden import beside
from leakref.golden.linting import lint
from leakref.golden.sets import Golden, Report, locate

__all__ = ["run_lint", "run_regenerate", "run_verify"]

NOTHING_TO_JUDGE = 3
FILES = "files"


def _opened(number: int, place: Path | None) -> Golden:
    if place is not None and not place.is_dir():
        raise LeakrefError("golden", f"there is no folder {place}", "give that of a golden set, such as golden/v1")
    return Golden(locate(number) if place is None else place.resolve())


def _shown(title: str, report: Report, json: bool, ok: bool, **fields: Any) -> None:
    """The report on standard output, as JSON or as a table with a line for each failure."""
    if json:
        failures = [{"id": f.id, "stage": f.stage, "message": f.message} for f in report.failures]
        print(
            dump(
                envelope(
                    "golden", ok, action=title, sets=report.sets, values=report.values, failures=failures, **fields
                )
            )
        )
        return
    table = Table(title=f"golden {title}: {report.values} values")
    for column in (report.sets or [{"name": ""}])[0]:
        table.add_column(column, justify="left" if column in ("name", "set", "state") else "right")
    for row in report.sets:
        table.add_row(*(str(value) for value in row.values()))
    show = Console()
    show.print(table)
    for failure in report.failures:
        show.print(f"[red]FAILS[/red]  {failure}", soft_wrap=True, highlight=False)
    show.print("[green]holds[/green]" if ok else f"{len(report.failures)} fell short")


def _linted(golden: Golden, place: Path | None) -> Report:
    """The set and, unless it stands alone, what lies beside it."""
    report = lint(golden)
    folder = beside.home() if place is None else place.resolve().parent
    if place is not None and not folder.joinpath(beside.MANIFEST).is_file():
        return report
    row, failures = beside.lint(folder)
    return Report([*report.sets, row], report.values, [*report.failures, *failures])


def run_lint(number: int, place: Path | None, *, json: bool) -> bool:
    """Whether the set is whole and unchanged, and so is what lies beside it.

    `number` is that of an installed set, `place` a folder instead of it. A set in a folder of its own, without a
    manifest beside it, is judged alone.
    """
    report = _linted(_opened(number, place), place)
    _shown("lint", report, json, report.ok)
    return report.ok


def run_verify(
    wanted: Sequence[str],
    number: int,
    place: Path | None,
    *,
    full: bool,
    route: str,
    work: Path,
    workers: int,
    json: bool,
) -> int:
    """0 if everything computed again agrees, 1 if not, 3 if the set was changed or there was nothing to compute.
    `route` is `A` or `B`, for ensembles only. LeakrefError is raised for another route, a folder that is not there and
    an id that no entry has.
    """
    golden = _opened(number, place)
    if route not in ("A", "B"):
        raise LeakrefError("golden", f"no route named {route!r}", "choose A (surface and FFT) or B (closed form)")
    report = lint(golden)
    whole = not report.failures  # by what was changed nothing can be judged
    if whole:
        from leakref.golden import verifying

        kept = folder(work) if full or wanted else None
        with progress_bar("golden entries", len(verifying.looked_at(golden, full or bool(wanted), wanted))) as step:
            report = verifying.verify(
                golden, full=full, wanted=wanted, route=route, work=kept, workers=workers, step=step
            )
    _shown("verify", report, json, report.ok, full=full)
    return 0 if report.ok else 1 if report.failures and whole else NOTHING_TO_JUDGE


def run_regenerate(
    wanted: Sequence[str], number: int, place: Path | None, *, work: Path, workers: int, json: bool
) -> bool:
    """Whether nothing differs that was not named; see `making.regenerate`. `files` are those beside the sets.

    Afterwards the set is linted, and what is amiss makes the result False, too. The table names only what is not the
    same as before; `--json` names all.
    """
    from leakref.golden import ids, making

    target = (place or Path(str(locate(number)))).resolve()
    values = [name for name in wanted if name != FILES]
    rows: list[dict[str, Any]] = []
    settled = True
    if values or not wanted:
        folder(work)
        with progress_bar("golden entries", len(values) or len(ids.ids(*("vectors", "analytic")))) as step:
            rows, settled = making.regenerate(values, target, work=work, workers=workers, step=step)
    if FILES in wanted:
        rows += [
            {"id": f"golden/{name}", "change": "digest", "largest": None, "over_tolerance": None, "written": True}
            for name in beside.record(target.resolve().parent)
        ]
    report = _linted(Golden(target), place) if settled else Report([], 0)
    ok = settled and not report.failures
    if json:
        _shown("regenerate", report, True, ok, changes=rows)
        return ok
    table = Table(title=f"golden regenerate: {len(rows)} entries computed, those that are not the same")
    for column, justify in (
        ("id", "left"),
        ("changed", "left"),
        ("largest", "right"),
        ("over tolerance", "right"),
        ("written", "left"),
    ):
        table.add_column(column, justify=justify)
    for row in rows:
        if row["change"] != "same":
            figures = ["" if row[key] is None else f"{row[key]:.2g}" for key in ("largest", "over_tolerance")]
            table.add_row(row["id"], row["change"], *figures, "yes" if row["written"] else "beside, as .new.json")
    Console().print(table)
    for failure in report.failures:
        console().print(f"[red]FAILS[/red]  {failure}", soft_wrap=True)
    if not settled:
        console().print("Nothing was taken over: name the ids to have them written.")
    return ok
