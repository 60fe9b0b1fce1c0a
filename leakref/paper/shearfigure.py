"""The picture of case shear: velocities against the depth that each wavenumber feels.

A straight line in these axes is a linear profile. The slope of the points is the shear that would be inferred, and
leakage bends it; `shear` computes the figures in the titles.
"""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from leakref.ensemble import Ensemble
from leakref.figures import COLOURS, WINDOW_WORDS, figure, styled
from leakref.paper.shear import DIRECTIONS, PROFILES, Sheared, inferred

__all__ = ["shear_figure"]

_LOOKS = {"box": (COLOURS[1], "--"), "hann": (COLOURS[0], "-")}


@styled
def shear_figure(ensembles: Sequence[Ensemble], title: str) -> Figure:
    """A panel for each profile and direction: mean velocity along the current by NSP, with two standard deviations.

    Up the effective depth -1 / 2k; black is the truth, eq:SJ. In each panel the shears inferred over all shells.
    """
    shown = [(e, e.configuration) for e in ensembles if e.method == "nsp" and isinstance(e.configuration, Sheared)]
    profiles = [name for name in PROFILES if any(c.profile == name for _, c in shown)]
    directions = [angle for angle in DIRECTIONS if any(c.current_direction == angle for _, c in shown)]
    drawing, axes = figure(
        len(directions), len(profiles), width=max(5.5, 3.0 * len(profiles)), height=2.6, sharey=True, sharex="row"
    )
    said: dict[tuple[int, int], list[str]] = {}
    for e, c in shown:
        at = directions.index(c.current_direction), profiles.index(c.profile)
        ax, depth, along = axes[at], -0.5 / e.wavenumbers, e.velocities @ c.along
        colour, line = _LOOKS[e.window]
        mean, spread = along.mean(axis=0), 2 * along.std(axis=0, ddof=1) if len(along) > 1 else 0.0
        ax.fill_betweenx(depth, mean - spread, mean + spread, color=colour, alpha=0.15, lw=0)
        ax.plot(mean, depth, color=colour, ls=line, lw=1.3, label=WINDOW_WORDS[e.window])
        overall = inferred(e)[-1]
        if at not in said:
            ax.plot(c.truth @ c.along, depth, color="black", lw=1, label="truth (eq:SJ)")
            said[at] = [f"shear: true {round(overall.true, 3) + 0.0:.3f}"]
        said[at].append(f"{WINDOW_WORDS[e.window]} {overall.mean:.3f} ± {overall.random:.3f}")
    for (row, column), words in said.items():
        axes[row, column].set_title(
            "\n".join([f"{profiles[column]}, {DIRECTIONS[directions[row]]}", words[0], "; ".join(words[1:])]),
            fontsize=8,
        )
        axes[row, column].set_xlabel(r"velocity along the current / $c_0$")
    for ax in axes[:, 0]:
        ax.set_ylabel(r"effective depth $-k_0 / 2k$")
    handles = dict(zip(*axes[0, 0].get_legend_handles_labels()[::-1], strict=True))
    drawing.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=4)
    drawing.suptitle(title)
    return drawing
