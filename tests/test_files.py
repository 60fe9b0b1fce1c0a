"""Cubes in files: what comes back is what went in, and what is wrong is said in one line."""

from __future__ import annotations

import io
import pickle
import re
import struct
import sys
import time
import tracemalloc
import zipfile
from dataclasses import fields
from pathlib import Path

import h5netcdf
import numpy as np
import pytest
import xarray
from scipy.io import loadmat, savemat

from leakref import Components, Grid, LeakrefError
from leakref.cases import Configuration
from leakref.cubes import coordinates, files
from leakref.dispersion import Scales

GRID = Grid((5, 6, 7), (0.3, 0.7, 0.11))
WAVES = Components([0.3, 1.1], [0.2, -0.4], [0.9, 1.3], [0.1, 0.02], [0.4, 5.0])
SUFFIX = {"npz": ".npz", "mat": ".mat", "netcdf": ".nc"}


def small_cube(**changes):
    surface = np.random.default_rng(2).normal(size=GRID.shape)
    return files.Cube(surface, GRID, 9.81, "si", WAVES, np.array([0.3, -0.1]), 0.27, **changes)


@pytest.mark.parametrize("format", files.FORMATS)
@pytest.mark.parametrize(("units", "gravity"), [("si", 9.81), ("scaled", 1.0), ("given", 3.7)])
def test_what_is_written_comes_back_bit_for_bit(tmp_path, format, units, gravity):
    cube = files.Cube(small_cube().surface, GRID, gravity, units, WAVES, np.array([0.3, -0.1]), 0.27)
    back = files.read(files.write(tmp_path / f"cube{SUFFIX[format]}", cube, format))
    assert (back.grid, back.gravity, back.units, back.peak_wavenumber) == (GRID, gravity, units, 0.27)
    assert np.array_equal(back.surface, cube.surface)
    assert back.surface.dtype == np.float64
    assert np.array_equal(back.current, cube.current)
    for field in fields(WAVES):
        assert np.array_equal(getattr(back.components, field.name), getattr(WAVES, field.name))
    assert [path.name for path in tmp_path.iterdir()] == [f"cube{SUFFIX[format]}"]


@pytest.mark.parametrize("format", files.FORMATS)
def test_the_same_cube_gives_the_same_bytes_under_any_name(tmp_path, format, monkeypatch):
    one = files.write(tmp_path / "one.dat", small_cube(), format, {"case": "a"}).read_bytes()
    monkeypatch.setattr("time.time", lambda: 1e9)
    monkeypatch.setattr("time.asctime", lambda *_: "another day")
    time.sleep(1.1 if format == "netcdf" else 0)  # HDF5 asks the system itself, and for whole seconds
    assert files.write(tmp_path / "two", small_cube(), format, {"case": "a"}).read_bytes() == one


def test_spacing_is_the_same_float_that_made_the_coordinate(tmp_path):
    rng = np.random.default_rng(0)
    for d in rng.uniform(1e-3, 100, 300):
        for n in (2, 7, 281):
            assert coordinates.steps(tmp_path, "x", np.arange(n) * d, (n,), 0).step == d
    # where the origin is elsewhere the sum has rounded, and the spacing is known to that rounding only
    assert coordinates.steps(tmp_path, "x", 1000.3 + np.arange(50) * 0.1, (50,), 0).step == pytest.approx(
        0.1, rel=1e-13
    )
    assert coordinates.steps(tmp_path, "x", (np.arange(300) * 0.1).astype(np.float32), (300,), 0).step == pytest.approx(
        0.1, rel=1e-7
    )


def test_a_configuration_in_other_units_is_the_same_sea():
    configuration = Configuration("small", length=1.0, duration=1.0, speed=0.1, current_direction=30.0)
    scaled, metric = (files.of_configuration(configuration, 3, s) for s in (None, Scales(0.4, 9.81)))
    assert (scaled.units, scaled.gravity, metric.units, metric.gravity) == ("scaled", 1.0, "si", 9.81)
    assert files.of_configuration(configuration, 3, Scales(2.0, 1.0)).units == "given"
    c0 = np.sqrt(9.81 / 0.4)
    np.testing.assert_allclose(metric.surface, scaled.surface / 0.4, rtol=0, atol=1e-12 * np.abs(metric.surface).max())
    np.testing.assert_allclose(metric.current, c0 * np.array([0.1 * np.cos(np.pi / 6), 0.05]), rtol=1e-14)
    np.testing.assert_allclose(metric.grid.spacing[2], scaled.grid.spacing[2] / np.sqrt(9.81 * 0.4), rtol=1e-15)
    assert not np.array_equal(files.of_configuration(configuration, 4).surface, scaled.surface)


# --- orders, kinds and units -----------------------------------------------------------------------------------------


def variables(**changes):
    """What a good file holds; None drops a variable."""
    cube = small_cube()
    good = {"eta": cube.surface, "x": GRID.samples(0), "y": GRID.samples(1), "t": GRID.samples(2), "gravity": 9.81}
    return {name: value for name, value in {**good, **changes}.items() if value is not None}


def as_npz(path: Path, **changes) -> Path:
    np.savez(path, **variables(**changes))
    return path


def as_mat(path: Path, **changes) -> Path:
    savemat(path, variables(**changes), appendmat=False)
    return path


def as_netcdf(path: Path, dims=("x", "y", "t"), units=("m", "m", "s"), **changes) -> Path:
    held = variables(**changes)
    data = {
        name: ((name,), held[name], {"units": unit}) for name, unit in zip("xyt", units, strict=True) if name in held
    }
    if "eta" in held:
        data["eta"] = (dims, held["eta"])
    if "gravity" in held:
        data["gravity"] = ((), held["gravity"])
    xarray.Dataset(data).to_netcdf(path, engine="h5netcdf")
    return path


@pytest.mark.parametrize("order", ["xyt", "txy", "ytx", "tyx"])
def test_any_order_of_axes(tmp_path, order):
    surface = small_cube().surface
    stored = surface.transpose(["xyt".index(name) for name in order])
    by_name = files.read(as_netcdf(tmp_path / "a.nc", dims=tuple(order), eta=stored))
    assert np.array_equal(by_name.surface, surface)
    for path in (
        as_npz(tmp_path / "a.npz", eta=stored),
        as_mat(tmp_path / "a.mat", eta=stored),
        as_netcdf(tmp_path / "b.nc", dims=("frame", "row", "column"), eta=stored),
    ):
        back = files.read(path, axes=order)
        assert np.array_equal(back.surface, surface)
        assert back.grid == GRID
        told = files.read(path)  # the sides are all different: their sizes tell the order
        assert np.array_equal(told.surface, surface)
        assert told.assumed.axes == order
        assert told.assumed.sources["axes"] in ("the sizes of the coordinates", "the names of the dimensions")


def test_npy_stays_on_the_disk(tmp_path):
    surface = small_cube().surface
    for name, array in (("c.npy", surface), ("f.npy", np.asfortranarray(surface))):
        np.save(tmp_path / name, array)
        back = files.read(tmp_path / name, spacing=GRID.spacing, gravity=9.81, axes="xyt")
        assert isinstance(back.surface, np.memmap)
        assert np.array_equal(back.surface, surface)
        assert (back.grid, back.units) == (GRID, "given")
    np.save(tmp_path / "t.npy", surface.transpose(2, 0, 1))
    back = files.read(tmp_path / "t.npy", spacing=GRID.spacing, gravity=1, axes="txy")
    assert np.array_equal(back.surface, surface)
    assert isinstance(back.surface, np.memmap)


def test_integers_are_converted_and_it_is_said(tmp_path):
    images = np.random.default_rng(0).integers(0, 255, GRID.shape, dtype=np.uint8)
    for back in (
        files.read(as_npz(tmp_path / "a.npz", eta=images)),
        files.read(as_mat(tmp_path / "a.mat", eta=images)),
        files.read(as_netcdf(tmp_path / "a.nc", eta=images)),
    ):
        assert np.array_equal(back.surface, images)
        assert back.surface.dtype == np.float64
        assert any("uint8 samples were converted" in note for note in back.notes)


@pytest.mark.parametrize(
    ("units", "word"),
    [
        (("m", "m", "s"), "si"),
        (("metre", "m", "seconds since 2020-01-01"), "si"),
        (("", "", ""), "given"),
        (("1", "1", "1"), "given"),
    ],
)
def test_units_of_coordinates(tmp_path, units, word):
    assert files.read(as_netcdf(tmp_path / "a.nc", units=units)).units == word


def test_gravity_given_goes_before_that_of_the_file(tmp_path):
    assert files.read(as_npz(tmp_path / "a.npz"), gravity=3.7).gravity == 3.7
    assert files.read(as_npz(tmp_path / "a.npz", gravity=None), gravity=1.0).gravity == 1.0


# --- everything that can be wrong ------------------------------------------------------------------------------------


def cut(path: Path, part: float = 0.6) -> Path:
    content = path.read_bytes()
    path.write_bytes(content[: int(len(content) * part)])
    return path


def damaged(path: Path, at: float) -> Path:
    content = bytearray(path.read_bytes())
    content[int(len(content) * at)] ^= 0xFF
    path.write_bytes(content)
    return path


def raw(path: Path, content: bytes) -> Path:
    path.write_bytes(content)
    return path


def npy_bytes(array, **kwargs) -> bytes:
    stream = io.BytesIO()
    np.save(stream, array, **kwargs)
    return stream.getvalue()


def huge_npy() -> bytes:
    """A header for 10 GB, and nothing behind it but a few bytes."""
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": "<f8", "fortran_order": False, "shape": (1000, 1000, 1250)})
    return stream.getvalue() + bytes(800)


def huge_npz(path: Path, compression: int) -> Path:
    with zipfile.ZipFile(path, "w", compression) as archive:
        for name, value in variables(eta=None).items():
            archive.writestr(f"{name}.npy", npy_bytes(value))
        archive.writestr("eta.npy", huge_npy())
    return path


def lying_npz(path: Path) -> Path:
    """A packed file whose directory, too, claims 4 GB for what is a few hundred bytes."""
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": "<f8", "fortran_order": False, "shape": (1000, 1000, 500)})
    held = stream.getvalue() + bytes(1001)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("eta.npy", held)
    return raw(path, path.read_bytes().replace(struct.pack("<I", len(held)), struct.pack("<I", 4_000_000_128)))


def rootless(path: Path) -> Path:
    """A NetCDF file whose superblock points beside the root group."""
    as_netcdf(path)
    content = bytearray(path.read_bytes())
    content[64] ^= 1
    return raw(path, bytes(content))


def huge_mat(path: Path) -> Path:
    """A 5 x 6 x 7 array whose tag claims the most that a tag can, or whose dimensions claim 10 GB."""
    as_mat(path)
    content = bytearray(path.read_bytes())
    dims = content.index(np.array([5, 6, 7], "<i4").tobytes())
    content[dims : dims + 12] = np.array([1000, 1000, 1250], "<i4").tobytes()
    return raw(path, bytes(content))


def long_mat(path: Path) -> Path:
    as_mat(path)
    content = bytearray(path.read_bytes())
    content[132:136] = np.array([0xFFFFFFF0], "<u4").tobytes()
    return raw(path, bytes(content))


def huge_netcdf(path: Path) -> Path:
    with h5netcdf.File(path, "w") as stream:
        stream.dimensions = {"x": 1000, "y": 1000, "t": 1250}
        stream.create_variable("eta", ("x", "y", "t"), np.float64, chunks=(100, 100, 125))
    return path


def object_npz(path: Path) -> Path:
    np.savez(path, **variables(eta=np.full((2, 2, 2), None)))
    return path


def with_nan():
    surface = small_cube().surface
    surface[3, 2, 5] = np.nan
    return surface


def test_spacings_do_instead_of_coordinates(tmp_path):
    dx, dy, dt = GRID.spacing
    found = files.read(as_npz(tmp_path / "a.npz", x=None, y=None, t=None, dx=dx, dy=dy, dt=dt), axes="xyt")
    assert found.grid == GRID


X = GRID.samples(0)
T, GAP, FRO, TWICE = GRID.samples(2), X.copy(), X[::-1].copy(), X.copy()
FRO[[2, 3]] = FRO[[2, 1]]
GAP[3] += 0.02 * GRID.spacing[0]
TWICE[3] = TWICE[2]
BAD = {
    "no file": (lambda p: p / "none.npz", "does not exist", "check the name"),
    "folder": (lambda p: p, "is a folder without images", "name the file"),
    "empty": (lambda p: raw(p / "a.npz", b""), "is empty", "export it again"),
    "text": (lambda p: raw(p / "a.npz", b"x, y, t\n1, 2, 3\n" * 50), "of no kind that is known", "pass an npz"),
    "picture": (lambda p: raw(p / "a.nc", b"\x89PNG\r\n\x1a\n" + bytes(500)), "single image", "folder with all images"),
    "pickle": (lambda p: raw(p / "a.npy", pickle.dumps(small_cube().surface)), "is a pickle", "numpy.savez"),
    "matlab 7.3": (lambda p: raw(p / "a.mat", b"MATLAB 7.3 MAT-file".ljust(512)), "damaged", "export it again"),
    "classic netcdf": (lambda p: raw(p / "a.nc", b"CDF\x01" + b"\xff" * 200), "damaged", "export it again"),
    "npz cut": (lambda p: cut(as_npz(p / "a.npz")), "damaged or cut short", "export it again"),
    "npz cut early": (lambda p: cut(as_npz(p / "a.npz"), 0.05), "damaged or cut short", "export it again"),
    "npz damaged": (lambda p: damaged(as_npz(p / "a.npz"), 0.3), "damaged", "export it again"),
    "mat cut": (lambda p: cut(as_mat(p / "a.mat")), "cut short", "export it again"),
    "mat cut in its header": (lambda p: cut(as_mat(p / "a.mat"), 0.03), "no kind|cut short", "export|pass"),
    "netcdf without a root": (lambda p: rootless(p / "a.nc"), "damaged", "export it again"),
    "netcdf cut": (lambda p: cut(as_netcdf(p / "a.nc")), "damaged or cut short", "export it again"),
    "npy cut": (lambda p: raw(p / "a.npy", npy_bytes(small_cube().surface)[:-9]), "cut short", "export it again"),
    "npy of objects": (
        lambda p: raw(p / "a.npy", npy_bytes(np.full((2, 2, 2), None), allow_pickle=True)),
        "pickled objects, which are never loaded",
        "array of numbers",
    ),
    "npy with fields": (lambda p: raw(p / "a.npy", npy_bytes(np.zeros((2, 2, 2), [("a", "f8")]))), "type", "numbers"),
    "npz of objects": (lambda p: object_npz(p / "a.npz"), "pickled objects, which are never loaded", "numbers"),
    "mat of cells": (lambda p: as_mat(p / "a.mat", eta=np.full((2, 2, 2), "a", object)), "eta as cells", "numbers"),
    "mat of a structure": (lambda p: as_mat(p / "a.mat", eta={"a": 1.0}), r"no variable eta.* eta\.a", "--variable"),
    "no eta": (
        lambda p: as_npz(p / "a.npz", eta=None),
        r"no variable eta and none with three axes: it holds x 5 float64, y 6",
        r"store the surface as eta\[x, y, t\]",
    ),
    "several cubes": (
        lambda p: as_npz(p / "a.npz", eta=None, u=np.ones((5, 6, 7)), v=np.ones((5, 6, 7))),
        r"2 variables with three axes: it holds .*u 5 x 6 x 7 float64, v",
        "--variable",
    ),
    "two axes": (lambda p: as_mat(p / "a.mat", eta=np.ones((5, 6))), "2 axes instead of three", "store eta"),
    "four axes": (lambda p: as_npz(p / "a.npz", eta=np.ones((5, 6, 7, 3))), "4 axes", r"store eta\[x, y, t\]"),
    "Octave's own": (
        lambda p: raw(p / "a.mat", b"# Created by Octave 8.4.0\n# name: eta\n"),
        "of Octave's own",
        "save -v7",
    ),
    "no t": (lambda p: as_npz(p / "a.npz", t=None), "lacks the coordinate t", "--spacing"),
    "netcdf without x": (
        lambda p: as_netcdf(p / "a.nc", x=None, units=("", "", "")),
        "lacks the coordinate x",
        "--spacing",
    ),
    "wrong size": (
        lambda p: as_npz(p / "a.npz", y=np.arange(9.0)),
        "9 values of y for 6 samples.* in no order",
        "--axes",
    ),
    "uneven": (
        lambda p: as_npz(p / "a.npz", x=GAP),
        r"coordinate x that is not uniform: 0.906 \(index 3\)",
        "interpolate",
    ),
    "backwards in time": (
        lambda p: as_mat(p / "a.mat", t=T[::-1]),
        "not increase: 0.66 is followed by 0.55",
        "reverse",
    ),
    "to and fro": (lambda p: as_mat(p / "a.mat", x=FRO), "x that does not decrease: 0.6 is followed by 0.9", "reverse"),
    "repeated": (lambda p: as_npz(p / "a.npz", x=TWICE), r"not increase: 0.6 is followed by 0.6 \(index 2\)", "sort"),
    "coordinate with nan": (
        lambda p: as_npz(p / "a.npz", x=np.where(X > 1, np.nan, X)),
        "x that is not all finite",
        "correct it",
    ),
    "feet": (lambda p: as_netcdf(p / "a.nc", units=("m", "ft", "s")), "mixed units: x in m, y in ft", "convert"),
    "frames": (lambda p: as_netcdf(p / "a.nc", units=("m", "m", "frames")), "mixed units", "convert"),
    "degrees": (
        lambda p: as_netcdf(p / "a.nc", units=("degrees_east", "degrees_north", "s")),
        "mixed units",
        "a degree of latitude is 111.2 km",
    ),
    "units of one only": (lambda p: as_netcdf(p / "a.nc", units=("m", "m", "")), "t in no unit", "convert"),
    "si with scaled gravity": (
        lambda p: as_npz(p / "a.npz", units="si", gravity=1.0),
        "mixed units: it says SI",
        "--gravity",
    ),
    "scaled with gravity": (lambda p: as_npz(p / "a.npz", units="scaled"), "mixed units: it says scaled", "--gravity"),
    "unknown units": (lambda p: as_npz(p / "a.npz", units="feet"), "units = 'feet'", "say si"),
    "no gravity": (lambda p: as_npz(p / "a.npz", gravity=None), "does not say its gravity", "--gravity"),
    "negative gravity": (lambda p: as_npz(p / "a.npz", gravity=-9.81), "gravity = -9.81", "positive"),
    "gravity as a word": (lambda p: as_npz(p / "a.npz", gravity="g"), "gravity = 'g'", "positive"),
    "nan": (lambda p: as_npz(p / "a.npz", eta=with_nan()), "1 of 210 values that are not finite", "NaN"),
    "nan in netcdf": (lambda p: as_netcdf(p / "a.nc", eta=with_nan()), "1 of 210 values", "NaN"),
    "one frame": (lambda p: as_npz(p / "a.npz", eta=np.ones((5, 6, 1)), t=np.zeros(1)), "only 1 frame", "at least two"),
    "a single image": (lambda p: as_npz(p / "a.npz", eta=np.ones((5, 6))), "one frame is no video", "store"),
    "one row": (lambda p: as_npz(p / "a.npz", eta=np.ones((5, 1, 7)), y=np.zeros(1)), "only 1 sample along y", "two"),
    "complex": (lambda p: as_npz(p / "a.npz", eta=small_cube().surface * 1j), "complex samples", "real surface"),
    "complex mat": (lambda p: as_mat(p / "a.mat", eta=small_cube().surface * 1j), "complex samples", "real surface"),
    "true and false": (lambda p: as_npz(p / "a.npz", eta=small_cube().surface > 0), "true and false", "images"),
    "words": (lambda p: as_npz(p / "a.npz", eta=np.full(GRID.shape, "a")), "samples of type <U1", "numbers"),
    "10 GB npy": (lambda p: raw(p / "a.npy", huge_npy()), "takes 10000000000 bytes, at most 800", "copy"),
    "10 GB npz": (lambda p: huge_npz(p / "a.npz", zipfile.ZIP_STORED), "takes 10000000000 bytes", "copy"),
    "10 GB npz, packed": (lambda p: huge_npz(p / "a.npz", zipfile.ZIP_DEFLATED), "takes 10000000000 bytes", "copy"),
    "4 GB npz, packed, in its directory": (lambda p: lying_npz(p / "a.npz"), "takes 4000000000 bytes", "copy"),
    "10 GB mat": (lambda p: huge_mat(p / "a.mat"), "takes 1250000000 bytes, at most 210", "copy"),
    "4 GB element in a mat": (lambda p: long_mat(p / "a.mat"), "an element of 4294967280 bytes", "copy"),
    "10 GB netcdf": (lambda p: huge_netcdf(p / "a.nc"), "0 of 1000 parts were ever written", "finish writing"),
}


@pytest.mark.parametrize("name", BAD)
def test_one_message_names_file_fault_and_remedy(tmp_path, name):
    make, fault, remedy = BAD[name]
    path = make(tmp_path)
    before = {p: p.stat().st_mtime_ns for p in tmp_path.iterdir()}
    options = {"spacing": GRID.spacing, "gravity": 9.81, "axes": "xyt"} if path.suffix == ".npy" else {}
    tracemalloc.start()
    try:
        with pytest.raises(LeakrefError) as caught:
            files.read(path, **options)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert re.search(fault, caught.value.fault), caught.value.fault
    assert re.search(remedy, caught.value.remedy), caught.value.remedy
    assert peak < 5e6
    assert {p: p.stat().st_mtime_ns for p in tmp_path.iterdir()} == before


def test_the_good_file_behind_the_bad_ones_is_read(tmp_path):
    for path in (as_npz(tmp_path / "a.npz"), as_mat(tmp_path / "a.mat"), as_netcdf(tmp_path / "a.nc")):
        assert files.read(path).grid == GRID
        # a compressed file is no less good
    np.savez_compressed(tmp_path / "b.npz", **variables(eta=np.zeros(GRID.shape)))
    savemat(tmp_path / "b.mat", variables(eta=np.zeros(GRID.shape)), do_compression=True)
    for name in ("b.npz", "b.mat"):
        assert not files.read(tmp_path / name).surface.any()


def test_a_file_that_may_not_be_read(tmp_path, monkeypatch):
    path = as_npz(tmp_path / "a.npz")

    def closed(*_, **__):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "open", closed)  # for the superuser no mode forbids anything
    with pytest.raises(LeakrefError, match=r"a\.npz may not be read by you; ask for permission"):
        files.read(path)


def test_a_cube_too_large_for_memory_is_refused_with_the_way_round(tmp_path, monkeypatch):
    path = as_npz(tmp_path / "a.npz")
    monkeypatch.setattr("os.sysconf", lambda name: 4096 if name == "SC_PAGE_SIZE" else 1)
    with pytest.raises(LeakrefError, match=r"too large for this machine's memory; save eta with numpy\.save as \.npy"):
        files.read(path)
    np.save(tmp_path / "a.npy", small_cube().surface)
    assert files.read(tmp_path / "a.npy", spacing=GRID.spacing, gravity=1, axes="xyt").grid == GRID


def test_a_file_that_opens_no_code(tmp_path, monkeypatch):
    def load(*_, **__):
        raise AssertionError("something was unpickled")

    object_npz(tmp_path / "a.npz")
    monkeypatch.setattr(pickle, "load", load)
    monkeypatch.setattr(pickle, "loads", load)
    with pytest.raises(LeakrefError, match="never loaded"):
        files.read(tmp_path / "a.npz")


def test_netcdf_without_its_libraries_says_how_to_get_them(tmp_path, monkeypatch):
    path = as_netcdf(tmp_path / "a.nc")
    monkeypatch.setitem(sys.modules, "h5netcdf", None)
    for call in (lambda: files.read(path), lambda: files.write(tmp_path / "b.nc", small_cube(), "netcdf")):
        with pytest.raises(LeakrefError, match=r"pip install 'leakref\[netcdf\] @ ADDRESS'"):
            call()
    assert not (tmp_path / "b.nc").exists()


def test_a_write_that_fails_leaves_nothing(tmp_path, monkeypatch):
    good = files.write(tmp_path / "a.npz", small_cube(), "npz").read_bytes()

    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez", full)
    with pytest.raises(LeakrefError, match="No space left on device"):
        files.write(tmp_path / "a.npz", small_cube(), "npz")
    assert (tmp_path / "a.npz").read_bytes() == good
    assert len(list(tmp_path.iterdir())) == 1


def test_netcdf_follows_the_conventions(tmp_path):
    with xarray.open_dataset(files.write(tmp_path / "a.nc", small_cube(), "netcdf")) as data:
        assert data.attrs["Conventions"] == "CF-1.10"
        assert data["eta"].dims == ("x", "y", "t")
        assert {name: data[name].attrs["units"] for name in ("eta", "x", "t", "gravity", "kx", "omega", "current")} == {
            "eta": "m",
            "x": "m",
            "t": "s",
            "gravity": "m s-2",
            "kx": "m-1",
            "omega": "s-1",
            "current": "m s-1",
        }
        assert data["eta"].attrs["standard_name"] == "sea_surface_height_above_mean_sea_level"
        assert [data[name].attrs["axis"] for name in "xyt"] == ["X", "Y", "T"]


def test_mat_holds_the_variables_of_the_contract(tmp_path):
    held = loadmat(files.write(tmp_path / "a.mat", small_cube(), "mat"))
    assert held["__version__"] == "1.0"
    assert {"eta", "x", "y", "t", "gravity", "kx", "ky", "omega", "amplitude", "phase", "current"} <= set(held)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("kind", ["npz", "mat", "nc", "npy"])
def test_damage_anywhere_is_refused_or_harmless(tmp_path, kind, capfd):
    """Bytes changed or cut off at random: no other exception than the refusal, in one line, ever gets out.

    NetCDF is only cut: bytes changed within can keep the HDF5 library itself busy for ever.
    """
    make = {
        "npz": as_npz,
        "mat": as_mat,
        "nc": as_netcdf,
        "npy": lambda path: raw(path, npy_bytes(small_cube().surface)),
    }[kind]
    options = {"spacing": GRID.spacing, "gravity": 1.0, "axes": "xyt"} if kind == "npy" else {}
    content = make(tmp_path / f"good.{kind}").read_bytes()
    rng, refused = np.random.default_rng(11), []
    for n in range(90):
        bad = bytearray(content)
        if n % 3 and kind != "nc":
            for at in rng.integers(0, len(bad) if n % 3 == 1 else min(600, len(bad)), 3):
                bad[at] = rng.integers(256)
        else:
            bad = bad[: rng.integers(len(bad))]
        try:
            files.read(raw(tmp_path / f"bad.{kind}", bytes(bad)), **options)
        except LeakrefError as error:
            refused.append(str(error))
    assert len(refused) >= 30  # what was cut, at least
    assert all(f"bad.{kind}" in message and "\n" not in message for message in refused)
    assert capfd.readouterr().err == ""
