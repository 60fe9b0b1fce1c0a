"""The exchange folder: what is written for an implementation, what is read back, and what is not."""

from __future__ import annotations

import io
import os
import shutil
import struct
import tracemalloc
import zipfile
import zlib
from pathlib import Path

import numpy as np
import pytest
import scipy.io

from leakref.certify.subject.exchange import Exchange
from leakref.certify.verdict import Unanswered

FORMATS = ("npz", "mat", "raw")
CUBE = np.random.default_rng(5).standard_normal((3, 4, 5))


@pytest.fixture(params=FORMATS)
def exchange(request):
    used = Exchange()
    used.form = request.param
    used.given, _ = used.give(1, request.param, {"eta": CUBE, "x": [0.0, 0.5, 1.0]})
    yield used
    used.close()
    assert not used.folder.exists()


def put(exchange, **values):
    """An output as another program writes it."""
    if exchange.form == "raw":
        for name, value in values.items():
            array = np.asarray(value)
            array.astype("<c16" if np.iscomplexobj(array) else "<f8").tofile(exchange.output / f"{name}.f64")
    elif exchange.form == "mat":
        scipy.io.savemat(exchange.output, values, do_compression=True)
    else:
        np.savez_compressed(exchange.output, **values)


def test_inputs_are_as_the_protocol_says(exchange):
    if exchange.form == "raw":
        found = {path.stem: np.fromfile(path, "<f8") for path in exchange.given.iterdir()}
        found["eta"] = found["eta"].reshape(CUBE.shape)
    elif exchange.form == "mat":
        found = scipy.io.loadmat(exchange.given, squeeze_me=True)
    else:
        with np.load(exchange.given, allow_pickle=False) as stored:
            found = dict(stored)
    assert np.array_equal(found["eta"], CUBE)
    assert np.array_equal(found["x"], [0.0, 0.5, 1.0])
    assert exchange.folder.stat().st_mode & 0o777 == 0o700
    assert exchange.given.is_absolute()


@pytest.mark.parametrize("value", [CUBE, CUBE + 1j * CUBE[::-1]])
def test_outputs_come_back_as_they_are(exchange, value):
    put(exchange, S=value)
    found = exchange.take("S", CUBE.shape)
    assert found.dtype == value.dtype
    assert np.array_equal(found, value)
    assert exchange.changes() == []


def test_numbers_of_other_types_are_converted(exchange):
    put(exchange, w=np.arange(5, dtype=np.int16))
    found = exchange.take("w", (5,))
    assert found.dtype == np.float64
    assert found.ravel().tolist() == [0, 1, 2, 3, 4]


def refused(exchange, name="S"):
    with pytest.raises(Unanswered) as nothing:
        exchange.take(name, CUBE.shape)
    return str(nothing.value.verdict), nothing.value.message


def test_no_output_is_an_error(exchange):
    verdict, message = refused(exchange)
    assert (verdict, "there is no file" in message) == ("error", True)


def test_another_variable_is_no_answer(exchange):
    put(exchange, other=CUBE)
    assert refused(exchange)[0] == ("error" if exchange.form == "raw" else "fail")


def bomb(path, form, claimed, size=64 << 20, other=False):
    """A small file that unpacks to very many zeros, whose header says it is of the shape `claimed`."""
    name = "other" if other else "S"
    if form == "npz":
        header = io.BytesIO()
        np.lib.format.write_array_header_1_0(header, {"descr": "<f8", "fortran_order": False, "shape": claimed})
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr(f"{name}.npy", header.getvalue() + bytes(size))
    else:

        def element(kind, data):
            return struct.pack("<2I", kind, len(data)) + data + bytes(-len(data) % 8)

        parts = (
            element(6, struct.pack("<2I", 6, 0)),
            element(5, struct.pack("<3i", *claimed)),
            element(1, name.encode()),
            element(9, bytes(size)),
        )
        packed = zlib.compress(element(14, b"".join(parts)))
        path.write_bytes(b"MATLAB 5.0".ljust(124) + b"\0\1IM" + struct.pack("<2I", 15, len(packed)) + packed)
    assert path.stat().st_size < 2**17


def most_memory(work):
    tracemalloc.start()
    try:
        return work(), tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("exchange", ["npz", "mat"], indirect=True)
@pytest.mark.parametrize("case", ["large", "lying", "other"])
def test_what_is_more_than_was_asked_for_is_not_unpacked(exchange, case):
    claimed = {"large": (256, 256, 128), "lying": CUBE.shape, "other": (256, 256, 128)}[case]
    bomb(exchange.output, exchange.form, claimed, other=case == "other")
    (verdict, message), most = most_memory(lambda: refused(exchange))
    assert verdict == ("error" if case == "lying" and exchange.form == "npz" else "fail")
    assert {"large": "of shape (256, 256, 128)", "lying": "S of shape", "other": "does not hold S"}[case] in message
    assert most < 4 * 2**20


@pytest.mark.parametrize("exchange", ["npz"], indirect=True)
@pytest.mark.parametrize("method", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_what_numpy_does_not_pack_is_not_unpacked(exchange, method):
    with zipfile.ZipFile(exchange.output, "w", method) as archive:
        archive.writestr("S.npy", b"\x93NUMPY\1\0" + bytes(64 << 20))
    (verdict, message), most = most_memory(lambda: refused(exchange))
    assert (verdict, "packed in a way" in message, most < 4 * 2**20) == ("error", True, True)


@pytest.mark.parametrize("exchange", ["npz"], indirect=True)
def test_a_header_of_any_length_is_not_unpacked(exchange):
    with zipfile.ZipFile(exchange.output, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("S.npy", b"\x93NUMPY\2\0" + (64 << 20).to_bytes(4, "little") + bytes(64 << 20))
    (verdict, message), most = most_memory(lambda: refused(exchange))
    assert (verdict, "the header of S takes 67108864 bytes" in message, most < 4 * 2**20) == ("error", True, True)


@pytest.mark.parametrize("exchange", ["npz"], indirect=True)
def test_long_words_are_not_unpacked(exchange):
    put(exchange, S=np.full(CUBE.shape, "x" * 10**5))
    (verdict, message), most = most_memory(lambda: refused(exchange))
    assert (verdict, "should be 60 numbers" in message, most < 4 * 2**20) == ("fail", True, True)


def test_a_file_of_terabytes_is_not_read(exchange):
    put(exchange, S=CUBE)
    path = exchange.output / "S.f64" if exchange.form == "raw" else exchange.output
    os.truncate(path, 1 << 40)
    assert refused(exchange)[0] == "fail"
    given = exchange.given / "eta.f64" if exchange.form == "raw" else exchange.given
    given.chmod(0o644)
    os.truncate(given, 1 << 40)
    assert exchange.changes() == [f"altered its input {given.relative_to(exchange.output.parent)}"]


@pytest.mark.skipif(os.name != "posix", reason="no pipes or links with a name")
@pytest.mark.parametrize("what", ["pipe", "link", "link to the folder"])
def test_what_takes_its_place_at_the_last_moment_is_not_waited_for_or_followed(exchange, what, tmp_path, monkeypatch):
    put(exchange, S=CUBE)
    path = exchange.output / "S.f64" if exchange.form == "raw" else exchange.output
    look = os.open

    def late(*arguments, **keywords):
        monkeypatch.undo()
        there = path.parent if what == "link to the folder" else path
        there.rename(tmp_path / "moved")
        os.mkfifo(there) if what == "pipe" else there.symlink_to(tmp_path / "moved")
        return look(*arguments, **keywords)

    monkeypatch.setattr(os, "open", late)
    verdict, message = refused(exchange)
    assert (verdict, "there is no file" in message) == ("error", True)


@pytest.mark.parametrize("depth", [3, 2000])
def test_folders_as_deep_as_can_be_are_removed(exchange, depth):
    here = Path.cwd()
    try:
        os.chdir(exchange.output.parent)
        for _ in range(depth):
            os.mkdir("d")
            os.chdir("d")
        Path("file").touch(mode=0)
    finally:
        os.chdir(here)
    assert "left in the exchange folder 'run-1/d'" in exchange.changes()[0]


def test_somebody_who_takes_the_folder_away_is_named(tmp_path):
    exchange = Exchange(tmp_path)
    exchange.give(1, "npz", {"eta": CUBE})
    (exchange.folder / "run-2").mkdir()
    assert exchange.give(2, "npz", {"eta": CUBE})[0].parent.name.startswith("run-2-")
    shutil.rmtree(exchange.folder)
    with pytest.raises(Unanswered, match="removed or replaced the exchange folder"):
        exchange.give(3, "npz", {"eta": CUBE})
    exchange.note("answer.json", {})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(os.name != "posix", reason="no pipes or links with a name")
@pytest.mark.parametrize("what", ["pipe", "link", "folder"])
def test_what_is_no_file_is_not_opened(exchange, what, tmp_path):
    place = exchange.output / "S.f64" if exchange.form == "raw" else exchange.output
    if what == "pipe":
        os.mkfifo(place)
    elif what == "folder":
        place.mkdir()
    else:
        np.savez(tmp_path / "elsewhere.npz", S=CUBE)
        place.symlink_to(tmp_path / "elsewhere.npz")
    verdict, message = refused(exchange)
    assert (verdict, "there is no file" in message) == ("error", True)


def test_a_file_cut_short_is_no_answer(exchange):
    put(exchange, S=CUBE)
    path = exchange.output / "S.f64" if exchange.form == "raw" else exchange.output
    path.write_bytes(path.read_bytes()[:-30])
    assert refused(exchange)[0] == ("fail" if exchange.form == "raw" else "error")


@pytest.mark.parametrize("exchange", ["npz", "mat"], indirect=True)
@pytest.mark.parametrize("value", [{"a": 1.0}, np.array([1.0, "a"], dtype=object)])
def test_objects_are_not_loaded(exchange, value):
    put(exchange, S=value)
    assert refused(exchange)[0] == "error"


@pytest.mark.parametrize("exchange", ["npz", "mat"], indirect=True)
def test_a_file_of_another_kind_is_no_answer(exchange):
    with exchange.output.open("wb") as stream:
        np.save(stream, CUBE)
    verdict, message = refused(exchange, "eta")
    assert (verdict, "of the kind npy" in message) == ("error", True)


@pytest.mark.parametrize("exchange", ["npz", "mat"], indirect=True)
def test_words_are_no_numbers(exchange):
    put(exchange, S="none")
    assert refused(exchange)[0] == "fail"


@pytest.mark.parametrize("exchange", ["raw"], indirect=True)
def test_a_raw_file_has_the_size_of_the_shape(exchange):
    put(exchange, S=CUBE[:, :, 1:])
    verdict, message = refused(exchange)
    assert (verdict, "S.f64 holds 384 bytes" in message) == ("fail", True)


def test_a_stage_without_input_still_has_a_file():
    for form in FORMATS:
        exchange = Exchange()
        given, _ = exchange.give(1, form, {})
        assert given.exists()
        exchange.close()


def test_clearing_makes_room_for_the_next_run(exchange):
    (exchange.folder / "run-1" / "locked").mkdir(mode=0o000)
    assert exchange.changes() == ["left in the exchange folder 'run-1/locked'"]
    exchange.clear()
    assert list(exchange.folder.iterdir()) == []
    exchange.give(1, exchange.form, {"eta": CUBE})
    assert exchange.changes() == []


def test_folders_that_are_kept_do_not_meet(tmp_path):
    kept = [Exchange(tmp_path / "new") for _ in range(2)]
    for exchange in kept:
        exchange.give(1, "npz", {"eta": CUBE})
        exchange.clear()
        exchange.give(2, "npz", {"eta": CUBE})
        assert exchange.changes() == []
        exchange.close()
    assert sorted(path.parent.name for path in tmp_path.glob("new/*/*/in.npz")) == ["run-1", "run-1", "run-2", "run-2"]
