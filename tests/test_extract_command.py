"""`leakref export` and `leakref extract`, as a user types them."""

from __future__ import annotations

import csv
import hashlib
import json
import re
import subprocess
import sys

import numpy as np
import pytest
import xarray
from typer.testing import CliRunner

from leakref import Components, Grid, LeakrefError, Scales, SeaState, UniformCurrent, chain, synthesize
from leakref.cases import configurations
from leakref.cli.base import app
from leakref.cubes import files, measuring, wavenumbers
from leakref.dispersion import DEEP, velocity_resolutions

CASE = "L-T/L=5,T=10"
SUFFIX = {"npz": "npz", "mat": "mat", "netcdf": "nc"}
SCALES = {"scaled": None, "sea": (0.3, 9.81), "tank": (25.0, 9.81)}


def run(*words, status=0):
    """Output of a command; its status is checked, and that nothing but the refusal's one line is on stderr."""
    done = CliRunner().invoke(app, [str(word) for word in words], catch_exceptions=False)
    assert done.exit_code == status, done.stderr
    return done


def answer(*words, status=0):
    done = run(*words, "--json", status=status)
    assert done.stdout.count("\n") == 1
    return json.loads(done.stdout)


def in_memory(units, wavenumbers, **settings):
    """What the chain returns for the case, made without `files`: by its waves, its grid and its synthesis."""
    configuration, grid = configurations([CASE])[0], configurations([CASE])[0].grid
    waves, gravity = configuration.components(7), 1.0
    if units != "scaled":
        gravity = SCALES[units][1]
        scales = Scales(*SCALES[units])
        waves = waves.to_units(scales)
        grid = Grid(
            grid.shape,
            (grid.spacing[0] * scales.length, grid.spacing[1] * scales.length, grid.spacing[2] * scales.time),
        )
    eta = synthesize(waves, *(grid.samples(axis) for axis in range(3)))
    return chain.extract(eta, grid.spacing, wavenumbers, gravity=gravity, **settings).velocities


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cubes")

    def export(units, format):
        path = folder / f"{units}.{SUFFIX[format]}"
        if not path.exists():
            scale = SCALES[units]
            words = [] if scale is None else ["--peak-wavenumber", scale[0], "--gravity", scale[1]]
            said = answer("export", CASE, "--realization", 7, "--format", format, "--out", path, *words)
            assert said["path"] == str(path)
            assert said["sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()
        return path

    return export


@pytest.mark.parametrize("format", files.FORMATS)
@pytest.mark.parametrize("units", SCALES)
def test_export_then_extract_is_the_chain_in_memory(exported, units, format):
    k0, c0 = (1.0, 1.0) if units == "scaled" else (Scales(*SCALES[units]).wavenumber, Scales(*SCALES[units]).velocity)
    given = answer("extract", exported(units, format), "--wavenumbers", f"{0.8 * k0!r},{2.2 * k0!r}")
    expected = in_memory(units, np.array([0.8 * k0, 2.2 * k0]))
    measured = np.array(given["doppler_shift_velocities"])
    assert np.abs(expected).max() > 1e-4 * c0  # there is something to compare
    if format == "npz":
        assert np.array_equal(measured, expected)
    else:
        assert np.abs(measured - expected).max() <= 1e-12 * c0
    assert given["wavenumbers"] == [0.8 * k0, 2.2 * k0]
    assert given["units"]["velocity"] == ("c0" if units == "scaled" else "m/s")
    assert (given["schema"], given["ok"], given["flags"]) == ("leakref/extract/1", True, [[], []])


def test_other_windows_and_methods_reach_the_chain(exported):
    given = answer("extract", exported("scaled", "npz"), "--wavenumbers", "1.2", "--window", "box", "--method", "ls")
    assert given["doppler_shift_velocities"] == in_memory("scaled", [1.2], window="box", method="ls").tolist()
    assert given["doppler_shift_velocities"] != in_memory("scaled", [1.2]).tolist()


def test_the_name_of_the_file_says_its_format(tmp_path):
    for name, format in (("a.mat", "mat"), ("a.nc", "netcdf"), ("a.npz", "npz"), ("a.dat", "npz")):
        assert answer("export", CASE, "--realization", 7, "--out", tmp_path / name)["format"] == format
        files.read(tmp_path / name)


def test_export_is_deterministic_and_realisations_differ(exported, tmp_path):
    again = answer("export", CASE, "--realization", 7, "--format", "mat", "--out", tmp_path / "b.mat")
    other = answer("export", CASE, "--realization", 8, "--format", "mat", "--out", tmp_path / "c.mat")
    assert again["sha256"] == hashlib.sha256(exported("scaled", "mat").read_bytes()).hexdigest() != other["sha256"]


def test_the_truth_is_in_the_file(exported):
    cube = files.read(exported("sea", "npz"))
    waves = configurations([CASE])[0].components(7).to_units(Scales(0.3, 9.81))
    assert np.array_equal(cube.components.omega, waves.omega)
    assert cube.peak_wavenumber == 0.3
    assert cube.current.tolist() == [0, 0]


# --- a small cube of one's own ---------------------------------------------------------------------------------------

GRID = Grid((52, 60, 64), (0.6, 0.55, 0.8))
CURRENT = (0.08, -0.05)


@pytest.fixture(scope="module")
def sea(tmp_path_factory):
    """A broad sea on a current, sampled on a grid with no two sides alike."""
    waves = SeaState(direction=70, spread=60, length=5, current=UniformCurrent(CURRENT)).components(1)
    surface = synthesize(waves, *(GRID.samples(axis) for axis in range(3)))
    path = tmp_path_factory.mktemp("sea") / "sea.npz"
    files.write(path, files.Cube(surface, GRID, 1.0, "scaled"), "npz")
    return path, surface


def test_the_current_is_found_where_there_is_signal(sea):
    given = answer("extract", sea[0])
    k, c = np.array(given["wavenumbers"]), np.array(given["doppler_shift_velocities"])
    dk = GRID.wavenumber_resolution
    np.testing.assert_allclose(k / dk, np.rint(k / dk), rtol=0, atol=1e-9)
    assert np.rint(k / dk).min() >= 4
    assert k.max() + 2 * dk < np.pi / 0.6
    resolution = np.maximum(*velocity_resolutions(k, dk, GRID.frequency_resolution, water=DEEP))
    high = k > 1.2  # below, tapered biases reach the resolution (the paper's A8)
    assert high.sum() >= 5
    assert np.all(np.hypot(*(c - CURRENT).T)[high] < resolution[high])
    np.testing.assert_allclose(given["resolution_frequency"], GRID.frequency_resolution / k, rtol=1e-14)
    np.testing.assert_allclose(given["resolution_wavenumber"], dk / k / np.sqrt(k) / 2, rtol=1e-14)


def test_wavenumbers_as_list_and_as_range():
    assert wavenumbers.parse_wavenumbers("0.4,0.5").tolist() == [0.4, 0.5]
    np.testing.assert_allclose(wavenumbers.parse_wavenumbers("0.4:3.5:0.1"), np.linspace(0.4, 3.5, 32), rtol=1e-14)
    assert wavenumbers.parse_wavenumbers("2:2:1").tolist() == [2]
    for bad in ("", "a", "1,,2", "1:2", "2:1:0.1", "1:2:0", "1:2:-1", "nan", "1:2:1e-9", "1:2:3:4"):
        with pytest.raises(LeakrefError, match="--wavenumbers"):
            wavenumbers.parse_wavenumbers(bad)


def test_default_wavenumbers_fill_what_is_whole():
    dk = GRID.wavenumber_resolution
    k = wavenumbers.default_wavenumbers(GRID)
    assert k[0] == 4 * dk
    assert k[-1] + 2 * dk < np.pi / 0.6 <= k[-1] + 3 * dk
    with pytest.raises(LeakrefError, match="no whole shell"):
        wavenumbers.default_wavenumbers(Grid((8, 8, 8), (1, 1, 1)))


def test_npy_in_any_order_with_spacing(sea, tmp_path):
    path, surface = sea
    np.save(tmp_path / "cube.npy", surface.transpose(2, 1, 0))
    spacing = ",".join(repr(d) for d in GRID.spacing)
    words = (
        "extract",
        tmp_path / "cube.npy",
        "--spacing",
        spacing,
        "--axes",
        "tyx",
        "--gravity",
        1,
        "--wavenumbers",
        "1.5",
    )
    given = answer(*words)
    assert (
        given["doppler_shift_velocities"] == answer("extract", path, "--wavenumbers", "1.5")["doppler_shift_velocities"]
    )
    assert given["units"]["system"] == "given"
    assert "m/s" not in run(*words).stdout
    assert "coordinate x" in run("extract", tmp_path / "cube.npy", "--gravity", 1, "--axes", "tyx", status=2).stderr
    lacking = run("extract", tmp_path / "cube.npy", "--gravity", 1, "--spacing", spacing, status=2).stderr
    assert "says nothing of the order of its axes; pass --axes" in lacking


def test_a_mapped_cube_in_blocks_gives_the_same(sea, tmp_path, monkeypatch):
    surface = sea[1]
    np.save(tmp_path / "cube.npy", (1000 * surface).round().astype(np.int32))
    words = (
        "extract",
        tmp_path / "cube.npy",
        "--spacing",
        ",".join(map(repr, GRID.spacing)),
        "--axes",
        "xyt",
        "--gravity",
        1,
        "--detrend",
        "linear",
    )
    whole = answer(*words, "--wavenumbers", "1.2:2:0.4")
    monkeypatch.setattr(measuring, "IN_MEMORY", 10**5)
    monkeypatch.setattr(measuring.blocks, "_BLOCK", 10**5)
    monkeypatch.setattr(measuring, "fourier", None)  # not to be used
    parts = answer(*words, "--wavenumbers", "1.2:2:0.4")
    assert any("in blocks" in note for note in parts["notes"])
    np.testing.assert_allclose(parts["doppler_shift_velocities"], whole["doppler_shift_velocities"], rtol=0, atol=1e-11)
    by_default = answer(*words)["wavenumbers"]
    monkeypatch.setattr(measuring, "KEPT", 10**6)  # what memory allows now is less than what there is
    fewer = answer(*words)["wavenumbers"]
    assert 0 < len(fewer) < len(by_default)
    monkeypatch.setattr(measuring, "KEPT", 10**5)
    refused = run(*words, "--wavenumbers", "1.2,2", status=2).stderr
    assert "ask for wavenumbers up to some" in refused
    assert float(refused.partition("up to some ")[2].split()[0]) < 2
    assert "too large" in run(*words, "--screen", "--rotate", 20, status=2).stderr


@pytest.mark.parametrize("detrend", ["mean", "linear"])
def test_what_is_removed_is_said_and_what_it_was_for_is_gone(sea, tmp_path, detrend):
    path, surface = sea
    x, y, t = (np.arange(n) - (n - 1) / 2 for n in GRID.shape)
    added = 1000.0
    if detrend == "linear":
        added = added + (3 * x[:, None] - 2 * y)[:, :, None] + t
    files.write(tmp_path / "b.npz", files.Cube(surface + added, GRID, 1.0, "scaled"), "npz")
    words = ("--wavenumbers", "1,1.6", "--window", "box")
    plain = np.array(answer("extract", path, *words, "--detrend", detrend)["doppler_shift_velocities"])
    removed = answer("extract", tmp_path / "b.npz", *words, "--detrend", detrend)
    np.testing.assert_allclose(removed["doppler_shift_velocities"], plain, rtol=0, atol=1e-8)
    if detrend == "linear":  # untapered, a slope that stays leaks into everything
        left = answer("extract", tmp_path / "b.npz", *words)["doppler_shift_velocities"]
        assert np.abs(np.array(left) - plain).max() > 1e-3
        np.testing.assert_allclose(removed["removed"]["slopes_per_sample"], [3, -2, 1], atol=1e-2)
    assert removed["removed"]["trend"] == detrend
    assert removed["removed"]["mean"] == pytest.approx(1000, abs=0.1)
    said = run("extract", tmp_path / "b.npz", "--wavenumbers", "1", "--detrend", detrend).stdout
    assert "removed" in said
    assert "the mean, 1000" in said
    assert "neither mean nor trend" in run("extract", path, "--wavenumbers", "1").stdout


def test_everything_written_agrees_and_is_whole(sea, tmp_path):
    out = tmp_path / "results"
    water = ("--depth", "5", "--surface-tension", "0.001")
    given = answer("extract", sea[0], "--wavenumbers", "1,1.5,2", "--screen", "--out", out, *water)
    assert json.loads((out / "extract.json").read_text()) == given
    with (out / "extract.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [[float(row["cx"]), float(row["cy"])] for row in rows] == given["doppler_shift_velocities"]
    assert [row["verdict"] for row in rows] == given["verdicts"]
    with xarray.open_dataset(out / "extract.nc") as data:
        assert data["cx"].values.tolist() == [c[0] for c in given["doppler_shift_velocities"]]
        assert data["verdict"].values.tolist() == given["verdicts"]
        assert data["wavenumber"].values.tolist() == given["wavenumbers"]
        assert (data.attrs["depth"], data.attrs["surface_tension"]) == (5, 0.001)
    assert {path.name for path in out.iterdir()} == {
        "extract.json",
        "extract.csv",
        "extract.nc",
        "extract.png",
        "extract.svg",
        "screen.png",
        "screen.svg",
    }
    assert min(path.stat().st_size for path in out.glob("*.png")) > 10_000


def test_table_holds_velocities_resolutions_and_flags(sea):
    said = run("extract", sea[0], "--wavenumbers", "1,2").stdout
    c = answer("extract", sea[0], "--wavenumbers", "1,2")["doppler_shift_velocities"]
    assert all(f"{value:.4f}" in said for row in c for value in row)
    assert all(word in said for word in ("domega / k", "cg dk / k", "flags", "in c0"))


def test_where_there_is_no_number_there_is_null(tmp_path):
    """Waves on bins, untapered: nothing but rounding in the other shells."""
    kx, ky, omega = GRID.bin_widths
    waves = Components([5 * kx, 0.0], [0.0, 6 * ky], [10 * omega, 11 * omega], [1.0, 1.0], [0.0, 1.0])
    surface = synthesize(waves, *(GRID.samples(axis) for axis in range(3)))
    files.write(tmp_path / "a.npz", files.Cube(surface, GRID, 1.0), "npz")
    far = 14 * GRID.wavenumber_resolution
    given = answer("extract", tmp_path / "a.npz", "--window", "box", "--wavenumbers", f"{5 * kx!r},{far!r}")
    assert given["doppler_shift_velocities"][1] is None
    assert given["doppler_shift_velocities"][0] is not None
    assert given["flags"][1] == ["no-signal"]


# --- wrong use -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--window", "square"], "no window named 'square'"),
        (["--method", "fft"], "no method named 'fft'"),
        (["--detrend", "cubic"], "--detrend cubic"),
        (["--rotate", "10"], "--screen"),
        (["--spacing", "1"], "--spacing 1 is not 3"),
        (["--spacing", "1,2,-1"], "not positive"),
        (["--axes", "xxt"], "xxt"),
        (["--gravity", "-1"], "gravity = -1"),
        (["--wavenumbers", "4:1:1"], "is no range"),
        (["--wavenumbers", "99"], "Nyquist"),
        (["--wavenumbers", "-1"], "not positive"),
        (["--screen", "--rotate", "nan"], "not finite"),
        (["--out", "/dev/null/x"], "nothing can be written"),
    ],
)
def test_wrong_use_is_refused_in_one_line_and_nothing_is_written(sea, tmp_path, words, said):
    where = [] if "--out" in words else ["--out", tmp_path / "results"]
    done = run(
        "extract",
        sea[0],
        *(["--wavenumbers", "1"] if "--wavenumbers" not in words else []),
        *words,
        *where,
        "--json",
        status=2,
    )
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert re.search(said, done.stderr)
    assert "Traceback" not in done.stderr
    assert not list((tmp_path / "results").glob("*"))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["gamma"], "12 configurations"),
        (["nonsense"], "no case is called 'nonsense'"),
        ([CASE, "--format", "xls"], "npz, mat, netcdf"),
        ([CASE, "--gravity", "9.81"], "--peak-wavenumber"),
        ([CASE, "--peak-wavenumber", "0.1"], "give both"),
        ([CASE, "--peak-wavenumber", "0", "--gravity", "9"], "positive"),
        ([CASE, "--realization", "-1"], "--realization"),
    ],
)
def test_exports_that_are_refused(tmp_path, words, said):
    done = run("export", *words, "--out", tmp_path / "a.npz", status=2)
    assert said in done.stderr
    assert not list(tmp_path.iterdir())


def test_samples_that_are_not_finite_in_a_mapped_file(tmp_path, monkeypatch):
    surface = np.zeros(GRID.shape)
    surface[3, 4, 5] = np.inf
    np.save(tmp_path / "a.npy", surface)
    words = ("extract", tmp_path / "a.npy", "--spacing", "1,1,1", "--axes", "xyt", "--gravity", 1, "--wavenumbers", "1")
    for limit in (2**30, 10**5):
        monkeypatch.setattr(measuring, "IN_MEMORY", limit)
        refused = run(*words, status=2).stderr
        assert "a.npy" in refused
        assert "not finite" in refused
        assert refused.count("\n") == 1


@pytest.mark.parametrize("size", [0.0, 1.0])
def test_a_cube_of_nothing_or_of_noise_falls_short(tmp_path, size):
    noise = size * np.random.default_rng(0).normal(size=GRID.shape)
    files.write(tmp_path / "a.npz", files.Cube(noise, GRID, 1.0), "npz")
    said = run("extract", tmp_path / "a.npz", status=1).stdout
    assert "No dispersion shell: no shell holds more than noise." in said
    given = answer("extract", tmp_path / "a.npz", status=1)
    assert not given["ok"]
    assert len(given["shell"]) == len(given["wavenumbers"])
    assert max(one or 0 for one in given["shell"]) == 0


def test_a_real_process_keeps_its_streams_apart(sea):
    command = [sys.executable, "-c", "from leakref.cli import main; main()"]
    done = subprocess.run(
        [*command, "extract", str(sea[0]), "--wavenumbers", "1.5", "--json"],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0
    assert json.loads(done.stdout)["wavenumbers"] == [1.5]
    bad = subprocess.run([*command, "extract", str(sea[0].parent)], capture_output=True, text=True, timeout=120)
    assert (bad.returncode, bad.stdout) == (2, "")
    assert bad.stderr.strip().endswith(
        "without images; name the file with the cube in it, or a folder of PNG or TIFF images."
    )
