"""The picture of a claim: by how much each comparison behind it holds, at every shell; and that of the decisions.

Pictures are drawn from what a Finding carries, or from the JSON of the decisions: nothing is computed for them. Green
is shown, red contradicted, grey open, as in `words`.
"""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from matplotlib.ticker import MaxNLocator

from leakref.claims.registry import Finding
from leakref.claims.words import Reading, Tally
from leakref.figures import COLOURS, figure, save
from leakref.methods import METHODS
from leakref.window import window

__all__ = ["decisions_figure", "draw", "picture", "where_figure"]

_MOST = 12  # panels
_FAR_OFF = 20  # times the median margin
_LOOKS = {"shown": (COLOURS[2], "o", 2.5), "open": ("0.6", "_", 4), "contradicted": (COLOURS[1], "x", 3.5)}
_ANSWERS = {True: "holds", False: "does not hold", None: "open"}


def draw(finding: Finding, place: Path) -> list[Path]:
    """Write `claim_ID.png` and `.svg` to the folder `place`."""
    return save(picture(finding), place / f"claim_{finding.claim.id}")


def picture(finding: Finding) -> Figure:
    """A panel for each reading and comparison: the margin by which it holds, with two standard errors, against k.

    Readings that rest on the same comparison share a panel, named after the first of them; beyond twelve, the rest is
    left out, and said so. A claim without ensembles (windows, timings) is a panel of its readings.
    """
    panels: list[tuple[str, str, Tally]] = []
    seen = set()
    for reading in finding.readings:
        choices = [chosen for name, chosen in reading.choices.items() if name not in ("holds at", "rises at")]
        for part, tally in reading.tallies.items():
            key = (part, tally.margin.tobytes())
            if key not in seen:
                seen.add(key)
                panels.append((", ".join(choices), part.replace("_", " "), tally))
    if not panels:
        return _list(finding)
    left_out = len(panels) - _MOST
    panels = panels[:_MOST]
    columns = min(3, len(panels))
    rows = -(-len(panels) // columns)
    with mpl.rc_context({"axes.titlesize": 8.6, "font.size": 8.6}):
        drawing, axes = figure(rows, columns, width=3.6 * columns + 0.4, height=2.3)
        for ax, (words, part, tally) in zip(axes.flat, panels, strict=False):
            _panel(ax, tally)
            ax.set_title("\n".join(textwrap.wrap(f"{words}: {part}" if words else part, 46)))
        for ax in axes.flat[len(panels) :]:
            ax.set_axis_off()
        more = f" ({left_out} more panels in the JSON)" if left_out > 0 else ""
        drawing.suptitle("\n".join(textwrap.wrap(f"{_title(finding)}{more}", 36 * columns + 14)), fontsize=9)
    return drawing


def _title(finding: Finding) -> str:
    """Id, statement and verdict, and on which choices it turns."""
    said = f"; turns on {', '.join(finding.depends_on)}" if finding.depends_on else ""
    return f"{finding.claim.id}: {finding.claim.words} — {finding.verdict}{said}"


def where_figure(finding: Finding) -> Figure:
    """Where the nearest reading holds: a row for each part and sea, a mark at each wavenumber. What is pooled over
    shells is shown as its margin with two standard errors; a claim without comparisons as the list of its readings.
    """
    parts = [
        (name.replace("_", " "), sea, tally, tally.sea == sea)
        for name, tally in finding.nearest.tallies.items()
        for sea in dict.fromkeys(tally.sea)
    ]
    if not parts:
        return _list(finding)
    by_shell = any(np.ptp(tally.k[own]) > 0 for _, _, tally, own in parts)
    names = ["\n".join(textwrap.wrap(f"{part}: {sea}" if sea else part, 70)) for part, sea, _, _ in parts]
    lines = max(name.count("\n") + 1 for name in names)
    with mpl.rc_context({"font.size": 8.6}):
        drawing, axes = figure(1, 1, width=8.6, height=0.9 + (0.07 + 0.15 * lines) * len(parts))
        ax = axes[0, 0]
        for row, (_, _, tally, own) in enumerate(parts):
            _where_row(ax, row, tally, own, by_shell)
        ax.set_yticks(range(len(parts)), names)
        ax.set_ylim(len(parts) - 0.4, -0.6)
        ax.grid(visible=False, axis="y")
        if by_shell:
            ax.set_xlabel("$k$ / $k_0$")
        else:
            ax.axvline(0, color="black", lw=0.8)
            ax.set_xlabel("holds by, with two standard errors")
        handles = [
            Line2D([], [], ls="", color=colour, marker=marker, ms=1.6 * size, label=name)
            for name, (colour, marker, size) in _LOOKS.items()
        ]
        drawing.legend(handles=handles, loc="outside upper right", ncols=3)
    return drawing


def _where_row(ax: Any, row: int, tally: Tally, own: Any, by_shell: bool) -> None:
    """One sea: what is shown, open and contradicted at each of its shells; the last drawn is what speaks against."""
    masks = {"shown": tally.shown, "open": ~(tally.shown | tally.contradicted), "contradicted": tally.contradicted}
    for name, mask in masks.items():
        colour, marker, size = _LOOKS[name]
        here = own & mask
        if by_shell:
            ax.plot(tally.k[here], np.full(here.sum(), row), marker, ls="", ms=1.6 * size, color=colour)
        else:
            error = 2 * np.nan_to_num(tally.error[here])
            ax.errorbar(tally.margin[here], np.full(here.sum(), row), xerr=error, fmt=marker, color=colour, lw=0.9)


def _panel(ax: Any, tally: Tally) -> None:
    """One comparison at all its shells; where these have one wavenumber, in the order of the case."""
    by_shell = np.ptp(tally.k) > 0 if tally.size else False
    at = tally.k if by_shell else np.arange(1, tally.size + 1)
    masks = {"shown": tally.shown, "contradicted": tally.contradicted, "open": ~(tally.shown | tally.contradicted)}
    for name, mask in masks.items():
        if mask.any():
            colour, marker, size = _LOOKS[name]
            ax.errorbar(
                at[mask],
                tally.margin[mask],
                2 * tally.error[mask],
                fmt=marker,
                ms=size,
                lw=0.8,
                color=colour,
                label=f"{name} {mask.sum()}",
                alpha=0.8,
            )
    ax.axhline(0, color="black", lw=0.8)
    usual = float(np.median(np.abs(tally.margin))) if tally.size else 0.0
    if usual and np.abs(tally.margin).max() > _FAR_OFF * usual:  # a few would press all others onto the axis
        ax.set_yscale("symlog", linthresh=10.0 ** np.ceil(np.log10(usual)))
    if not by_shell:
        ax.set_xlim(0.5, tally.size + 0.5)
        ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set_xlabel("$k$ / $k_0$" if by_shell else "comparison, in the order of the case")
    ax.set_ylabel("holds by ($c_0$, ratio or °)")
    if tally.size:
        ax.legend(loc="best")


def _list(finding: Finding) -> Figure:
    """The readings in words; for a claim about windows, beside their transforms (fig:leakage_lobes)."""
    of_windows = finding.claim.id[0] == "W"
    with mpl.rc_context({"font.size": 8.6}):
        drawing, axes = figure(
            1, 1 + of_windows, width=9 if of_windows else 6, height=max(2.4, 0.4 + 0.4 * len(finding.readings))
        )
        if finding.claim.id == "W8":
            _plane(axes[0, 0])
        elif of_windows:
            _transforms(axes[0, 0])
        ax = axes[0, -1]
        ax.set_axis_off()
        for row, reading in enumerate(finding.readings):
            ax.text(
                0.0,
                1 - (row + 0.5) / len(finding.readings),
                _lines(reading),
                transform=ax.transAxes,
                va="center",
                color={True: COLOURS[2], False: COLOURS[1], None: "0.4"}[reading.holds],
            )
        drawing.suptitle("\n".join(textwrap.wrap(_title(finding), 100 if of_windows else 66)), fontsize=9)
    return drawing


def _lines(reading: Reading) -> str:
    """A reading in words: whether it holds, what was chosen, its figures."""
    figures = ", ".join(f"{name.replace('_', ' ')} {value}" for name, value in reading.figure.items())
    return "\n".join(textwrap.wrap(f"{_ANSWERS[reading.holds]}: {reading.words} ({figures})", 70))


def _transforms(ax: Any) -> None:
    """The windows of fig:leakage_lobes, with the levels that the claims name."""
    v = np.linspace(0, 24, 4801)
    for name, colour in zip(("box", "hann", "blackman"), COLOURS, strict=False):
        taper = window(name)
        ax.semilogy(
            v, np.maximum(np.abs(taper.transform(v) / taper.transform(0.0)), 1e-7), color=colour, lw=1, label=name
        )
        on_bins = np.maximum(np.abs(taper.transform(v[::200]) / taper.transform(0.0)), 1e-7)
        ax.semilogy(
            v[::200], on_bins, "o", ms=3, color=colour
        )  # points: a wave on a bin is seen at whole offsets alone
    for level in (1e-2, 1e-3):
        ax.axhline(level, color="0.5", lw=0.8, ls="--")
    ax.set_ylim(1e-6, 1.5)
    ax.set_xlabel("offset in bins")
    ax.set_ylabel("|transform| / its largest value")
    ax.legend(loc="upper right")


def _plane(ax: Any) -> None:
    """The box in two dimensions, in decibels, with a circle on which the least is looked for."""
    v = np.linspace(-16, 16, 641)
    height = np.abs(window("box").transform(v) / window("box").transform(0.0))
    power = 20 * np.log10(np.maximum(np.outer(height, height), 1e-5))
    shown = ax.pcolormesh(v, v, power, vmin=-80, vmax=0, cmap="magma", rasterized=True)
    ax.add_patch(Circle((0, 0), 10, fill=False, color="white", lw=1, ls="--"))
    ax.grid(visible=False)
    ax.set_aspect("equal")
    ax.set_xlabel("offset along x in bins")
    ax.set_ylabel("offset along y in bins")
    ax.figure.colorbar(shown, ax=ax, label="box (dB)", shrink=0.8)


_LEAST, _TENTH = 1e-8, 0.1  # of the resolution: the left edge, and what counts as an effect


def decisions_figure(result: dict[str, Any]) -> Figure:
    """How far each variant moves the velocities, from the JSON of `leakref claims --decisions`, a panel a method.

    A line for each variant and window, from the median over a bar to the 95th percentile and a point at the largest
    shift, in units of the smaller resolution; what is below 1e-8 stands at the left edge. Dotted is a tenth of the
    resolution, from where on the claims are judged again.
    """
    methods = {name: record.title for name, record in METHODS.items()}
    rows = {
        method: [
            (
                record["id"],
                variant,
                [row for row in variant["rows"] if row["case"] == "all" and row["method"] == method],
            )
            for record in result["decisions"]
            for variant in record["variants"]
            if any(row["method"] == method for row in variant["rows"])
        ]
        for method in methods
    }
    rows = {method: found for method, found in rows.items() if found}
    most = max(map(len, rows.values()))
    with mpl.rc_context({"font.size": 8.6, "axes.titlesize": 10}):
        drawing, axes = figure(1, len(rows), width=7.6 * len(rows), height=max(2.0, 0.5 + 0.33 * most), sharex=True)
        for ax, (method, variants) in zip(axes[0], rows.items(), strict=True):
            for line, (_, _, members) in enumerate(variants):
                _shift_lines(ax, line, members)
            ax.set_yticks(range(len(variants)), [_label(id, variant) for id, variant, _ in variants])
            ax.set_ylim(len(variants) - 0.4, -0.6)
            ax.set_xscale("log")
            ax.set_xlim(_LEAST / 2, 200)
            for level, look in ((_TENTH, ":"), (1.0, "-")):
                ax.axvline(level, color="0.4", lw=0.9, ls=look, zorder=0)
            ax.set_title(methods[method])
            ax.set_xlabel("shift / smaller resolution")
            ax.set_ylabel("what is done instead, and the decision (D)")
        _shift_legend(drawing)
        drawing.suptitle(
            "How far the velocities move if a decision is taken otherwise: median, 95th percentile, "
            f"largest; {result['realizations']} realisations of {len(result['configurations'])} seas"
        )
    return drawing


_WINDOW_LOOKS = {
    "box": (COLOURS[1], "o", "untapered"),
    "hann": (COLOURS[0], "D", "Hann"),
    "kaiser-bessel": (COLOURS[2], "s", "Kaiser-Bessel"),
}


def _label(id: str, variant: dict[str, Any]) -> str:
    words = textwrap.fill(variant["words"] + ("" if variant["paired"] else " *"), 58)
    return f"{words}  {id}"


def _shift_lines(ax: Any, line: int, rows: list[dict[str, Any]]) -> None:
    """A line for each window at one variant: bar from the median to the 95th percentile, point at the largest."""
    offsets = np.linspace(-0.16, 0.16, len(rows)) if len(rows) > 1 else [0.0]
    for offset, row in zip(offsets, rows, strict=True):
        if row["unflagged"]["shells"]:
            colour, marker, _ = _WINDOW_LOOKS[row["window"]]
            spread = [max(row["unflagged"]["resolution"][name], _LEAST) for name in ("median", "p95", "largest")]
            y = line + offset
            ax.plot(spread[::2], [y, y], color=colour, lw=0.7)
            ax.plot(spread[:2], [y, y], color=colour, lw=2.6, solid_capstyle="butt")
            ax.plot(spread[0], y, "|", color=colour, ms=6, mew=1.4)
            ax.plot(spread[2], y, marker, color=colour, ms=3.6)


def _shift_legend(drawing: Figure) -> None:
    handles = [
        Line2D([], [], color=colour, marker=marker, ms=4, lw=2, label=words)
        for colour, marker, words in _WINDOW_LOOKS.values()
    ]
    handles.append(Line2D([], [], ls="", label="* other waves: what chance does"))
    handles.append(Line2D([], [], color="0.4", ls=":", label="a tenth of the resolution; left edge: no shift"))
    drawing.legend(handles=handles, loc="outside lower center", ncols=len(handles))
