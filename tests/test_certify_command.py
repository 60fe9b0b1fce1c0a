"""leakref certify, explain and scaffold on the command line."""

from __future__ import annotations

import json
import shlex
import sys
from dataclasses import replace

import jsonschema
import pytest
from test_commands import here
from test_commands import leakref as command

from leakref import LeakrefError
from leakref.certify import commands
from leakref.certify.certificate import schema
from leakref.certify.runner import certify, select
from leakref.explain import TERMS, explain

ODD = """
import numpy as np
from leakref.chain import reference

class Empty:
    "Offers no stage."

class Windows:
    def window(self, name, size):
        return reference.window(name, size)

def dated(surface, spacing, wavenumbers, *, gravity, window, method):
    return reference.extract(surface, spacing, wavenumbers, gravity=gravity, window=window, method=method) * [1, -1]
"""


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    folder = tmp_path_factory.mktemp("project")
    (folder / "odd.py").write_text(ODD)
    return folder


@pytest.mark.parametrize(
    ("words", "status", "said"),
    [
        ((), 2, "no target was given"),
        (("",), 2, "the target is empty"),
        (("reference", "--command", "x"), 2, "a target and a --command was given"),
        (("--command", ""), 2, "is empty"),
        (("--command", "'"), 2, "cannot be split"),
        (("nonsense",), 2, "names nothing"),
        (("no_such_module:x",), 2, "there is no module"),
        (("odd:nothing",), 2, "has no 'nothing'"),
        (("fault:no-such",), 2, "no-such"),
        (("variant:no-such",), 2, "no-such"),
        (("reference", "--only", "no.such"), 2, "no check is called"),
        (("reference", "--profile", "x"), 2, "no profile"),
        (("reference", "--golden", "99"), 2, "golden set number 99"),
        (("--command", "no-such-program-here"), 2, "no-such-program-here"),
        (("reference", "--only", "scale.peak[quarter]"), 3, "Nothing to run"),
        (("odd:Empty", "--only", "signs"), 3, "offers none of"),
        (("odd:Windows", "--only", "signs"), 3, "no grade"),
    ],
)
def test_wrong_use_and_nothing_to_judge_are_told_apart(project, words, status, said):
    done = here("certify", *words, cwd=project)
    assert done.returncode == status, done.stderr + done.stdout
    text = done.stderr + done.stdout
    assert said in " ".join(text.split())
    assert "Traceback" not in text


def test_a_certificate_in_json_follows_its_schema_and_names_the_mistake(project, tmp_path):
    done = command(
        "certify",
        "odd:dated",
        "--only",
        "signs.aligned",
        "--only",
        "recovery.pair",
        "--report",
        tmp_path / "report",
        "--json",
        cwd=project,
    )
    record = json.loads(done.stdout)
    jsonschema.validate(record, schema())
    assert (done.returncode, record["ok"], record["grade"]) == (1, False, "rejected")
    assert record["diagnosis"][0]["fault"] == "flipped-y"
    assert record["diagnosis"][0]["digits"] > 9
    assert "odd:dated" in record["findings"][0]["repro"]
    assert json.loads((tmp_path / "report" / "certificate.json").read_text()) == record
    page = (tmp_path / "report" / "certificate.html").read_text()
    assert "the y component has the wrong sign" in page
    assert "<script" not in page
    assert "rejected" in (tmp_path / "report" / "badge.svg").read_text()
    assert 'failures="' in (tmp_path / "report" / "junit.xml").read_text()


def test_known_failures_are_let_pass_until_they_pass(project, tmp_path):
    names = [f"{c.id}[{case.id}]" for c, case in select(["signs.aligned"], profile="quick")]
    known = tmp_path / "known.toml"
    known.write_text("".join(f'"{name}" = {{reason = "rows", issue = "#1"}}\n' for name in names))
    words = ("--only", "signs.aligned", "--known", known, "--no-diagnosis")
    assert command("certify", "odd:dated", *words, cwd=project).returncode == 0
    done = command("certify", "reference", *words, cwd=project)
    assert done.returncode == 1
    assert "passes; take it off" in " ".join(done.stdout.split())
    known.write_text('"signs.nothing[x]" = {reason = "rows", issue = "#1"}\n')
    assert command("certify", "reference", *words, cwd=project).returncode == 2


def test_a_program_is_certified_as_a_target_is(project):
    worker = shlex.join([sys.executable, "-m", "leakref.certify.worker", "reference"])
    done = command(
        "certify", "--command", worker, "--only", "conformance.window", "--workers", 1, "--json", cwd=project
    )
    record = json.loads(done.stdout)
    assert (done.returncode, record["grade"], record["target"]) == (0, "conformant", worker)
    assert len(record["findings"]) == len(select(["conformance.window"], profile="quick"))


@pytest.mark.parametrize(
    ("words", "limit"),
    [
        (("--timeout", 0.7), "0.7"),
        (("--start-timeout", 0.6), "0.6"),
        (("--timeout", 0.7, "--start-timeout", 0.5), "0.5"),
    ],
)
def test_silence_at_the_start_is_not_waited_for_beyond_the_limit(project, words, limit):
    silent = shlex.join([sys.executable, "-S", "-c", "import time; time.sleep(600)"])
    for target in (("--command", silent), ("silent:code",)):
        (project / "silent.py").write_text("import time\ntime.sleep(600)\n")
        done = command("certify", *target, *words, "--workers", 1, cwd=project)
        assert (done.returncode, f"gave no answer within {limit} s" in " ".join(done.stderr.split())) == (3, True)


def test_what_is_ours_does_not_count_as_the_start(project):
    done = command(
        "certify",
        "reference",
        "--start-timeout",
        0.1,
        "--only",
        "conformance.window[window-box-7]",
        "--workers",
        1,
        cwd=project,
    )
    assert done.returncode in (0, 3)
    assert "within 30 s" not in done.stderr


def test_lists_and_schema_are_printed():
    ids = here("certify", "--list").stdout.split()
    assert len(ids) == len(set(ids)) == len(select(profile="quick")) > 100
    assert json.loads(here("certify", "--schema").stdout) == schema()


@pytest.mark.parametrize(
    ("identifier", "kind"),
    [
        ("signs", "a family of checks"),
        ("signs.sea", "a check"),
        ("signs.sea[to-22.5]", "a check"),
        ("exchanged-axes", "a fault"),
        ("fault:exchanged-axes", "a fault"),
        ("bfgs", "a correct alternative"),
        ("A4", "a claim of the paper"),
        ("D4", "a decision"),
        ("D12", "a decision"),
        ("window-hann-7", "a golden value"),
    ],
)
def test_every_kind_of_id_is_explain(identifier, kind):
    found = explain(identifier)
    assert str(found["kind"]).startswith(kind)
    assert str(found.get("asked", "")).startswith("Given: ") == (kind == "a check")
    assert len(found) > 3
    with pytest.raises(LeakrefError, match=r"perhaps .* is meant"):
        explain(identifier + "s")


BAD = ("room", "from rest", "around rest", "bare", "cry wolf", "cries wolf", " lies", "nobody")
"""Words that a reader who has read nothing else does not understand, or that are not plain."""


def test_what_is_said_of_a_check_is_whole_sentences_in_plain_words():
    for check in {c.id: c for c, _ in select()}.values():
        for said in (check.reason, check.tolerance):
            assert said[0].isupper(), check.id
            assert said.endswith("."), check.id
            assert ";;" not in said.replace("..", ";;"), check.id
            assert not [word for word in BAD if word in said.lower()], check.id
        found = explain(check.id)
        assert ("c0" in check.tolerance) <= ("c0" in found["terms"])
    assert "the phase velocity" in explain("signs.sea")["terms"]["c0"]
    assert {"NSP", "velocity resolution"} <= set(explain("leakage.still")["terms"])


def test_every_word_that_is_explained_occurs():
    said = " ".join(f"{c.reason} {c.tolerance}" for c, _ in select())
    assert [term for term in TERMS if term not in said] == []


def test_explain_prints_words_or_json():
    assert "x and y exchanged" in here("explain", "exchanged-axes").stdout
    assert json.loads(here("explain", "D4", "--json").stdout)["question"]
    assert here("explain", "no-such-thing-at-all").returncode == 2
    ids = json.loads(here("explain", "--json").stdout)["ids"]
    assert {"signs", "signs.sea", "exchanged-axes", "bfgs", "A4", "D4"} <= set(ids)
    assert len(set(ids)) == len(ids)


def test_conformance_alone_rejects_no_code(monkeypatch, capsys):
    monkeypatch.setattr(commands, "explain", lambda found, *session, **how: found)
    assert commands.run(commands.Request("fault:narrow-width", None, only=["conformance.extract[nsp-oblong]"])) == 1
    said = capsys.readouterr().out
    assert "conformance by itself rejects no code" in said
    assert "why: Velocities of small cubes" in said
    assert commands.run(commands.Request("fault:flipped-y", None, only=["signs.sea[to-22.5]"])) == 1
    assert "conformance by itself" not in capsys.readouterr().out


def test_what_was_found_before_an_interruption_is_told(monkeypatch, capsys, tmp_path):
    def impatient(*args, after_each, **kwargs):
        seen = []

        def few(finding):
            seen.append(finding)
            after_each(finding)
            if len(seen) == 2:
                raise KeyboardInterrupt

        return certify(*args, after_each=few, **kwargs)

    monkeypatch.setattr(commands, "certify", impatient)
    request = commands.Request("fault:flipped-y", None, only=["signs.aligned"], workers=1, report=tmp_path)
    with pytest.raises(KeyboardInterrupt):  # which is exit status 130
        commands.run(request)
    shown = capsys.readouterr()
    assert "interrupted after 2 of 4 questions" in shown.err
    assert "fail signs.aligned[to-112.5]" in shown.out
    assert "comes back with y flipped" in shown.out
    with pytest.raises(KeyboardInterrupt):
        commands.run(request, json=True)
    record = json.loads(capsys.readouterr().out)
    assert (record["complete"], record["ok"], record["grade"]) == (False, False, "rejected")
    assert record["cut_short"] == "interrupted after 2 of 4 questions"
    assert len(record["findings"]) == 2
    assert record["scope"]["peak_wavelengths"]  # of what it had answered
    assert json.loads((tmp_path / "certificate.json").read_text())["complete"] is False
    assert "Cut short" in (tmp_path / "certificate.html").read_text()
    with pytest.raises(KeyboardInterrupt):
        commands.run(replace(request, target="reference"), json=True)
    assert json.loads(capsys.readouterr().out)["grade"] is None  # what is right so far is no verdict


def test_a_diagnosis_that_is_interrupted_leaves_the_findings(monkeypatch, capsys):
    def impatient(*args, **kwargs):
        raise KeyboardInterrupt

    monkeypatch.setattr(commands, "explain", impatient)
    with pytest.raises(KeyboardInterrupt):  # which is exit status 130
        commands.run(commands.Request("fault:flipped-y", None, only=["signs.sea[to-22.5]"]))
    shown = capsys.readouterr()
    assert "Cut short" in shown.err
    assert "rejected, asked only signs.sea[to-22.5], 1 of 1 questions" in shown.out


def test_a_diagnosis_can_be_done_without(monkeypatch, capsys):
    monkeypatch.setattr(commands, "explain", lambda *args, **kwargs: pytest.fail("was asked"))
    request = commands.Request("fault:flipped-y", None, only=["signs.sea[to-22.5]"], diagnosis=False)
    assert commands.run(request) == 1
    assert "Diagnosis" not in capsys.readouterr().out


def test_a_run_of_another_seed_says_how_to_repeat_it(capsys):
    request = commands.Request("fault:flipped-y", None, only=["signs.sea[to-22.5]"], diagnosis=False, seed="5")
    assert commands.run(request, json=True) == 1
    shown = capsys.readouterr()
    record = json.loads(shown.out)
    assert (record["seed"], record["scope"]["seed"]) == (5, 5)
    assert "fault:flipped-y" in record["findings"][0]["repro"]
    assert "--seed 5" in record["findings"][0]["repro"]
    assert "--seed 5" in shown.err


def test_scaffold_writes_and_says_what_comes_next(tmp_path):
    done = command("scaffold", "python", tmp_path / "new", "--json")
    said = json.loads(done.stdout)
    assert said["next"] == "leakref certify adapter:Code"
    assert (tmp_path / "new" / "adapter.py").exists()
    assert command("scaffold", "python", tmp_path / "new").returncode == 2
    assert command("scaffold", "cobol", tmp_path / "other").returncode == 2
