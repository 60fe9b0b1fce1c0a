"""What stresses do to a code, for its page: a table of breakdowns and a figure of all curves."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping, Sequence
from io import BytesIO
from typing import Any

import numpy as np

from leakref.certify.measures.stress import Found
from leakref.figures import COLOURS, styled
from leakref.figures import figure as blank

__all__ = ["figure", "picture", "table"]


def picture(found: Sequence[Found]) -> dict[str, Any]:
    """What the page shows: a title, words, the table, and the figure as a PNG in base64."""
    followed = [f"{one.followed[:1].upper()}{one.followed[1:]}." for one in found if one.own.stress.moves]
    return {
        "title": "Stress: what poor sensors make of it",
        "words": " ".join([_WORDS, *followed]),
        "table": table(found),
        "data": b64encode(figure(found)).decode(),
    }


def table(found: Sequence[Found]) -> Mapping[str, Any]:
    """For the page: `head`, names of columns, and `rows` of as many words, one for each stress."""
    head = ["what the sensor does"]
    head += [f"{what}{who}" for what in ("error doubled", "smaller resolution passed") for who in (_OWN, _REFERENCE)]
    rows = []
    for one in found:
        both = one.own, one.reference
        rows.append([one.own.stress.words, *(c.doubles.words for c in both), *(c.passes.words for c in both)])
    return {"head": head, "rows": rows}


@styled
def figure(found: Sequence[Found]) -> bytes:
    """A PNG: the mean error at every level of every stress, beside the reference and the smaller resolution.

    There is a panel for each stress; levels are one step apart, in the order in which they grow worse, and errors in
    `c0` on a logarithmic axis. Hollow is where the code has not answered all that it answers of the sea as it is. The
    bytes are those of a PNG file.
    """
    columns = 3
    rows = -(-len(found) // columns)
    drawing, axes = blank(rows, columns, width=8.0, height=2.3, sharey=True)
    for ax, one in zip(axes.ravel(), found, strict=False):
        own, stress = one.own, one.own.stress
        steps = np.arange(1 + len(stress.levels))
        ax.axhspan(1e-9, float(np.nanmean(own.resolutions)), color="0.9", lw=0, label="below the smaller resolution")
        ax.plot(steps, own.mean, color=COLOURS[0], lw=1.4, label="this code")
        ax.axhline(2 * own.mean[0], color=COLOURS[0], lw=0.9, ls=":", label="its error as it is, doubled")
        whole = np.append(True, own.answered >= 1)
        for part, face in ((whole, COLOURS[0]), (~whole, "white")):
            ax.plot(steps[part], own.mean[part], "o", color=COLOURS[0], mfc=face, ms=4)
        ax.plot(steps, one.reference.mean, color="0.25", ls="--", lw=1.2, label="the reference, Hann")
        ax.set_title(stress.name, fontsize=10)
        ax.set_xticks(steps, ["as\nit is", *(f"{level:g}" for level in stress.levels)], fontsize=7.5)
        ax.set_xlabel(_AXES.get(stress.name, stress.unit.strip()), fontsize=8)
        ax.grid(visible=False, axis="x")
    means = np.concatenate([curve.mean for one in found for curve in (one.own, one.reference)])
    means = means[np.isfinite(means) & (means > 0)]
    for ax in axes.ravel()[: len(found)]:
        ax.set_yscale("log")
        ax.set_ylim(means.min() / 1.5, max(0.1, means.max() * 1.5))
    for ax in axes[:, 0]:
        ax.set_ylabel("mean |c - U| / c0")
    for ax in axes.ravel()[len(found) :]:
        ax.set_visible(False)
    drawing.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4, fontsize=8)
    stream = BytesIO()
    drawing.savefig(stream, format="png", dpi=110)
    return stream.getvalue()


_OWN, _REFERENCE = ", this code", ", the reference"
_WORDS = (
    "Four seas of known current, each shown as a poor sensor sees it, from bad to worse. Where the mean error |c - U| "
    "is twice that in the seas as they are, and where it passes the smaller velocity resolution, between the levels "
    "that were tried, beside the reference with Hann and NSP; sigma is the standard deviation of the elevation. It "
    "changes no grade. In the figure errors stand over levels; hollow is where not all was answered."
)
_AXES = {
    "noise": "signal to noise, dB",
    "grey": "bits of a grey value",
    "slope": "part of the slope, %",
    "crests": "threshold, sigma",
    "harmonics": "share of the harmonics, %",
    "jitter": "displacement, pixels",
    "column": "flicker, sigma",
    "lost": "frames lost of 80",
    "platform": "speed, c0",
}
