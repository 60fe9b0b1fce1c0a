"""The runners of an examination, each where no Python is on the path, marked as certify marks the same program."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from test_exam import WATCHED, copied, marks
from tools import requires

from leakref.certify import scaffold
from leakref.certify.runner import certify, select
from leakref.certify.strength.diagnosis import explain
from leakref.certify.subject.declaration import Declaration
from leakref.certify.targets import connect
from leakref.exam import folder
from leakref.exam.answers import read

HERE = Path(__file__).parent
LS = {
    "name": "my code", "version": "1", "units": "si", "water": {"depth": "given"},
    "can": {"window": {"names": ["box", "hann"]}, "extract": {"methods": ["ls"], "windows": ["box", "hann"]}},
}  # fmt: skip
NSP = {"name": "nsp.m", "units": "si", "can": {"extract": {"methods": ["nsp"], "windows": ["box", "hann"]}}}
SOME = (
    "signs.aligned[to-22.5]",
    "recovery.pair[even-1]",
    "depth.aligned[0.7]",
    "conformance.window[window-hann-7]",
    "behaviour.refuses[nan]",
    "behaviour.past-nyquist[past]",
    "metamorphic.reversal[untapered]",
)
LANGUAGES = ("octave", "cpp", "r")


@pytest.fixture(scope="module")
def path_without_python(tmp_path_factory):
    """A PATH on which there is all but Python."""
    place = tmp_path_factory.mktemp("bin")
    for top in ("/usr/bin", "/bin", "/usr/local/bin"):
        for one in Path(top).iterdir() if Path(top).is_dir() else ():
            if not one.name.startswith(("python", "pip", "pydoc", "idle")) and not (place / one.name).exists():
                (place / one.name).symlink_to(one)
    assert shutil.which("python3", path=str(place)) is None
    return str(place)


@pytest.fixture(scope="module")
def run(path_without_python):
    """A function that runs a command in a folder, there."""

    def ran(place, *words, status=0):
        done = subprocess.run(
            [str(word) for word in words], cwd=place, capture_output=True, text=True, timeout=1800,
            env={"PATH": path_without_python, "HOME": str(place), "LC_ALL": "C.UTF-8", "OMP_NUM_THREADS": "1"},
        )  # fmt: skip
        assert done.returncode == status, done.stdout[-2000:] + done.stderr[-2000:]
        return done.stdout + done.stderr

    return ran


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The quick examination for a least squares in SI that is handed a depth."""
    place = tmp_path_factory.mktemp("whole") / "exam"
    folder.lay_down(place, Declaration.read(LS), "raw", profile="quick", golden=2, seed=1)
    return place


def shortened(place, checks):
    """The table of a folder, cut down to some checks: the rest is left unanswered."""
    record = json.loads((place / "questions.json").read_text())
    wanted = {
        one["id"] for one in record["questions"] if any(check.startswith(tuple(checks)) for check in one["checks"])
    }
    lines = (place / "questions.tsv").read_text().splitlines(keepends=True)
    (place / "questions.tsv").write_text("".join([*lines[:2], *(x for x in lines[2:] if x.split("\t")[0] in wanted)]))
    return len(wanted)


def start(language, run, place):
    """Build and run the example of a language; what it prints."""
    if language == "octave":
        return run(place, requires("octave-cli", "octave"), "--quiet", "--no-init-file", "--eval", "leakref_example")
    if language == "r":
        return run(place, requires("Rscript"), "--vanilla", "leakref_example.R")
    requires("g++")
    run(place, requires("make"), "--silent")
    return run(place, place / "leakref_example")


def verdicts(found, only=()):
    return {f.id: str(f.verdict) for f in found.findings if f.id not in WATCHED and f.id.startswith(tuple(only) or "")}


def adapter(place, source=None):
    """The command of the scaffold's adapter in Octave, the same fit, or of another text in its place."""
    scaffold.write("octave", place)
    if source is not None:
        (place / "adapter.m").write_text(source)
    return [requires("octave-cli", "octave"), "--quiet", "--no-init-file", str(place / "adapter.m")]


def direct(command, *checks, workers=1):
    """As certify judges the program itself."""
    sessions = [connect(command=command) for _ in range(workers)]
    return certify("it", sessions, select(checks, profile="quick"), profile="quick")


# ---------------------------------------------------------------- some questions, in each language


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_runner_answers_and_goes_on_where_it_stopped(language, run, whole, tmp_path):
    place = copied(whole, tmp_path)
    count = shortened(place, SOME)
    printed = start(language, run, place)
    assert f"{count} of {count}" in printed
    assert f"leakref exam grade {place}" in printed.replace("//", "/")
    said = json.loads((place / "answers.json").read_text())
    assert len(said["answers"]) == count
    assert said["code"] == json.loads((place / "declaration.json").read_text())
    first = (place / "answers.json").read_text()

    kept = (place / "answers.part").read_text()  # stopped in the middle of a line
    lines = kept.splitlines(keepends=True)
    (place / "answers.part").write_text("".join(lines[:3]) + lines[3][:20])
    again = start(language, run, place)
    assert again.count(" to go") == count - 2
    assert (place / "answers.json").read_text() == first
    assert (place / "answers.part").read_text() == kept
    assert start(language, run, place).count(" to go") == 0

    found = verdicts(marks(place), SOME)
    assert set(found.values()) == {"pass"}
    assert len(found) == len(SOME)


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_runner_answers_no_stale_copy(language, run, whole, tmp_path):
    place = copied(whole, tmp_path)
    shortened(place, SOME[:1])
    start(language, run, place)
    text = (place / "answers.part").read_text()

    def refused(words):
        with pytest.raises(AssertionError, match=words):
            start(language, run, place)

    (place / "answers.part").write_text("0" * 64 + text[64:])
    refused("answers.part answers another examination")
    (place / "answers.part").unlink()
    refused("no answers.part goes with")
    (place / "answers.json").unlink()
    cube = place / "inputs" / (place / "questions.tsv").read_text().splitlines()[2].split("\t")[2][7:] / "eta.f64"
    content = bytearray(cube.read_bytes())
    content[1000] ^= 16
    cube.unlink()
    cube.write_bytes(content)
    refused("copy the whole folder again")
    cube.unlink()
    refused("copy the whole folder again")
    (place / "questions.tsv").write_text((place / "questions.tsv").read_text().replace("\traw\n", "\tnpz\n", 1))
    refused("have it written with --format raw")


OTHER = {
    "octave": """leakref_exam(struct('extract', @(eta, p) error('leakref:unsupported', 'no "such" \\\\ thing'), ...
      'window', @(p) error('leakref:mine', ['a ' char(10) 'line'])));""",
    "cpp": """#include "leakref_exam.hpp"
      int main() { leakref::Code code;
      code.extract = [](const leakref::Given&, const leakref::Question&) -> leakref::Rows {
        throw leakref::Unsupported("no \\"such\\" \\\\ thing"); };
      code.window = [](const leakref::Given&, const leakref::Question&) -> leakref::Values {
        throw std::runtime_error("a \\n line"); };
      return leakref::exam(code); }""",
    "r": """source("leakref_exam.R")
      leakref_exam(list(extract = function(eta, p) stop("unsupported: no \\"such\\" \\\\ thing"),
                        window = function(p) stop("a \\n line")))""",
}
NAMES = {"octave": "leakref_example.m", "cpp": "leakref_example.cpp", "r": "leakref_example.R"}


def replaced(place, language, text):
    path = place / NAMES[language]
    path.write_text(f"function leakref_example()\n{text}\nend\n" if language == "octave" else text)


@pytest.mark.parametrize("language", LANGUAGES)
def test_what_a_code_cannot_do_or_breaks_at_is_said(language, run, whole, tmp_path):
    place = copied(whole, tmp_path)
    shortened(place, ("recovery.pair[even-1]", "conformance.window[window-hann-7]"))
    replaced(place, language, OTHER[language])
    start(language, run, place)
    said = {f.id: (str(f.verdict), f.message) for f in marks(place).findings}
    verdict, message = said["recovery.pair[even-1]"]
    assert (verdict, " ".join(message.split())) in {
        ("missing", "refused: no such thing"), ("missing", "refused: unsupported: no such thing")
    }  # fmt: skip
    verdict, message = said["conformance.window[window-hann-7]"]
    assert (verdict, " ".join(message.split())) == ("error", "a line")


STAGES = {
    "octave": """leakref_exam(struct('extract', @(eta, p) struct('velocities', [p.dx, Inf; NaN, 2], ...
        'wavenumbers', [p.t(2), p.y(3)]), 'spectrum', @(eta, p) (1 + 2i) * eta, ...
      'synthesize', @(p) p.kx(1) * reshape(p.x, [], 1) + 10 * p.y + 100 * reshape(p.t, 1, 1, [])));""",
    "cpp": """#include "leakref_exam.hpp"
      int main() { leakref::Code code;
      code.extract = [](const leakref::Given& g, const leakref::Question& q) {
        leakref::Rows r{{{q.number("dx"), HUGE_VAL}, {std::nan(""), 2}}, {g.at("t")[1], g.at("y")[2]}};
        return r; };
      code.spectrum = [](const leakref::Given& g, const leakref::Question&) {
        std::vector<std::complex<double>> S;
        for (double e : g.at("eta")) S.push_back({e, 2 * e});
        return S; };
      code.synthesize = [](const leakref::Given& g, const leakref::Question&) {
        leakref::Values eta;
        for (double x : g.at("x")) for (double y : g.at("y"))
          for (double t : g.at("t")) eta.push_back(g.at("kx")[0] * x + 10 * y + 100 * t);
        return eta; };
      return leakref::exam(code); }""",
    "r": """source("leakref_exam.R")
      leakref_exam(list(
        extract = function(eta, p) list(velocities = rbind(c(p$dx, Inf), c(NaN, 2)), wavenumbers = c(p$t[2], p$y[3])),
        spectrum = function(eta, p) complex(real = 1, imaginary = 2) * eta,
        synthesize = function(p) outer(outer(p$kx[1] * p$x, 10 * p$y, "+"), 100 * p$t, "+")))""",
}


@pytest.mark.parametrize(("language", "form"), [*((language, "raw") for language in LANGUAGES), ("octave", "mat")])
def test_all_stages_and_orders_of_axes_go_through_a_runner(language, form, run, tmp_path):
    """To the last bit, there and back: numbers, shapes, complex ones, infinity, null."""
    import numpy as np
    from test_exam import arrays_of

    from leakref.certify.subject.exchange import taken

    place = tmp_path / "exam"
    can = {"extract": {"windows": ["hann"], "methods": ["mine"]}, "spectrum": {}, "synthesize": {}}
    folder.lay_down(place, Declaration.read({"can": can}), form, profile="quick", golden=2, seed=1)
    shortened(
        place,
        (
            "signs.aligned[to-22.5]",
            "conformance.spectrum[spectrum-odd",
            "conformance.spectrum[transform",
            "synthesis.sum[oblong]",
        ),
    )
    replaced(place, language, STAGES[language])
    start(language, run, place)
    record = json.loads((place / "questions.json").read_text())
    asked = {one["id"]: one for one in record["questions"]}
    said = json.loads((place / "answers.json").read_text())["answers"]
    stages = set()
    for one in said:
        question = asked[one["id"]]
        given = arrays_of(place, record, question["input"])
        stages.add(question["stage"])
        assert one["status"] == "ok", one
        if question["stage"] == "extract":
            assert one["velocities"] == [[question["parameters"]["dx"], float("inf")], None]
            assert one["wavenumbers"] == [given["t"][1], given["y"][2]]
        elif question["stage"] == "spectrum":
            found = taken(place, place / one["output"], form, "S", given["eta"].shape)
            assert np.array_equal(found, (1 + 2j) * given["eta"])
        else:
            shape = tuple(given[axis].size for axis in "xyt")
            should = given["kx"][0] * given["x"][:, None, None] + 10 * given["y"][:, None] + 100 * given["t"]
            assert np.allclose(taken(place, place / one["output"], form, "eta", shape), should, rtol=1e-14)
    assert stages == {"extract", "spectrum", "synthesize"}


# ---------------------------------------------------------------- mistakes


MISTAKES = {
    "x": ("ndgrid(-bins(nx, p.dx), -bins(ny, p.dy))", "ndgrid(bins(nx, p.dx), -bins(ny, p.dy))"),
    "transform": ("ndgrid(-bins(nx, p.dx), -bins(ny, p.dy))", "ndgrid(bins(nx, p.dx), bins(ny, p.dy))"),
    "exchanged": (
        "c(n, :) = (normal \\ (direction' * shift))';",
        "c(n, :) = fliplr((normal \\ (direction' * shift))');",
    ),
    "hertz": ("omega = 2 * pi / (nt * p.dt)", "omega = 1 / (nt * p.dt)"),
    "duration": ("2 * pi / (nt * p.dt)", "2 * pi / ((nt - 1) * p.dt)"),
    "deep": (" .* tanh(p.depth * k(strong))", ""),
    "no-taper": (
        "eta = eta .* taper(p.window, nx) .* taper(p.window, ny)' .* reshape(taper(p.window, nt), 1, 1, nt);",
        "",
    ),
}
"""Each in one line of the fit that adapter and example have in common."""
TELLING = ("signs.aligned", "recovery.pair", "recovery.ring", "recovery.sea", "depth.aligned", "leakage.still")


@pytest.mark.parametrize("mistake", [pytest.param(m, marks=[] if m == "x" else pytest.mark.slow) for m in MISTAKES])
def test_a_mistake_in_the_code_is_named_as_by_certify(mistake, run, whole, tmp_path):
    """By the questions that tell, asked of the program itself and by examination."""
    old, new = MISTAKES[mistake]
    place = copied(whole, tmp_path / "there")
    shortened(place, TELLING)
    text = (place / "leakref_example.m").read_text()
    assert text.count(old) == 1
    (place / "leakref_example.m").write_text(text.replace(old, new))
    start("octave", run, place)
    command = adapter(tmp_path / "adapter")
    source = (tmp_path / "adapter" / "adapter.m").read_text()
    assert source.count(old) == 1
    (tmp_path / "adapter" / "adapter.m").write_text(source.replace(old, new))
    found, by_certify = marks(place), explain(direct(command, *TELLING))
    assert verdicts(found, TELLING) == verdicts(by_certify, TELLING)
    assert found.grade == by_certify.grade == "rejected"
    assert [dict(one) for one in found.diagnosis] == [dict(one) for one in by_certify.diagnosis]
    assert "fault" in {one["kind"] for one in found.diagnosis}


# ---------------------------------------------------------------- the whole of it


@pytest.mark.slow
@pytest.mark.parametrize("language", LANGUAGES)
def test_the_whole_quick_examination_is_marked_as_certify_judges(language, run, whole, tmp_path):
    place = copied(whole, tmp_path)
    start(language, run, place)
    found, by_certify = marks(place), direct(adapter(tmp_path / "adapter"))
    assert verdicts(found) == verdicts(by_certify)
    assert found.grade == by_certify.grade == "conformant"
    assert not found.diagnosis


@pytest.mark.slow
def test_an_nsp_in_octave_is_marked_as_certify_judges(run, tmp_path):
    """That of tests/real_codes, which shares no line with leakref, on seas that are drawn."""
    source = (HERE / "real_codes" / "nsp.m").read_text()
    place = tmp_path / "exam"
    folder.lay_down(place, Declaration.read(NSP), "mat", profile="quick", golden=2, seed=1)
    functions = source[source.index("function ") : source.index("function text = velocities")]
    (place / "leakref_example.m").write_text(
        "function leakref_example()\n  leakref_exam(@answer);\nend\n"
        "function c = answer(eta, p)\n"
        '  if ! all(isfinite(eta(:))), error("there are gaps in the surface"); end\n'
        "  s = transformed(eta, p);\n"
        '  c = cell2mat(arrayfun(@(k) current(s, k, p.gravity), p.wavenumbers(:), "UniformOutput", false));\nend\n'
        + functions
    )
    start("octave", run, place)
    (tmp_path / "nsp").mkdir()
    found = marks(place)
    by_certify = direct(adapter(tmp_path / "nsp", source), workers=os.cpu_count() or 1)
    assert verdicts(found) == verdicts(by_certify)
    assert found.grade == by_certify.grade == "conformant"
    sheet = folder.load(place)
    assert len(read(place, sheet).by_id) == len(sheet.record["questions"])


# ---------------------------------------------------------------- in CI


def ci_jobs(place):
    """What the jobs of each file do, in their order: the questions, the answers, the marks; and its variables."""
    scaffold.write("ci", place)
    github = yaml.safe_load((place / ".github" / "workflows" / "leakref-exam.yml").read_text())
    gitlab = yaml.safe_load((place / ".gitlab-ci-exam.yml").read_text())
    names = ("questions", "answers", "marks")
    yield [[s["run"] for s in github["jobs"][name]["steps"] if "run" in s] for name in names], github["env"]
    yield [gitlab[f"leakref-{name}"]["script"] for name in names], gitlab[".leakref-exam"]["variables"]
    assert [github["jobs"][name].get("needs") for name in names] == [None, "questions", "answers"]
    assert [gitlab[f"leakref-{name}"].get("needs") for name in names] == [
        None,
        ["leakref-questions"],
        ["leakref-answers"],
    ]
    assert "python" not in github["jobs"]["answers"]["container"] + gitlab["leakref-answers"]["image"]


def test_both_kinds_of_ci_do_the_same(tmp_path):
    first, second = ci_jobs(tmp_path)
    assert first == second


@pytest.mark.slow
def test_the_jobs_of_ci_examine_a_code(run, path_without_python, tmp_path):
    """Line by line, but for what installs: leakref is here, and so is Octave."""
    requires("octave-cli", "octave")
    (questions, answers, grades), variables = next(ci_jobs(tmp_path))
    (tmp_path / "declare.json").write_text(json.dumps(LS))
    code = folder.text_of("leakref_example.m").partition("function c = deep_or_not")[2]
    (tmp_path / "my_current.m").write_text("function c = my_current" + code)
    with_python = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    for line in questions[1:]:
        subprocess.run(["sh", "-c", line], cwd=tmp_path, check=True, env=with_python, capture_output=True)
    for line in answers[1:]:
        subprocess.run(
            ["sh", "-c", line], cwd=tmp_path, check=True, capture_output=True,
            env={"PATH": path_without_python, "HOME": str(tmp_path), "ANSWER": variables["ANSWER"]},
        )  # fmt: skip
    for line in grades[1:]:
        done = subprocess.run(["sh", "-c", line], cwd=tmp_path, env=with_python, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
    assert "by examination" in (tmp_path / "leakref-report" / "junit.xml").read_text()
