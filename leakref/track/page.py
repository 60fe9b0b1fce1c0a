"""The history as pictures and as a page: bias against version with its steps, and against wavenumber.

It draws what the history holds and measures nothing. Every version is compared with the one before it, by `changes` and
with its margins, and what is called a step is what is called better or worse there. Used by `leakref track plot`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from leakref import __version__
from leakref._output import template
from leakref.figures import COLOURS, figure
from leakref.track.changes import ALPHA, BANDS, MARGIN, VERDICTS, Change, Comparison, compare, in_band
from leakref.track.history import Entry, History
from leakref.track.tracking import Series

__all__ = ["Version", "curves_figure", "levels_figure", "page", "versions"]

_GRADES = {0: ("no rise", "sound"), 1: ("worse", "rejected"), 3: ("not compared", "unjudged")}  # by exit status
_MOST = 5
"""Curves in one picture: the first version, the last, and those with the latest steps between."""


@dataclass(frozen=True, eq=False)
class Version:
    """An entry with its series by case, window and method, and its `step` from the one before, None for the first.

    `series` are keyed by case, window and method; `step` is a Comparison with the version before.
    """

    entry: Entry
    series: Mapping[tuple[str, str, str], Series]
    step: Comparison | None

    def steps(self, key: tuple[str, str, str] | None = None) -> list[Change]:
        """Bands that are better or worse than in the version before; all of them, or those of one series."""
        return [
            change
            for change in (self.step.changes if self.step else ())
            if not change.single
            and change.verdict in ("better", "worse")
            and key in (None, (change.case, change.window, change.method))
        ]


def versions(entries: Sequence[Entry], cases: Sequence[str] = (), *, margin: float = MARGIN) -> list[Version]:
    """Entries in order, each compared with the one before; of the `cases` named, or of all.

    `margin` is a part of the smaller resolution. Raises Trouble for an entry whose measurements are not whole.
    """
    found: list[Version] = []
    for entry in entries:
        series = [Series.read(kept) for kept in entry.record["measurements"]]
        own = {one.key: one for one in series if not cases or one.case in cases}
        step = compare(list(found[-1].series.values()), list(own.values()), margin=margin) if found else None
        found.append(Version(entry, own, step))
    return found


def _grid(shown: Sequence[Version], case: str) -> tuple[list[str], list[str]]:
    """Windows and methods there are of a case."""
    keys = [key for one in shown for key in one.series if key[0] == case]
    return list(dict.fromkeys(key[1] for key in keys)), list(dict.fromkeys(key[2] for key in keys))


def levels_figure(shown: Sequence[Version], case: str) -> Figure:
    """Mean error of each band over the mean resolution in it, against version, with its standard error.

    Triangles mark steps, up for worse and down for better. A line ends where the case is not the same any more. Colours
    are the bands of `changes.BANDS`; there is an axis for each window and method.
    """
    windows, methods = _grid(shown, case)
    drawing, axes = figure(len(methods), len(windows), width=9.0, height=2.6, sharex=True)
    for row, method in enumerate(methods):
        for column, window in enumerate(windows):
            ax, key = axes[row, column], (case, window, method)
            for colour, (low, high) in zip(COLOURS, BANDS, strict=False):
                _level(ax, shown, key, (low, high), colour)
            ax.set_title(f"{window}, {method}")
            ax.set_ylabel("mean error / resolution")
            ax.set_ylim(bottom=0)
            ax.set_xlim(-0.5, len(shown) - 0.5)
            ax.grid(alpha=0.25)
            ax.set_xticks(range(len(shown)), [one.entry.label for one in shown], rotation=90 if len(shown) > 4 else 0)
    for ax in axes[-1]:
        ax.set_xlabel("version")
    _legend(drawing, axes, f"{shown[-1].entry.target}: {case}")
    return drawing


def _legend(drawing: Figure, axes: Any, title: str) -> None:
    """One below all axes, each label once; and the title above, which says whose versions these are."""
    once: dict[str, Any] = {}
    for ax in axes.flat:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            once.setdefault(label, handle)
    drawing.legend(once.values(), once.keys(), loc="outside lower center", ncols=6, frameon=False)
    drawing.suptitle(title, fontsize=9)


def _level(
    ax: Any, shown: Sequence[Version], key: tuple[str, str, str], band: tuple[float, float], colour: str
) -> None:
    """One band of one series over the versions; a line for each digest of the case, since others cannot be compared."""
    low, high = band
    name = f"{low:g} to {high:g}"
    rows: list[tuple[int, float, float, str]] = []
    for n, one in enumerate(shown):
        series = one.series.get(key)
        if series is None:
            continue
        inside = in_band(series.wavenumbers, low, high)
        if inside.any() and np.isfinite(errors := series.errors[:, inside]).any():
            each = np.nanmean(errors[np.isfinite(errors).any(axis=1)], axis=1) / series.resolution[inside].mean()
            spread = each.std(ddof=1) / np.sqrt(each.size) if each.size > 1 else 0.0
            rows.append((n, float(each.mean()), float(spread), series.digest))
    for digest in dict.fromkeys(row[3] for row in rows):
        x, y, spread, _ = zip(*(row for row in rows if row[3] == digest), strict=True)
        ax.errorbar(x, y, spread, color=colour, marker="o", ms=3.5, lw=1.2, capsize=2, label=f"k = {name}")
    heights = {row[0]: row[1] for row in rows}
    for n, one in enumerate(shown):
        for change in one.steps(key):
            if change.band == name and n in heights:
                worse = change.verdict == "worse"
                ax.plot(
                    n,
                    heights[n],
                    "^" if worse else "v",
                    color="#b3261e" if worse else "#00695c",
                    ms=9,
                    zorder=5,
                    label=change.verdict,
                )


def curves_figure(shown: Sequence[Version], case: str) -> Figure:
    """Mean error against wavenumber of at most five versions; what is below the smaller resolution is grey.

    They are the first, the last, and those between with the latest steps. Wavenumbers are in `k0`, errors in `c0`.
    """
    stepped = [one for one in shown[1:-1] if one.steps()][-(_MOST - 2) :]
    chosen = [one for one in shown if one in (shown[0], *stepped, shown[-1])]
    windows, methods = _grid(chosen, case)
    drawing, axes = figure(len(methods), len(windows), width=9.0, height=2.6, sharex=True)
    for row, method in enumerate(methods):
        for column, window in enumerate(windows):
            ax = axes[row, column]
            ends: list[float] = []
            for n, one in enumerate(chosen):
                if (series := one.series.get((case, window, method))) is not None:
                    ax.fill_between(
                        series.wavenumbers,
                        1e-9,
                        series.resolution,
                        color="0.92",
                        lw=0,
                        zorder=0,
                        label="below the resolution",
                    )
                    ax.plot(
                        series.wavenumbers,
                        series.bias,
                        color=COLOURS[n],
                        lw=2.6 - 0.45 * n,
                        ls=("-", "--")[n % 2],
                        marker="o" if len(series.wavenumbers) == 1 else "",
                        label=one.entry.label,
                    )
                    ends += [
                        float(v) for v in (np.nanmin(series.bias), np.nanmax(series.bias), series.resolution.max())
                    ]
            if ends:
                ax.set_ylim(min(ends) / 2, max(ends) * 1.5)
            ax.set_yscale("log")
            ax.set_ylabel("mean error / $c_0$")
            ax.set_title(f"{window}, {method}")
            ax.grid(alpha=0.25)
    for ax in axes[-1]:
        ax.set_xlabel("$k$ / $k_0$")
    _legend(drawing, axes, f"{shown[-1].entry.target}: {case}")
    return drawing


def page(history: History, shown: Sequence[Version], pictures: Sequence[Mapping[str, str]]) -> str:
    """One self-contained page. `pictures`: title, words, and data, PNG in base64.

    `shown` must not be empty; the grade on top is that of the last step. The text of the HTML file is returned.
    """
    last = shown[-1]
    grade, kind = _GRADES[last.step.status if last.step else 3]
    return template("history.html").render(
        target=last.entry.target,
        grade=grade,
        grade_class=kind,
        sentence=_sentence(last),
        faults=history.faults,
        versions=[_row(one) for one in shown],
        path=history.path.name,
        version=__version__,
        timings=_timings(shown),
        steps=[{"label": one.entry.label, "change": change} for one in shown for change in one.steps()],
        confidence=f"{100 * (1 - ALPHA):g} %",
        margin=f"{100 * MARGIN:g} %",
        pictures=pictures,
    )


def _sentence(last: Version) -> str:
    """What the last step came to, for the top of the page."""
    if last.step is None:
        return f"{last.entry.label} is the first version: nothing to compare it with."
    worse, compared = len(last.step.worse), len(last.step.changes)
    return " ".join(
        [
            f"{worse} of {compared} comparisons of {last.entry.label} with the version before it are worse "
            "beyond the margin.",
            *(f"{one}." for one in last.step.unlike),
        ]
    )


def _row(one: Version) -> dict[str, Any]:
    """A version in the table: label, date, step, system, source, and how many realisations."""
    record = one.entry.record
    counts = (
        [(verdict, sum(change.verdict == verdict for change in one.step.changes)) for verdict in VERDICTS]
        if one.step
        else []
    )
    said = ", ".join(f"{count} {verdict}" for verdict, count in counts if count)
    if one.step and one.step.unlike:
        said = ", ".join([*([said] if said else []), f"{len(one.step.unlike)} of other cases"])
    system = f"leakref {record['leakref']}, NumPy {record['numpy']}, SciPy {record['scipy']}, {record['platform']}"
    sizes = sorted({len(series.errors) for series in one.series.values()})
    return {
        "label": one.entry.label,
        "recorded": record["recorded"][:10],
        "step": said,
        "system": system,
        "source": record["source"]["sha256"][:8],
        "realizations": " or ".join(map(str, sizes)),
    }


def _timings(shown: Sequence[Version]) -> dict[str, Any] | None:
    """Ratios of all versions that share the last yardstick. None if no version has any."""
    timed = [(one.entry.label, one.entry.record["timings"]) for one in shown if one.entry.record["timings"]]
    if not timed:
        return None
    same = [(label, kept) for label, kept in timed if kept["yardstick"] == timed[-1][1]["yardstick"]]
    names = dict.fromkeys(name for _, kept in same for name in kept["ratios"])
    rows = [(name, [kept["ratios"].get(name, {"ratio": None})["ratio"] for _, kept in same]) for name in names]
    return {"yardstick": timed[-1][1]["yardstick"], "labels": [label for label, _ in same], "rows": rows}
