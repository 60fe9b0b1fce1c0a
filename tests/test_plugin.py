"""The pytest plugin as a third party has it: outcomes, counts and exit statuses of sessions of their own."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from leakref import LeakrefError
from leakref.certify import parametrize_with_checks

pytest_plugins = ["pytester"]

CODE = """
from leakref import extract as chain

def extract(surface, spacing, wavenumbers, *, gravity, window, method):
    return chain(surface, spacing, wavenumbers, gravity=gravity, window=window, method=method).velocities

def negated(surface, spacing, wavenumbers, *, gravity, window, method):
    return -extract(surface, spacing, wavenumbers, gravity=gravity, window=window, method=method)

def tapering(surface, spacing, wavenumbers):
    raise NotImplementedError("not yet")
"""
OWN = """
from leakref.certify import parametrize_with_checks
from mycode import extract, negated, tapering

KNOWN = {"signs.aligned[to-22.5]": {"reason": "the sign", "issue": "#3"}}
"""
DECORATED = """
@parametrize_with_checks(%s, only=["signs.aligned"], %s)
def test_%s(check):
    check()
"""


@pytest.fixture
def project(pytester, monkeypatch):
    """A third party's project, with a test of its own."""
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    monkeypatch.delenv("LEAKREF_PROPERTIES", raising=False)
    pytester.makepyfile(mycode=CODE, test_own="def test_own():\n    pass")
    return pytester


def session(project, *arguments):
    return project.runpytest_subprocess("-p", "no:cacheprovider", "-p", "no:benchmark", *arguments)


def said(result):
    return "\n".join([*result.outlines, *result.errlines])


def test_nothing_of_it_is_seen_where_it_is_not_asked_for(project):
    result = session(project)
    result.assert_outcomes(passed=1)
    assert result.ret == 0
    assert not [line for line in said(result).splitlines() if "leakref" in line and not line.startswith("plugins:")]


def test_loading_it_loads_nothing_heavy():
    heavy = {"numpy", "scipy", "hypothesis", "numba", "leakref.certify", "leakref.properties"}
    code = f"import sys, leakref.plugin\nprint(*({heavy} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []
    code = "import sys, leakref.certify\nprint(*({'pytest', 'numpy'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_a_plain_run_with_an_implementation_collects_properties_and_checks(project):
    result = session(project, "--leakref-implementation", "mycode:extract", "--collect-only", "-q")
    assert result.ret == 0
    lines = result.outlines
    assert "test_own.py::test_own" in lines
    for name in ("windows", "spectrum", "recovery", "symmetry", "scale", "optimum", "ensemble"):
        assert any(f"test_{name}.py::" in line for line in lines), name
    assert any("test_certification.py::test_check[signs.sea[to-22.5]]" in line for line in lines)
    tests = [line for line in lines if "::" in line]
    assert len(set(tests)) == len(tests)


PAIR = "test_a_pair or aligned and to-22"  # one property and one check


@pytest.mark.parametrize(
    ("name", "outcomes", "status"),
    [("extract", {"passed": 2, "failed": 0}, 0), ("negated", {"passed": 0, "failed": 2}, 1)],
)
def test_right_code_passes_and_wrong_code_fails(project, name, outcomes, status):
    result = session(project, "--leakref-implementation", f"mycode:{name}", "-k", PAIR)
    deselected = result.parseoutcomes()["deselected"]
    result.assert_outcomes(**outcomes, deselected=deselected)
    assert result.ret == status
    if status:
        for line in (
            "*but should be*",
            "*fail signs.aligned?to-22.5? (* times the tolerance)*",
            "*comes back negated*",
            "leakref certify mycode:negated --only *",
        ):
            result.stdout.fnmatch_lines([line])


def test_the_installed_properties_are_run_by_name(project):
    result = session(project, "--pyargs", "leakref.properties", "-k", "test_lobe")
    assert result.parseoutcomes()["passed"] == 2
    assert "nothing was judged" not in said(result)
    assert result.ret == 0


def test_a_command_is_judged(project):
    command = f"{sys.executable} -m leakref.certify.worker mycode:negated"
    result = session(project, "--leakref-command", command, "-k", PAIR)
    assert result.parseoutcomes()["failed"] == 2
    assert result.ret == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--leakref-implementation", "nosuch:thing"], "there is no module 'nosuch'"),
        (["--leakref-implementation", "broken:extract"], "ZeroDivisionError"),
        (["--leakref-implementation", ""], "not an empty one"),
        (["--leakref-command", " "], "not an empty one"),
        (["--leakref-command", "nosuchprogram"], "nosuchprogram"),
        (["--leakref-command", f"{sys.executable} -c 'print(1)'"], "cannot be judged"),
        (["--leakref-implementation", "mycode:extract", "--leakref-command", "true"], "not both"),
    ],
)
def test_what_cannot_be_opened_is_one_clear_line(project, arguments, words):
    project.makepyfile(broken="1 / 0")
    result = session(project, *arguments)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    errors = [line for line in said(result).splitlines() if line.startswith("ERROR: leakref:")]
    assert len(errors) == 1
    assert words in errors[0]
    assert "test_own" not in said(result)


@pytest.mark.parametrize("arguments", [["-k", "test_own"], ["-k", "nosuchtest"], ["-m", "nosuchmark"]])
def test_a_session_that_was_asked_and_judged_nothing_fails(project, arguments):
    result = session(project, "--leakref-implementation", "mycode:extract", *arguments)
    assert result.ret == 1
    assert "leakref: nothing was judged of mycode:extract" in said(result)


def test_a_code_that_offers_nothing_is_not_judged_and_that_fails(project):
    result = session(project, "--leakref-implementation", "mycode:tapering", "-k", PAIR)
    assert result.parseoutcomes()["skipped"] == 2
    assert "nothing was judged of mycode:tapering" in said(result)
    assert result.ret == 1


def own(project, *decorated):
    project.makepyfile(test_own=OWN + "".join(DECORATED % one for one in decorated))
    return session(project)


def test_a_decorated_test_is_one_for_each_check(project):
    """Right: 4; wrong, one of them known: 3 and 1; right, one still listed as known: 3 and 1; all there are: 8."""
    result = own(
        project,
        ("extract", "", "right"),
        ("negated", "known=KNOWN", "wrong"),
        ("extract", "known=KNOWN", "stale"),
        ("extract", 'profile="full"', "full"),
    )
    result.assert_outcomes(passed=4 + 3 + 8, failed=3 + 1, xfailed=1)
    result.stdout.fnmatch_lines(["*XPASS(strict)* the sign (#3)*"])
    result.stdout.fnmatch_lines(["leakref certify *:negated --only 'signs.*"])  # what a failure says can be pasted
    assert result.ret == 1


def test_a_decorated_test_of_which_all_is_skipped_fails(project):
    result = own(project, ("tapering", "", "own"))
    result.assert_outcomes(skipped=4)
    assert "leakref: nothing was judged of the implementation" in said(result)
    assert result.ret == 1


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"known": {"signs.nosuch[a]": {"reason": "a", "issue": "b"}}}, "is none of the"),
        ({"known": {"signs.nosuch[a]": "a"}}, "is none of the"),
        ({"known": {"signs.aligned[to-22.5]": {"reason": "a"}}}, "give it a reason in words"),
        ({"known": {"signs.aligned[to-22.5]": {"reason": " ", "issue": "#3"}}}, "give it a reason in words"),
        ({"known": {"signs.aligned[to-22.5]": ""}}, "give it a reason in words"),
        ({"known": {"signs.aligned[to-22.5]": 3}}, "give it a reason in words"),
        ({"known": ["signs.aligned[to-22.5]"]}, r"known = \['signs.aligned\[to-22.5\]'\] is of the type list"),
        ({"known": 3}, "known = 3 is of the type int"),
        ({"known": "nosuch.toml"}, "nosuch.toml cannot be read"),
        ({"profile": "quik"}, "choose quick or full"),
        ({"only": ["nosuch"]}, "no check is called 'nosuch'"),
    ],
)
def test_a_decorator_that_makes_no_sense_is_refused(given, words):
    with pytest.raises(LeakrefError, match=words):
        parametrize_with_checks("reference", **given)


def test_known_failures_may_be_given_in_every_likely_way(tmp_path):
    file = tmp_path / "known.toml"
    file.write_text('"signs.aligned[to-22.5]" = {reason = "the sign", issue = "#3"}')
    said = {"reason": "the sign", "issue": "#3"}
    for known, reason in (
        (file, "the sign (#3)"),
        (str(file), "the sign (#3)"),
        ({"signs.aligned[to-22.5]": said}, "the sign (#3)"),
        ({"signs.aligned[to-22.5]": "the sign"}, "the sign"),
    ):
        mark = parametrize_with_checks("reference", only=["signs.aligned"], known=known).mark
        strict = [m.kwargs for one in mark.args[1] for m in one.marks if m.name == "xfail"]
        assert strict == [{"strict": True, "reason": reason}]


def test_full_means_more_examples():
    code = (
        "from leakref.properties.strategies import examples\nprint(examples(10).max_examples, examples(10).derandomize)"
    )
    for profile, expected in (("ci", "10 True"), ("thorough", "200 False")):
        done = subprocess.run(
            [sys.executable, "-c", code],
            capture_output=True,
            text=True,
            check=True,
            env={**os.environ, "LEAKREF_PROPERTIES": profile},
        )
        assert done.stdout.strip() == expected
