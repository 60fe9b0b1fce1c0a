"""Answers are read as a file of somebody unknown: what cannot be theirs is refused in words, and nothing is run."""

from __future__ import annotations

import json
import os
import subprocess
import zlib
from contextlib import suppress

import numpy as np
import pytest
from scipy import io
from test_commands import here as command
from test_exam import answered, copied, marks
from tools import requires

from leakref import LeakrefError
from leakref.certify.subject.declaration import Declaration
from leakref.certify.targets import load
from leakref.certify.verdict import Verdict
from leakref.cubes import matlab
from leakref.exam import folder
from leakref.exam.answers import read
from leakref.exam.marking import recognise


class Windows:
    """So small an examination that each test has its own."""

    def window(self, name, size):
        return load("reference").window(name, size)

    def synthesize(self, components, x, y, t):
        return load("reference").synthesize(components, x, y, t)


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    place = tmp_path_factory.mktemp("small") / "exam"
    folder.lay_down(
        place, Declaration.read({"can": {"window": {}, "synthesize": {}}}), "raw", profile="quick", golden=2, seed=3
    )
    answered(place, Windows())
    return place


@pytest.fixture
def place(small, tmp_path):
    return copied(small, tmp_path)


def said(place):
    return json.loads((place / "answers.json").read_text())


def put(place, record):
    (place / "answers.json").write_text(json.dumps(record))


def looked_at(place):
    sheet = folder.load(place)
    read(place, sheet)
    recognise(place, sheet)


def refused(place, words):
    """In words, before anything is judged."""
    with pytest.raises(LeakrefError, match=words) as error:
        looked_at(place)
    assert error.value.status in (2, 3)


def test_as_it_was_answered_it_is_conformant(place):
    found = marks(place)
    assert found.grade == "conformant"
    assert found.counts["pass"] > 15


def test_the_command_ends_with_2_and_one_line(place):
    put(place, {**said(place), "digest": "0" * 64})
    done = command("exam", "grade", place)
    assert done.returncode == 2
    assert "answers another examination" in done.stderr
    assert "Traceback" not in done.stderr


# ---------------------------------------------------------------- questions


def sealed(place, record):
    """As somebody writes it who knows how the digest is made."""
    record["digest"] = folder.digest({name: value for name, value in record.items() if name != "digest"})
    (place / "questions.json").write_text(json.dumps(record))
    put(place, {**said(place), "digest": record["digest"]})


def test_a_question_that_was_altered_is_refused(place):
    text = (place / "questions.json").read_text()
    (place / "questions.json").write_text(text.replace('"size": 7', '"size": 8', 1))
    refused(place, "was altered: its digest")


def altered(**changes):
    def change(record):
        for name, value in changes.items():
            record[name] = value

    return change


def other_size(record):
    next(one for one in record["questions"] if one["stage"] == "window")["parameters"]["size"] += 1


def one_less(record):
    del record["questions"][-1]


def one_more(record):
    record["questions"].append({**record["questions"][-1], "id": "signs.more"})


def exchanged(record):
    first, second = record["questions"][:2]
    first["input"], second["input"] = second["input"], first["input"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (altered(profile="full"), "not the questions of seed 3"),
        (altered(profile="short"), "is no examination"),
        (altered(golden=99), "golden set number 99"),
        (altered(seed="3"), "has no seed as it should"),
        (altered(seed=-1), "the seed is -1"),
        (altered(schema="leakref/exam/2"), "not of the schema"),
        (altered(format="zip"), "no format is called"),
        (altered(declaration={"can": {"window": {}}}), "declares can"),
        (altered(declaration={"units": "feet"}), "declares units"),
        (other_size, "parameters of .* are others"),
        (one_less, "was not asked"),
        (one_more, "should be"),
        (exchanged, "not the questions of seed 3"),
    ],
)
def test_an_altered_examination_is_refused_whoever_sealed_it(place, change, words):
    record = json.loads((place / "questions.json").read_text())
    change(record)
    sealed(place, record)
    refused(place, words)


@pytest.mark.parametrize("path", ["../../etc/passwd", "/etc/passwd", "inputs/../../x", "inputs", "inputs/a/b", 7, None])
def test_a_path_that_leads_out_of_the_folder_is_refused(place, path):
    record = json.loads((place / "questions.json").read_text())
    record["inputs"][0]["path"] = path
    sealed(place, record)
    refused(place, "is no examination")


def test_an_input_that_was_altered_is_refused(place):
    path = place / json.loads((place / "questions.json").read_text())["inputs"][0]["path"] / "kx.f64"
    content = bytearray(path.read_bytes())
    path.unlink()
    content[3] ^= 1
    path.write_bytes(content)
    refused(place, "was altered: its SHA-256")


def test_another_cube_is_refused_even_if_all_sums_are_made_anew(place):
    record = json.loads((place / "questions.json").read_text())
    row = record["inputs"][0]
    path = place / row["path"] / "kx.f64"
    values = np.fromfile(path) * 1.01
    path.unlink()
    values.tofile(path)
    content = b"".join(one.read_bytes() for one in sorted(path.parent.iterdir()))
    row |= {"contents": "0" * 64, "sha256": folder.storing.sha256(content), "sum": zlib.adler32(content)}
    sealed(place, record)
    refused(place, "is another cube")


def test_numbers_of_another_machine_are_the_same_questions(place):
    """One in the last digit: another digest, the same cube; but then the inputs must be there."""
    record = json.loads((place / "questions.json").read_text())
    row = record["inputs"][0]
    path = place / row["path"] / "kx.f64"
    values = np.nextafter(np.fromfile(path), 9)
    path.unlink()
    values.tofile(path)
    content = b"".join(one.read_bytes() for one in sorted(path.parent.iterdir()))
    row |= {"contents": "0" * 64, "sha256": folder.storing.sha256(content)}
    sealed(place, record)
    assert marks(place).grade == "conformant"
    for one in path.parent.iterdir():
        one.unlink()
    path.parent.rmdir()
    refused(place, "another cube or not in the folder")


def test_questions_and_answers_alone_are_enough_where_the_numbers_are_the_same(place):
    for one in sorted((place / "inputs").rglob("*"), reverse=True):
        one.rmdir() if one.is_dir() else one.unlink()
    assert marks(place).grade == "conformant"


# ---------------------------------------------------------------- answers


def test_a_truncated_answer_is_refused(place):
    text = (place / "answers.json").read_text()
    for cut in (0, 1, len(text) // 2, len(text) - 2):
        (place / "answers.json").write_text(text[:cut])
        refused(place, "not strict JSON, or cut short")


def test_a_doubled_answer_is_refused(place):
    record = said(place)
    put(place, {**record, "answers": [*record["answers"], record["answers"][0]]})
    refused(place, "answers .* twice")
    text = json.dumps(record).replace('"status": "ok"', '"status": "ok", "status": "ok"', 1)
    (place / "answers.json").write_text(text)
    refused(place, "twice in one object")


def test_a_gigabyte_of_zeros_is_refused_unread(place):
    for name in ("answers.json", "questions.json"):
        kept = (place / name).read_bytes()
        with (place / name).open("wb") as stream:
            stream.truncate(1 << 30)
        refused(place, "takes 1073741824 bytes")
        (place / name).write_bytes(kept)
    output = next((place / "outputs").rglob("*.f64"))
    output.unlink()
    with output.open("wb") as stream:
        stream.truncate(1 << 30)
    found = marks(place)
    assert [f.verdict for f in found.wrong] == [Verdict.FAIL]
    assert "1073741824 bytes" in found.wrong[0].message


@pytest.mark.parametrize(
    "path", ["/etc/passwd", "../answers.json", "outputs/../../x", "outputs/002", ["x"], {"a": 1}, 3]
)
def test_an_answer_with_a_path_of_its_own_is_refused(place, path):
    record = said(place)
    record["answers"][0]["output"] = path
    put(place, record)
    refused(place, "names the output")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"digest": "f" * 64}, "answers another examination"),
        ({"digest": None}, "answers another examination"),
        ({"answers": {}}, "holds no answers"),
        ({"answers": [{"id": "signs.sea[to-22.5]", "status": "ok"}]}, "was not asked"),
        ({"answers": [3]}, "was not asked"),
        ({"answers": [{"id": ["a"]}]}, "was not asked"),
        ({"code": {"units": "si"}}, "declares units = si; the questions are for units = scaled"),
        ({"code": {"axes": "txy"}}, "declares axes = txy"),
        ({"code": {"can": {"window": {}}}}, "declares can"),
        ({"code": {"units": "feet"}}, "the code in .* declares units"),
        ({"code": "mine"}, "declares no code, but mine"),
        ({"code": {"can": {"extract": 3}}}, "declares can"),
    ],
)
def test_what_cannot_be_an_answer_to_these_questions_is_refused(place, change, words):
    put(place, said(place) | change)
    refused(place, words)


@pytest.mark.parametrize("text", ["[" * 100000, '{"a": ' * 60 + "1" + "}" * 60, '{"digest": NaN}', "\xff\xfe", "[1e9"])
def test_what_is_no_strict_json_is_refused(place, text):
    (place / "answers.json").write_bytes(text.encode("latin1"))
    refused(place, "not strict JSON")


def test_links_and_pipes_are_not_followed(place, tmp_path):
    for name in ("answers.json", "questions.json"):
        kept = (place / name).read_bytes()
        (tmp_path / "elsewhere").write_bytes(kept)
        (place / name).unlink()
        (place / name).symlink_to(tmp_path / "elsewhere")
        refused(place, "cannot be read")
        (place / name).unlink()
        os.mkfifo(place / name)
        refused(place, "cannot be read")
        (place / name).unlink()
        (place / name).write_bytes(kept)
    output = next((place / "outputs").rglob("*.f64"))
    kept = output.read_bytes()
    output.unlink()
    (tmp_path / "values").write_bytes(kept)
    output.symlink_to(tmp_path / "values")
    assert [str(f.verdict) for f in marks(place).wrong] == ["error"]


def test_two_files_of_answers_are_one_too_many_and_none_too_few(place):
    (place / "answers.mat").write_bytes(b"")
    refused(place, "answers.json and answers.mat")
    (place / "answers.json").unlink()
    (place / "answers.mat").unlink()
    refused(place, "neither answers.json nor answers.mat")


def test_a_name_and_a_version_are_the_owner_s_own(place):
    put(place, said(place) | {"code": {"name": "my code <b>", "version": "7"}})
    found = marks(place)
    assert (found.target, found.declaration["version"]) == ("my code <b>", "7")


# ---------------------------------------------------------------- answers.mat


@pytest.fixture(scope="module")
def velocities(tmp_path_factory):
    """One question with rows, answered with one of them null."""
    place = tmp_path_factory.mktemp("rows") / "exam"
    declaration = Declaration.read(
        {"name": "mat", "cube": {"multiple": 2}, "fixed": ["gravity"], "can": {"extract": {"methods": ["ls"]}}}
    )
    folder.lay_down(place, declaration, "mat", profile="quick", golden=2, seed=1)
    record = json.loads((place / "questions.json").read_text())
    rows = [[0.1 * n, -0.2] for n in range(4)]
    first, second, third = record["questions"][:3]
    said = [
        {
            "id": first["id"],
            "status": "ok",
            "velocities": [None, *rows[1:]],
            "wavenumbers": first["parameters"]["wavenumbers"],
        },
        {"id": second["id"], "status": "error", "message": "it broke"},
        {"id": third["id"], "status": "ok", "velocities": rows},
    ]
    put(place, {"digest": record["digest"], "code": record["declaration"], "answers": said})
    return place


def as_mat(record, compressed):
    """What Octave or MATLAB would save: a structure, an array of them, NaN for null."""
    fields = ("id", "status", "message", "velocities", "wavenumbers")
    rows = np.zeros(len(record["answers"]), dtype=[(name, object) for name in fields])
    for n, one in enumerate(record["answers"]):
        for name in fields:
            value = one.get(name, "" if name in ("message",) else np.zeros((0, 0)))
            rows[n][name] = (
                [[np.nan] * 2 if row is None else row for row in value]
                if name == "velocities" and name in one
                else value
            )
    return {"digest": record["digest"], "code": record["code"], "answers": rows}


@pytest.mark.parametrize("compressed", [False, True])
def test_answers_in_a_mat_file_say_the_same(velocities, compressed, tmp_path):
    sheet = folder.load(velocities)
    plain = read(velocities, sheet)
    record = said(velocities)
    (tmp_path / "questions.json").write_bytes((velocities / "questions.json").read_bytes())
    io.savemat(tmp_path / "answers.mat", as_mat(record, compressed), do_compression=compressed)
    found = read(tmp_path, sheet)
    assert found.declaration == plain.declaration
    assert dict(found.by_id) == dict(plain.by_id)


def test_a_mat_file_of_octave_is_read(velocities, tmp_path):
    octave = requires("octave-cli", "octave")
    for name in ("questions.json", "answers.json"):
        (tmp_path / name).write_bytes((velocities / name).read_bytes())
    code = """said = jsondecode(fileread("answers.json")); digest = said.digest; code = said.code;
    answers = struct("id", {}, "status", {}, "velocities", {});
    for n = 1:3
      one = said.answers{n}; v = [];
      if isfield(one, "velocities"), v = one.velocities; end
      if iscell(v), v = [NaN, NaN; cell2mat(cellfun(@(r) r(:)', v(2:end), "UniformOutput", false))]; end
      answers(n) = struct("id", one.id, "status", one.status, "velocities", v);
    end
    save("-v7", "answers.mat", "digest", "code", "answers"); delete("answers.json");"""
    subprocess.run([octave, "--quiet", "--no-init-file", "--eval", code], cwd=tmp_path, check=True, capture_output=True)
    sheet = folder.load(tmp_path)
    found, plain = read(tmp_path, sheet), read(velocities, sheet)
    assert found.declaration == plain.declaration
    for name, one in plain.by_id.items():
        assert found.by_id[name]["status"] == one["status"]
        assert found.by_id[name].get("velocities") == one.get("velocities")


def test_a_mat_file_that_unpacks_to_a_gigabyte_or_is_cut_is_refused(velocities, tmp_path):
    sheet = folder.load(velocities)
    whole = tmp_path / "whole.mat"
    io.savemat(whole, as_mat(said(velocities), True), do_compression=True)
    content = whole.read_bytes()
    for cut in (0, 60, 130, len(content) // 2, len(content) - 3):
        (tmp_path / "answers.mat").write_bytes(content[:cut])
        with pytest.raises(LeakrefError):
            read(tmp_path, sheet)
    bomb = zlib.compress(bytes(1 << 28))
    tag = np.array([15, len(bomb)], "<u4").tobytes()
    (tmp_path / "answers.mat").write_bytes(content[:128] + tag + bomb)
    with pytest.raises(LeakrefError, match="when it is unpacked"):
        read(tmp_path, sheet)
    rng = np.random.default_rng(3)
    for _ in range(200):  # whatever is in it, it is words
        damaged = bytearray(content)
        damaged[int(rng.integers(len(damaged)))] ^= int(rng.integers(1, 256))
        (tmp_path / "answers.mat").write_bytes(damaged)
        with suppress(LeakrefError):
            read(tmp_path, sheet)


def test_structures_within_structures_end_somewhere():
    deep: dict = {"a": 1.0}
    for _ in range(40):
        deep = {"a": deep}
    from io import BytesIO

    stream = BytesIO()
    io.savemat(stream, {"answers": deep})
    with pytest.raises(LeakrefError, match="beyond reason"):
        matlab.tree(folder.Path("x.mat"), stream.getvalue(), 1 << 20)
