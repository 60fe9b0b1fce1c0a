"""Users' files from rivers, coasts and tanks: the depth and surface tension asked for, or in the file, are those used.

Each cube is made by the chain in its own water, with a known current, and told to be in deep water, in its own and in
another: what is wrong is said, with the depth that comes right.
"""

from __future__ import annotations

import json
import re
from dataclasses import dataclass

import numpy as np
import pytest
import xarray
from scipy.io import savemat
from typer.testing import CliRunner

from leakref import Grid, LeakrefError, Scales, SeaState, UniformCurrent, Water, synthesize
from leakref.chain import extract as chain
from leakref.cli.base import app
from leakref.cubes.reading import read
from leakref.dispersion import velocity_resolutions
from leakref.planning.quantities import CLEAN_WATER


@dataclass(frozen=True)
class Site:
    """A place with its water (m, m3/s2), its waves' peak (m), and a current (2,) in c0; angles in degrees."""

    depth: float
    peak: float
    tension: float = 0.0
    current: tuple[float, float] = (0.14, -0.08)
    direction: float = 70.0
    shape: tuple[int, int, int] = (48, 56, 110)

    @property
    def scales(self):
        return Scales(2 * np.pi / self.peak, 9.81)

    @property
    def water(self):
        return Water(9.81, self.depth, self.tension)

    @property
    def grid(self):
        s = self.scales
        return Grid(self.shape, (0.62 * s.length, 0.56 * s.length, 0.52 * s.time))

    @property
    def truth(self):
        return np.array(self.current) * self.scales.velocity

    def surface(self):
        sea = SeaState(
            self.direction, 60, length=5, current=UniformCurrent(self.current), water=self.water.to_scaled(self.scales)
        )
        return synthesize(sea.components(2).to_units(self.scales), *(self.grid.samples(axis) for axis in range(3)))


SITES = {
    "river": Site(depth=0.8, peak=2.0),
    "ford": Site(depth=0.4, peak=3.0),
    "coast": Site(depth=3.0, peak=22.0, direction=20.0),
    "tank": Site(depth=0.05, peak=0.06, tension=CLEAN_WATER, current=(-0.1, 0.16)),
    "ocean": Site(depth=60.0, peak=40.0),
}


@pytest.fixture(scope="module")
def seas():
    return {name: site.surface() for name, site in SITES.items()}


def held(site, surface, **more):
    x, y, t = (site.grid.samples(axis) for axis in range(3))
    return {"eta": surface, "x": x, "y": y, "t": t, "gravity": 9.81, "units": "si", "axes": "xyt", **more}


def written(folder, kind, site, surface, **more):
    """A file as people have them: in mat version 5, npz, or NetCDF with units on everything."""
    variables = held(site, surface, **more)
    if kind == "npz":
        np.savez(folder / "a.npz", **variables)
        return folder / "a.npz"
    if kind == "mat":
        savemat(folder / "a.mat", variables)
        return folder / "a.mat"
    units = {"x": "m", "y": "m", "t": "s", "depth": "m", "surface_tension": "m3 s-2", "gravity": "m s-2"}
    data = {name: ((name,), variables[name], {"units": units[name]}) for name in "xyt"}
    data["eta"] = (("x", "y", "t"), surface, {"units": "m"})
    data |= {name: ((), variables[name], {"units": units[name]}) for name in ("gravity", *more)}
    xarray.Dataset(data).to_netcdf(folder / "a.nc", engine="h5netcdf")
    return folder / "a.nc"


def extract(path, *options, status=0):
    done = CliRunner().invoke(app, ["extract", str(path), *map(str, options), "--json"], catch_exceptions=False)
    assert done.exit_code == status, done.stderr + done.stdout
    return json.loads(done.stdout) if status < 2 else " ".join(done.stderr.split())


def off(site, given, up_to=2.4):
    """Errors over the larger resolution, at wavenumbers from the peak's to `up_to` times it."""
    k = np.array(given["wavenumbers"])
    here = (k > 0.95 * site.scales.wavenumber) & (k < up_to * site.scales.wavenumber)
    errors = np.hypot(*(np.array(given["doppler_shift_velocities"])[here] - site.truth).T)
    bins = site.grid.wavenumber_resolution, site.grid.frequency_resolution
    return errors / np.maximum(*velocity_resolutions(k[here], *bins, site.water))


# --- right where the water is known -----------------------------------------------------------------------------------
@pytest.mark.parametrize("kind", ["mat", "npz", "netcdf"])
@pytest.mark.parametrize("name", ["river", "coast", "tank"])
@pytest.mark.parametrize("whence", ["options", "the file"])
def test_the_current_is_found_in_the_water_that_there_is(tmp_path, seas, name, kind, whence):
    site = SITES[name]
    water = {"depth": site.depth} | ({"surface_tension": site.tension} if site.tension else {})
    options = ()
    if whence == "options":
        options = ("--depth", f"{100 * site.depth:g} cm")
        options += ("--surface-tension", "water") if site.tension else ()
        water = {}
    given = extract(written(tmp_path, kind, site, seas[name], **water), *options)
    assert off(site, given).max() < 1
    assert (given["shell_band"]["holds"], given["shell_band"]["words"]) == (True, [])
    assert min(given["shell"]) > 1
    low, high = given["shell_band"]["depths"]
    assert low <= site.depth * 1.0001
    assert high is None or high >= site.depth * 0.9999
    assumed = given["assumed"]
    assert (assumed["depth"], assumed["surface_tension"]) == pytest.approx((site.depth, site.tension), rel=1e-12)
    assert assumed["from"]["depth"] == ("--depth" if whence == "options" else "the file")
    assert (given["depth"], given["surface_tension"]) == (assumed["depth"], assumed["surface_tension"])


def test_it_is_the_chain_in_that_water(tmp_path, seas):
    """To the last bit: velocities, and the resolutions beside them; and the screen is in it too."""
    site = SITES["coast"]
    path = written(tmp_path, "npz", site, seas["coast"], depth=3.0)
    given = extract(path, "--wavenumbers", "0.3,0.4", "--screen")
    own = chain(seas["coast"], site.grid.spacing, [0.3, 0.4], water=site.water)
    assert given["doppler_shift_velocities"] == own.velocities.tolist()
    bins = site.grid.wavenumber_resolution, site.grid.frequency_resolution
    of_frequency, of_wavenumber = velocity_resolutions(np.array([0.3, 0.4]), *bins, site.water)
    assert given["resolution_wavenumber"] == of_wavenumber.tolist()
    assert given["screen"]["tapered"] == own.velocities.tolist()
    assert given["screen"]["resolution"] == np.maximum(of_frequency, of_wavenumber).tolist()
    untapered = chain(seas["coast"], site.grid.spacing, [0.3, 0.4], water=site.water, window="box")
    assert given["screen"]["untapered"] == untapered.velocities.tolist()
    turned = extract(path, "--wavenumbers", "0.4,0.5", "--screen", "--rotate", 20)["screen"]["rotated"]
    assert np.hypot(*(np.array(turned["tapered"]) - site.truth).T).max() < 0.5


# --- and told where it is not ----------------------------------------------------------------------------------------
@pytest.mark.parametrize("name", ["ford", "coast"])
def test_deep_water_taken_for_granted_is_told_with_the_depth_that_comes_right(tmp_path, seas, name):
    site = SITES[name]
    path = written(tmp_path, "npz", site, seas[name])
    given = extract(path, status=1)
    assert given["assumed"]["depth"] == "deep water"
    assert off(site, given).max() > 1  # what would be believed
    (words,) = (word for word in given["shell_band"]["words"] if "--depth" in word)
    assert words.startswith("Likely deep water taken for granted where it is shallow")
    low, high = (float(n) for n in re.search(r"depths (\S+) to (\S+) fit as well", words).groups())
    assert low * 0.99 < site.depth < high * 1.01
    again = extract(path, *re.search(r"--depth \S+", words)[0].split())
    assert again["shell_band"]["words"] == []


def test_a_wrong_depth_and_one_that_is_not_there_are_told(tmp_path, seas):
    site = SITES["coast"]
    path = written(tmp_path, "mat", site, seas["coast"])
    for wrong in ("1.4m", "3 ft"):
        words = " ".join(extract(path, "--depth", wrong, status=1)["shell_band"]["words"])
        found = float(re.search(r"Likely another depth: comes right with --depth (\S+)", words)[1])
        assert found == pytest.approx(site.depth, rel=0.2)
    deep = SITES["ocean"]
    path = written(tmp_path, "npz", deep, seas["ocean"])
    words = " ".join(extract(path, "--depth", "2m", status=1)["shell_band"]["words"])
    assert re.search(r"--depth (deep|\d\d) \(\d+ % of the energy; depths from \S+ up fit as well\)", words), words


@pytest.mark.parametrize("name", ["river", "ocean"])
def test_where_the_waves_hardly_feel_the_bottom_it_is_said_that_nothing_is_known(tmp_path, seas, name):
    site = SITES[name]
    path = written(tmp_path, "npz", site, seas[name])
    for options in ((), ("--depth", f"{site.depth}m"), ("--depth", "300m")):
        given = extract(path, *options)
        assert off(site, given).max() < 1
        assert given["shell_band"]["words"] == []
        assert given["shell_band"]["depths"][1] is None
        (note,) = (note for note in given["notes"] if note.startswith("depth:"))
        assert re.search(r"any from \d+\.\d+ m up fits as well", note), note


def test_surface_tension_left_out_is_told_and_one_that_is_not_there(tmp_path, seas):
    site = SITES["tank"]
    path = written(tmp_path, "npz", site, seas["tank"])
    given = extract(path, "--depth", "5cm", status=1)
    words = " ".join(given["shell_band"]["words"])
    assert "surface tension left out: comes right with --surface-tension water" in words, words
    assert extract(path, "--surface-tension", "7.29e-5")["shell_band"]["words"] == []


# --- what is said of it ----------------------------------------------------------------------------------------------
def test_what_is_assumed_stands_in_the_line_the_table_and_the_figures(tmp_path, seas):
    site = SITES["tank"]
    path = written(tmp_path, "npz", site, seas["tank"])
    words = ["extract", str(path), "--depth", "5cm", "--surface-tension", "72.9 cm3/s2", "--out", str(tmp_path / "out")]
    done = CliRunner().invoke(app, words, catch_exceptions=False)
    first, flat = done.stdout.splitlines()[0], " ".join(done.stdout.split())
    assert "depth 0.05 m (--depth); surface tension 7.29e-05 m3/s2 (--surface-tension)" in first
    assert "nsp, depth 0.05 m, surface tension 7.29e-05 m3/s2, in m/s" in flat
    assert "depth 0.05 m, surface tension 7.29e-05 m3/s2" in (tmp_path / "out/extract.svg").read_text()
    with xarray.open_dataset(tmp_path / "out/extract.nc") as kept:
        assert (kept.attrs["depth"], kept.attrs["surface_tension"]) == (0.05, pytest.approx(7.29e-5))
    plain = CliRunner().invoke(app, ["extract", str(path), "--surface-tension", "water"], catch_exceptions=False)
    assert (
        "deep water (by default; --depth if not); surface tension 7.29e-05 m3/s2 (--surface-tension)"
        in plain.stdout.splitlines()[0]
    )


def test_an_option_goes_before_the_file_and_that_they_differ_is_said(tmp_path, seas):
    site = SITES["coast"]
    path = written(tmp_path, "netcdf", site, seas["coast"], depth=3.0)
    given = extract(path, "--depth", "3.2m")
    assert "WARNING: --depth 3.2 was taken, and the file says depth = 3" in given["notes"]
    assert not any("WARNING" in note for note in extract(path, "--depth", "300 cm")["notes"])
    assert extract(path, "--depth", "deep", status=1)["assumed"]["depth"] == "deep water"


def test_a_coordinate_called_depth_is_not_that_of_the_water(tmp_path, seas):
    """As in files of ocean models: the level at which something was measured."""
    site = SITES["ocean"]
    data = held(site, seas["ocean"])
    sets = {name: ((name,), data[name], {"units": "m" if name != "t" else "s"}) for name in "xyt"}
    sets |= {"eta": (("x", "y", "t"), seas["ocean"]), "depth": (("depth",), [0.49], {"units": "m"})}
    xarray.Dataset(sets).to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
    given = extract(tmp_path / "a.nc", "--gravity", 9.81)
    assert given["assumed"]["depth"] == "deep water"
    assert any("depth is a coordinate of its own" in note for note in given["notes"])


def test_kilometres_and_centimetres_in_the_file_become_metres(tmp_path, seas):
    site = SITES["coast"]
    data = held(site, seas["coast"])
    sets = {name: ((name,), data[name] / (1e3 if name != "t" else 1), {"units": "km" if name != "t" else "s"})
            for name in "xyt"}  # fmt: skip
    for unit, value in (("cm", 300.0), ("m", 3.0), ("", 3.0)):
        both = sets | {"eta": (("x", "y", "t"), seas["coast"]), "depth": ((), value, {"units": unit})}
        xarray.Dataset(both).to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
        given = extract(tmp_path / "a.nc", "--gravity", 9.81, status=0 if unit else 2)
        assert (given["assumed"]["depth"] == pytest.approx(3)) if unit else ("pass --depth" in given)


# --- and refused ------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--depth", "0"), "--depth 0 is not positive: a depth counts downwards from the surface; write it as in"),
        (("--depth", "0m"), "is not positive"),
        (("--depth=-4m",), "--depth -4m is not positive: a depth counts downwards"),
        (("--depth", "nan"), "--depth nan is not a finite number"),
        (("--depth", "inf"), "--depth inf is not a finite number; write it as in --depth 4m, or --depth deep"),
        (("--depth", "four"), "--depth four is not a number with a unit"),
        (("--depth", "4s"), "second cannot be had in m"),
        (("--depth", "4 blah"), "there is no unit 'blah'"),
        (("--depth", "20000"), "is deeper than any ocean"),
        (("--depth", "40 km"), "is deeper than any ocean"),
        (("--surface-tension=-1e-5",), "is not a number of at least 0"),
        (("--surface-tension", "nan"), "is not a finite number"),
        (("--surface-tension", "oil"), "--surface-tension oil is not a number with a unit; write it as in"),
        (("--surface-tension", "0.073"), "is more than any liquid has: divide it by the density, 0.073 N/m is 7.3e-5"),
        (
            ("--surface-tension", "0.073 N/m"),
            "newton / meter cannot be had in m^3/s^2; write it as in --surface-tension",
        ),
    ],
)
def test_what_no_water_has_is_refused_with_a_remedy(tmp_path, options, said):
    variables = held(SITES["coast"], np.zeros(SITES["coast"].shape))
    np.savez(tmp_path / "a.npz", **variables)
    refused = extract(tmp_path / "a.npz", *options, status=2)
    assert said in refused
    assert refused.startswith("leakref: extract: --")


@pytest.mark.parametrize(
    ("value", "said"),
    [
        (0.0, "has depth = 0, which is not positive: a depth counts downwards from the surface; pass --depth"),
        (-3.0, "has depth = -3, which is not positive"),
        (np.nan, "has depth = nan, which is not a finite number"),
        (np.ones((48, 56)), "has a depth of shape (48, 56) that is not one number; pass --depth, or --depth deep"),
        ("four", "has a depth of shape () that is not one number"),
    ],
)
def test_what_a_file_cannot_mean_is_refused_and_the_option_helps(tmp_path, seas, value, said):
    site = SITES["coast"]
    np.savez(tmp_path / "a.npz", **held(site, seas["coast"], depth=value))
    assert said in extract(tmp_path / "a.npz", status=2)
    given = extract(tmp_path / "a.npz", "--depth", "3m")
    assert given["assumed"]["depth"] == 3
    assert any("what the file says of its depth is not a number to go by" in note for note in given["notes"])


def test_a_unit_says_something_in_metres_only(tmp_path, seas):
    """A plain number is in the cube's own units whatever they are: k0 h in scaled ones."""
    site = SITES["coast"]
    s = site.scales
    x, y, t = (
        site.grid.samples(axis) / unit for axis, unit in zip(range(3), (s.length, s.length, s.time), strict=True)
    )
    np.savez(tmp_path / "a.npz", eta=seas["coast"], x=x, y=y, t=t, gravity=1.0, units="scaled")
    refused = extract(tmp_path / "a.npz", "--depth", "3m", status=2)
    assert "--depth 3m is in metres, and the cube is not known to be in metres and seconds" in refused
    assert "not known to be" in extract(tmp_path / "a.npz", "--surface-tension", "water", status=2)
    given = extract(tmp_path / "a.npz", "--depth", f"{site.depth / s.length:.9g}")
    metric = extract(written(tmp_path, "npz", site, seas["coast"]), "--depth", site.depth)
    found, own = (np.array(one["doppler_shift_velocities"]) for one in (given, metric))
    assert found * s.velocity == pytest.approx(own, abs=1e-6 * s.velocity)
    assert given["shell_band"]["words"] == []


def test_in_python_a_cube_carries_its_water(tmp_path, seas):
    path = written(tmp_path, "npz", SITES["coast"], seas["coast"], depth=3.0)
    assert read(path).water == Water(9.81, 3.0)
    assert read(path, depth=4.0, surface_tension="water").water == Water(9.81, 4.0, CLEAN_WATER)
    with pytest.raises(LeakrefError, match="--depth -1"):
        read(path, depth=-1.0)
