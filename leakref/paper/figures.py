"""Every figure of the paper: those without results, and results from ensembles, computed or golden.

Results are drawn alike whether they were just computed (`reproduce`) or are those of the golden set (`stored`), in the
form of the paper's figures: bias and twice the random part against wavenumber, with both resolutions.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from leakref._base import FloatArray
from leakref._output import console, dump, envelope, folder
from leakref.cases import PAPER_CASES, REALIZATIONS, Configuration
from leakref.dispersion import DEEP, velocity_resolutions
from leakref.ensemble import statistics_record
from leakref.figures import Result, result_figure, save
from leakref.golden.sets import Golden, locate
from leakref.methods import DEFAULT

__all__ = ["RESULTS", "Stored", "draw_illustrations", "draw_results", "run", "stored"]

RESULTS = {
    "theta0-dtheta": ("fig:spec_ex", "fig:Ang_Dang"),
    "gamma": ("fig:peakedness",),
    "L-T": ("fig:video_duration",),
    "U": ("fig:ConstCurr",),
    "U_rotated30": ("fig:ConstCurr_rot30",),
    "windows": ("fig:DSV_win_comp_results",),
    "nsp-ls": ("fig:ex_NSP_vs_LS",),
}
"""The paper's labels of the figures of results, by case and rotation."""


@dataclass(frozen=True, eq=False)
class Stored:
    """The statistics of an ensemble that a golden set keeps: at n `wavenumbers`, in c0. Arrays are (n,), `mean` is (n,
    2). It has what a picture needs, and no single velocities.
    """

    configuration: Configuration
    window: str
    method: str
    wavenumbers: FloatArray
    bias: FloatArray
    random: FloatArray
    mean: FloatArray
    standard_error: FloatArray

    @property
    def resolutions(self) -> tuple[FloatArray, FloatArray]:
        """eq:dcdwk from frequency and from wavenumber, (n,) each."""
        grid = self.configuration.grid
        return velocity_resolutions(self.wavenumbers, grid.wavenumber_resolution, grid.frequency_resolution, water=DEEP)

    def record(self) -> dict[str, Any]:
        """As an Ensemble's, in the JSON of `leakref reproduce` (guide protocol, section 14)."""
        return statistics_record(self, REALIZATIONS)


def stored(golden: Golden | None = None) -> Iterator[Stored]:
    """Every ensemble of the paper as the golden set has it, `v1` unless it is given, which has those and no other.

    Raises Damaged for a set that is not whole.
    """
    known = {c.id: c for members in PAPER_CASES.values() for c in members}
    for entry in (golden or Golden(locate(1))).entries("ensembles"):
        given, out = entry.record["input"], entry.output
        c = known[given["configuration"]]
        yield Stored(
            c,
            given["window"],
            given["method"],
            c.wavenumbers,
            out["bias"],
            out["random"],
            out["mean"],
            out["standard_error"],
        )


def draw_results(out: Path, results: Sequence[Result], realizations: int) -> list[dict[str, Any]]:
    """A figure for each case, or each of its rotations, in the form of the paper's: `labels` there, `files` here.

    `results` are Ensembles or Stored. Of LS only those of its own case are drawn, unless other methods are there too:
    then a case of a single configuration has all of them in one figure, and of others each method but LS has its own,
    named after it but for NSP. Each figure is a PNG and an SVG.
    """
    groups: dict[str, list[Result]] = {}
    counted = Counter(c.case for c in {e.configuration.id: e.configuration for e in results}.values())
    compared = {e.method for e in results} - {*DEFAULT}  # else of LS only those of its own case are drawn
    several = {case for case, count in counted.items() if case != "nsp-ls" and (count > 1 or not compared)}
    for e in results:
        if e.configuration.case not in several or e.method != "ls":
            rotated = f"_rotated{e.configuration.rotation:g}" if e.configuration.rotation else ""
            own = f"_{e.method}" if e.configuration.case in several and e.method != "nsp" else ""
            groups.setdefault(e.configuration.case + rotated + own, []).append(e)
    drawn = []
    for name, members in groups.items():
        still = not any(e.configuration.speed for e in members)
        turned = f", rotated by {members[0].configuration.rotation:g}°" if "_rotated" in name else ""
        count = f"{realizations} realisation{'s' * (realizations > 1)}"
        title = f"case {members[0].configuration.case}{turned}, {count}"
        files = save(result_figure(members, title, logarithmic=still and realizations > 1), out / f"figure_{name}")
        drawn.append({"labels": RESULTS.get(name, ()), "files": files})
    return drawn


def draw_illustrations(out: Path) -> list[dict[str, Any]]:
    """The figures of the paper that show no results: `labels` there, `files` here."""
    from leakref.paper.illustrations import ILLUSTRATIONS

    return [
        {"labels": (label,), "files": save(draw(), out / f"figure_{name}")}
        for label, (name, draw) in ILLUSTRATIONS.items()
    ]


def run(out: Path, *, json: bool) -> bool:
    """Draw every figure of the paper to `out`, those of results from the golden ensembles; returns True."""
    folder(out)
    results = list(stored())
    drawn = draw_illustrations(out) + draw_results(out, results, REALIZATIONS)
    if json:
        print(dump(envelope("reproduce", True, cases=[e.record() for e in results], source="golden/v1", figures=drawn)))
    else:
        for one in drawn:
            print(f"{', '.join(one['labels'])}: {one['files'][0]}")
    console().print(
        f"[dim]{len(drawn)} figures, PNG and SVG, in {out}; results are from golden/v1, 100 realisations "
        "(name cases, or --all, to compute them)[/dim]",
        soft_wrap=True,
    )
    return True
