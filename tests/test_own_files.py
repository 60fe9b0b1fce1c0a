"""Files as users have them, made from a sea with a known current: right within the resolution, or said what is wrong.

None is silently wrong. The sea runs in a tank, 25 cm long waves filmed at 29.97 frames a second; no two sides are
alike, and the current has two components of which neither can be taken for the other or for its own negative.
"""

from __future__ import annotations

import json
import re
import sys

import av
import h5py
import numpy as np
import pytest
import xarray
from PIL import Image
from scipy.io import savemat
from typer.testing import CliRunner

from leakref import Grid, Scales, SeaState, UniformCurrent, synthesize
from leakref.cli.base import app
from leakref.cubes import deferred, hdf, measuring, mending
from leakref.dispersion import Water, velocity_resolutions

SCALES = Scales(25.0, 9.81)
GRID = Grid((48, 56, 96), (0.024, 0.022, 1 / 29.97))
CURRENT = np.array([0.21, -0.12]) * SCALES.velocity
K = np.array([1.6, 2.1]) * SCALES.wavenumber
ASKED = ("--wavenumbers", ",".join(f"{k:.6g}" for k in K))
SPACING = ("--spacing", "0.024,0.022,1/29.97")
TANK = ("--gravity", "9.81")
X, Y, T = (GRID.samples(axis) for axis in range(3))


@pytest.fixture(scope="module")
def surface():
    sea = SeaState(direction=70, spread=60, length=5, current=UniformCurrent(tuple(CURRENT / SCALES.velocity)))
    return synthesize(sea.components(1).to_units(SCALES), X, Y, T)


@pytest.fixture(scope="module")
def bytes_(surface):
    """As a camera sees it: 8 bits, grey in the middle."""
    return np.clip(128 + 30 * surface / surface.std(), 0, 255).astype(np.uint8)


def extract(path, *options, status=0):
    """The JSON of `leakref extract`, with its status seen to; for refusals what is on stderr."""
    words = ["extract", str(path), *ASKED, *map(str, options), "--json"]
    done = CliRunner().invoke(app, words, catch_exceptions=False)
    assert done.exit_code == status, done.stderr + done.stdout
    return json.loads(done.stdout) if status < 2 else done.stderr


def assert_right(given, times=1.0):
    """Each velocity within the larger resolution, and a shell that is plainly there."""
    off = np.hypot(*(np.array(given["doppler_shift_velocities"]) - CURRENT).T)
    shape, spacing = given["shape"], given["spacing"]
    grid = Grid(tuple(shape), tuple(spacing))
    assert np.all(
        off
        < times
        * np.maximum(*velocity_resolutions(K, grid.wavenumber_resolution, grid.frequency_resolution, Water(9.81)))
    )
    assert given["shell_band"]["holds"], given["shell_band"]
    assert min(given["shell"]) > 3
    assert np.hypot(*CURRENT) > 3 * off.max()


# --- kinds of files ---------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("order", ["xyt", "xty", "yxt", "ytx", "txy", "tyx"])
def test_npy_in_every_order(tmp_path, surface, order):
    np.save(tmp_path / "a.npy", surface.transpose(["xyt".index(name) for name in order]))
    given = extract(tmp_path / "a.npy", *SPACING, *TANK, "--axes", order)
    assert_right(given)
    assert given["assumed"]["axes"] == order
    assert given["assumed"]["from"]["axes"] == "--axes"
    assert (given["assumed"]["y"], given["assumed"]["depth"]) == ("up", "deep water")
    lacking = extract(tmp_path / "a.npy", *SPACING, *TANK, status=2)
    assert "pass --axes" in lacking


def test_sides_that_fit_more_than_one_order(tmp_path, surface):
    square = surface[:48, :48]
    held = {"eta": square, "x": X[:48], "y": 0.022 * np.arange(48), "t": T, "gravity": 9.81}
    np.savez(tmp_path / "a.npz", **held)
    assert "fits xyt, yxt alike; pass --axes" in extract(tmp_path / "a.npz", status=2)
    assert_right(extract(tmp_path / "a.npz", "--axes", "xyt"))
    np.savez(tmp_path / "b.npz", **held, axes="xyt")
    assert extract(tmp_path / "b.npz")["assumed"]["from"]["axes"] == "the file"


def test_mat_v5_in_another_order_under_another_name(tmp_path, surface):
    savemat(
        tmp_path / "a.mat", {"heights": surface.transpose(2, 1, 0), "X": X, "Y": Y, "time": T, "g": 9.81, "other": 3.0}
    )
    given = extract(tmp_path / "a.mat")
    assert_right(given)
    assert given["assumed"]["variable"] == "heights"
    assert (given["assumed"]["axes"], given["assumed"]["from"]["axes"]) == ("tyx", "the sizes of the coordinates")


def test_a_structure_in_mat_v5(tmp_path, bytes_):
    gx, gy = np.meshgrid(X, Y, indexing="ij")
    structure = {"IMG": bytes_, "gridX": gx, "gridY": gy, "dx": 0.024, "dy": 0.022, "dt": 1 / 29.97, "name": "flight 3"}
    savemat(tmp_path / "a.mat", {"IMG_SEQ": structure, "eta": np.zeros((2, 2))})
    given = extract(tmp_path / "a.mat", "--variable", "IMG_SEQ.IMG", "--axes", "xyt", *TANK)
    assert_right(given)
    refused = extract(tmp_path / "a.mat", "--variable", "IMG", status=2)
    assert "no variable IMG: it holds" in refused
    assert "IMG_SEQ.IMG 48 x 56 x 96 uint8" in refused


def matlab_73(path, **variables):
    """A file as MATLAB writes it: a block of words first, axes the other way round, structures as groups."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in variables.items():
            array = np.atleast_2d(value)
            file.create_dataset(name.replace(".", "/"), data=array.T).attrs["MATLAB_class"] = np.bytes_("double")
    with path.open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")
    return path


def test_every_tenth_frame_lost_in_noise_is_told_by_the_step(tmp_path, surface):
    """Where the frames cannot be told one by one: a warning that names the cause, since a shear does as much."""
    x, y, t = X, Y, np.arange(200) / 29.97
    sea = SeaState(70, 60, length=5, current=UniformCurrent(tuple(CURRENT / SCALES.velocity))).components(1)
    long = synthesize(sea.to_units(SCALES), x, y, t)
    long += 0.6 * long.std() * np.random.default_rng(0).normal(size=long.shape)
    np.save(tmp_path / "a.npy", long[:, :, np.flatnonzero(np.arange(200) % 10 != 9)])
    words = extract(tmp_path / "a.npy", *SPACING, *TANK, "--axes", "xyt")["shell_band"]["words"]
    assert words[0].startswith("WARNING")
    assert any("every tenth frame lost: comes right with --spacing 0.024,0.022,0.0370741" in word for word in words)


def test_an_array_of_structures_in_mat_v5(tmp_path, bytes_):
    film = np.zeros((1, 3), dtype=[("IMG", object), ("dt", object), ("at", object)])
    for n, start in enumerate((0, 10, 20)):
        film[0, n] = (bytes_[..., start : start + 76], (n + 1) / 29.97, {"dx": 0.024, "dy": 0.022})
    savemat(tmp_path / "a.mat", {"FILM": film})
    options = ("--axes", "xyt", *TANK)
    refused = extract(tmp_path / "a.mat", status=2)
    assert "holds 3 variables with three axes: it holds FILM(1).IMG to FILM(3).IMG 48 x 56 x 76 uint8" in refused
    assert "--variable 'FILM(1).IMG'" in refused
    given = extract(tmp_path / "a.mat", *options, "--variable", "FILM(1).IMG", "--spacing", "0.024,0.022")
    assert_right(given)
    other = extract(tmp_path / "a.mat", *options, "--variable", "FILM(3).IMG", *SPACING)
    assert_right(other)
    assert other["doppler_shift_velocities"] != given["doppler_shift_velocities"]
    assert "holds no variable FILM(4).IMG" in extract(tmp_path / "a.mat", "--variable", "FILM(4).IMG", status=2)
    frames = np.zeros((1, 40), dtype=[("frame", object)])
    for n in range(40):
        frames[0, n] = (bytes_[..., n],)
    savemat(tmp_path / "b.mat", {"S": frames})
    refused = extract(tmp_path / "b.mat", status=2)
    assert "S(1).frame to S(40).frame 48 x 56 uint8" in refused
    assert "are stacked by eta = cat(3, S.frame)" in refused


def test_an_array_of_structures_in_mat_v73(tmp_path, bytes_):
    """As MATLAB writes it: a field is an array of references to what it is in each structure."""
    path = matlab_73(tmp_path / "a.mat", **{"note": 7.0})
    with h5py.File(path, "r+") as file:
        references = {name: np.empty((3, 1), dtype=h5py.ref_dtype) for name in ("IMG", "dt", "at")}
        for n, start in enumerate((0, 10, 20)):
            held = file.create_dataset(f"#refs#/a{n}", data=bytes_[..., start : start + 76].T)
            step = file.create_dataset(f"#refs#/b{n}", data=[[(n + 1) / 29.97]])
            place = file.create_group(f"#refs#/c{n}")
            place.create_dataset("dx", data=[[0.024]])
            for name, one in (("IMG", held), ("dt", step), ("at", place)):
                references[name][n, 0] = one.ref
        for name, array in references.items():
            file.create_dataset(f"FILM/{name}", data=array, dtype=h5py.ref_dtype)
        file.create_dataset("cells", data=references["IMG"], dtype=h5py.ref_dtype)
        file["cells"].attrs["MATLAB_class"] = np.bytes_("cell")
    refused = extract(path, status=2)
    assert "FILM(1).IMG to FILM(3).IMG 48 x 56 x 76 uint8" in refused
    assert "FILM(1).at.dx to FILM(3).at.dx 1 x 1 float64" in refused
    assert "cells 1 x 3 cell" in refused
    given = extract(path, "--axes", "xyt", *TANK, "--variable", "FILM(1).IMG", "--spacing", "0.024,0.022")
    assert given["spacing"][2] == pytest.approx(1 / 29.97)
    assert_right(given)


@pytest.mark.parametrize("limit", [2**30, 10**5])
def test_mat_v73_whole_and_in_blocks(tmp_path, bytes_, monkeypatch, limit):
    for module in (hdf, deferred):
        monkeypatch.setattr(module, "IN_MEMORY", limit)
    monkeypatch.setattr(hdf, "BLOCK", 10**6)
    held = {"IMG_SEQ.IMG": bytes_, "IMG_SEQ.dx": 0.024, "IMG_SEQ.dy": 0.022, "IMG_SEQ.dt": 1 / 29.97, "note": 7.0}
    path = matlab_73(tmp_path / "a.mat", **held)
    given = extract(path, "--variable", "IMG_SEQ.IMG", "--axes", "xyt", *TANK)
    assert_right(given)
    assert given["shape"] == list(GRID.shape)
    assert_right(extract(path, "--axes", "xyt", *TANK))  # the only one with three axes


def as_netcdf(path, surface, name="height", time=(T, "seconds since 2024-05-01"), engine="h5netcdf", y=Y):
    data = {
        name: (("time", "northing", "easting"), surface.transpose(2, 1, 0)),
        "easting": (("easting",), X + 4e5, {"units": "m"}),
        "northing": (("northing",), y, {"units": "m"}),
        "time": (("time",), time[0], {"units": time[1]}),
    }
    dataset = xarray.Dataset(data)
    if engine == "zarr":
        dataset.to_zarr(path, consolidated=False, zarr_format=2)
    else:
        dataset.to_netcdf(path, engine=engine)
    return path


@pytest.mark.parametrize("engine", ["h5netcdf", "scipy"])
def test_netcdf_with_other_names_and_time_first(tmp_path, surface, engine):
    given = extract(as_netcdf(tmp_path / "a.nc", surface, engine=engine), *TANK)
    assert_right(given)
    assert (given["assumed"]["axes"], given["units"]["velocity"]) == ("tyx", "m/s")


@pytest.mark.parametrize(
    ("unit", "factor"), [("milliseconds", 1e3), ("days since 2024-05-01", 1 / 86400), ("hours", 1 / 3600)]
)
def test_netcdf_with_time_in_other_units(tmp_path, surface, unit, factor):
    given = extract(as_netcdf(tmp_path / "a.nc", surface, time=(T * factor, unit)), *TANK)
    assert_right(given)
    assert any(note.startswith("t was converted from") for note in given["notes"])


@pytest.mark.parametrize("limit", [2**30, 10**5])
def test_netcdf_whole_and_in_blocks(tmp_path, surface, monkeypatch, limit):
    for module in (hdf, deferred):
        monkeypatch.setattr(module, "IN_MEMORY", limit)
    monkeypatch.setattr(hdf, "BLOCK", 10**6)
    path = as_netcdf(tmp_path / "a.nc", surface)
    given = extract(path, *TANK, "--crop", "2:46,4:56", "--frames", "6:96")
    assert given["shape"] == [44, 52, 90]
    assert_right(given)


def test_zarr(tmp_path, surface):
    assert_right(extract(as_netcdf(tmp_path / "a.zarr", surface, engine="zarr"), *TANK))


# --- images and videos ------------------------------------------------------------------------------------------------
def pictures(samples):
    """Frames [row, column] whose rows run downwards, as a camera has them."""
    return samples.transpose(2, 1, 0)[:, ::-1]


def images(folder, frames, suffix="png"):
    folder.mkdir()
    for n, frame in enumerate(frames):
        Image.fromarray(np.ascontiguousarray(frame)).save(folder / f"frame_{n}.{suffix}")
    return folder


def test_a_folder_of_png(tmp_path, bytes_):
    folder = images(tmp_path / "film", pictures(bytes_))
    given = extract(folder, *SPACING, *TANK)
    assert_right(given)
    assert (given["assumed"]["y"], given["assumed"]["axes"]) == ("down", "tyx")
    mirrored = np.array(extract(folder, *SPACING, *TANK, "--y", "up")["doppler_shift_velocities"])
    assert mirrored[:, 1].min() > 0 > CURRENT[1]
    assert "lacks the coordinate x" in extract(folder, *TANK, status=2)
    Image.fromarray(np.zeros((4, 4), np.uint8)).save(folder / "frame_40.png")
    assert re.search(r"frame_40\.png is of 4 x 4 pixels", extract(folder, *SPACING, *TANK, status=2))


@pytest.mark.parametrize("kind", ["tif", "stack", "float", "colour"])
def test_tiff_of_sixteen_bits_in_a_folder_or_a_stack_and_colours(tmp_path, surface, bytes_, kind):
    deep = np.clip(30000 + 6000 * surface / surface.std(), 0, 65535).astype(np.uint16)
    if kind == "tif":
        path = images(tmp_path / "film", pictures(deep), "tif")
    elif kind == "colour":
        path = images(tmp_path / "film", np.stack([pictures(bytes_), 0 * pictures(bytes_), pictures(bytes_)], axis=-1))
    else:
        frames = pictures(deep if kind == "stack" else surface.astype(np.float32))
        first, *rest = (Image.fromarray(np.ascontiguousarray(frame)) for frame in frames)
        first.save(path := tmp_path / "a.tif", save_all=True, append_images=rest)
    assert_right(extract(path, *SPACING, *TANK))


@pytest.mark.parametrize(("suffix", "codec"), [("mp4", "mpeg4"), ("avi", "mjpeg")])
def test_videos(tmp_path, bytes_, suffix, codec):
    path = tmp_path / f"a.{suffix}"
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=30)
        stream.width, stream.height, stream.bit_rate = 48, 56, 4_000_000
        stream.pix_fmt = "yuvj420p" if codec == "mjpeg" else "yuv420p"
        for frame in pictures(bytes_):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(np.ascontiguousarray(frame), format="gray")))
        container.mux(stream.encode())
    given = extract(path, "--spacing", "0.024,0.022", *TANK)
    assert given["spacing"][2] == pytest.approx(1 / 30, rel=1e-3)
    assert_right(given)
    assert given["assumed"]["y"] == "down"
    part = extract(path, *SPACING, *TANK, "--frames", "5:90", "--crop", "0:46,2:56")
    assert part["shape"] == [46, 54, 85]
    assert_right(part)


def test_a_video_without_its_library_says_how_to_get_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    path = tmp_path / "a.mp4"
    path.write_bytes(b"\0\0\0\x18ftypmp42" + bytes(100))
    assert "leakref[video]" in extract(path, *SPACING, *TANK, status=2)


def test_bytes_without_a_word_of_where_the_rows_run(tmp_path, bytes_):
    np.save(tmp_path / "a.npy", pictures(bytes_))
    given = extract(tmp_path / "a.npy", *SPACING, *TANK, "--axes", "tyx")
    assert any("WARNING" in note and "--y down" in note for note in given["notes"])
    told = extract(tmp_path / "a.npy", *SPACING, *TANK, "--axes", "tyx", "--y", "down")
    assert_right(told)
    assert not any("WARNING" in note for note in told["notes"])


def test_rows_downwards_by_their_coordinate(tmp_path, surface):
    path = as_netcdf(tmp_path / "a.nc", surface[:, ::-1], y=Y[::-1])
    given = extract(path, *TANK)
    assert_right(given)
    assert (given["assumed"]["y"], given["assumed"]["from"]["y"]) == ("down", "y falls with the index")
    assert "leave out --y" in extract(path, *TANK, "--y", "up", status=2)


def test_a_trend_of_brightness(tmp_path, bytes_):
    x, y, t = (np.linspace(-1, 1, n) for n in GRID.shape)
    dusk = np.clip(0.6 * bytes_ + (25 * x[:, None] - 15 * y)[:, :, None] - 20 * t + 30, 0, 255).astype(np.uint8)
    folder = images(tmp_path / "film", pictures(dusk))
    assert_right(extract(folder, *SPACING, *TANK))
    assert_right(extract(folder, *SPACING, *TANK, "--detrend", "linear"))


# --- time ------------------------------------------------------------
def stamped(path, surface, t, **more):
    np.savez(path, eta=surface, x=X, y=Y, t=t, gravity=9.81, **more)
    return path


@pytest.mark.parametrize("start", [0.0, 1.7e9])
def test_stamps_in_milliseconds(tmp_path, surface, start):
    given = extract(stamped(tmp_path / "a.npz", surface, np.round(start + T, 3)))
    assert_right(given)
    assert given["spacing"][2] == pytest.approx(1 / 29.97, rel=2e-4)
    assert any("t is rounded to 0.001" in note for note in given["notes"])


def test_stamps_that_are_unsteady(tmp_path, surface):
    t = T + np.random.default_rng(0).normal(size=T.size) * 0.05 / 29.97
    given = extract(stamped(tmp_path / "a.npz", surface, t))
    assert_right(given)
    assert any("t is unsteady" in note for note in given["notes"])


@pytest.mark.parametrize("digits", [3, 9])
def test_a_lost_frame_is_named_and_every_remedy_works(tmp_path, surface, digits):
    kept = np.delete(np.arange(96), 20)
    path = stamped(tmp_path / "a.npz", surface[:, :, kept], np.round(T[kept], digits))
    refused = extract(path, status=2)
    assert "has lost 1 frame, behind frame 19 (counted from 0" in refused
    share, frames = re.search(r"--fill-holes (\S+)", refused)[1], re.search(r"--frames (\d+:\d+)", refused)[1]
    assert frames == "20:95"
    assert_right(extract(path, "--frames", frames))
    filled = extract(path, "--fill-holes", share)
    assert_right(filled)
    assert filled["shape"][2] == 96
    step = re.search(r"--spacing dx,dy,(\S+)", refused)[1]
    assert_right(extract(path, "--spacing", f"0.024,0.022,{step}"))


def test_every_tenth_frame_lost_and_no_stamps(tmp_path, surface):
    long = synthesize(
        SeaState(70, 60, length=5, current=UniformCurrent(tuple(CURRENT / SCALES.velocity)))
        .components(1)
        .to_units(SCALES),
        X,
        Y,
        np.arange(200) / 29.97,
    )
    kept = np.flatnonzero(np.arange(200) % 10 != 9)
    np.save(tmp_path / "a.npy", long[:, :, kept])
    told = extract(tmp_path / "a.npy", *SPACING, *TANK, "--axes", "xyt", status=1)
    assert any(word.startswith("19 of 199 frames are lost") for word in told["shell_band"]["words"])
    assert any("lost, behind frames 8, 17, 26, 35, 44, 53, 62, 71 and 11 more" in note for note in told["notes"])
    put_in = re.search(r"--fill-holes (\S+)", " ".join(told["notes"]))[1]
    assert_right(extract(tmp_path / "a.npy", *SPACING, *TANK, "--axes", "xyt", "--fill-holes", put_in))
    t = np.arange(200)[kept] / 29.97
    refused = extract(stamped(tmp_path / "a.npz", long[:, :, kept], t), status=2)
    assert "has lost 19 frames, behind frames 8, 17, 26" in refused
    assert_right(extract(tmp_path / "a.npz", "--fill-holes", re.search(r"--fill-holes (\S+)", refused)[1]))


def test_a_doubled_frame(tmp_path, surface):
    twice = np.insert(np.arange(96), 31, 30)
    told = extract(stamped(tmp_path / "a.npz", surface[:, :, twice], T[twice]))
    assert_right(told)
    assert "frame 31, the same as the one before, left out" in told["notes"]
    unlike = extract(stamped(tmp_path / "b.npz", surface, T[np.r_[0:31, 30, 32:96]]), status=2)
    assert "has frame 31 with the time of the one before, but unlike it" in unlike
    assert_right(extract(tmp_path / "b.npz", "--spacing", f"0.024,0.022,{1 / 29.97}"))


def test_frames_doubled_by_a_conversion(tmp_path, surface):
    """From 24 to 30 a second: every fifth is the fourth again, and the stamps do not say so."""
    twice = (np.arange(120) * 4) // 5
    path = stamped(tmp_path / "a.npz", surface[:, :, twice], np.arange(120) * 0.8 / 29.97)
    given = extract(path)
    assert any("WARNING" in note and "the same as the one before" in note for note in given["notes"])
    dropped = extract(path, "--drop-doubled")
    assert_right(dropped)
    assert dropped["spacing"][2] == pytest.approx(1 / 29.97, rel=1e-12)


# --- what no file says: the shell does --------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"t": T / 86400}, r"time in days: comes right with --spacing 0\.024,0\.022,0\.0333"),
        ({"t": T * 1e3}, r"time in milliseconds: comes right with --spacing 0\.024,0\.022,0\.0333"),
        (
            {"t": np.arange(96) * 29.97},
            r"frames a second taken for seconds: comes right with --spacing 0\.024,0\.022,0\.0333",
        ),
        ({"gravity": 981.0}, r"gravity in cm/s2, lengths in metres: comes right with --gravity 9\.81"),
        ({"gravity": 1.0}, r"gravity of 1 with metres and seconds: comes right with --gravity 9\.81"),
        ({"x": X * 100, "y": Y * 100}, r"lengths in centimetres.*: comes right with --spacing 0\.024,0\.022"),
        ({"x": X / 111195, "y": Y / 111195}, r"lengths in degrees"),
        ({"x": np.arange(48.0), "y": np.arange(56.0)}, r"lengths in pixels: comes right with pixels of 0\.02"),
        ({"t": T / 1.2}, r"Comes right with dt x 1\.(19|2)"),
    ],
)
def test_a_wrong_step_unit_or_gravity_is_told_by_the_shell(tmp_path, surface, change, said):
    held = {"eta": surface, "x": X, "y": Y, "t": T, "gravity": 9.81, **change}
    np.savez(tmp_path / "a.npz", **held)
    done = CliRunner().invoke(app, ["extract", str(tmp_path / "a.npz"), "--json"], catch_exceptions=False)
    assert done.exit_code == 1
    given = json.loads(done.stdout)
    assert not given["ok"]
    assert any(re.search(said, word) for word in given["shell_band"]["words"]), given["shell_band"]["words"]


def test_the_remedy_that_is_named_works(tmp_path, surface):
    path = stamped(tmp_path / "a.npz", surface, T * 1e3)
    words = extract(path, status=1)["shell_band"]["words"]
    (remedy,) = (word for word in words if "milliseconds" in word)
    assert_right(extract(path, *re.search(r"--spacing \S+", remedy)[0].split()))


def test_axes_that_are_wrong_are_told_by_the_shell(tmp_path, surface):
    np.save(tmp_path / "a.npy", surface.transpose(2, 0, 1))
    words = extract(tmp_path / "a.npy", *SPACING, *TANK, "--axes", "xyt", status=1)["shell_band"]["words"]
    assert any("--axes txy" in word for word in words), words


# --- holes ------------------------------------------------------------
@pytest.mark.parametrize("kind", ["npz", "npy"])
def test_holes_are_filled_on_request_up_to_a_share(tmp_path, surface, kind, monkeypatch):
    holed = surface.copy()
    holed[np.random.default_rng(1).random(surface.shape) < 0.01] = np.nan
    options = ()
    if kind == "npz":
        path = stamped(tmp_path / "a.npz", holed, T)
    else:
        path, options = tmp_path / "a.npy", (*SPACING, *TANK, "--axes", "xyt")
        np.save(path, holed)
        for module in (mending, measuring):
            monkeypatch.setattr(module, "IN_MEMORY", 10**5)  # mapped, and filled as it is read
    refused = extract(path, *options, status=2)
    assert "not finite" in refused
    assert "--fill-holes" in extract(path, *options, "--fill-holes", 0.001, status=2)
    given = extract(path, *options, "--fill-holes", 0.02)
    assert_right(given)
    assert any("were missing: filled with the mean" in note for note in given["notes"])


# --- cubes of a few samples -------------------------------------------------------------------------------------------
@pytest.mark.parametrize("screen", [(), ("--screen",)])
@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("size", [1, 2, 3, 4, 5, 7, 9])
def test_a_cube_of_a_few_samples_is_judged_or_refused_in_words(tmp_path, surface, axis, size, screen):
    """Whatever there is too little of: a verdict or a refusal, and not a fault of leakref's own."""
    np.save(tmp_path / "a.npy", np.take(surface, range(size), axis=axis))
    for asked in (ASKED, ()):
        words = ["extract", str(tmp_path / "a.npy"), *asked, *SPACING, *TANK, "--axes", "xyt", *screen]
        done = CliRunner().invoke(app, words)
        assert done.exit_code in (0, 1, 2), (done.exception, done.stdout)
        assert not isinstance(done.exception, ArithmeticError | LookupError | ValueError | TypeError), done.exception
        assert done.exit_code != 0 or size > 3  # nothing is measured in three samples
