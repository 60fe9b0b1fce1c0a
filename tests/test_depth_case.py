"""Case depth: measured with the depth known and with deep water assumed; what is exported of it says its depth."""

from __future__ import annotations

import json
from dataclasses import replace
from io import StringIO

import numpy as np
import pytest
import xarray
from rich.console import Console
from test_figures import unreadable
from typer.testing import CliRunner

from leakref import runs
from leakref._base import LeakrefError
from leakref.cases import ASSUMED_DEEP, CASES, PAPER_CASES, Configuration, configurations
from leakref.cli import app
from leakref.cubes import files
from leakref.cubes.formats import variables
from leakref.dispersion import DEEP, Scales, Water
from leakref.explain import explain
from leakref.paper import depth, reproduce
from leakref.paper.depthfigure import depth_figure
from leakref.paper.figures import stored

SMALL = [replace(c, length=5.0, duration=10.0) for c in (*CASES["depth"][1:3], *ASSUMED_DEEP[1:3])]


@pytest.fixture(scope="module")
def measured():
    """Some realisations on a smaller domain, both ways."""
    return [e for found in runs.run(SMALL, realizations=4) for e in found]


def test_the_missing_depth_is_seen_as_a_current_against_the_waves(measured):
    """As large as the phase velocity is too large: (omega0 / k) (1 / sqrt(tanh(k h)) - 1), the waves going to +y."""
    seen = 0
    for e in measured:
        if e.window == "hann" and e.method == "nsp":
            k = e.wavenumbers
            on = (k >= 1) & (k <= 2)
            off = (e.configuration.water.phase_velocity(k) - DEEP.phase_velocity(k))[on]
            error = np.array([np.zeros(on.sum()), off if e.configuration.assumed else 0 * off]).T
            finest = np.minimum(*e.resolutions)[on]
            assert (np.hypot(*(e.mean[on] - error).T) < finest).all(), e.configuration.id
            seen += bool(e.configuration.assumed) and float(np.abs(off[0])) > finest[0]
    assert seen == 1  # k0 h = 1, which is beyond the resolution


def test_the_table_of_mistakes(measured):
    rows = depth.mistakes(measured)
    assert [(r.kh, r.window, r.method) for r in rows] == [
        (kh, window, method) for kh in (1.0, 1.5) for window in ("box", "hann") for method in ("nsp", "ls")
    ]
    row = next(r for r in rows if (r.kh, r.window, r.method) == (1.0, "hann", "nsp"))
    assert row.wavenumbers == pytest.approx(depth.AT)
    known, deep = (
        next(e for e in measured if e.configuration.id == name and (e.window, e.method) == ("hann", "nsp"))
        for name in ("depth/kh=1", "depth/kh=1,assumed=deep")
    )
    at = [5 - 2, 7 - 2, 9 - 2]  # k = 1, 1.4, 1.8 in bins of 0.2, the first shell at 0.4
    assert row.known == pytest.approx(known.bias[at])
    assert row.deep == pytest.approx(deep.bias[at])
    assert row.resolution == pytest.approx(np.minimum(*known.resolutions)[at])
    assert set(row.record()) == {"kh", "window", "method", "wavenumbers", "known", "deep", "resolution"}
    assert not depth.mistakes([e for e in measured if e.configuration.assumed is None])
    shown = StringIO()
    Console(file=shown, width=100).print(depth.mistakes_table(rows, 4))
    assert shown.getvalue().count(" -> ") == 3 * len(rows) + 1
    assert f"{row.known[0]:.3f} -> {row.deep[0]:.3f}" in shown.getvalue()


def test_the_figure_can_be_read(measured):
    assert unreadable(depth_figure(measured, "What it costs to take water for deep, 4 realisations")) == []
    known = [e for e in measured if e.configuration.assumed is None]
    words = [text.get_text() for text in depth_figure(known, "known").legends[0].get_texts()]
    assert "depth known" in words
    assert "deep water assumed" not in words


def test_the_case_is_measured_both_ways_and_one_configuration_as_it_is():
    assert reproduce._named(["depth"]) == [*CASES["depth"], *ASSUMED_DEEP]
    assert reproduce._named(["depth/kh=1"]) == list(configurations(["depth/kh=1"]))
    assert reproduce._named(["depth/kh=2,assumed=deep"]) == [ASSUMED_DEEP[-1]]
    with pytest.raises(LeakrefError, match=r"no case is called 'depth/kh=3'.*depth/kh=0\.7"):
        reproduce._named(["depth/kh=3"])


def test_all_is_the_paper_and_no_more(monkeypatch, tmp_path):
    asked = []
    monkeypatch.setattr(reproduce, "run", lambda ids, **_: asked.append(ids) or True)
    assert CliRunner().invoke(app, ["reproduce", "--all", "--out", str(tmp_path)]).exit_code == 0
    assert asked == [list(PAPER_CASES)]
    assert {e.configuration.case for e in stored()} == set(PAPER_CASES)


def test_it_is_reproduced_like_any_case(tmp_path):
    words = "reproduce depth/kh=1 depth/kh=1,assumed=deep L-T/L=5,T=10 --realizations 1 --workers 1 --figures --json"
    done = CliRunner().invoke(app, [*words.split(), "--out", str(tmp_path)], catch_exceptions=False)
    assert done.exit_code == 0
    found = json.loads(done.stdout)
    assert [case["case"] for case in found["cases"][::4]] == ["depth/kh=1", "depth/kh=1,assumed=deep", "L-T/L=5,T=10"]
    assert [case.get("assumed_depth", "none") for case in found["cases"][::4]] == [1.0, None, "none"]
    assert {case.get("depth") for case in found["cases"][:8]} == {1.0}
    assert len(found["assumed_deep"]) == 4
    assert all(row["deep"][0] > 3 * row["known"][0] for row in found["assumed_deep"] if row["window"] == "hann")
    for name in ("figure_depth.png", "figure_depth.svg", "figure_L-T.png", "depth_kh1_hann_nsp.csv"):
        assert (tmp_path / name).stat().st_size > 100
    assert (tmp_path / "depth_kh1_assumeddeep_hann_nsp.csv").exists()


@pytest.mark.parametrize("format", ["npz", "mat"])
@pytest.mark.parametrize(("scales", "water"), [(None, (0.5, 0.1)), (Scales(0.4, 9.81), (1.25, 0.1 * 9.81 / 0.16))])
def test_an_exported_cube_says_its_depth_and_its_tension(format, scales, water, tmp_path):
    c = Configuration("small", length=1.5, duration=1.0, depth=0.5, surface_tension=0.1, assumed=DEEP)
    cube = files.of_configuration(c, 2, scales)
    path = files.write(tmp_path / f"cube.{format}", cube, format)
    found = variables(path, ("depth", "surface_tension", "gravity", "omega", "kx", "ky"))
    assert [float(found[name].squeeze()) for name in ("depth", "surface_tension")] == pytest.approx(water)
    law = Water(float(found["gravity"].squeeze()), *water)
    omega = law.frequency(np.hypot(found["kx"], found["ky"]))
    np.testing.assert_allclose(found["omega"], omega, rtol=1e-13)


def test_a_cube_of_deep_water_is_written_as_ever(tmp_path):
    cube = files.of_configuration(Configuration("small", length=1.5, duration=1.0), 2)
    path = files.write(tmp_path / "cube.npz", cube, "npz")
    with np.load(path) as stored_in:
        assert not {"depth", "surface_tension"} & set(stored_in.files)


def test_netcdf_gives_them_units(tmp_path):
    c = Configuration("small", length=1.5, duration=1.0, depth=0.5)
    path = files.write(tmp_path / "cube.nc", files.of_configuration(c, 0, Scales(0.4, 9.81)), "netcdf")
    with xarray.open_dataset(path, engine="h5netcdf") as data:
        assert (float(data.depth), data.depth.units, data.surface_tension.units) == (1.25, "m", "m3 s-2")


def test_the_command_exports_it(tmp_path):
    out = tmp_path / "cube.npz"
    done = CliRunner().invoke(
        app, ["export", "depth/kh=0.7", "--out", str(out), "--peak-wavenumber", "0.2", "--gravity", "9.81", "--json"]
    )
    assert done.exit_code == 0, done.output
    said = json.loads(done.stdout)
    assert (said["depth"], said["surface_tension"]) == (pytest.approx(3.5), 0)
    assert float(variables(out, ("depth",))["depth"]) == pytest.approx(3.5)


@pytest.mark.parametrize("name", ["depth/kh=1", "L-T/L=5,T=10"])
def test_a_case_is_no_id_to_explain_and_the_command_that_runs_it_is_told(name):
    with pytest.raises(LeakrefError, match="is a case") as refused:
        explain(name)
    assert f"leakref reproduce {name}" in refused.value.remedy
