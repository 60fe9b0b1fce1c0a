"""Every figure can be read: axes say what they show and in which unit, no text covers other text or leaves the page."""

from __future__ import annotations

import json
import re
from importlib.resources import files
from itertools import combinations, product

import numpy as np
import pytest
from matplotlib.text import Text
from mpl_toolkits.mplot3d import Axes3D
from test_plan import CAMPAIGN, made
from test_shear_case import SHEARED, measured
from typer.testing import CliRunner

from leakref import bench, figures
from leakref.cases import PAPER_CASES
from leakref.certify.measures import bias
from leakref.chain import analyse
from leakref.claims import CLAIMS
from leakref.claims.pictures import decisions_figure, picture
from leakref.claims.registry import Finding
from leakref.claims.stored import stored_claims, stored_decisions
from leakref.claims.words import Reading, Tally
from leakref.cli.base import app
from leakref.cubes.figures import extraction_figure, screening_figure
from leakref.cubes.screen import screen
from leakref.dispersion import DEEP, velocity_resolutions
from leakref.figures import figure, result_figure
from leakref.paper.figures import RESULTS, stored
from leakref.paper.illustrations import ILLUSTRATIONS
from leakref.paper.shearfigure import shear_figure
from leakref.planning.figures import plan_figure, sweep_figure
from leakref.planning.plan import Plan
from leakref.track import history
from leakref.track.page import curves_figure, levels_figure, versions

PAPER = {
    "fig:leakage_lobes",
    "fig:spectrum_examples",
    "fig:leakage_illustration2D",
    "fig:cylinderIllustration",
    "fig:spec_ex",
    "fig:Ang_Dang",
    "fig:peakedness",
    "fig:video_duration",
    "fig:ConstCurr",
    "fig:ConstCurr_rot30",
    "fig:DSV_win_comp_results",
    "fig:ex_NSP_vs_LS",
}
"""The labels of all figure environments of the paper."""
UNITLESS = ("pixels", "bins", "peak", "largest", "°", "depth", "log", "version", "comparison")


SMALLEST = 6.0
"""Points: no letter of a figure is smaller, as journals ask for."""


def smallest(text):
    """The size in points of the smallest letters of a text: a subscript is of 0.7, one of a subscript of 0.49."""
    raised = [part for part in re.findall(r"\$([^$]*)\$", text.get_text()) if re.search(r"[_^]", part)]
    nested = any(re.search(r"[_^]\{[^}]*[_^]", part) for part in raised)
    return text.get_fontsize() * (0.49 if nested else 0.7 if raised else 1)


def unreadable(drawing):
    """What is wrong with a figure, in words."""
    drawing.canvas.draw()
    renderer = drawing.canvas.get_renderer()
    texts, found = [], []
    written = [text for text in drawing.findobj(Text) if text.get_visible() and text.get_text().strip()]
    found += [
        f"{text.get_text()!r} has letters of {smallest(text):.3g} points"
        for text in written
        if smallest(text) < SMALLEST - 1e-6
    ]
    for ax in drawing.axes:
        texts += [text for text in ax.texts if text.get_visible()] if ax.get_visible() else []
        if not (ax.axison and ax.get_visible()):
            continue
        shared_x = any(other.get_xlabel() for other in ax.get_shared_x_axes().get_siblings(ax))
        shared_y = any(other.get_ylabel() for other in ax.get_shared_y_axes().get_siblings(ax))
        if not (ax.get_xlabel() or shared_x or ax.get_label() == "<colorbar>"):
            found.append("an axis x has no label")
        if not (ax.get_ylabel() or shared_y):
            found.append("an axis y has no label")
        for label in (ax.get_xlabel(), ax.get_ylabel()):
            if label and not ("/" in label or "(" in label or any(word in label for word in UNITLESS)):
                found.append(f"{label} has no unit")
        texts += [ax.title, ax.xaxis.label, ax.yaxis.label]
        if not isinstance(ax, Axes3D):
            for axis in (ax.xaxis, ax.yaxis):
                low, high = sorted(axis.get_view_interval())
                texts += [
                    tick.label1
                    for tick in axis.get_major_ticks()
                    if tick.label1.get_visible() and low <= tick.get_loc() <= high
                ]
        texts += ax.get_legend().get_texts() if ax.get_legend() else []
    texts += [text for legend in drawing.legends for text in (*legend.get_texts(), legend.get_title())]
    texts += [drawing._suptitle] if drawing._suptitle else []
    boxes = [(text.get_text(), text.get_window_extent(renderer)) for text in texts if text.get_text().strip()]
    page = drawing.bbox.padded(1)
    for said, box in boxes:
        if not (page.x0 <= box.x0 and box.x1 <= page.x1 and page.y0 <= box.y0 and box.y1 <= page.y1):
            found.append(f"{said!r} leaves the page")
    for (one, a), (two, b) in combinations(boxes, 2):
        if min(a.x1, b.x1) - max(a.x0, b.x0) > 1 and min(a.y1, b.y1) - max(a.y0, b.y0) > 1:
            found.append(f"{one!r} covers {two!r}")
    return found


def test_the_reader_of_figures_sees_what_is_wrong():
    drawing, axes = figure(1, 2)
    axes[0, 0].set_xlabel("speed")
    axes[0, 0].set_ylabel("mean / $c_0$")
    axes[0, 1].set(xlabel="$k$ / $k_0$", title="x" * 120)
    drawing.legend(
        handles=axes[0, 0].plot([0, 1], [0, 1], label="a line"), loc="upper left", bbox_to_anchor=(0.3, 0.08)
    )
    found = "\n".join(unreadable(drawing))
    for fault in ("speed has no unit", "an axis y has no label", "leaves the page"):
        assert fault in found
    axes[0, 1].set(title="", ylabel="mean / $c_0$")
    axes[0, 0].set_xlabel("speed (m/s)")
    drawing.legends.clear()
    assert unreadable(drawing) == []
    axes[0, 0].xaxis.set_label_coords(0.5, -0.05)  # among the numbers
    assert any("covers" in fault for fault in unreadable(drawing))


def test_every_figure_of_the_paper_has_its_own():
    assert {label for labels in RESULTS.values() for label in labels} | set(ILLUSTRATIONS) == PAPER


@pytest.mark.parametrize("label", ILLUSTRATIONS)
def test_illustrations_can_be_read(label):
    assert unreadable(ILLUSTRATIONS[label][1]()) == []


@pytest.fixture(scope="module")
def golden():
    return list(stored())


def test_stored_results_are_complete(golden):
    assert {e.configuration.id for e in golden} == {c.id for members in PAPER_CASES.values() for c in members}
    assert len(golden) == 2 * sum(len(c.windows) for members in PAPER_CASES.values() for c in members)


@pytest.mark.parametrize(
    ("case", "rotation"),
    [("theta0-dtheta", 0), ("gamma", 0), ("L-T", 0), ("U", 0), ("U", 30), ("windows", 0), ("nsp-ls", 0)],
)
def test_result_figures_can_be_read(case, rotation, golden):
    members = [
        e
        for e in golden
        if (e.configuration.case, e.configuration.rotation) == (case, rotation)
        and (e.method == "nsp" or case == "nsp-ls")
    ]
    drawing = result_figure(members, f"case {case}, 100 realisations", logarithmic=case != "U")
    assert unreadable(drawing) == []
    if case == "windows":  # compared in one column, as the paper does
        assert len(drawing.axes) == 2
        assert [text.get_text() for text in drawing.legends[0].get_texts()][:4] == [
            "no window",
            "Hann",
            "Blackman",
            "Kaiser-Bessel",
        ]


def test_figures_of_a_cube_can_be_read(untapered, tapered):
    k = 2 * np.pi / 32 * np.arange(4, 9)
    grid = tapered.grid
    units = ("rad/m", "m/s")
    resolutions = velocity_resolutions(k, grid.wavenumber_resolution, grid.frequency_resolution, water=DEEP)
    flags = [["flat", "edge"], [], ["leakage"], [], []]
    found = analyse(tapered, k, search=False, gravity=1.0)
    drawn = extraction_figure(found, flags, resolutions, units, "cube.nc: nsp, window hann", np.array([0.1, 0.0]))
    assert unreadable(drawn) == []
    screened = screen(untapered, tapered, k, gravity=1.0)
    assert unreadable(screening_figure(screened, resolutions, units, "cube.nc: is leakage at work?")) == []


@pytest.fixture(scope="module")
def ways():
    return {
        (window, method): made(scale, window, method)
        for window, method, scale in (
            ("box", "nsp", 0.9),
            ("box", "ls", 1.5),
            ("hann", "nsp", 0.3),
            ("hann", "ls", 0.6),
        )
    }


def test_figures_of_a_plan_can_be_read(ways):
    title = "128 x 96 m for 30 s; waves of 15 m at 90°, spread 45°, $\\gamma$ = 3.3; current 0.3 m/s at 90°"
    assert unreadable(plan_figure(Plan(CAMPAIGN, ways, made(0.2), made(0.3)), title)) == []
    swept = sweep_figure("spread (deg)", [15.0, 33.333333, 90.0], [ways] * 3, f"Sweep over the spread: {title}")
    assert unreadable(swept) == []


def test_the_figure_of_case_shear_can_be_read():
    rng = np.random.default_rng(1)
    found = []
    for c in SHEARED:
        e = measured(c, c.truth + 0.02 * rng.standard_normal((3, *c.truth.shape)))
        found += [e, measured(c, c.truth).__class__(c, "box", "nsp", c.wavenumbers, e.velocities, e.notes)]
    assert unreadable(shear_figure(found, "sheared currents by NSP, 3 realisations")) == []


def as_read(claim):
    """A finding in the words and figures of the stored result, with made-up margins behind its readings."""
    rng = np.random.default_rng(2)
    readings = []
    for kept in claim["readings"]:
        choices = dict(part.split(": ", 1) for part in kept["reading"].split(", ") if ": " in part)
        parts = kept["figure"] if isinstance(kept["figure"], dict) else {}
        names = [name for name, value in parts.items() if isinstance(value, dict)] or (
            ["comparison"] if "mean_margin" in parts else []
        )
        tallies = {}
        for name in names:
            margin, error = rng.standard_normal((2, 30)) * [[0.1], [0.03]]
            error = np.abs(error)
            against = np.where(margin < -2 * error, 0.0, 1.0)
            sea = np.full(30, "direction 60, spread 15", dtype=object)
            k = np.linspace(0.4, 3.4, 30)
            tallies[name] = Tally(k, margin, error, margin > 2 * error, against, np.zeros(30, bool), sea)
        readings.append(Reading(choices, kept["holds"], kept["figure"], tallies))
    return Finding(CLAIMS[claim["id"]], tuple(readings))


@pytest.mark.parametrize(
    "name",
    [name if name in ("N4", "A12", "W9", "W7") else pytest.param(name, marks=pytest.mark.slow) for name in CLAIMS],
)
def test_the_picture_of_a_claim_can_be_read(name):
    (kept,) = (claim for claim in stored_claims()["claims"] if claim["id"] == name)
    assert unreadable(picture(as_read(kept))) == []


def test_the_picture_of_the_decisions_can_be_read():
    assert unreadable(decisions_figure(stored_decisions())) == []


def test_figures_of_a_history_can_be_read():
    shown = versions(history.read(files("leakref._golden").joinpath("history.jsonl")).entries)
    assert len(shown) > 1
    for case in dict.fromkeys(key[0] for key in shown[-1].series):
        assert unreadable(levels_figure(shown, case)) == [], case
        assert unreadable(curves_figure(shown, case)) == [], case
    many = shown * 8
    assert unreadable(levels_figure(many, case)) == []


@pytest.fixture
def drawn(monkeypatch):
    """The figures that are written while a test runs."""
    kept = []
    monkeypatch.setattr(
        figures.Figure,
        "savefig",
        lambda self, where, **how: (
            kept.append(self) or (where.write_bytes(b"x") if hasattr(where, "write_bytes") else where.write(b"x"))
        ),
    )
    return kept


def test_the_figure_of_the_timings_can_be_read(drawn, tmp_path):
    names = (
        "components of a sea",
        "spectrum by the FFT",
        "spectrum in closed form",
        "NSP of a shell",
        "one realisation, both windows and methods",
        "nothing against it",
    )
    rows = [
        bench.Row(
            name,
            10.0 ** -(n % 4),
            "the same, written out in NumPy for one core",
            3.0 * 9**n if n < 5 else None,
            0.4,
            "memory",
        )
        for n, name in enumerate(names)
    ]
    bench._draw(rows, tmp_path)
    assert unreadable(drawn[0]) == []


def test_the_figure_of_the_bias_can_be_read(drawn):
    found = []
    for sea, scale in product(bias.SEAS.values(), (1.0, 4.0)):
        k = np.array(sea.wavenumbers)
        error = 0.05 / k
        found.append(
            bias.Bias(
                sea,
                scale,
                "nsp",
                k,
                error,
                error / 2,
                error / 3,
                error / 4,
                sea.cube(0).resolutions,
                3.0,
                (2.5, 3.5),
                8,
            )
        )
    assert bias.figure(found) == b"x"
    assert unreadable(drawn[0]) == []


def test_the_command_draws_all_of_them_from_the_golden_set(tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(figures.Figure, "savefig", lambda self, path, **how: drawn.append(path.write_bytes(b"x")))
    done = CliRunner().invoke(app, ["reproduce", "--figures", "--out", str(tmp_path), "--json"], catch_exceptions=False)
    assert done.exit_code == 0
    found = json.loads(done.stdout)
    assert {label for one in found["figures"] for label in one["labels"]} == PAPER
    assert len(drawn) == 22
    assert len(list(tmp_path.glob("figure_*.svg"))) == 11
    entry = next(
        case for case in found["cases"] if (case["case"], case["window"], case["method"]) == ("nsp-ls", "hann", "nsp")
    )
    assert entry["bias"][6] == pytest.approx(0.0058, abs=1e-4)
    assert len(entry["resolution_frequency"]) == len(entry["wavenumbers"]) == 32
