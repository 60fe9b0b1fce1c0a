"""The guides: what they say to type is typed here, in a new folder, and comes out as they say."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from tools import requires

from leakref import LeakrefError, guides

FOLDER = Path(guides.__file__).parent / "guide"
BLOCK = re.compile(r"(?:<!-- (?P<note>[^\n]*) -->\n)?```(?P<language>\w+)\n(?P<text>.*?)^```$",
                   re.DOTALL | re.MULTILINE)
NEEDS = {"octave": ("octave-cli", "octave"), "cpp": ("g++",)}


def blocks(topic):
    """(note, language, text) of the fenced blocks of a guide, in order."""
    words = (FOLDER / f"{topic}.md").read_text(encoding="utf-8")
    assert words.count("\n```") == 2 * len(list(BLOCK.finditer(words))), "a block that is not one"
    return [(m["note"] or "", m["language"], m["text"]) for m in BLOCK.finditer(words)]


def typed(line, folder):
    """Run a line of a shell; `# exit status N` at its end is what is expected."""
    expected = re.search(r"  # exit status (\d+)$", line)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(["bash", "-c", line], cwd=folder, capture_output=True, text=True,
                          env={**os.environ, "PATH": path, "OMP_NUM_THREADS": "1"})
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
            seen += subprocess.run([sys.executable, "-c", words], cwd=folder, check=True, capture_output=True,
                                   text=True).stdout
        else:
            assert language == "sh", f"nobody tries this block of {language}"
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
