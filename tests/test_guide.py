"""The guides: what they say to type is typed here, in a new folder, and comes out as they say."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from tools import requires

from leakref import Grid, LeakrefError, aligned_waves, guides, synthesize
from leakref._base import installed_with
from leakref.certify.certificate import schema
from leakref.certify.runner import run_check
from leakref.certify.subject import child, protocol
from leakref.certify.subject.declaration import Declaration
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.subject.seas import Sea
from leakref.certify.targets import Limits, connect, load
from leakref.certify.verdict import Verdict
from leakref.window import WINDOWS

FOLDER = Path(guides.__file__).parent / "guide"
PROJECT = FOLDER.parents[1]
BLOCK = re.compile(
    r"(?:<!-- (?P<note>[^\n]*) -->\n)?```(?P<language>\w+)\n(?P<text>.*?)^```$", re.DOTALL | re.MULTILINE
)
NEEDS = {"exam": ("octave-cli", "octave"), "octave": ("octave-cli", "octave"), "cpp": ("g++",)}


def blocks(topic):
    """(note, language, text) of the fenced blocks of a guide, in order."""
    words = (FOLDER / f"{topic}.md").read_text(encoding="utf-8")
    assert words.count("\n```") == 2 * len(list(BLOCK.finditer(words))), "a block that is not one"
    return [(m["note"] or "", m["language"], m["text"]) for m in BLOCK.finditer(words)]


def typed(line, folder):
    """Run a line of a shell; `# exit status N` at its end is what is expected."""
    expected = re.search(r"  # exit status (\d+)$", line)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["bash", "-c", line],
        cwd=folder,
        capture_output=True,
        text=True,
        env={**os.environ, "PATH": path, "OMP_NUM_THREADS": "1"},
    )
    printed = done.stdout + done.stderr
    assert done.returncode == (int(expected[1]) if expected else 0), f"{line}\n{printed[-3000:]}"
    return printed


def followed(topic, folder):
    """What a reader sees who types all of it."""
    seen = ""
    for note, language, words in blocks(topic):
        if note.startswith("file: "):
            (folder / note.removeprefix("file: ")).write_text(words, encoding="utf-8")
        elif instead := re.fullmatch(r"in (\S+), instead of (\w+)", note):
            path = folder / instead[1]
            old = re.compile(rf"^function [^\n]*\b{instead[2]}\(.*?^end$\n", re.DOTALL | re.MULTILINE)
            changed, count = old.subn(lambda _, words=words: words, path.read_text(encoding="utf-8"))
            assert count == 1
            path.write_text(changed, encoding="utf-8")
        elif language == "python":
            seen += subprocess.run(
                [sys.executable, "-c", words], cwd=folder, check=True, capture_output=True, text=True
            ).stdout
        else:
            assert language == "sh", f"a block of {language} that is not tried"
            for line in words.splitlines():
                if line.startswith("cd "):
                    folder = folder / line.removeprefix("cd ")
                else:
                    seen += typed(line, folder)
    return seen


@pytest.mark.slow
@pytest.mark.parametrize("topic", guides.TOPICS)
def test_a_guide_can_be_followed(topic, tmp_path):
    if topic in NEEDS:
        requires(*NEEDS[topic])
    seen = re.sub(r"\s+", " ", followed(topic, tmp_path))
    for quoted in re.findall(r"^    (Diagnosis: .*)$", (FOLDER / f"{topic}.md").read_text(encoding="utf-8"), re.M):
        assert re.sub(r"\s+", " ", quoted) in seen


def test_all_that_are_there_are_listed_and_speak_of_each_other_only(capsys):
    assert {path.stem for path in FOLDER.glob("*.md")} == set(guides.TOPICS)
    assert guides.run(None)
    printed = capsys.readouterr().out
    for topic in guides.TOPICS:
        assert f"leakref guide {topic}" in printed
        named = re.findall(r"leakref guide ([a-z-]+)", (FOLDER / f"{topic}.md").read_text(encoding="utf-8"))
        assert set(named) <= set(guides.TOPICS)


def test_a_guide_is_printed_as_it_is(capsys):
    assert guides.run("octave")
    printed = capsys.readouterr().out
    assert printed == guides.text("octave")
    assert "<!--" not in printed
    assert printed.startswith("# Certifying an Octave")


def test_a_guide_that_there_is_not_is_refused():
    with pytest.raises(LeakrefError, match="did you mean octave"):
        guides.text("octav")


# ---------------------------------------------------------------- documents that are named

TEXTS = (".py", ".md", ".m", ".cpp", ".sh", ".yml", ".html", ".toml")
FOLDERS = ("leakref", "properties", "golden", "tests")


def named_in_vain(words):
    """What a text names that is not there: documents, modules by their path, guides, and sections of a guide."""
    words = re.sub(r'(?:"\s*\n\s*f?"|\s|#(?= ))+', " ", words)  # across the lines of a comment or of a string
    there = {path.name for folder in ("", ".github", *FOLDERS) for path in (PROJECT / folder).glob("*.md")}
    there |= {path.name for path in (PROJECT / "leakref").rglob("*.md")}
    found = [
        name
        for name in re.findall(r"(?<![\w*}])[\w./-]*\w\.md\b", words)
        if name.rpartition("/")[2] not in there
        or (
            "/" in name and name[0] != "/" and not any((PROJECT / folder / name).exists() for folder in ("", "leakref"))
        )
    ]
    found += [
        name
        for name in re.findall(r"(?<![\w/.])(?:leakref|properties)/[\w/]+\.py\b", words)
        if not (PROJECT / name).exists()
    ]
    found += [topic for topic in re.findall(r"\bleakref guide ([a-z][a-z-]*)", words) if topic not in guides.TOPICS]
    for topic, numbers in re.findall(r"\bguide ([a-z-]+), sections? (\d+(?:(?:, | and )\d+)*)", words):
        found += [f"{topic}, section {n}" for n in re.findall(r"\d+", numbers) if int(n) not in sections(topic)]
    return found


def sections(topic):
    """The numbers of the sections of a guide; none if there is no such guide."""
    path = FOLDER / f"{topic}.md"
    text = path.read_text(encoding="utf-8") if path.exists() else ""
    return {int(number) for number in re.findall(r"^## (\d+)\. ", text, re.MULTILINE)}


def texts():
    """All that is written in the project but for the golden values, by its path."""
    files = [path for folder in FOLDERS for path in sorted((PROJECT / folder).rglob("*")) if path.suffix in TEXTS]
    files += [PROJECT / name for name in ("README.md", "CHANGELOG.md", "pyproject.toml", ".ci/run")]
    assert len(files) > 200
    return {path.relative_to(PROJECT).as_posix(): path.read_text(encoding="utf-8") for path in files}


def test_no_document_is_named_that_is_not_there():
    assert {path: found for path, words in texts().items() if (found := named_in_vain(words))} == {}


def test_nothing_says_that_leakref_comes_from_an_index():
    """It is on none: an address goes with its name. Only one place in the package says how it is installed."""
    said = {
        path: found
        for path, words in texts().items()
        if (found := re.findall(r"pip install [^\n]*leakref[^\n]*", words)) and not path.startswith("tests/")
    }
    wrong = {
        path: line
        for path, lines in said.items()
        for line in lines
        if not re.search(r"leakref(\[[^]]*\])? @ |/leakref-\*\.whl|install --quiet \. && ", line)
    }
    assert wrong == {}
    assert [path for path in said if path.endswith(".py")] == ["leakref/_base.py"]
    assert "leakref[netcdf] @ ADDRESS" in installed_with("netcdf")
    extras = re.findall(r"^(\w+) = \[", texts()["pyproject.toml"], re.MULTILINE)
    (listed,) = re.findall(r"^Extras: (.*)$", texts()["README.md"], re.MULTILINE)
    assert set(quoted(listed)) | {"test", "lint"} <= set(extras)


def test_the_readme_is_what_is_seen():
    """The wrong code that it shows, and the pictures that it names."""
    readme = (PROJECT / "README.md").read_text(encoding="utf-8")
    finding = run_check("signs.sea[to-22.5]", InProcess(load("fault:exchanged-axes")))
    assert f"    fail {finding.id} ({finding.over:.3g} times the tolerance)\n      {finding.message}\n" in readme
    pictures = re.findall(r"!\[[^]]*\]\(([^)]*)\)", readme)
    assert len(pictures) == 2
    assert all(0 < (PROJECT / picture).stat().st_size < 150_000 for picture in pictures)
    assert len([line for line in readme.splitlines() if line.startswith("python3 -m venv")]) == 2
    assert readme.index("fault:exchanged-axes") < readme.index("python3 -m venv") < 6000


@pytest.mark.parametrize(
    "words",
    [  # in pieces, so that this file names none of them
        "as in CONTRACT" + ".md",
        "see leakref/guide/protocoll" + ".md",
        "`leakref guide " + "protocoll`",
        "(guide " + "protocol, section 99)",
        "guide " + "protocol,\n    # sections 1 and 99",
        '"guide "\n  "' + 'protocol, section 0"',
        "guide " + "python, section 1",
        "in `leakref/" + "certify/faults.py`",
    ],
)
def test_a_document_that_is_not_there_is_seen(words):
    assert len(named_in_vain(words)) == 1


# ---------------------------------------------------------------- the guide to the protocol

PROTOCOL = FOLDER / "protocol.md"


def section(number):
    """The text of a section of the guide to the protocol."""
    return re.split(r"^## \d+\. ", PROTOCOL.read_text(encoding="utf-8"), flags=re.MULTILINE)[number]


def rows(number, width):
    """The rows of the tables in a section that have so many columns, without the titles."""
    cells = [
        [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
        for line in section(number).splitlines()
        if line.startswith("|")
    ]
    return [row for row in cells if len(row) == width and not row[0].startswith("---")]


def quoted(cell):
    return re.findall(r"`([^`]*)`", cell)


def test_its_sections_are_numbered_and_it_refers_to_those_there_are():
    text = PROTOCOL.read_text(encoding="utf-8")
    numbers = [int(n) for n in re.findall(r"^## (\d+)\.", text, re.MULTILINE)]
    assert numbers == list(range(1, 16))
    assert {int(n) for n in re.findall(r"section (\d+)", text)} <= set(numbers)


def test_its_defaults_are_those_of_a_declaration():
    declared = Declaration.read({})
    seen = set()
    for names, default, values in rows(3, 3)[1:]:
        if not default.startswith("`") or not set(quoted(names)) <= set(Declaration.__dataclass_fields__):
            continue  # the table of what stands in `can`
        for name, value in zip(quoted(names), quoted(default), strict=True):
            assert json.loads(value) == json.loads(json.dumps(getattr(declared, name))), name
            seen.add(name)
            if name in ("units", "axes", "y", "direction", "format"):
                assert all(Declaration.read({name: json.loads(one)}) for one in quoted(values))
    assert seen == set(Declaration.__dataclass_fields__)
    of_extract = {
        quoted(names)[0]: json.loads(quoted(default)[0]) if quoted(default) else []  # none named
        for names, default, _ in rows(3, 3)
        if names.startswith("`extract")
    }
    assert of_extract == {
        "extract.methods": list(declared.methods),
        "extract.windows": list(declared.windows),
        "extract.resolves": "band" if declared.band else "wavenumber",
    }
    assert set(WINDOWS) <= set(quoted(section(3)))


def test_its_conversation_is_one():
    lines = re.sub(r"\n       ", " ", section(6))
    said = [(mark, json.loads(words)) for mark, words in re.findall(r"^    ([<>]) (\{.*\})$", lines, re.MULTILINE)]
    assert [mark for mark, _ in said] == [">", "<", ">", "<", ">"]
    start, ready, run, answer, stop = (message for _, message in said)
    assert start == {"op": "start", "protocol": protocol.PROTOCOL, "formats": list(protocol.FORMATS)}
    assert Declaration.read({key: ready[key] for key in ready if key not in ("op", "protocol")}).units == "si"
    assert (ready["op"], ready["protocol"], stop) == ("ready", protocol.PROTOCOL, {"op": "stop"})
    assert (run["id"], len(run["parameters"]["wavenumbers"])) == (answer["id"], len(answer["velocities"]))
    assert set(run) == {"op", "id", "stage", "input", "output", "parameters"}


def test_its_stages_are_handed_what_it_says(tmp_path):
    grid = Grid((8, 9, 10), (0.8, 0.9, 0.7))
    waves, _ = aligned_waves(grid, [(2, 1, 2), (1, 2, 2)], gravity=1.0)
    axes = [grid.samples(axis) for axis in range(3)]
    with connect("reference", keep=tmp_path) as subject:
        subject.window("hann", 8)
        subject.synthesize(waves, *axes)
        surface = synthesize(waves, *axes)
        subject.spectrum(surface, grid.spacing, "hann")
        subject.extract(surface, grid.spacing, [1.5], window="box", raw=True)
    with connect("leakref.generator:generator", keep=tmp_path / "seas") as subject:
        subject.sea(Sea(grid, 30.0, 120.0, 3.3, 1e-3, (0.0, 0.0), subject.still()), 1)
    seen = {}
    for request in tmp_path.rglob("request.json"):
        asked = json.loads(request.read_text(encoding="utf-8"))
        with np.load(asked["input"]) as stored:
            seen[asked["stage"]] = (set(stored.files), set(asked["parameters"]))
    table = {
        quoted(stage)[0]: (set(quoted(arrays)), set(quoted(parameters)))
        for stage, arrays, parameters, _ in rows(4, 4)[1:]
    }
    assert table == seen


def test_its_program_works(tmp_path):
    (code,) = [words for note, _, words in blocks("protocol") if note == "file: program.py"]
    (tmp_path / "program.py").write_text(code, encoding="utf-8")
    grid = Grid((6, 7, 8), (0.8, 0.9, 0.7))
    waves, _ = aligned_waves(grid, [(2, 1, 2), (1, -2, 2)], gravity=1.0)
    axes = [grid.samples(axis) for axis in range(3)]
    surface = synthesize(waves, *axes)
    with connect(command=[sys.executable, str(tmp_path / "program.py")]) as subject, connect("reference") as reference:
        assert np.abs(subject.synthesize(waves, *axes) - surface).max() < 1e-13
        assert np.abs(subject.window("hann", 7) - reference.window("hann", 7)).max() < 1e-15
        found = [one.spectrum(surface, grid.spacing, "hann") for one in (subject, reference)]
        assert np.abs(found[0] - found[1]).max() < 1e-12
        assert subject.violations == []


def test_its_numbers_are_those_of_the_code():
    limits = " ".join(cell for row in rows(9, 3) for cell in row)
    for words in (f"{Limits.start:g} s", f"{Limits.run:g} s", f"{Limits.memory / 2**30:g} GiB"):
        assert words in limits
    assert protocol.STRIKES == 3
    assert "three breaches in a row" in section(11)
    assert f"{child.LONGEST / 2**20:g} MiB" in section(6)
    assert {word for row in rows(12, 2) for word in row[0].split(", ")} == {"verdict", *map(str, Verdict)}
    (certify,) = [fields for command, fields in rows(14, 2) if command == "`certify`"]
    required = set(schema()["required"]) - {"schema", "version", "ok"}
    assert required <= set(quoted(certify))
    assert set(schema()["properties"]["findings"]["items"]["required"]) == set(
        re.search(r"`findings`: `\[\{(.*?)\}\]`", certify)[1].split(", ")
    )
