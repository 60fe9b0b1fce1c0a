"""A third party's project, installed beside the wheel in a clean environment: their own `pytest`, and files for CI."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import venv
from collections import Counter
from pathlib import Path

import pytest
import yaml

from leakref.certify import scaffold
from leakref.certify.runner import select
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.verdict import Verdict

ROOT = Path(__file__).parent.parent
EXAMPLE = Path(__file__).parent / "example_project"
FAMILIES = ("signs", "recovery", "behaviour")
"""What the example asks for."""


@pytest.fixture(scope="module")
def installed(tmp_path_factory) -> Path:
    """The scripts of an environment with the wheel, its extra for pytest and the example, and nothing of the tree."""
    folder = tmp_path_factory.mktemp("installed")
    for part in ("leakref", "properties", "golden"):
        shutil.copytree(ROOT / part, folder / "tree" / part, ignore=shutil.ignore_patterns("__pycache__"))
    for part in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / part, folder / "tree")
    shutil.copytree(EXAMPLE, folder / "example", ignore=shutil.ignore_patterns("__pycache__"))
    subprocess.run([sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "-w", folder, folder / "tree"], check=True)
    (wheel,) = folder.glob("*.whl")
    venv.create(folder / "venv", with_pip=True)
    scripts = folder / "venv" / ("Scripts" if os.name == "nt" else "bin")
    subprocess.run(
        [scripts / "python", "-m", "pip", "install", "-q", f"leakref[pytest] @ {wheel.as_uri()}", folder / "example"],
        check=True,
    )
    shutil.rmtree(folder / "tree")
    return scripts


def counted(scripts: Path, folder: Path, *arguments: str, **environment: str) -> tuple[int, dict[str, int]]:
    """Exit status and counts of a session."""
    done = subprocess.run(
        [scripts / "python", "-m", "pytest", "-q", "-p", "no:cacheprovider", *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        env={**os.environ, "OMP_NUM_THREADS": "1", **environment},
    )
    print(done.stdout[-4000:], done.stderr[-2000:])
    return done.returncode, {
        word: int(n) for n, word in re.findall(r"(\d+) (passed|failed|skipped|error)", done.stdout.splitlines()[-1])
    }


def expected(monkeypatch, planted: str) -> dict[str, int]:
    """Counts of the verdicts on the example, in this process and from this tree."""
    import wavecode

    monkeypatch.setenv("PLANTED", planted)
    subject = InProcess(wavecode.Code())
    verdicts = [check(subject, case).verdict for check, case in select(FAMILIES, profile="quick")]
    words = {Verdict.PASS: "passed", Verdict.UNSUPPORTED: "skipped", Verdict.MISSING: "skipped"}
    return dict(Counter(words.get(verdict, "failed") for verdict in verdicts))


@pytest.mark.slow
def test_their_own_pytest_says_right_and_wrong(installed, tmp_path, monkeypatch):
    """One line in their test file; as many pass, fail and are skipped as checks do when they are called directly."""
    shutil.copy(EXAMPLE / "test_wavecode.py", tmp_path)
    monkeypatch.syspath_prepend(EXAMPLE)
    right, wrong = expected(monkeypatch, ""), expected(monkeypatch, "1")
    assert "failed" not in right
    assert wrong["failed"] >= 8  # all those of signs
    assert counted(installed, tmp_path, PLANTED="") == (0, right)
    assert counted(installed, tmp_path, PLANTED="1") == (1, wrong)


@pytest.mark.slow
def test_a_plain_run_with_the_option_judges_the_installed_code(installed, tmp_path):
    """Properties and checks from the wheel, far from a checkout."""
    status, right = counted(installed, tmp_path, "--leakref-implementation", "wavecode:Code", "-k", "recovery or pair")
    assert (status, right.get("failed", 0), right["passed"] > 4) == (0, 0, True)
    status, wrong = counted(
        installed, tmp_path, "--leakref-implementation", "wavecode:Code", "-k", "recovery or pair", PLANTED="1"
    )
    assert status == 1
    assert wrong["failed"] > 4
    status, reference = counted(installed, tmp_path, "--pyargs", "leakref.properties", "-k", "windows or spectrum")
    assert (status, reference["passed"] > 10, reference.get("failed", 0)) == (0, True, 0)


def jobs(folder: Path) -> dict[str, tuple[list[str], dict[str, str]]]:
    """Of each file for CI its commands and its variables."""
    github = yaml.safe_load((folder / ".github" / "workflows" / "leakref.yml").read_text())
    gitlab = yaml.safe_load((folder / ".gitlab-ci.yml").read_text())
    steps = [step["run"] for step in github["jobs"]["leakref"]["steps"] if "run" in step]
    return {"github": (steps, github["env"]), "gitlab": (gitlab["leakref"]["script"], gitlab["leakref"]["variables"])}


def test_the_files_for_ci_run_the_same_and_leave_no_way_to_be_green_for_nothing(tmp_path):
    scaffold.write("ci", tmp_path)
    (github, variables), (gitlab, others) = jobs(tmp_path).values()
    assert github == gitlab
    assert variables["TARGET"] == others["TARGET"] == "adapter:Code"
    assert variables["LEAKREF"] == others["LEAKREF"]
    assert [line for line in github if "pip install" in line] == ['python -m pip install "leakref[pytest] @ $LEAKREF"']
    assert "full" in variables["PROFILE"]
    assert not [line for line in github if "||" in line or line.endswith("; true")]
    workflow = yaml.safe_load((tmp_path / ".github" / "workflows" / "leakref.yml").read_text())
    assert set(workflow[True]) == {"push", "pull_request", "schedule"}  # YAML reads `on` as true


@pytest.mark.slow
@pytest.mark.parametrize("planted", [False, True])
def test_the_commands_of_the_files_for_ci_run(tmp_path, planted):
    """As they stand, but for the installation, on the adapter that `scaffold python` writes."""
    scaffold.write("ci", tmp_path)
    scaffold.write("python", tmp_path)
    if planted:
        adapter = tmp_path / "adapter.py"
        adapter.write_text(adapter.read_text().replace("-2 * np.pi * np.fft.fftfreq", "2 * np.pi * np.fft.fftfreq"))
    environment = {
        **os.environ,
        "TARGET": "adapter:Code",
        "PROFILE": "quick",
        "OMP_NUM_THREADS": "1",
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
    }
    lines, _ = jobs(tmp_path)["github"]
    run = [line for line in lines if "pip install" not in line]
    assert len(run) == len(lines) - 1
    for line in run:
        done = subprocess.run(line, shell=True, cwd=tmp_path, env=environment, capture_output=True, text=True)
        assert done.returncode == int(planted), f"{line}\n{done.stdout[-4000:]}\n{done.stderr[-2000:]}"
    assert {path.name for path in (tmp_path / "leakref-report").iterdir()} >= {
        "certificate.json",
        "junit.xml",
        "properties.xml",
    }
