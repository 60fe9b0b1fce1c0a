"""The commands, as a user types them."""

import contextlib
import csv
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from leakref import LeakrefError, _output
from leakref.cli.base import app


def leakref(*words, cwd=None):
    return subprocess.run(
        [sys.executable, "-c", "from leakref.cli import main; main()", *map(str, words)],
        capture_output=True,
        text=True,
        encoding="utf-8",
        cwd=cwd,
        timeout=300,
    )


def here(*words, cwd="."):
    """The same without a process of its own: where that is not what matters, it is quicker."""
    with contextlib.chdir(cwd):
        done = CliRunner().invoke(app, [str(word) for word in words])
    return subprocess.CompletedProcess(words, done.exit_code, done.stdout, done.stderr)


def test_help_groups_the_commands():
    done = leakref("--help")
    assert done.returncode == 0
    assert "The paper" in done.stdout
    assert leakref("--version").stdout.startswith("leakref ")


@pytest.fixture(scope="module")
def reproduced(tmp_path_factory):
    out = tmp_path_factory.mktemp("results")
    done = leakref("reproduce", "L-T/L=5,T=10", "--realizations", 2, "--figures", "--out", out, "--json")
    assert done.returncode == 0, done.stderr
    return out, done


def test_reproduce_prints_one_object_and_writes_what_it_prints(reproduced):
    out, done = reproduced
    printed = json.loads(done.stdout)
    assert done.stdout.count("\n") == 1
    assert printed["schema"] == "leakref/reproduce/1"
    assert printed["ok"] is True
    assert json.loads((out / "reproduce.json").read_text()) == printed
    assert [c["window"] + c["method"] for c in printed["cases"]] == ["boxnsp", "boxls", "hannnsp", "hannls"]
    for entry in printed["cases"]:
        with (out / f"L-T_L5_T10_{entry['window']}_{entry['method']}.csv").open() as stream:
            rows = list(csv.DictReader(stream))
        assert [float(row["bias"]) for row in rows] == entry["bias"]
        assert [float(row["wavenumber"]) for row in rows] == entry["wavenumbers"]
    with np.load(out / "L-T_L5_T10.npz") as stored:
        assert stored["hann_nsp_velocities"].shape == (2, 16, 2)
        np.testing.assert_allclose(
            np.hypot(*stored["box_nsp_velocities"].T).mean(axis=1), printed["cases"][0]["bias"], rtol=1e-12
        )
    assert (out / "figure_L-T.png").stat().st_size > 10_000
    assert not list(out.glob(".*"))  # nothing half written is left


def test_the_table_shows_every_wavenumber(tmp_path):
    done = here("reproduce", "L-T/L=5,T=10", "--realizations", 1, "--out", tmp_path, "--route", "a")
    assert done.returncode == 0
    assert len(set(re.findall(r"^│ +\d\.\d\d ", done.stdout, re.MULTILINE))) == 16  # in one table or more


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["reproduce"], "no case was named"),
        (["reproduce", "nonsense"], "no case is called 'nonsense'"),
        (["reproduce", "--all", "nsp-ls"], "both --all and cases"),
        (["reproduce", "nsp-ls", "--route", "C"], "no route named 'C'"),
        (["reproduce", "nsp-ls", "--realizations", "0"], "--realizations"),
        (["nonsense"], "nonsense"),
        (["reproduce", "L-T/L=5,T=10", "--realizations", "1", "--out", "file/x"], "file/x"),
    ],
)
def test_wrong_use_exits_2_with_one_message_and_no_traceback(words, said, tmp_path):
    (tmp_path / "file").touch()
    done = leakref(*words, cwd=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert not done.stdout


def test_the_list_names_every_configuration():
    ids = here("reproduce", "--list").stdout.split()
    assert "U/rotation=30,current=0.15,current_direction=-90" in ids
    assert json.loads(here("reproduce", "--list", "--json").stdout)["ids"] == ids


@pytest.mark.slow
def test_the_demo_comes_true(tmp_path):
    done = leakref("demo", "--json", cwd=tmp_path)
    assert done.returncode == 0
    printed = json.loads(done.stdout)
    assert printed["ok"]
    assert all(set(step) == {"name", "ok", "figure"} and step["ok"] for step in printed["steps"])
    assert all((tmp_path / picture).stat().st_size > 10_000 for picture in printed["pictures"])


def test_the_readme_s_python_runs_and_finds_the_current(capsys):
    text = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    names = {}
    exec(code, names)
    assert capsys.readouterr().out.count("k = ") == 3
    assert np.abs(names["result"].velocities - [0.05, 0.1]).max() < 0.05  # within the coarse resolutions of L = 5


def test_files_are_whole_or_not_there(tmp_path):
    target = tmp_path / "deep" / "file.txt"

    def fails(path):
        path.write_text("half")
        raise RuntimeError

    with pytest.raises(RuntimeError):
        _output.write_whole(target, fails)
    assert list(target.parent.iterdir()) == []
    _output.write_whole(target, lambda path: path.write_text("whole"))
    assert target.read_text() == "whole"
    with pytest.raises(LeakrefError, match="cannot be written"):
        _output.write_whole(target / "below a file", lambda path: path.write_text(""))


def test_json_has_no_nan():
    assert _output.dump({"a": np.array([1.0, np.nan]), "b": (np.int64(3), np.True_), "c": Path("x")}) == (
        '{"a": [1.0, null], "b": [3, true], "c": "x"}'
    )
