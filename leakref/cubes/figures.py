"""Pictures of what was found in a user's cube.

Both are drawn for `leakref extract --out`, from what has been computed before; nothing is measured here. Velocities
keep the units of the file, which stand on the axes.
"""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import fill

import numpy as np
from matplotlib.figure import Figure

from leakref._base import FloatArray
from leakref.cubes.screen import LEAKAGE, NO_CHANGE, NO_SIGNAL, UNRESOLVED, Screening
from leakref.figures import COLOURS, figure, styled
from leakref.shell import Extraction

__all__ = ["extraction_figure", "screening_figure"]


@styled
def extraction_figure(
    found: Extraction,
    flags: Sequence[Sequence[str]],
    resolutions: Sequence[FloatArray],
    units: tuple[str, str],
    title: str,
    current: FloatArray | None = None,
) -> Figure:
    """Both components of the measured velocity in bands of both resolutions; flagged ones hollow, flags named.

    `units` are those of a wavenumber and of a velocity; `current` (2,) is the truth, if known.

    `flags` are names for each wavenumber, `resolutions` the two of eq:dcdwk, (n,) each, the one from frequency first.
    """
    drawing, axes = figure(1, 2, width=8.5, height=4.0, sharey=True)
    k = found.wavenumbers
    flagged = np.array([bool(names) for names in flags])
    for component, ax in enumerate(axes[0]):
        c, colour = found.velocities[:, component], COLOURS[component]
        for values, alpha, what in zip(resolutions, (0.3, 0.15), ("frequency", "wavenumber"), strict=True):
            ax.fill_between(
                k,
                c - values,
                c + values,
                color=colour,
                alpha=alpha,
                lw=0,
                label=f"± resolution ({what})",
            )
        ax.plot(k, c, color=colour, lw=1.2)
        ax.plot(k[~flagged], c[~flagged], "o", color=colour, ms=3.5, label="measured")
        if flagged.any():
            names = fill(", ".join(sorted({name for one in flags for name in one})), 18)
            ax.plot(k[flagged], c[flagged], "o", mec=colour, mfc="white", ms=4.5, label=f"flagged: {names}")
        if current is not None:
            ax.axhline(current[component], color="black", lw=0.8, ls="--", label="current stated in the file")
        ax.set_title(f"$\\tilde{{c}}_{'xy'[component]}$")
        ax.set_xlabel(f"wavenumber ({units[0]})")
        if not np.isfinite(c).any():  # an empty picture would look like a mistake of the drawing
            ax.text(0.5, 0.5, "no velocity at any wavenumber", transform=ax.transAxes, ha="center", va="center")
            ax.set_xlim(k.min() * 0.95, k.max() * 1.05)
        ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)
    axes[0, 0].set_ylabel(f"Doppler shift velocity ({units[1]})")
    drawing.suptitle(fill(title, 90))
    return drawing


@styled
def screening_figure(
    result: Screening, resolutions: Sequence[FloatArray], units: tuple[str, str], title: str
) -> Figure:
    """Left: both components untapered and tapered. Right: how far apart they are, the resolutions, the verdicts.

    `units` are those of a wavenumber and of a velocity.

    `resolutions` are as in `extraction_figure`. If the cube was turned as well, crosses are how far the untapered
    velocity then moved, and the dash-dotted line is the larger resolution of the smaller cube.
    """
    drawing, axes = figure(1, 2, width=8.5, height=4.0)
    k = result.wavenumbers
    left, right = axes[0]
    for e, line, what in ((result.untapered, ":", "untapered"), (result.tapered, "-", "tapered")):
        for component in (0, 1):
            left.plot(
                k,
                e.velocities[:, component],
                ls=line,
                color=COLOURS[component],
                lw=1.4,
                label=rf"$\tilde{{c}}_{'xy'[component]}$ {what}",
            )
    for values, line, what in zip(resolutions, ("-", "--"), ("frequency", "wavenumber"), strict=True):
        right.plot(k, values, color="0.6", ls=line, lw=1, label=f"resolution ({what})")
    looks = {
        NO_CHANGE: ("o", COLOURS[2]),
        UNRESOLVED: ("D", COLOURS[4]),
        LEAKAGE: ("X", COLOURS[1]),
        NO_SIGNAL: ("_", "0.5"),
    }
    for verdict, (marker, colour) in looks.items():
        on = np.array([v == verdict for v in result.verdicts])
        if on.any():
            shown = np.where(np.isfinite(result.disagreement[on]), result.disagreement[on], 0.0)
            right.plot(k[on], shown, marker, color=colour, ms=5, label=f"{verdict} ({on.sum()})")
    right.set_ylabel(f"|untapered - tapered| ({units[1]})")
    if result.turned is not None:
        off = np.hypot(*(result.turned.untapered - result.untapered.velocities).T)
        right.plot(k, off, "+", color=COLOURS[3], ms=5, label=f"untapered, turned {result.turned.angle:g}°")
        right.plot(k, result.turned.resolution, color=COLOURS[3], lw=1, ls="-.", label="larger resolution, turned")
        right.set_ylabel(f"length of the difference ({units[1]})")
    left.set_ylabel(f"Doppler shift velocity ({units[1]})")
    right.set_ylim(bottom=0)
    for ax in (left, right):
        ax.set_xlabel(f"wavenumber ({units[0]})")
        ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)  # below: points may be anywhere
    drawing.suptitle(fill(title, 90))
    return drawing
