"""The history file: what is written is read again, and whatever else happens to it is seen and said."""

from __future__ import annotations

import json
import multiprocessing

import pytest

from leakref import LeakrefError
from leakref.golden.digests import digest
from leakref.track import history


def fields(label, target="mine", **more):
    return {"label": label, "target": target, "measurements": [{"errors": [[12, None, 7]], "unit": 1e-6}], **more}


@pytest.fixture
def path(tmp_path):
    place = tmp_path / "deep" / "history.jsonl"
    for n in range(4):
        history.append(place, fields(f"v{n}", level=0.1 + n / 3))
    return place


def labels(path):
    return [entry.label for entry in history.read(path).entries]


def lines(path):
    return path.read_bytes().splitlines(keepends=True)


def test_what_is_written_is_read_again(path):
    kept = history.read(path)
    assert kept.faults == ()
    assert labels(path) == ["v0", "v1", "v2", "v3"]
    assert [entry.line for entry in kept.entries] == [1, 2, 3, 4]
    assert kept.entries[1].record["level"] == 0.1 + 1 / 3
    assert kept.entries[1].record["after"] == kept.entries[0].digest
    assert kept.entries[0].record["after"] is None


def test_pandas_reads_it_in_full(path):
    import pandas  # which xarray needs

    table = pandas.read_json(path, lines=True)
    assert table["label"].tolist() == ["v0", "v1", "v2", "v3"]
    assert table["measurements"][3][0]["errors"] == [[12, None, 7]]


# one change to a line, by name; the last are those that leave its JSON the same, or nearly
EDITS = {
    "number": lambda line: line.replace(b"12", b"13", 1),
    "label": lambda line: line.replace(b'"v1"', b'"v9"'),
    "digest": lambda line: line.replace(b'"digest":"', b'"digest":"0'),
    "null for a number": lambda line: line.replace(b"[[12", b"[[null"),
    "NaN": lambda line: line.replace(b"[[12", b"[[NaN"),
    "half": lambda line: line[: len(line) // 2] + b"\n",
    "empty": lambda line: b"\n",
    "no object": lambda line: b"[1]\n",
    "no digest": lambda line: b"{}\n",
    "a key twice": lambda line: line.replace(b'{"schema"', b'{"label":"v9","schema"'),
    "space": lambda line: line.replace(b'"target":', b'"target": '),
    "bytes": lambda line: line.replace(b"mine", b"m\xffne"),
    "deep": lambda line: b"[" * 100_000 + b"\n",
}


@pytest.mark.parametrize("name", EDITS)
def test_an_edited_line_is_said_and_harms_no_other(path, name):
    all_lines = lines(path)
    changed = EDITS[name](all_lines[1])
    assert changed != all_lines[1]
    path.write_bytes(b"".join([all_lines[0], changed, *all_lines[2:]]))
    assert labels(path) == ["v0", "v2", "v3"]
    kept = history.read(path)
    assert any(fault.startswith("line 2 ") for fault in kept.faults)
    with pytest.raises(LeakrefError):
        kept.entry("v1")


@pytest.mark.parametrize("kept_bytes", [1, 40, -2])
def test_a_last_line_that_is_cut_off_loses_that_entry_only(path, kept_bytes):
    *whole, last = lines(path)
    path.write_bytes(b"".join(whole) + last[:kept_bytes])
    assert labels(path) == ["v0", "v1", "v2"]
    (fault,) = history.read(path).faults
    assert "line 4 is cut off" in fault


def test_after_a_cut_the_next_entry_is_whole(path):
    path.write_bytes(path.read_bytes()[:-30])
    entry, said = history.append(path, fields("v4"))
    assert "line 4 was cut off" in said
    assert entry.line == 4
    assert labels(path) == ["v0", "v1", "v2", "v4"]
    assert history.read(path).faults == ()


def test_a_last_line_that_lacks_its_end_only_is_kept(path):
    path.write_bytes(path.read_bytes().rstrip(b"\n"))
    assert history.read(path).faults == ()
    _, said = history.append(path, fields("v4"))
    assert said == ""
    assert labels(path) == ["v0", "v1", "v2", "v3", "v4"]


def test_a_repeated_line_counts_once_and_is_said(path):
    first, *others = lines(path)
    path.write_bytes(b"".join([first, *others, first]))
    kept = history.read(path)
    assert labels(path) == ["v0", "v1", "v2", "v3"]
    assert kept.faults == ("line 5 repeats line 1: it counts once",)
    assert kept.entry("last").label == "v3"
    assert kept.entry("v0").line == 1


@pytest.mark.parametrize("gone", [0, 1, 2])
def test_a_line_that_is_missing_is_said(path, gone):
    path.write_bytes(b"".join(line for n, line in enumerate(lines(path)) if n != gone))
    (fault,) = history.read(path).faults
    assert fault.startswith(f"line {gone + 1} was written after an entry")


def test_two_branches_that_are_merged_are_no_fault(path):
    common = path.read_bytes()
    history.append(path, fields("ours"))
    ours = lines(path)[-1]
    path.write_bytes(common)
    history.append(path, fields("theirs"))
    path.write_bytes(path.read_bytes() + ours)
    assert labels(path)[-2:] == ["theirs", "ours"]
    assert history.read(path).faults == ()
    path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))  # as git may check it out elsewhere
    assert history.read(path).faults == ()


def test_a_line_of_a_later_schema_is_left_alone(path):
    record = {"schema": "leakref/history/2", "label": "later"}
    record["digest"] = digest(record)
    path.write_bytes(path.read_bytes() + json.dumps(record, separators=(",", ":")).encode() + b"\n")
    assert labels(path) == ["v0", "v1", "v2", "v3"]
    assert "of another schema" in history.read(path).faults[0]


def test_names(path):
    history.append(path, fields("v1", "other"))
    kept = history.read(path)
    assert kept.entry("last").line == 5
    assert kept.entry("v1").line == 5  # of several the last
    assert kept.entry(kept.entries[2].digest[:8]).line == 3
    with pytest.raises(LeakrefError, match="no entry of the target of the last one, other, before it"):
        kept.entry("previous")  # none before it of the same target
    history.append(path, fields("v4"))
    assert history.read(path).entry("previous").label == "v3"
    with pytest.raises(LeakrefError, match="there are v0, v1, v2, v3"):
        kept.entry("nonsense")
    with pytest.raises(LeakrefError, match="no entry ''"):
        kept.entry("")


def test_the_last_entry_is_refused_if_it_was_edited(path):
    """And not the one before taken for it."""
    *others, last = lines(path)
    path.write_bytes(b"".join([*others, last.replace(b"12", b"99", 1)]))
    with pytest.raises(history.Damaged, match="was edited"):
        history.read(path).entry("last")


def test_what_cannot_be_read_or_written_is_refused(tmp_path):
    with pytest.raises(LeakrefError, match="cannot be read"):
        history.read(tmp_path / "nothing")
    with pytest.raises(LeakrefError, match="cannot be written"):
        history.append(tmp_path, fields("v0"))
    (tmp_path / "empty").touch()
    kept = history.read(tmp_path / "empty")
    assert (kept.entries, kept.faults) == ([], ())
    with pytest.raises(LeakrefError, match="there are none"):
        kept.entry("last")


COUNT = 25


def write_many(path, name, start):
    start.wait()
    for n in range(COUNT):
        history.append(path, fields(f"{name}{n}", padding="x" * 20_000))


def test_two_writers_at_once_lose_nothing(tmp_path):
    context = multiprocessing.get_context("spawn")
    start, place = context.Barrier(2), tmp_path / "history.jsonl"
    writers = [context.Process(target=write_many, args=(place, name, start)) for name in "ab"]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join(120)
        assert writer.exitcode == 0
    kept = history.read(place)
    assert kept.faults == ()
    for name in "ab":
        own = [label for label in labels(place) if label.startswith(name)]
        assert own == [f"{name}{n}" for n in range(COUNT)]
