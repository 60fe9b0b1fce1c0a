"""The pictures of inferred depths, from the records that `inferredtables` makes: what is stored is drawn as what is
new.

Depths are shown over the true one, so that 1 is right; a shell or a domain in which fewer than half of the realisations
have a depth is drawn hollow, and one in which none has is left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from leakref._base import FloatArray
from leakref.figures import COLOURS, WINDOW_WORDS, figure, save, styled

__all__ = ["domains_figure", "draw", "shells_figure"]

_LOOKS = {"box": (COLOURS[1], "s", -1), "hann": (COLOURS[0], "o", 1)}
_CURRENT_WORDS = {"known": "current known", "along": "current inferred along"}
Record = dict[str, Any]


def draw(out: Path, records: Sequence[Record]) -> list[Path]:
    """The figures to the folder `out`, PNG and SVG each: of every domain's shells, and of all domains' bands.

    One domain gives `figure_inferred_depth`, several `figure_inferred_depth_L10_T20` and so on, and
    `figure_inferred_depth_domains`.
    """
    sizes = list(dict.fromkeys((r["length"], r["duration"]) for r in records))
    paths = []
    for length, duration in sizes:
        members = [r for r in records if (r["length"], r["duration"]) == (length, duration)]
        name = f"_L{length:g}_T{duration:g}" if len(sizes) > 1 else ""
        paths += save(shells_figure(members), out / f"figure_inferred_depth{name}")
    if len(sizes) > 1:
        paths += save(domains_figure(records), out / "figure_inferred_depth_domains")
    return paths


def _numbers(values: Any) -> FloatArray:
    """As floats, NaN for null."""
    return np.asarray(values, dtype=np.float64)


def _points(ax: Any, x: FloatArray, part: Record, realizations: int, window: str, **look: Any) -> None:
    """Means with one standard deviation, of h over the true one: filled where at least half have a depth."""
    colour, marker, _ = _LOOKS[window]
    ratio, random, count = 1 + _numbers(part["bias"]), _numbers(part["random"]), _numbers(part["count"])
    there = np.isfinite(ratio)
    ax.vlines(x[there], *(np.maximum(ratio + s * np.nan_to_num(random), 0.02)[there] for s in (-1, 1)), colour, lw=1.1)
    many = 2 * count >= realizations
    for chosen, fill in ((there & many, colour), (there & ~many, "white")):
        ax.plot(x[chosen], ratio[chosen], marker, ms=4.5, mfc=fill, mec=colour, ls="", zorder=3, **look)


def _depth_axis(ax: Any, low: float, high: float, ticks: Sequence[float]) -> None:
    ax.axhline(1, color="black", lw=0.9, zorder=0)
    ax.set_yscale("log")
    ax.set_ylim(low, high)
    ax.yaxis.set_major_locator(FixedLocator(list(ticks)))
    ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.yaxis.set_minor_locator(NullLocator())


def _legend(drawing: Figure, ax: Any, windows: Sequence[str], realizations: str) -> None:
    for window in windows:
        colour, marker, _ = _LOOKS[window]
        ax.plot([], [], marker, color=colour, label=WINDOW_WORDS[window])
    ax.plot([], [], "o", mfc="white", mec="0.4", ls="", label="fewer than half have a depth")
    ax.plot([], [], color="0.4", lw=1.1, label=f"one standard deviation of {realizations}")
    handles, labels = ax.get_legend_handles_labels()
    drawing.legend(handles, labels, loc="outside lower center", ncols=len(labels))


@styled
def shells_figure(records: Sequence[Record]) -> Figure:
    """A column for each depth, a row for what is known of the current: h over the true depth against wavenumber.

    To the right of the line the depth of the whole band, "all". Grey: wavenumbers whose waves are those of deep water,
    k h > pi. `records` are of one domain.
    """
    depths = sorted({r["kh"] for r in records})
    windows = [w for w in _LOOKS if any(r["window"] == w for r in records)]
    drawing, axes = figure(2, len(depths), width=max(5.0, 2.5 * len(depths)), height=2.6, sharex=True, sharey=True)
    for r in records:
        ax = axes[list(_CURRENT_WORDS).index(r["current"]), depths.index(r["kh"])]
        k = _numbers(r["shells"]["wavenumbers"])
        aside = 0.022 * _LOOKS[r["window"]][2]
        _points(ax, k + aside, r["shells"], r["realizations"], r["window"])
        band = {name: [value] for name, value in r["band"].items()}
        _points(ax, np.array([k[-1] + 0.3 + 2 * aside]), band, r["realizations"], r["window"])
    for (row, column), ax in np.ndenumerate(axes):
        kh, last = depths[column], float(k[-1])
        _depth_axis(ax, 0.18, 3.5, (0.2, 0.3, 0.5, 0.7, 1, 1.5, 2, 3))
        ax.axvline(last + 0.13, color="0.6", lw=0.8)
        if np.pi / kh < last + 0.13:
            ax.axvspan(max(np.pi / kh, 0.3), last + 0.13, color="0.9", zorder=-1)
        ax.set_xlim(0.3, last + 0.45)
        ax.set_xticks([0.5, 1, 1.5, 2, last + 0.3], ["0.5", "1", "1.5", "2", "all"])
        ax.set_title(f"$k_0 h$ = {kh:g}: {list(_CURRENT_WORDS.values())[row]}", fontsize=9)
        if row:
            ax.set_xlabel("$k$ / $k_0$")
        if not column:
            ax.set_ylabel("inferred / true depth")
    number = f"{records[0]['realizations']} realisations"
    _legend(drawing, axes[0, 0], windows, number)
    size = f"$L$ = {records[0]['length']:g}, $T$ = {records[0]['duration']:g}"
    drawing.suptitle(
        f"What leakage does to a depth inferred from single wavenumbers and, right, from all of them ({size})\n"
        "nothing is drawn where no depth can be told; grey: waves too short to feel the bottom",
        fontsize=10,
    )
    return drawing


@styled
def domains_figure(records: Sequence[Record]) -> Figure:
    """A panel for each depth: the depth of the whole band, the current inferred along, over the true one, by domain.

    Domains in the order of length and duration.
    """
    chosen = [r for r in records if r["current"] == "along"]
    depths = sorted({r["kh"] for r in chosen})
    sizes = sorted({(r["length"], r["duration"]) for r in chosen})
    windows = [w for w in _LOOKS if any(r["window"] == w for r in chosen)]
    columns = min(2, len(depths))
    panels = -(-len(depths) // columns)
    drawing, axes = figure(panels, columns, width=9.0, height=2.6, sharex=True, sharey=True)
    for r in chosen:
        ax = axes.flat[depths.index(r["kh"])]
        x = np.array([sizes.index((r["length"], r["duration"])) + 0.13 * _LOOKS[r["window"]][2]])
        _points(ax, x, {name: [value] for name, value in r["band"].items()}, r["realizations"], r["window"])
    for kh, ax in zip(depths, axes.flat, strict=False):
        _depth_axis(ax, 0.77, 1.65, (0.8, 0.9, 1, 1.1, 1.2, 1.3, 1.4, 1.6))
        ax.set_title(f"$k_0 h$ = {kh:g}")
        ax.set_xticks(range(len(sizes)), [f"{length:g}, {duration:g}" for length, duration in sizes])
        ax.set_xlim(-0.5, len(sizes) - 0.5)
        for n in range(1, len(sizes)):
            if sizes[n][0] != sizes[n - 1][0]:
                ax.axvline(n - 0.5, color="0.7", lw=0.8)
    for ax in axes[-1]:
        ax.set_xlabel("domain: $L$ wavelengths, $T$ periods")
    for ax in axes[:, 0]:
        ax.set_ylabel("inferred / true depth")
    numbers = sorted({r["realizations"] for r in chosen})
    counted = f"{numbers[0]} to {numbers[-1]} realisations" if len(numbers) > 1 else f"{numbers[0]} realisations"
    _legend(drawing, axes[0, 0], windows, counted)
    drawing.suptitle(
        "The depth inferred with the current from all wavenumbers, by size of the domain\n"
        "nothing is drawn where no depth can be told",
        fontsize=10,
    )
    return drawing
