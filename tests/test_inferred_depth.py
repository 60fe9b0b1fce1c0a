"""A depth inferred along with the current: N over (cx, cy, h) against the plain N, exact recovery, what is refused,
ensembles that are the same bits everywhere, the claim."""

from __future__ import annotations

import json
import re
import shutil
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import root

from leakref import Components, Grid, LeakrefError, depth, leakage, nsp, runs
from leakref._output import dump
from leakref.cases import Configuration, configurations
from leakref.chain import transform
from leakref.claims.evidence import Evidence
from leakref.claims.shifts import Altered, NotCovered
from leakref.depthscore import depth_resolutions, derivatives
from leakref.dispersion import DEEP, Water
from leakref.golden import beside
from leakref.paper import inferred as depths
from leakref.paper import inferredfigure, inferredtables, reproduce
from leakref.shell import Note, shell_at

GRID = Grid((40, 56, 256), (0.8, 0.62, 0.45))  # oblong; omega >= 2 a from 0.44 up
WIDTH = nsp.WIDTH * GRID.frequency_resolution
BAND = (0.35, 2.0)


def on_bins(numbers, water, current):
    """Waves at bins (i, j) of GRID, and the current and depth near those given that put all three exactly on bins."""
    k = np.array(numbers) * GRID.bin_widths[:2]
    size, step = np.hypot(*k.T), GRID.frequency_resolution
    m = np.rint((water.frequency(size) + k @ current) / step)

    def off(x):
        return replace(water, depth=np.exp(x[2])).frequency(size) + k @ x[:2] - m * step

    x = root(off, [*current, np.log(water.depth)], tol=1e-13).x
    assert np.abs(off(x)).max() < 1e-13
    waves = Components(*k.T, m * step, np.array([1.0, 0.8, 0.6]), np.array([0.3, 1.9, 4.0]))
    return waves, x[:2], float(np.exp(x[2]))


CASES = {
    "shallow": ([(3, 1), (-2, 5), (6, -4)], Water(1.0, depth=0.7), (0.05, -0.04)),
    "middle": ([(2, 2), (5, -1), (-1, 7)], Water(1.0, depth=1.2), (-0.06, 0.08)),
    "deeper": ([(2, 1), (1, -4), (7, 3)], Water(1.0, depth=2.0), (0.1, 0.02)),
    "gravity": ([(2, 1), (1, -4), (7, 3)], Water(gravity=1.3, depth=1.0), (0.04, 0.03)),
    "tension": ([(3, 1), (-2, 5), (6, -4)], Water(1.0, depth=0.9, surface_tension=0.03), (0.02, 0.05)),
}


@pytest.mark.parametrize("case", CASES)
def test_waves_on_bins_give_their_depth_and_current_exactly(case):
    """Each wave stands at the middle of its Gaussian at the truth, whatever its weight, so that the gradient vanishes.

    What is left are the tails of the other branch, exp(-2 (2 omega / a)^2) <= 1e-14 for omega >= 2 a, and rounding of
    the sums, of 1e-13 after 35 products; over a curvature of N of 1 or so, times the conditioning of three waves (30).
    """
    waves, current, h = on_bins(*CASES[case])
    spectrum = leakage.spectrum(waves, GRID, "box")
    found = depth.infer_band(spectrum, *BAND, water=replace(CASES[case][1], depth=np.inf))
    assert found.notes[0] is Note.NONE
    assert found.depths[0] == pytest.approx(h, rel=1e-11)
    np.testing.assert_allclose(found.velocities[0], current, atol=1e-11)
    known = depth.infer_band(spectrum, *BAND, water=CASES[case][1], current=current)
    assert known.depths[0] == pytest.approx(h, rel=1e-11)
    assert known.curvature[0] >= found.curvature[0]  # a current that follows can only soften it


def test_one_wave_tells_its_depth_only_if_the_current_is_known_and_as_well_as_its_slope():
    k, m = float(np.hypot(*(np.array([3, 1]) * GRID.bin_widths[:2]))), 12
    omega = m * GRID.frequency_resolution
    h = float(np.arctanh(omega**2 / k) / k)  # omega0^2 = k tanh(k h)
    kx, ky = np.array([3, 1]) * GRID.bin_widths[:2]
    wave = Components(*(np.array([one]) for one in (kx, ky, omega, 1.0, 0.4)))
    spectrum = leakage.spectrum(wave, GRID, "box")
    known = depth.infer_shells(spectrum, [k], gravity=1.0, current=(0.0, 0.0))
    slope = omega * k * h / np.sinh(2 * k * h)
    assert known.depths[0] == pytest.approx(h, rel=1e-11)
    assert known.curvature[0] == pytest.approx(4 * (slope / WIDTH) ** 2, rel=1e-9)
    along = depth.infer_shells(spectrum, [k], gravity=1.0)
    # N is the same along a ridge of current and depth, to the tails of the mirror image, which favour an end of it
    assert along.notes[0] & (Note.FLAT | Note.EDGE)
    assert np.isnan(along.depths[0])
    assert depth.reasons(along.notes[0])


def test_three_waves_may_have_two_depths_and_then_it_is_said():
    """omega0 is no straight line, so that three equations may have two solutions, with one and the same N."""
    waves, current, h = on_bins([(3, 1), (-2, 5), (6, -4)], Water(gravity=1.3, depth=1.0), (0.04, 0.03))
    water, spectrum = Water(gravity=1.3), leakage.spectrum(waves, GRID, "box")
    found = depth.infer_band(spectrum, *BAND, water=water)
    both = [
        derivatives(depth.band(spectrum, *BAND, water=water), replace(water, depth=one), c, width=WIDTH)
        for one, c in ((found.depths[0], found.velocities[0]), (h, current))
    ]
    assert found.notes[0] is Note.ANOTHER_BASIN
    assert both[0][0] == pytest.approx(both[1][0], rel=1e-13)
    within = depth.infer_band(spectrum, *BAND, water=water, depths=(0.5, 1.5))
    assert (within.notes[0], within.depths[0]) == (Note.NONE, pytest.approx(h, rel=1e-11))


def test_it_is_the_plain_n_with_the_frequency_of_the_depth():
    """Against nsp's own N on a shell with other intrinsic frequencies; derivatives against complex-free differences."""
    sea = Configuration("small", length=4, duration=6, depth=0.9)
    (spectrum,) = transform(sea.components(2), sea.grid, ("hann",), route="B")
    a, c, eps = 4 * sea.grid.frequency_resolution, np.array([0.07, -0.03]), 1e-4
    for shell in (shell_at(spectrum, 1.2, water=DEEP), depth.band(spectrum, 0.4, 2.5, water=sea.water)):
        k = np.hypot(shell.kx, shell.ky)

        def plain(x, shell=shell, k=k):
            water = Water(1.0, depth=float(np.exp(x[2])))
            return nsp.normalized_scalar_product(replace(shell, intrinsic=water.frequency(k)), x[:2], a)

        x = np.array([*c, np.log(1.3)])
        n, slope, bend = derivatives(shell, Water(1.0, depth=1.3), c, width=a)
        assert n == pytest.approx(plain(x), rel=1e-12)  # tails cut at 1e-15, 35 products
        at_c = nsp.score_derivatives(replace(shell, intrinsic=Water(1.0, depth=1.3).frequency(k)), c, a)
        np.testing.assert_allclose(slope[:2], at_c[1], rtol=1e-11, atol=1e-12)
        np.testing.assert_allclose(bend[:2, :2], at_c[2], rtol=1e-11, atol=1e-11)
        steps = np.eye(3) * eps
        rise = [(plain(x + s) - plain(x - s)) / (2 * eps) for s in steps]
        np.testing.assert_allclose(slope, rise, atol=1e-6 * np.abs(bend).max())  # eps^2 times a third derivative
        turn = [
            [(plain(x + s + t) - plain(x + s - t) - plain(x - s + t) + plain(x - s - t)) / (4 * eps**2) for t in steps]
            for s in steps
        ]
        np.testing.assert_allclose(bend, turn, atol=1e-5 * np.abs(bend).max())


def test_the_band_holds_every_bin_once_and_levelling_gives_each_ring_one_say():
    sea = Configuration("small", length=4, duration=6, depth=0.9)
    (spectrum,) = transform(sea.components(2), sea.grid, ("box",), route="B")
    band, dk = depth.band(spectrum, 0.5, 2.0, water=sea.water), sea.grid.wavenumber_resolution
    k = np.hypot(*np.meshgrid(spectrum.kx, spectrum.ky, indexing="ij"))
    inside = (k >= 0.5 - 1e-9) & (k <= 2.0 + 1e-9)
    assert band.kx.size == inside.sum()
    np.testing.assert_allclose(band.magnitude.sum(), np.abs(spectrum.values[inside]).sum(), rtol=1e-13)
    level = depth.levelled(band, dk)
    ring = np.rint(np.hypot(band.kx, band.ky) / dk)
    means = [(level.magnitude[ring == r] @ band.weight).mean() for r in np.unique(ring)]
    np.testing.assert_allclose(means, 1, rtol=1e-13)
    np.testing.assert_allclose(
        level.magnitude[0] / level.magnitude[0].max(), band.magnitude[0] / band.magnitude[0].max(), rtol=1e-13
    )
    for bad in ((2.0, 0.5), (0.0, 1.0), (0.5, 90.0)):
        with pytest.raises(LeakrefError):
            depth.band(spectrum, *bad, water=sea.water)


def test_waves_of_k_h_of_five_have_no_depth_and_it_is_said_in_words():
    deep = [(3, 1), (-2, 5), (6, -4)]
    k = np.hypot(*(np.array(deep) * GRID.bin_widths[:2]).T)
    waves, _, _ = on_bins(deep, Water(1.0, depth=1.0), (0.05, -0.04))
    still = Water(1.0, depth=5 / k.min())
    spectrum = leakage.spectrum(replace(waves, omega=still.frequency(k)), GRID, "hann")
    for current in (None, (0.0, 0.0)):
        found = depth.infer_band(spectrum, *BAND, gravity=1.0, current=current)
        assert np.isnan(found.depths[0])
        assert np.isnan(found.velocities).all()
        assert Note.FLAT in found.notes[0]
        assert "hardly feel the bottom" in depth.reasons(found.notes[0])
    shells = depth.infer_shells(spectrum, [0.8, 1.2], gravity=1.0)
    assert np.isnan(shells.depths).all()
    assert all(note & (Note.FLAT | Note.EDGE) for note in shells.notes)


def test_ends_of_the_search_are_no_depths():
    waves, _, h = on_bins(*CASES["middle"])
    spectrum = leakage.spectrum(waves, GRID, "box")
    for limits in ((0.2, 0.6 * h), (1.5 * h, 4.0)):
        found = depth.infer_band(spectrum, *BAND, gravity=1.0, depths=limits)
        assert np.isnan(found.depths[0]) or limits[0] < found.depths[0] < limits[1]
        known = depth.infer_band(spectrum, *BAND, gravity=1.0, depths=limits, current=CASES["middle"][2])
        assert np.isnan(known.depths[0]) or limits[0] < known.depths[0] < limits[1]
        assert known.notes[0] is not Note.NONE
    for bad in ((2.0, 1.0), (0.0, 1.0), (1.0, np.inf), (1.0, 2.0, 3.0)):
        with pytest.raises(LeakrefError):
            depth.infer_band(spectrum, *BAND, gravity=1.0, depths=bad)
    with pytest.raises(LeakrefError, match="current"):
        depth.infer_band(spectrum, *BAND, gravity=1.0, current=(1.0, 2.0, 3.0))


def test_nothing_is_inferred_from_nothing():
    silent = Components(*np.array([[0.5], [0.3], [0.7], [0.0], [0.0]]))
    (spectrum,) = transform(silent, Grid.scaled(4, 6), ("hann",))
    found = depth.infer_shells(spectrum, [1.0], gravity=1.0)
    assert (found.notes[0], np.isnan(found.depths[0])) == (Note.NO_SIGNAL, True)


def test_the_resolution_is_a_bin_over_the_slope():
    k, water, eps = np.array([0.5, 1.0, 1.7]), Water(1.0, depth=1.1), 1e-6
    slope = (
        replace(water, depth=1.1 * (1 + eps)).frequency(k) - replace(water, depth=1.1 * (1 - eps)).frequency(k)
    ) / (2 * eps)
    by_frequency, by_wavenumber = depth_resolutions(k, 0.1, 0.05, water)
    np.testing.assert_allclose(by_frequency, 0.05 / slope, rtol=1e-8)
    np.testing.assert_allclose(by_wavenumber, 0.1 * water.group_velocity(k) / slope, rtol=1e-8)
    assert depth_resolutions(1.0, 0.1, 0.05, Water(1.0, depth=40.0))[0] > 1e20


# ---- ensembles

SMALL = Configuration("depth", length=3, duration=6, depth=1.0)


def bits(found):
    return b"".join(
        getattr(e, name).tobytes() for e in found for name in ("depths", "velocities", "curvature", "notes")
    )


def test_ensembles_are_what_the_plain_chain_gives():
    sea = Configuration("depth", length=5, duration=10, depth=1.0)
    spectra = transform(sea.components(0), sea.grid, sea.windows, route="B")
    for e, (spectrum, current) in zip(
        depths.ensembles(sea, 1), [(s, c) for s in spectra for c in (None, (0.0, 0.0))], strict=True
    ):
        assert (e.window, e.current) == (spectrum.window, "along" if current is None else "known")
        shells = depth.infer_shells(spectrum, depths.WAVENUMBERS, gravity=1.0, current=current)
        bands = [
            depth.infer_band(spectrum, 0.4, 3.5, gravity=1.0, current=current, peak_wavenumber=1.0, each_alike=alike)
            for alike in (False, True)
        ]
        both = depth.gathered([shells, *bands])
        np.testing.assert_allclose(e.depths[0], both.depths, rtol=1e-8)  # 1e-11 in N, over FLAT
        assert e.notes[0].tolist() == [note.value for note in both.notes]


@pytest.mark.parametrize("workers", [ThreadPoolExecutor, pytest.param(runs.pool, marks=pytest.mark.slow)])
def test_neither_workers_nor_what_is_kept_matter(workers, tmp_path, monkeypatch):
    serial = bits(depths.ensembles(SMALL, 3))
    with workers(2) as executor:
        assert bits(depths.ensembles(SMALL, 3, folder=tmp_path, executor=executor)) == serial
    kept = sorted(tmp_path.rglob("*.npz"))
    assert len(kept) == 3
    kept[1].write_bytes(kept[1].read_bytes()[:300])  # damaged: computed again
    shutil.copy(kept[0], kept[2])  # and so is one that is of another realisation
    computed, compute = [], depths._computed
    monkeypatch.setattr(depths, "_computed", lambda c, r: computed.append(r) or compute(c, r))
    assert bits(depths.ensembles(SMALL, 3, folder=tmp_path)) == serial
    assert computed == [1, 2]
    other = bits(depths.ensembles(replace(SMALL, depth=1.5), 3, folder=tmp_path))
    assert other != serial
    with pytest.raises(LeakrefError, match="deep water"):
        depths.ensembles(Configuration("deep"), 1)
    with pytest.raises(LeakrefError, match="at least one"):
        depths.ensembles(SMALL, 0)


# ---- what is said of them


def made_up(window="hann", current="along", kh=1.0, off=0.0, missing=0, **size):
    """Depths that are off by a known part, six of them, of which some are missing."""
    spread = 0.02 * np.array([-1.0, 1.0, -0.5, 0.5, 2.0, -2.0])
    found = kh * (1 + 3.0 + np.repeat(spread[:, None], depths.WAVENUMBERS.size + 2, axis=1))
    found[:, depths.BAND] = kh * (1 + off + spread)  # of all places only the band is off by that
    found[:missing] = np.nan
    notes = np.where(np.isnan(found), Note.FLAT.value, 0)
    rest = np.zeros((*found.shape, 2)), np.ones(found.shape), notes
    return depths.Depths(depths.domain(kh, **size), window, current, found, *rest)


def test_statistics_are_parts_of_the_true_depth():
    e = made_up(off=0.1, kh=1.5)
    spread = 0.02 * np.array([-1.0, 1.0, -0.5, 0.5, 2.0, -2.0])
    np.testing.assert_allclose(e.bias, [*[3.0] * 9, 0.1, 3.0], rtol=1e-12)
    np.testing.assert_allclose(e.random, spread.std(ddof=1), rtol=1e-12)
    few = made_up(off=0.1, missing=5)
    assert few.count.tolist() == [1] * 11
    np.testing.assert_allclose(few.bias[depths.BAND], 0.1 - 0.04, rtol=1e-12)
    assert np.isnan(few.random).all()
    none = made_up(missing=6)
    assert np.isnan(none.bias).all()
    assert none.noted(Note.FLAT).tolist() == [6] * 11
    assert made_up().resolution[2:6] == pytest.approx(
        np.minimum(*depth_resolutions(depths.WAVENUMBERS[2:6], 0.1, 0.05, Water(1.0, depth=1.0)))
    )


def test_the_rows_and_the_answer_are_of_the_band_with_the_current_inferred():
    found = [made_up(w, c, off=0.1 if w == "box" else 0.01) for w in ("box", "hann") for c in depths.CURRENTS]
    found += [made_up("box", "along", 2.0, missing=5), made_up("hann", "along", 2.0, missing=1)]
    rows = json.loads(dump(inferredtables.rows(found)))
    assert [(row["kh"], row["window"]) for row in rows] == [(1, "box"), (1, "hann"), (2, "box"), (2, "hann")]
    assert rows[0]["bias"] == pytest.approx(0.1)
    assert rows[2] == {
        "kh": 2.0, "window": "box", "bias": rows[2]["bias"], "random": None, "count": 1, "realizations": 6
    }  # fmt: skip
    assert inferredtables.answer(inferredtables.rows(found)) == (
        "The depth inferred along with the current, untapered: k0 h = 1: +10.0 ± 2.9 %; k0 h = 2: none in 5 of 6, "
        "where it cannot be told apart. The depth inferred along with the current, tapered: k0 h = 1: +1.0 ± 2.9 %; "
        "k0 h = 2: +0.4 ± 3.0 % (none in 1)."
    )
    record = json.loads(dump(inferredtables.record(found[-1])))
    assert (record["case"], record["band"]["count"], record["flagged"]["flat"][0]) == ("depth/kh=2", 5, 1)
    assert len(record["shells"]["bias"]) == len(record["shells"]["resolution"]) == 9


@pytest.fixture
def small_case(monkeypatch):
    """Case depth on a domain that takes no time."""
    seas = [replace(SMALL, depth=kh, windows=("box", "hann"), varied=("depth",)) for kh in (0.7, 1.0)]
    monkeypatch.setattr(reproduce, "_named", lambda ids: seas if ids == ["depth"] else configurations(ids))
    monkeypatch.setattr(inferredtables, "DEPTHS", (0.7, 1.0))
    monkeypatch.setattr(inferredtables, "DOMAINS", ((3.0, 6.0), (4.0, 6.0)))


def test_the_case_is_reproduced_with_the_depths_inferred(tmp_path, capsys, small_case, monkeypatch):
    how = {"realizations": 2, "route": "B", "out": tmp_path}
    monkeypatch.setattr(reproduce, "_draw", lambda *_: [])
    assert reproduce.run(["depth"], figures=True, json=True, **how)
    found = json.loads(capsys.readouterr().out)
    assert [(row["kh"], row["window"]) for row in found["inferred_depth"]] == [
        (0.7, "box"), (0.7, "hann"), (1.0, "box"), (1.0, "hann")
    ]  # fmt: skip
    assert set(found["inferred_depth"][0]) == {"kh", "window", "bias", "random", "count", "realizations"}
    assert found["inferred_depth_answer"].startswith("The depth inferred along with the current, untapered: k0 h = 0.7")
    assert json.loads((tmp_path / "reproduce.json").read_text(encoding="utf-8")) == found
    assert (tmp_path / "figure_inferred_depth.png").stat().st_size > 10_000
    assert reproduce.run(["depth"], figures=False, json=False, **how)  # from what is kept
    printed = re.sub(r"\s+", " ", capsys.readouterr().out)
    assert found["inferred_depth_answer"] in printed
    assert "depth: the depth inferred" in printed or "depth/kh=1: the depth inferred" in printed


def test_all_domains_are_a_run_of_their_own(tmp_path, capsys, small_case):
    how = {"realizations": 2, "route": "B", "out": tmp_path, "figures": True}
    assert reproduce.run(["inferred-depth"], json=True, **how)
    found = json.loads(capsys.readouterr().out)
    assert len(found["depths"]) == 2 * 2 * 4  # depths, domains, windows and currents
    assert {(r["length"], r["duration"]) for r in found["depths"]} == {(3, 6), (4, 6)}
    assert {path.name for path in tmp_path.glob("*.png")} == {
        "figure_inferred_depth_L3_T6.png", "figure_inferred_depth_L4_T6.png", "figure_inferred_depth_domains.png"
    }  # fmt: skip
    with pytest.raises(LeakrefError, match="by itself"):
        reproduce.run(["inferred-depth", "gamma"], json=True, **how)
    assert inferredtables.fewer(20, 20.0, 80.0) == 4
    assert inferredtables.fewer(20, 20.0, 20.0) == 20


def test_the_figures_can_be_drawn_of_what_is_stored():
    records = [
        json.loads(dump(inferredtables.record(made_up(w, c, kh, off=0.05, missing=m, length=size))))
        for w in ("box", "hann")
        for c in depths.CURRENTS
        for kh, m in ((0.7, 0), (2.0, 6))
        for size in (5.0, 10.0)
    ]
    assert len(inferredfigure.shells_figure(records[::2]).axes) == 4
    assert len(inferredfigure.domains_figure(records).axes) == 2


def test_measured_low_shells_are_too_deep_high_ones_too_shallow_and_tapered_less_so():
    """What leaks from stronger waves has their frequency: too fast for longer waves, too slow for shorter ones."""
    sea = depths.domain(0.7, 5.0, 10.0)
    found = {e.window: e for e in depths.ensembles(sea, 4) if e.current == "known"}
    for e in found.values():
        assert e.bias[2] > 2 * e.random[2] / 2 > 0  # k = 0.8, four realisations
        assert e.bias[6] < -2 * e.random[6] / 2 < 0  # k = 1.6
    for place in (2, 6, depths.BAND):
        assert abs(found["hann"].bias[place]) < abs(found["box"].bias[place])


def test_the_claim_takes_what_is_kept_and_no_decision_is_judged_by_it(tmp_path):
    evidence = Evidence(2, tmp_path)
    found = evidence.depths(SMALL)
    assert bits(found) == bits(depths.ensembles(SMALL, 2))
    assert evidence.depths(SMALL) is found
    assert len(list(tmp_path.rglob("*.npz"))) == 2
    with pytest.raises(NotCovered):
        Altered(evidence).depths(SMALL)


# ---------------------------------------------------------------- what is kept in golden/


def kept_records():
    return beside.read("inferred_depth.json")["depths"]


def test_what_is_kept_is_of_a_hundred_seas_at_each_depth():
    records = kept_records()
    assert [(r["kh"], r["window"], r["current"]) for r in records] == [
        (kh, window, current) for kh in depths.DEPTHS for window in ("box", "hann") for current in depths.CURRENTS
    ]
    assert {r["realizations"] for r in records} == {100}
    by = {(r["kh"], r["window"], r["current"]): r for r in records}
    assert abs(by[1.0, "hann", "along"]["band"]["bias"]) < 0.03 < by[2.0, "hann", "along"]["band"]["bias"]
    assert by[2.0, "box", "along"]["band"]["count"] == 0  # and then there is no number
    assert by[2.0, "box", "along"]["band"]["bias"] is None


@pytest.mark.parametrize(
    ("kh", "window", "route"),
    [
        (1.0, "hann", "B"),
        pytest.param(0.7, "box", "B", marks=pytest.mark.slow),
        pytest.param(1.5, "hann", "A", marks=pytest.mark.slow),
    ],
)
def test_what_is_kept_is_what_the_plain_chain_finds(kh, window, route):
    """Sea by sea, by the whole spectrum in closed form or by surface and FFT, in place of the fast path."""
    c = depths.domain(kh)
    reach = 3.5 + 3 * c.grid.wavenumber_resolution
    (spectrum,) = transform(c.components(1), c.grid, (window,), route=route, largest_wavenumber=reach)
    shells = depths.WAVENUMBERS[[1, 4, 7]]
    for record in (r for r in kept_records() if (r["kh"], r["window"]) == (kh, window)):
        how = {"gravity": 1.0, "current": (0.0, 0.0) if record["current"] == "known" else None}
        band = depth.infer_band(spectrum, 0.4, 3.5, peak_wavenumber=1.0, **how).depths
        each = depth.infer_shells(spectrum, shells, peak_wavenumber=1.0, **how).depths
        golden = np.array(record["first"][1], dtype=float)
        np.testing.assert_allclose([*each, *band], golden[[1, 4, 7, depths.BAND]], rtol=1e-8)
