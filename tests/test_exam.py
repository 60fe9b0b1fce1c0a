"""An examination in Python: what is asked, what is in the folder, what comes back; marks are those of certify."""

from __future__ import annotations

import json
import re
import zlib
from contextlib import nullcontext
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from scipy import io
from test_commands import here as command

from leakref import LeakrefError
from leakref.certify.certificate import schema
from leakref.certify.runner import certify, select
from leakref.certify.strength import faults
from leakref.certify.subject.declaration import Declaration
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.targets import load
from leakref.certify.verdict import Unanswered, Verdict
from leakref.exam import folder, storing
from leakref.exam.answers import read
from leakref.exam.commands import declared
from leakref.exam.marking import mark, recognise
from leakref.exam.recording import IDENTITY, LARGEST, questions, watched

SI = {"units": "si", "can": {"extract": {"methods": ["ls"], "windows": ["box", "hann"]}}}
WATCHED = {"behaviour.input[all-stages]", "behaviour.deterministic[twice]"}


def arrays_of(place, record, path):
    """The arrays of a question, read as a runner would."""
    shapes = {one["path"]: one["shapes"] for one in record["inputs"]}[path]
    if record["format"] == "raw":
        return {name: np.fromfile(place / path / f"{name}.f64", "<f8").reshape(shape) for name, shape in shapes.items()}
    if record["format"] == "npz":
        return dict(np.load(place / path))
    if record["format"] == "mat":
        held = io.loadmat(place / path)
        return {name: held[name].reshape(shape) for name, shape in shapes.items()}
    with io.netcdf_file(place / path, mmap=False) as held:
        return {name: np.array(held.variables[name][...], dtype=float) for name in shapes}


def answered(place, implementation, keep=lambda question: True):
    """Have a Python object answer a folder, by the files alone."""
    record = json.loads((place / "questions.json").read_text())
    subject = InProcess(implementation)
    said = []
    for question in filter(keep, record["questions"]):
        arrays = arrays_of(place, record, question["input"]) if question["input"] else {}
        one = {"id": question["id"], "status": "ok"}
        try:
            found = subject._work(question["stage"], arrays, question["parameters"])
        except Exception as error:
            said.append({**one, "status": "error", "message": str(error)})
            continue
        if question["output"]:
            ((name, value),) = found.items()
            write_output(place / question["output"], record["format"], name, np.asarray(value))
            said.append(one)
        else:
            rows = np.ma.filled(np.ma.asarray(found["velocities"], dtype=float), np.nan).tolist()
            rows = [row if np.isfinite(row).all() else None for row in rows]
            said.append(
                {**one, "velocities": rows, **({"wavenumbers": found["wavenumbers"]} if "wavenumbers" in found else {})}
            )
    code = {**record["declaration"], "name": subject.declaration.name}
    (place / "answers.json").write_text(json.dumps({"digest": record["digest"], "code": code, "answers": said}))
    return record


def write_output(path, form, name, value):
    path.parent.mkdir(exist_ok=True)
    if form == "raw":
        path.mkdir()
        value.astype("<c16" if np.iscomplexobj(value) else "<f8").tofile(path / f"{name}.f64")
    elif form == "netcdf":
        storing.write(path, form, {name: np.abs(value) if np.iscomplexobj(value) else value})
    else:
        with path.open("wb") as stream:
            np.savez(stream, **{name: value}) if form == "npz" else io.savemat(stream, {name: value}, appendmat=False)


def marks(place):
    sheet = folder.load(place)
    return mark(place, sheet, read(place, sheet), recognise(place, sheet))


def verdicts(found):
    return {f.id: (str(f.verdict), f.message, f.digits) for f in found.findings if f.id not in WATCHED}


def judged(implementation, declaration, **asked):
    """As certify judges it, in this process."""
    subject = InProcess(implementation)
    subject.declaration = declaration
    given = {"profile": "quick", "golden": 2, "seed": 1} | asked
    return certify("it", [nullcontext(subject)], select(**given), **given)


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """The published questions for a least squares in SI."""
    place = tmp_path_factory.mktemp("exam") / "exam"
    folder.lay_down(place, Declaration.read(SI), "npz", profile="quick", golden=2, seed=1)
    return place


@pytest.fixture(scope="module")
def reference(written, tmp_path_factory):
    """The same folder, answered by the reference."""
    place = copied(written, tmp_path_factory.mktemp("answered"))
    answered(place, load("reference"))
    return place


def copied(place, where):
    """A folder beside it whose inputs are the same files."""
    new = where / "exam"
    new.mkdir(parents=True)
    for path in place.iterdir():
        if path.name in ("inputs", "outputs"):
            (new / path.name).mkdir()
            for inner in path.rglob("*"):
                target = new / inner.relative_to(place)
                target.mkdir(exist_ok=True) if inner.is_dir() else target.hardlink_to(inner)
        else:
            (new / path.name).write_bytes(path.read_bytes())
    return new


# ---------------------------------------------------------------- what is asked


@pytest.fixture(scope="module")
def direct():
    """The same reference, judged by certify."""
    return judged(load("reference"), Declaration.read(SI))


def test_the_questions_are_those_of_certify(written, direct):
    record = json.loads((written / "questions.json").read_text())
    ids = {f"{check.id}[{case.id}]" for check, case in select(profile="quick")}
    asked = {one["id"].partition("#")[0] for one in record["questions"]}
    assert asked - ids <= {IDENTITY}
    named = {check for one in record["questions"] for check in one["checks"]}
    assert named <= ids
    beyond = {f.id for f in direct.findings if f.verdict is Verdict.UNSUPPORTED}
    assert named | beyond | WATCHED == {f.id for f in direct.findings}
    assert not named & WATCHED
    assert set(record["unsupported"]) == set(watched()) == WATCHED
    assert len({one["id"] for one in record["questions"]}) == len(record["questions"])
    assert (record["seed"], record["profile"], record["schema"]) == (1, "quick", "leakref/exam/1")


def test_each_cube_is_stored_once_and_the_folder_is_small(written):
    record = json.loads((written / "questions.json").read_text())
    files = list((written / "inputs").iterdir())
    assert len({one["contents"] for one in record["inputs"]}) == len(record["inputs"]) == len(files)
    assert len({path.read_bytes() for path in files}) == len(files) < len(record["questions"])
    assert sum(path.stat().st_size for path in written.rglob("*") if path.is_file()) < LARGEST


EVERY = {stage: {} for stage in ("window", "synthesize", "spectrum", "extract")}


@pytest.mark.parametrize(
    ("windows", "water"),
    [
        pytest.param(w, fixed, marks=pytest.mark.slow if len(w) + len(fixed) == 1 else pytest.mark.night)
        for w in ([], ["box", "hann"])
        for fixed in ((), ("depth",), ("surface_tension",), ("depth", "surface_tension"))
    ],
)
@pytest.mark.parametrize("methods", [["nsp", "ls"], []], ids=["named", "unnamed"])
def test_the_quick_examination_is_small_whatever_is_declared(water, windows, methods):
    total = []
    can = EVERY | {"extract": {"windows": windows, **({"methods": methods} if methods else {})}}
    declaration = Declaration.read({"units": "si", "water": dict.fromkeys(water, "given"), "can": can})
    questions(declaration, lambda digest, arrays: total.append(sum(np.asarray(one).nbytes for one in arrays.values())))
    assert sum(total) < LARGEST - 2e6  # headers, questions, runners


def test_the_table_says_the_same_as_the_json(written):
    record = json.loads((written / "questions.json").read_text())
    first, names, *lines = (written / "questions.tsv").read_text().splitlines()
    assert first.split("\t") == ["leakref/exam/1", record["digest"], "npz"]
    assert names.split("\t")[:5] == ["id", "stage", "input", "sum", "output"]
    for line, question in zip(lines, record["questions"], strict=True):
        identifier, stage, path, total, output, *cells = line.split("\t")
        assert (identifier, stage) == (question["id"], question["stage"])
        assert (path, output) == (question["input"] or "-", question["output"] or "-")
        assert int(total) == (zlib.adler32((written / path).read_bytes()) if path != "-" else 0)
        given = dict(cell.split("=", 1) for cell in cells if not cell.startswith("shape_"))
        assert set(given) == set(question["parameters"])
        for name, value in question["parameters"].items():
            said = given[name]
            assert value == (
                said
                if isinstance(value, str)
                else json.loads(f"[{said}]")[: len(value)]
                if isinstance(value, list)
                else json.loads(said)
            )


def test_nothing_in_the_folder_says_what_is_right(written):
    """No current, no velocity but zero, no wave: neither by name nor as a number in any file."""
    record = json.loads((written / "questions.json").read_text())
    for path in (written / "inputs").iterdir():
        assert set(np.load(path)) <= {"eta", "x", "y", "t"}
    allowed = {"dx", "dy", "dt", "gravity", "wavenumbers", "window", "method", "name", "size"}
    assert {name for one in record["questions"] for name in one["parameters"]} <= allowed
    words = (written / "questions.json").read_text() + (written / "questions.tsv").read_text()
    said = "current[^s.]|truth|amplitude[^[]|phase|direction\\W+[\\d-]|realization"
    assert not re.search(said, words.replace('"direction": "to"', ""))
    from leakref.certify.checks import inputs

    cube = inputs.sea(82.5, 180.0, inputs.UniformCurrent(inputs.polar(0.3, 22.5)), realization=7)
    units = Declaration.read(SI).scales()
    numbers = set(map(float, re.findall(r"-?\d+\.\d+(?:e-?\d+)?", words)))
    for value in (*cube.truth.ravel(), *(cube.truth.ravel() * units.velocity)):
        assert not any(abs(value - one) < 1e-12 for one in numbers)


def test_components_are_in_the_folder_where_a_surface_is_asked_for():
    seen = {}
    found = questions(
        Declaration.read({"can": {"synthesize": {}, "window": {}}}),
        lambda digest, arrays: seen.update({digest: set(arrays)}),
    )
    waves = {"kx", "ky", "omega", "amplitude", "phase", "x", "y", "t"}
    assert {one.stage for one in found} == {"synthesize", "window"}
    assert all(seen[one.input] == waves for one in found if one.stage == "synthesize")


def test_another_seed_asks_other_questions_of_the_same_ids():
    declaration = Declaration.read({"can": {"extract": {"methods": ["ls"], "windows": ["hann"]}}})
    first, second, again = (questions(declaration, seed=seed) for seed in (1, 5, 5))
    assert second == again
    assert {one.id for one in first} == {one.id for one in second} - {IDENTITY}
    assert sum(a.input != b.input for a, b in zip(first, second, strict=False)) > 30


# ---------------------------------------------------------------- what comes back


def test_marks_are_those_of_certify(reference, direct):
    found = marks(reference)
    assert verdicts(found) == verdicts(direct)
    assert found.grade == direct.grade == "conformant"
    assert {f.id: str(f.verdict) for f in found.findings if f.id in WATCHED} == dict.fromkeys(WATCHED, "unsupported")
    assert "by examination" in found.grade_line
    assert found.alike == direct.alike
    record = found.record()
    jsonschema.validate(record, schema())
    assert record["examination"]["digest"] == json.loads((reference / "questions.json").read_text())["digest"]
    assert record["examination"]["answers"] == storing.sha256((reference / "answers.json").read_bytes())
    assert all("questions.tsv" in f.repro for f in found.findings if f.verdict is Verdict.PASS)


@pytest.mark.parametrize("form", ["raw", "mat", "npz", "netcdf"])
def test_every_format_brings_back_arrays_of_all_stages(form, tmp_path):
    declaration = Declaration.read(
        {"axes": "txy", "y": "down", "can": {stage: {} for stage in ("window", "synthesize", "spectrum")}}
    )
    place = tmp_path / "exam"
    folder.lay_down(place, declaration, form, profile="quick", golden=2, seed=1)

    class Down:
        """The reference, with rows from the top and time first."""

        def describe(self):
            return {"axes": "txy", "y": "down"}

        def window(self, name, size):
            return load("reference").window(name, size)

        def synthesize(self, components, x, y, t):
            return load("reference").synthesize(components, x, y, t).transpose(2, 0, 1)

        def spectrum(self, surface, spacing, window):
            return load("reference").spectrum(surface.transpose(1, 2, 0), spacing, window=window).transpose(2, 0, 1)

    answered(place, Down())
    found = marks(place)
    assert found.grade == "conformant", [f for f in found.findings if f.verdict not in ("pass", "unsupported")]
    assert found.counts["pass"] > 20


def test_what_is_not_answered_is_missing_and_the_rest_is_marked(written, tmp_path):
    place = copied(written, tmp_path)
    with_gaps = ("behaviour.refuses[nan]#2", "behaviour.refuses[infinity]")
    some = ("signs", "behaviour.refuses", "metamorphic.amplitude")
    answered(place, load("reference"), lambda one: one["id"].startswith(some) and one["id"] not in with_gaps)
    found = marks(place)
    said = {f.id: str(f.verdict) for f in found.findings}
    assert {said[i] for i in said if i.startswith("behaviour.refuses")} == {"missing"}  # not: refused, and so right
    assert set(said.values()) == {"missing", "unsupported", "pass"}
    assert found.grade is None
    assert found.status == 3
    again = marks(place)
    assert verdicts(again) == verdicts(found)


@pytest.mark.slow
@pytest.mark.parametrize("which", ["negated-current", "no-taper", "gravity-hard-coded"])
def test_a_fault_is_diagnosed_as_by_certify(which, written, tmp_path):
    from leakref.certify.strength.diagnosis import explain

    place = copied(written, tmp_path)
    code = faults.implementation(which)
    answered(place, code)
    found, direct = marks(place), explain(judged(code, Declaration.read(SI)))
    assert verdicts(found) == verdicts(direct)
    assert found.grade == direct.grade == "rejected"
    assert list(found.diagnosis) == list(direct.diagnosis)
    assert found.diagnosis


KINDS = (
    {},
    {"can": {"extract": {"windows": []}}},
    {"can": {"extract": {"resolves": "band", "methods": ["mine"]}}},
    {"fixed": ["wavenumbers", "dy"], "units": "si", "water": {"depth": 8.0}},
    {"cube": {"multiple": 4}, "water": {"depth": "given"}},
)


def test_what_is_asked_of_everybody_is_there_and_what_follows_as_far_as_there_is_room(monkeypatch):
    few = select(["recovery.pair[even-1]", "recovery.ring[still]", "signs.sea[to-22.5]"])
    monkeypatch.setattr("leakref.exam.recording.select", lambda **asked: few)
    declaration, sizes = Declaration(), []

    def keep(digest, arrays):
        sizes.append(sum(np.asarray(one).nbytes for one in arrays.values()))

    whole = questions(declaration, keep, room=np.inf)
    least = questions(declaration, room=0.0)
    assert [one.key for one in least] == [one.key for one in whole[: len(least)]]
    own = sum(sizes[: len({one.input for one in least})])
    some = questions(declaration, room=own + sizes[-1])
    assert len(least) < len(some) < len(whole)
    assert {one.checks[0] for one in least} >= {f"{check.id}[{case.id}]" for check, case in few}


@pytest.mark.parametrize("kind", KINDS, ids=str)
@pytest.mark.parametrize(
    "how",
    [pytest.param(how, marks=pytest.mark.slow) for how in ("reference", "swapped")]
    + [pytest.param(how, marks=pytest.mark.night) for how in ("null", "random")],
)
def test_nothing_is_asked_that_was_not_foreseen(kind, how):
    """Whatever a code answers, every question that certify puts to it was in the examination."""
    from leakref.certify.subject.frames import Subject
    from leakref.exam.recording import key_of

    declaration = Declaration.read(kind)
    known = {question.key for question in questions(declaration, room=np.inf)}
    rng = np.random.default_rng(5)

    class Code(Subject):
        watched = False

        def _work(self, stage, arrays, parameters):
            assert key_of(stage, arrays, parameters) in known
            count = 1 if declaration.band else len(parameters["wavenumbers"])
            at = {"wavenumbers": parameters["wavenumbers"][:count]}
            if how == "null":
                return {"velocities": [None if rng.random() < 0.6 else [0.0, 0.0]] * count, **at}
            if how == "random":
                return {"velocities": rng.normal(size=(count, 2)), **at}
            p = {"gravity": parameters["gravity"], "window": parameters["window"], "method": "ls"}
            spacing = [parameters[name] for name in ("dx", "dy", "dt")]
            water = {name: parameters[name] for name in ("depth", "surface_tension") if name in parameters}
            try:
                found = load("reference").extract(arrays["eta"], spacing, parameters["wavenumbers"], **p, **water)
            except LeakrefError as error:
                raise Unanswered(Verdict.ERROR, str(error)) from None
            found = np.asarray(found)[:count, :: -1 if how == "swapped" else 1]
            return {"velocities": np.ma.masked_where(np.isnan(found), found), **at}

    certify("it", [nullcontext(Code(declaration))], select(profile="quick"), profile="quick")


def test_a_question_that_hangs_on_an_answer_is_unsupported(reference):
    sheet = folder.load(reference)
    everything = recognise(reference, sheet)
    left = [one for one in everything if one.id != "recovery.pair[even-1]"]
    rows = [row for row in sheet.record["questions"] if row["id"] != "recovery.pair[even-1]"]
    short = folder.Sheet({**sheet.record, "questions": rows}, sheet.declaration)
    found = mark(reference, short, read(reference, sheet), left)
    said = {f.id: f for f in found.findings}["recovery.pair[even-1]"]
    assert said.verdict is Verdict.UNSUPPORTED
    assert "hangs on an answer" in said.message


def test_another_seed_than_that_of_the_questions_is_found_out(reference, tmp_path):
    """Who claims to have answered other seas than he was shown."""
    record = json.loads((reference / "questions.json").read_text()) | {"seed": 2}
    record["digest"] = folder.digest({name: value for name, value in record.items() if name != "digest"})
    (tmp_path / "questions.json").write_text(json.dumps(record))
    with pytest.raises(LeakrefError, match=r"not the questions of seed 2: .* is another cube"):
        recognise(tmp_path, folder.load(tmp_path))


# ---------------------------------------------------------------- the commands


def test_an_examination_has_the_seed_that_was_asked_for(tmp_path):
    (tmp_path / "d.json").write_text(json.dumps({"name": "w", "can": {"window": {}}}))
    published, other = (
        json.loads(
            command("exam", "write", tmp_path / f"{n}", "--declare", tmp_path / "d.json", "--json", *seed).stdout
        )
        for n, seed in enumerate([(), ("--seed", 7)])
    )
    assert published["digest"] != other["digest"]


def test_the_commands_say_what_the_contract_has(tmp_path):
    (tmp_path / "d.json").write_text(json.dumps({"name": "w", "can": {"window": {}}}))
    done = command(
        "exam", "write", tmp_path / "exam", "--format", "mat", "--declare", tmp_path / "d.json", "--json", "--seed", 7
    )
    said = json.loads(done.stdout)
    assert said["schema"] == "leakref/exam/1"
    assert set(said) >= {"path", "questions", "bytes", "digest", "version", "ok"}
    files = [path for path in (tmp_path / "exam").rglob("*") if path.is_file()]
    assert said["bytes"] == sum(path.stat().st_size for path in files)
    record = answered(
        tmp_path / "exam", type("W", (), {"window": lambda self, name, size: load("reference").window(name, size)})()
    )
    assert (record["seed"], record["digest"]) == (7, said["digest"])
    done = command("exam", "grade", tmp_path / "exam", "--json", "--report", tmp_path / "report")
    found = json.loads(done.stdout)
    assert (done.returncode, found["grade"], found["seed"]) == (0, "conformant", 7)
    page = (tmp_path / "report" / "certificate.html").read_text()
    assert "By examination" in page
    assert record["digest"] in page
    words = command("exam", "grade", tmp_path / "exam").stdout
    assert "By examination" in words
    done = command("exam", "write", tmp_path / "exam")
    assert done.returncode == 2
    assert "is there already" in done.stderr


@pytest.mark.parametrize(
    ("text", "said"),
    [("{", "is not JSON"), ("[]", "holds no object"), ('{"units": "feet"}', "units"), ('{"can": {"sing": {}}}', "can")],
)
def test_a_declaration_that_is_none_is_refused(text, said, tmp_path):
    (tmp_path / "d.json").write_text(text)
    with pytest.raises(LeakrefError, match=said):
        declared(tmp_path / "d.json")
    with pytest.raises(LeakrefError, match="cannot be read"):
        declared(Path("nowhere.json"))


def test_a_folder_is_made_whole_or_not_at_all(tmp_path):
    def stop():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        folder.lay_down(tmp_path / "exam", Declaration(), "raw", profile="quick", golden=2, seed=1, after_each=stop)
    assert list(tmp_path.iterdir()) == []
