"""Strangers: codes that share nothing with the chain. Right ones must pass, mistakes must be rejected and named.

The seas by which they are known to be right are made here, not by leakref.
"""

import ast
import inspect
import re
from contextlib import nullcontext
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from strangers import leastsquares, nsp
from strangers.measure import judge, of_mistake, of_right, shares, told
from strangers.mistakes import HERE, LS, MISTAKES, NSP, REPAIRS
from strangers.right import RIGHT

from leakref.certify.runner import certify, select
from leakref.certify.strength.faults import FAULTS
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.verdict import Verdict

CODES = {"nsp": nsp.Extractor, "leastsquares": leastsquares.Extractor, **RIGHT}
GRAVITY, PEAK = 9.81, 0.25
C0, OMEGA0 = np.sqrt(GRAVITY / PEAK), np.sqrt(GRAVITY * PEAK)
K = np.array([1.25, 1.5, 1.8, 2.15]) * PEAK
GRIDS = {"even": ((50, 44, 80), (2.5, 2.7, 0.5)), "prime": ((53, 41, 97), (2.3, 2.9, 0.45))}
CURRENTS = {"even": (1.2, -0.6), "prime": (-0.8, -1.5)}


@lru_cache
def sea(grid):
    """A broad sea of 600 waves between the bins, in metres and seconds, eta[x, y, t]."""
    (shape, spacing), current, rng = GRIDS[grid], CURRENTS[grid], np.random.default_rng(3)
    k, towards = PEAK * rng.uniform(0.5, 3.4, 600), np.radians(rng.uniform(-50, 130, 600))
    kx, ky, height = k * np.cos(towards), k * np.sin(towards), (k / PEAK) ** -1.25 * np.exp(-0.625 * (PEAK / k) ** 2)
    omega = np.sqrt(GRAVITY * k) + kx * current[0] + ky * current[1]
    x, y, t = (
        np.exp(1j * np.outer(np.arange(n) * d, w)) for n, d, w in zip(shape, spacing, (kx, ky, -omega), strict=True)
    )
    t *= height * np.exp(2j * np.pi * rng.random(600))
    return np.einsum("xn,yn,tn->xyt", x, y, t, optimize=True).real


def velocities(code, grid):
    """What a code finds in that sea, in m/s and to the east and north, whatever it declares."""
    said, call = code.describe() if hasattr(code, "describe") else {}, getattr(code, "extract", code)
    eta, spacing, scaled = sea(grid), GRIDS[grid][1], said.get("units", "scaled") == "scaled"
    along, during, gravity = (PEAK, OMEGA0, 1.0) if scaled else (1.0, 1.0, GRAVITY)
    eta = eta[:, ::-1] if said.get("y") == "down" else eta
    eta = eta.transpose(["xyt".index(axis) for axis in said.get("axes", "xyt")])
    windows = said.get("can", {}).get("extract", {}).get("windows", ["hann"])
    window = {"window": "hann" if "hann" in windows else windows[0]}
    window = window if "window" in inspect.signature(call).parameters else {}
    steps = (spacing[0] * along, spacing[1] * along, spacing[2] * during)
    found = np.array(call(eta, steps, K / along, gravity=gravity, **window), dtype=float)
    found = found * (C0 if scaled else 1.0) * [1, -1 if said.get("y") == "down" else 1]
    return np.broadcast_to(-found if said.get("direction") == "from" else found, (K.size, 2))


def resolution(grid):
    """The larger of the two of eq:dcdwk in the mean."""
    bins = [2 * np.pi / (n * d) for n, d in zip(*GRIDS[grid], strict=True)]
    return float(np.maximum(bins[2] / K, np.sqrt(GRAVITY / K) / 2 * max(bins[:2]) / K).mean())


def off(code, grid):
    """Error over the resolution, in the mean over wavenumbers."""
    return float(np.hypot(*(velocities(code, grid) - CURRENTS[grid]).T).mean()) / resolution(grid)


@pytest.mark.parametrize("grid", GRIDS)
@pytest.mark.parametrize("name", CODES)
def test_right_codes_find_the_current_of_a_sea_within_half_of_the_resolution(name, grid):
    assert off(CODES[name](), grid) < 0.5


@pytest.mark.parametrize("name", ["nsp-kx-sign", "nsp-exchanged", "nsp-hertz", "ls-upside-down", "ls-twice"])
def test_mistakes_do_not(name):
    assert off(MISTAKES[name].plant().Extractor(), "even") > 1


def test_every_mistake_is_one_line_of_the_extractor_and_named_by_ids_that_there_are():
    known = set(REPAIRS.split()) | set(FAULTS)
    assert len(MISTAKES) == len(NSP) + len(LS)
    assert min(len(NSP), len(LS)) >= 45
    for mistake in MISTAKES.values():
        assert "\n" not in mistake.old + mistake.new
        mistake.plant()  # raises unless the line is there once
        re.compile(mistake.says)
        unknown = {name for part in mistake.named if ":" not in part for name in part.split("+")} - known
        assert not unknown, mistake.id
    assert 1 / 5 < sum(not mistake.named for mistake in MISTAKES.values()) / len(MISTAKES) < 1 / 2


def test_strangers_import_nothing_of_leakref_and_share_no_line_with_the_chain():
    chain = HERE.parents[1] / "leakref"
    own = {line.strip() for path in chain.glob("*.py") for line in path.read_text().splitlines()}
    for name in ("nsp", "leastsquares", "parts", "right"):
        text = (HERE / f"{name}.py").read_text()
        for node in ast.walk(ast.parse(text)):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else [
                alias.name for alias in getattr(node, "names", ()) if isinstance(node, ast.Import)
            ]  # fmt: skip
            assert not any(each.startswith("leakref") for each in names), name
        lines = {line.strip() for line in text.splitlines() if not line.startswith(("import", "from"))}
        assert not {line for line in lines & own if len(line) > 40}, name


@pytest.mark.parametrize("name", ["nsp-negated", "ls-cramer-plus", "ls-short-y", "ls-intercept", "ls-linspace"])
def test_some_mistakes_are_rejected_by_two_waves_on_bins(name):
    pairs = select(["recovery.pair", "signs.aligned"], profile="quick")
    found = certify(name, [nullcontext(InProcess(MISTAKES[name].plant().Extractor()))], pairs, profile="quick")
    assert found.grade == "rejected"


@pytest.mark.parametrize("code", [nsp.Extractor, leastsquares.Extractor])
def test_without_a_mistake_nothing_is_wrong(code):
    pairs = select(["recovery.pair", "signs", "behaviour"], profile="quick")
    found = certify("right", [nullcontext(InProcess(code()))], pairs, profile="quick")
    assert {f.verdict for f in found.findings} <= {Verdict.PASS, Verdict.UNSUPPORTED}


def test_what_counts_as_told_rightly():
    def of(words, *ids, wrong=True):
        return told({"wrong": {"a": []} if wrong else {}, "faults": ids, "explanation": words}, MISTAKES["nsp-third"])

    assert of("", wrong=False) == "unseen"
    assert of("equals the reference, but times 0.333", "factor") == "right"
    assert of("equals the reference, but times 0.353", "factor") == "false"
    assert of("x and y exchanged", "exchanged-axes") == "false"
    assert of("unexplained: no fault of the list reproduces these answers") == of("") == "unexplained"
    assert of("times a factor that depends on the scale of the sea", "scale-dependent") == "unexplained"
    negated = {"wrong": {"a": []}, "faults": ["flipped-x", "negated-current"], "explanation": "either"}
    assert told(negated, MISTAKES["nsp-negated"]) == "right"


SOME = [
    "nsp-floored",
    "nsp-line",
    "nsp-power",
    "nsp-at-centre",
    "nsp-gravity-10",
    "nsp-twelve",
    "ls-pi",
    "ls-transposed",
    "ls-short-duration",
    "ls-disc",
]
"""One or two of each kind, and each hole that a question was made for."""


@pytest.mark.slow
@pytest.mark.parametrize("name", SOME)
def test_some_mistakes_are_rejected_and_told_nothing_false(name, tmp_path):
    record = of_mistake(MISTAKES[name], tmp_path)
    assert record["rejected"]
    assert record["told"] != "false", record["explanation"]


@pytest.mark.night
def test_mistakes_are_rejected_and_named(tmp_path):
    found = shares([of_mistake(mistake, tmp_path) for mistake in MISTAKES.values()])
    assert found["rejected"] >= 0.97, found["survivors"]
    assert found["named"] >= 0.8, found["unexplained"]
    assert not found["false"]


def accepted(name, seed, folder):
    record = of_right(name, seed, folder)
    assert record["grade"] in ("conformant", "sound"), record["wrong"] or record["missing"]


@pytest.mark.slow
@pytest.mark.parametrize("name", RIGHT)
def test_right_codes_are_not_rejected(name, tmp_path):
    accepted(name, 1, tmp_path)


@pytest.mark.night
@pytest.mark.parametrize("seed", [7, 19])
@pytest.mark.parametrize("name", RIGHT)
def test_right_codes_are_not_rejected_under_other_seeds(name, seed, tmp_path):
    accepted(name, seed, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("code", [nsp.Extractor, leastsquares.Extractor])
def test_the_extractors_without_a_mistake_conform(code):
    assert judge(code(), "right", diagnosis=False)["grade"] == "conformant"


@pytest.mark.parametrize(
    ("name", "seed", "question"),
    [
        ("welch", 8, "metamorphic.shift[untapered]"),  # segments in time
        ("even", 11, "metamorphic.shift[untapered]"),  # the last of an odd number of frames left out
        ("cylinder-called-nsp", 209, "leakage.still[sharp]"),  # another make, in a sea in which the reference errs too
        ("cylinder-called-nsp", 651, "leakage.still[sharp]"),
        ("cylinder-called-nsp", 703, "leakage.still[sharp]"),
        ("ls-slices", 292, "leakage.still[sharp]"),  # slices of a few periods
        ("huber", 290, "currents.backwards[opposing]"),  # omega >= 0 only (D19)
        ("huber-unnamed", 848, "currents.backwards[opposing]"),
    ],
)
def test_choices_that_some_seeds_held_against_right_codes_do_not_reject_them(name, seed, question):
    ((check, case),) = select([question])
    finding = check(InProcess(RIGHT[name]()), replace(case, seed=seed))
    assert finding.verdict in (Verdict.PASS, Verdict.UNSUPPORTED), finding.message


def test_a_shift_still_shows_the_real_part_taken_for_the_magnitude():
    ((check, case),) = select(["metamorphic.shift[untapered]"])
    assert check(InProcess(MISTAKES["nsp-real-part"].plant().Extractor()), case).over > 1.5
