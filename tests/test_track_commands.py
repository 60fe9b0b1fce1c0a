"""`leakref track`, as a team types it: one entry a version, a gate in CI, pictures; for a code in any language."""

from __future__ import annotations

import json
import re
import subprocess
from contextlib import chdir, redirect_stderr, redirect_stdout
from html.parser import HTMLParser
from io import StringIO

import pytest
from tools import requires

from leakref.certify import scaffold
from leakref.cli.base import app
from leakref.track import history, page

CODE = """
from leakref import extract
FACTOR = 1.0

def code(surface, spacing, wavenumbers, gravity=1.0, window="hann"):
    found = extract(surface, spacing, wavenumbers, gravity=gravity, window=window, method="ls").velocities
    found[2:5] *= FACTOR
    return found
"""


def leakref(*words, cwd):
    """In this process, since starting one takes seconds; targets run in processes of their own all the same."""
    out, err = StringIO(), StringIO()
    with chdir(cwd), redirect_stdout(out), redirect_stderr(err), pytest.raises(SystemExit) as end:
        app(["track", *map(str, words)])
    return subprocess.CompletedProcess(words, end.value.code, out.getvalue(), err.getvalue())


def record(*words, cwd, case="small", count=6):
    done = leakref("record", *words, "--case", case, "--realizations", count, "--workers", 1, "--json", cwd=cwd)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def team(tmp_path_factory):
    """A folder with a code of which two versions are recorded, the second worse in the middle of the band."""
    place = tmp_path_factory.mktemp("team")
    (place / "mycode.py").write_text(CODE)
    first = record("mycode:code", "--label", "1.0", cwd=place, count=12)
    (place / "mycode.py").write_text(CODE.replace("FACTOR = 1.0", "FACTOR = 6.0"))
    second = record("mycode:code", "--label", "1.1", cwd=place, count=12)
    return place, first, second


def test_an_entry_says_what_was_measured(team):
    place, first, second = team
    assert first["schema"] == "leakref/track/1"
    (a,), (b,) = first["entries"], second["entries"]
    assert (a["label"], a["line"], b["label"], b["line"]) == ("1.0", 1, "1.1", 2)
    assert a["source"]["of"] == "mycode.py"
    assert a["source"]["sha256"] != b["source"]["sha256"]
    assert [(m["case"], m["window"], m["method"]) for m in a["measurements"]] == [
        ("small", "box", "nsp"),
        ("small", "hann", "nsp"),
    ]  # it names no methods: it has one
    assert all("errors" not in m and len(m["bias"]) == len(m["wavenumbers"]) for m in a["measurements"])
    kept = history.read(place / "leakref-history.jsonl")
    assert kept.faults == ()
    assert len(kept.entries[0].record["measurements"][0]["errors"]) == 12


def test_a_rise_is_exit_1_and_named(team):
    place, *_ = team
    done = leakref("compare", "1.0", "1.1", "--json", cwd=place)
    assert done.returncode == 1
    printed = json.loads(done.stdout)
    assert printed["ok"] is False
    worse = [c for c in printed["comparisons"] if c["verdict"] == "worse"]
    assert ("small", "hann") in {(c["case"], c["window"]) for c in worse}
    assert {k for c in worse if c["band"].startswith("k") for k in c["wavenumbers"]} <= {2.2, 2.6, 3.0}
    for c in worse:
        low, high = c["interval"]
        assert c["margin"] < low < c["change"] < high
        assert c["smallest"] > c["margin"]
    plain = leakref("compare", "1.0", "1.1", cwd=place)
    assert plain.returncode == 1
    assert "Bonferroni" in plain.stdout
    assert "seen from" in plain.stdout
    assert "worse" in plain.stdout.splitlines()[-1]


def test_a_fall_is_exit_0(team):
    place, *_ = team
    done = leakref("compare", "last", "1.0", "--json", cwd=place)
    assert done.returncode == 0
    verdicts = {c["verdict"] for c in json.loads(done.stdout)["comparisons"]}
    assert "better" in verdicts
    assert "worse" not in verdicts


def test_the_reference_is_recorded_the_fast_way_and_does_not_change(tmp_path):
    for label in ("a", "b"):
        record("reference", "--label", label, cwd=tmp_path, case="L-T/L=5,T=10")
    done = leakref("compare", "previous", "last", "--json", cwd=tmp_path)
    assert done.returncode == 0
    assert {c["verdict"] for c in json.loads(done.stdout)["comparisons"]} == {"equal"}


def test_nothing_to_compare_is_exit_3(tmp_path):
    record("reference", "--label", "a", cwd=tmp_path, case="small", count=3)
    record("reference", "--label", "b", cwd=tmp_path, case="broad", count=2)
    done = leakref("compare", "a", "b", "--json", cwd=tmp_path)
    assert done.returncode == 3
    printed = json.loads(done.stdout)
    assert printed["ok"] is False
    assert printed["comparisons"] == []
    assert len(printed["alone"]) == 8
    assert "could not judge" in leakref("compare", "a", "b", cwd=tmp_path).stdout


def test_another_case_of_the_same_name_is_not_compared(team, tmp_path):
    place, *_ = team
    kept = history.read(place / "leakref-history.jsonl").entries
    for label, entry in zip(("a", "b"), kept, strict=True):
        fields = {k: v for k, v in entry.record.items() if k not in ("schema", "digest", "after", "label")}
        measured = [
            {**m, "case_sha256": m["case_sha256"] if label == "a" else "f" * 64} for m in fields["measurements"]
        ]
        history.append(tmp_path / "h.jsonl", {**fields, "label": label, "measurements": measured})
    done = leakref("compare", "a", "b", "--history", "h.jsonl", cwd=tmp_path)
    assert done.returncode == 3
    assert "the case is not the same any more" in done.stdout


def test_a_damaged_history_is_said_and_a_damaged_entry_not_used(team, tmp_path):
    place, *_ = team
    path = tmp_path / "h.jsonl"
    data = (place / "leakref-history.jsonl").read_bytes()
    path.write_bytes(data)
    assert leakref("check", "--history", path, cwd=tmp_path).returncode == 0
    first, second = data.splitlines(keepends=True)
    bias = json.loads(second)["measurements"][0]["bias"][0]
    path.write_bytes(first + second.replace(str(bias).encode(), b"0.001", 1))
    done = leakref("check", "--history", path, "--json", cwd=tmp_path)
    assert done.returncode == 1
    printed = json.loads(done.stdout)
    assert printed["faults"] == ["line 2 was edited: its contents are not those of its digest"]
    assert [entry["fault"] != "" for entry in printed["entries"]] == [False, True]
    done = leakref("compare", "1.0", "last", "--history", path, "--json", cwd=tmp_path)
    assert done.returncode == 3
    assert json.loads(done.stdout)["comparisons"] == []
    assert "was edited" in done.stderr
    path.write_bytes(data + first)
    assert leakref("compare", "1.0", "1.1", "--history", path, cwd=tmp_path).returncode == 1
    assert "repeats line 1" in leakref("check", "--history", path, cwd=tmp_path).stderr
    path.write_bytes(data[:-100])
    done = leakref("check", "--history", path, cwd=tmp_path)
    assert done.returncode == 1
    assert "line 2 is cut off: that entry is lost, no other" in done.stderr
    assert "1 whole entries" in done.stdout


def test_a_program_in_another_language(tmp_path, monkeypatch):
    for tool in ("make", "g++"):
        requires(tool)
    monkeypatch.chdir(tmp_path)
    scaffold.write("cpp", tmp_path)
    subprocess.run(["make"], check=True, capture_output=True)
    (entry,) = record("--command", "./adapter", "--source", "adapter.cpp", cwd=tmp_path, count=2)["entries"]
    assert entry["source"]["of"] == "adapter, adapter.cpp"
    assert {m["method"] for m in entry["measurements"]} == {"ls"}
    # the reference's own least squares are as far off in the same seas, more or less
    (other,) = record("reference", cwd=tmp_path, count=2)["entries"]
    theirs = {(m["window"], m["method"]): m["bias"] for m in other["measurements"]}
    for m in entry["measurements"]:
        assert m["case_sha256"] == other["measurements"][0]["case_sha256"]
        assert m["bias"] == pytest.approx(theirs[m["window"], "ls"], rel=1e-3)


def test_a_target_that_does_not_answer_is_exit_3_and_not_recorded(tmp_path):
    for name, condition in (("broken", "True"), ("small_only", "surface.size > 5000")):
        (tmp_path / f"{name}.py").write_text(
            f"def code(surface, spacing, wavenumbers):\n    if {condition}:\n"
            "        raise RuntimeError('no')\n    return [(0.0, 0.0)]\n"
        )
        done = leakref("record", f"{name}:code", "--case", "small", "--realizations", 2, cwd=tmp_path)
        assert done.returncode == 3
    assert "Nothing was recorded" in done.stderr
    done = leakref("record", "--command", "true", "--case", "small", "--realizations", 2, cwd=tmp_path)
    assert done.returncode == 3
    assert not (tmp_path / "leakref-history.jsonl").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["record"], "no target was given"),
        (["record", ""], "no target was given"),
        (["record", "reference", "--command", "x"], "a target and a --command"),
        (["record", "reference", "--label", "last"], "'last' cannot be used"),
        (["record", "reference", "--label", ""], "the label is empty"),
        (["record", "reference", "--case", "L-T"], "has 9 configurations"),
        (["record", "reference", "--case", "nonsense"], "no case is called"),
        (["record", "reference", "--timings", "x.json"], "without --yardstick"),
        (["record", "reference", "--timings", "x.json", "--yardstick", "y"], "x.json cannot be read"),
        (["record", "nonsense:x", "--case", "small"], "no module 'nonsense'"),
        (["compare", "a", "b"], "cannot be read"),
        (["compare", "a"], "Missing argument"),
        (["plot"], "cannot be read"),
        (["check"], "cannot be read"),
    ],
)
def test_wrong_use_exits_2_with_one_message(words, said, tmp_path):
    done = leakref(*words, cwd=tmp_path)
    assert done.returncode == 2
    assert said in " ".join(done.stderr.split())
    assert "Traceback" not in done.stderr
    assert not done.stdout


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["1.0", "2.0"], "no entry '2.0'; there are 1.0, 1.1"),
        (["1.0", "1.0"], "are the same entry"),
        (["1.0", "1.1", "--margin", "0"], "margin"),
    ],
)
def test_wrong_names_exit_2(team, words, said):
    done = leakref("compare", *words, cwd=team[0])
    assert done.returncode == 2
    assert said in done.stderr


def test_timings_are_recorded_and_compared(tmp_path):
    for label, seconds in (("a", 0.5), ("b", 1.0)):
        stats = {"iqr": 0.001, "rounds": 100}
        (tmp_path / "bench.json").write_text(
            json.dumps(
                {
                    "benchmarks": [
                        {"fullname": "t.py::test_fft", "stats": {"median": 0.1, **stats}},
                        {"fullname": "t.py::test_chain", "stats": {"median": seconds, **stats}},
                    ]
                }
            )
        )
        record(
            "reference", "--label", label, "--timings", "bench.json", "--yardstick", "test_fft", cwd=tmp_path, count=2
        )
    done = leakref("compare", "a", "b", "--json", cwd=tmp_path)
    (row,) = json.loads(done.stdout)["timings"]
    assert (row["name"], row["verdict"]) == ("t.py::test_chain", "slower")
    assert done.returncode == 0  # said, and fails nothing
    assert "+100 %" in leakref("compare", "a", "b", cwd=tmp_path).stdout
    assert leakref("plot", cwd=tmp_path).returncode == 0
    assert "t.py::test_chain" in (tmp_path / "leakref-track" / "history.html").read_text()


class Elements(HTMLParser):
    """Tags, and what they refer to."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.references = [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.references += [value for name, value in attrs if name in ("src", "href")]


def test_the_page_shows_the_step_and_needs_nothing_from_elsewhere(team, tmp_path):
    place, *_ = team
    done = leakref("plot", "--out", tmp_path / "out", "--json", cwd=place)
    assert done.returncode == 0
    printed = json.loads(done.stdout)
    assert [entry["label"] for entry in printed["entries"]] == ["1.0", "1.1"]
    page = (tmp_path / "out" / "history.html").read_text(encoding="utf-8")
    seen = Elements(page)
    assert seen.tags.count("img") == 2
    assert all(reference.startswith("data:image/png;base64,") for reference in seen.references)
    assert re.search(r'class="grade rejected">worse<', page)
    assert "2 to 3.5" in page
    for name in ("levels_small", "curves_small"):
        assert (tmp_path / "out" / f"{name}.png").stat().st_size > 10_000
        assert (tmp_path / "out" / f"{name}.svg").stat().st_size > 10_000


def test_words_of_a_history_are_text_on_the_page(tmp_path, team):
    hostile = "<script>alert(1)</script>{{ 7 * 7 }}"
    entry = history.read(team[0] / "leakref-history.jsonl").entries[0].record
    fields = {k: v for k, v in entry.items() if k not in ("schema", "digest", "after")}
    fields |= {"label": hostile, "target": hostile, "recorded": hostile, "platform": hostile}
    history.append(tmp_path / "h.jsonl", fields)
    kept = history.read(tmp_path / "h.jsonl")
    text = page.page(kept, page.versions(kept.entries), [])
    assert "script" not in Elements(text).tags
    assert "{{ 7 * 7 }}" in text


def test_steps_are_marked_where_they_are(team):
    first, second = page.versions(history.read(team[0] / "leakref-history.jsonl").entries)
    assert first.steps() == []
    assert {(c.band, c.verdict) for c in second.steps()} == {("2 to 3.5", "worse")}
    for draw in (page.levels_figure, page.curves_figure):
        drawing = draw([first, second], "small")
        (legend,) = drawing.legends
        labels = [text.get_text() for text in legend.get_texts()]
        assert len(set(labels)) == len(labels)
        assert ("worse" in labels) is (draw is page.levels_figure)


def test_plot_of_what_is_not_there(team, tmp_path):
    done = leakref("plot", "--case", "broad", cwd=team[0])
    assert done.returncode == 2
    assert "choose among small" in done.stderr
    done = leakref("plot", "--target", "nobody", cwd=team[0])
    assert done.returncode == 3


def test_one_version_has_no_line_from_version_to_version_and_the_others_are_named(team, tmp_path):
    kept = [entry.record for entry in history.read(team[0] / "leakref-history.jsonl").entries]
    fields = [{k: v for k, v in one.items() if k not in ("schema", "digest", "after")} for one in kept]
    path = tmp_path / "h.jsonl"
    for own in ({**fields[0], "target": "another:code"}, fields[1]):
        history.append(path, own)
    done = leakref("plot", "--history", path, "--out", tmp_path / "out", cwd=tmp_path)
    assert done.returncode == 0
    assert f"Drawn: 1 version of {fields[1]['target']}, the last entry's." in " ".join(done.stdout.split())
    assert "another:code; see --target" in " ".join(done.stdout.split())
    assert not list((tmp_path / "out").glob("levels_*"))
    assert list((tmp_path / "out").glob("curves_*"))
