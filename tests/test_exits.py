"""How commands end: status and words, whatever breaks in leakref or around it."""

from __future__ import annotations

import errno
import json
import os
import resource
import signal
import subprocess
import sys
import time
from concurrent.futures import CancelledError
from pathlib import Path

import distributed
import pytest
from distributed import KilledWorker
from distributed.comm import CommClosedError
from test_commands import here

from leakref import ending, runs
from leakref._base import LeakrefError, Trouble, refusal
from leakref.golden.digests import digest
from leakref.track import history

MAIN = [sys.executable, "-c", "from leakref.cli import main; main()"]
PATIENCE = 600  # seconds after which it hangs


def leakref(*words, before="", **settings):
    """A command in a process of its own, after the Python lines in `before`."""
    code = f"{before}\nfrom leakref.cli import main; main()"
    given = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "timeout": PATIENCE, **settings}
    return subprocess.run([sys.executable, "-c", code, *map(str, words)], check=False, **given)


def one_line(done, status, said=""):
    assert done.returncode == status, done.stderr
    assert done.stderr.startswith("leakref: ")
    assert done.stderr.count("\n") == 1
    assert done.stderr.endswith("\n")
    assert said in done.stderr


BROKEN = """
import leakref.explain, os, signal, sys
def breaks(*words, **settings):
    {}
leakref.explain.run = breaks
"""


@pytest.mark.parametrize(
    ("raised", "status", "said"),
    [
        ("raise OSError(28, 'No space left on device', 'there')", 3, "No space left on device: 'there'; make room"),
        ("raise OSError(24, 'Too many open files')", 3, "ulimit"),
        ("raise OSError(5, 'I/O')", 3, "I/O"),
        ("raise MemoryError", 3, "memory"),
        ("raise RecursionError('too deep')", 3, "a fault of its own, RecursionError"),
        ("raise KeyError('one\\ntwo')", 3, "KeyError"),
        ("raise RuntimeError('a\\nb')", 3, "a b; please report"),
        ("raise ZeroDivisionError", 3, "ZeroDivisionError"),
        ("assert False", 3, "AssertionError"),
        ("raise SystemExit(1)", 3, "SystemExit"),
        ("raise UnicodeEncodeError('ascii', 'a', 0, 1, 'no')", 3, "codec"),
        ("raise leakref.LeakrefError('a', 'b\\nc', 'd')", 2, "a: b c; d."),
        ("from leakref._base import Trouble; raise Trouble('a', 'b', 'c')", 3, "a: b; c."),
        ("os.kill(os.getpid(), signal.SIGTERM)", 143, "ended by SIGTERM"),
        ("os.kill(os.getpid(), signal.SIGHUP)", 129, "ended by SIGHUP"),
        ("os.kill(os.getpid(), signal.SIGINT)", 130, "interrupted"),
        ("raise KeyboardInterrupt", 130, "interrupted"),
    ],
)
def test_whatever_breaks_is_one_line_and_a_status_that_is_no_verdict(raised, status, said):
    usual = "import signal; signal.signal(signal.SIGHUP, signal.SIG_DFL)"  # pytest may run under nohup
    done = leakref("explain", before=usual + BROKEN.format(raised))
    one_line(done, status, said)
    assert done.stdout == ""
    assert ("leakref --traceback" in done.stderr) == (status == 3 and "Trouble" not in raised)


@pytest.mark.parametrize(("words", "env"), [(["--traceback", "explain"], {}), (["explain"], {ending.TRACEBACK: "1"})])
def test_the_traceback_is_there_for_the_asking(words, env):
    done = leakref(*words, before=BROKEN.format("raise OSError(28, 'full')"), env={**os.environ, **env})
    assert done.returncode == 3
    assert "in breaks" in done.stderr
    assert done.stderr.splitlines()[-1].startswith("leakref: explain: ")


@pytest.mark.parametrize("where", ["__del__", "a weak reference's callback"])
def test_a_signal_that_python_cannot_raise_where_it_comes_is_not_lost(where):
    lost = (
        "    import time, weakref\n    class One:\n"
        + ("        def __del__(self): end()\n" if where == "__del__" else "        pass\n")
        + "    def end(*_): os.kill(os.getpid(), signal.SIGTERM)\n    one = One()\n"
        + ("" if where == "__del__" else "    kept = weakref.ref(one, end)\n")
        + "    del one\n    time.sleep(60)"
    )
    one_line(leakref("explain", before=BROKEN.format("pass\n" + lost)), 143, "ended by SIGTERM")


def test_nohup_is_respected():
    ignored = "import signal; signal.signal(signal.SIGHUP, signal.SIG_IGN)" + BROKEN
    assert leakref("explain", before=ignored.format("os.kill(os.getpid(), signal.SIGHUP); return True")).returncode == 0


@pytest.mark.parametrize(
    "words",
    [
        ["explain"],
        ["explain", "--json"],
        ["explain", "D1"],
        ["--version"],
        ["--help"],
        ["certify", "--list"],
        ["certify", "--schema"],
        ["reproduce", "--list"],
    ],
)
def test_what_cannot_be_printed_is_no_success(words):
    if not Path("/dev/full").exists():
        assert sys.platform != "linux"
        return
    with open("/dev/full", "w") as full:
        one_line(leakref(*words, stdout=full), 3, "No space left")


@pytest.mark.parametrize("words", [["explain", "--json"], ["explain"], ["--help"], ["certify", "--list"]])
def test_a_reader_who_has_gone_is_neither_success_nor_noise(words):
    reading, writing = os.pipe()
    os.close(reading)
    done = leakref(*words, stdout=writing)
    os.close(writing)
    assert (done.returncode, done.stderr) == (128 + signal.SIGPIPE, "")


@pytest.mark.parametrize("stream", [1, 2])
def test_a_stream_that_is_closed_or_full_stops_nothing(stream, tmp_path):
    closed = subprocess.run(
        ["sh", "-c", f'exec "$@" {stream}>&-', "sh", *MAIN, "explain", "nonsense"],
        timeout=PATIENCE,
        capture_output=True,
        text=True,
        check=False,
    )
    assert closed.returncode == 2
    assert ("nonsense" in closed.stderr) == (stream == 1)
    assert "Traceback" not in closed.stderr


def test_characters_that_an_encoding_lacks_are_no_fault(tmp_path):
    ascii_only = {**os.environ, "LC_ALL": "C", "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}
    assert leakref("explain", "negated-current", env=ascii_only, encoding="utf-8").returncode == 0
    one_line(leakref("extract", os.fsencode(tmp_path) + b"/\xff.npz", env=ascii_only), 2, "does not exist")


def limited(size):
    return f"import resource; resource.setrlimit(resource.RLIMIT_FSIZE, ({size}, {size}))"


@pytest.mark.parametrize("name", ["a.npz", "a.mat", "a.nc"])
def test_a_disk_that_is_full_is_no_wrong_use(name, tmp_path):
    assert resource.getrlimit(resource.RLIMIT_FSIZE)[0] < 0  # the limit stands in for the end of the disk
    done = leakref("export", "L-T/L=5,T=10", "--out", tmp_path / name, before=limited(1 << 16))
    one_line(done, 3, f"{name} cannot be written (File too large)")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("family", "size"), [("leakage", 1 << 12), ("synthesis", 60_000)])  # the question, the answer
def test_a_full_exchange_folder_is_not_blamed_on_the_code(family, size):
    done = leakref("certify", "reference", "--only", family, "--workers", "1", before=limited(size))
    one_line(done, 3, "File too large")


@pytest.mark.parametrize(
    ("number", "kind"),
    [
        (errno.EACCES, LeakrefError),
        (errno.EROFS, LeakrefError),
        (errno.ENOENT, LeakrefError),
        (errno.ENOSPC, Trouble),
        (errno.EDQUOT, Trouble),
        (errno.EIO, Trouble),
        (errno.EMFILE, Trouble),
        (None, Trouble),
    ],
)
def test_a_path_that_was_asked_for_is_wrong_use_and_the_machine_is_not(number, kind):
    error = refusal("a", "b", "c", OSError(number, "x") if number else OSError("x"))
    assert type(error) is kind
    assert error.status == (2 if kind is LeakrefError else 3)


def test_a_worker_that_is_killed_ends_a_record_with_3(tmp_path):
    killed = """
import leakref.runs as runs, os, signal
from contextlib import contextmanager
whole = runs.pool
@contextmanager
def pool(workers):
    with whole(workers) as executor:
        executor.submit(os.getpid).result()
        os.kill(next(iter(executor._processes)), signal.SIGKILL)
        yield executor
runs.pool = pool
"""
    done = leakref(
        "track",
        "record",
        "reference",
        "--case",
        "L-T/L=5,T=10",
        "--realizations",
        4,
        "--workers",
        2,
        "--history",
        "h.jsonl",
        before=killed,
        cwd=tmp_path,
    )
    one_line(done, 3, "a worker process died")
    assert not (tmp_path / "h.jsonl").exists()


@pytest.mark.parametrize("error", [CancelledError("key"), CommClosedError("gone"), KilledWorker("task", "it", 1)])
def test_a_lost_scheduler_is_no_verdict(error):
    with (
        distributed.LocalCluster(n_workers=1, processes=False, dashboard_address=None) as cluster,
        pytest.raises(Trouble, match=r"are gone.*goes on where"),
        runs.connected(cluster.scheduler_address),
    ):
        raise error


def test_a_scheduler_that_is_killed_in_the_middle_ends_with_3_and_one_line(tmp_path):
    started = []

    def start(*words, **streams):
        streams = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL} | streams
        started.append(subprocess.Popen([sys.executable, *words], cwd=tmp_path, text=True, **streams))
        return started[-1]

    try:
        scheduler = start(
            "-m",
            "distributed.cli.dask_scheduler",
            "--no-dashboard",
            "--host",
            "127.0.0.1",
            "--port",
            "0",
            "--scheduler-file",
            "where.json",
        )
        wait_for(tmp_path / "where.json")
        address = json.loads((tmp_path / "where.json").read_text())["address"]
        start(
            "-m",
            "distributed.cli.dask_worker",
            "--no-dashboard",
            "--no-nanny",
            "--nthreads",
            "1",
            "--death-timeout",
            "1",
            address,
        )
        client = start(
            *MAIN[1:],
            "reproduce",
            "nsp-ls",
            "--realizations",
            "1000",
            "--out",
            "out",
            "--scheduler",
            address,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        wait_for(tmp_path / "out" / "parts", "*/*.npz", client)
        scheduler.kill()
        output, said = client.communicate(timeout=PATIENCE)
    finally:
        for process in started:
            process.kill()
            process.wait()
    one_line(subprocess.CompletedProcess(client.args, client.returncode, output, said), 3, "are gone")
    assert output == ""


def wait_for(place, pattern=None, process=None):
    """Until a file is there, or one of its kind; the process, if given, must not end before."""
    for _ in range(10 * PATIENCE):
        if place.exists() if pattern is None else list(place.glob(pattern)):
            return
        assert process is None or process.poll() is None, process.communicate()
        time.sleep(0.1)
    raise AssertionError(f"{place} does not come")


@pytest.mark.parametrize("field", ["after", "label", "target", "measurements", "timings"])
@pytest.mark.parametrize("action", [["check"], ["compare", "one", "last"], ["plot"]])
def test_a_history_of_any_form_is_judged_or_not_and_never_breaks(field, action, tmp_path):
    path = tmp_path / "h.jsonl"
    for label in ("one", "two"):
        history.append(path, {"label": label, "target": "t", "measurements": [], "timings": None})
    first, second = path.read_text().splitlines()
    record = json.loads(second)
    del record["digest"]
    record[field] = 7.5 if field == "measurements" else [{"an": "object"}]
    path.write_text(f"{first}\n{history._line(record | {'digest': digest(record)}).decode()}\n")
    done = here("track", *action, "--history", path, "--json", cwd=tmp_path)
    assert done.returncode in (1, 3)
    assert "Traceback" not in done.stderr
    assert f"is no entry: its {field} is" in done.stderr or action == ["check"]


COMMANDS = [
    ["certify", "fault:nothing"],
    ["compare", "nothing.json", "nothing.json", "--out", "x"],
    ["strength", "--workers", "x"],
    ["scaffold", "cobol", "."],
    ["explain", "nonsense"],
    ["guide", "nonsense"],
    ["extract", "nothing.npz"],
    ["export", "nonsense", "--out", "x"],
    ["demo", "--out", "file/x"],
    ["plan", "--field-of-view", "x", "--duration", "1s", "--peak-wavelength", "1m"],
    ["reproduce", "nonsense"],
    ["claims", "nonsense"],
    ["bench", "--out", "file/x"],
    ["golden", "lint", "--set", "nothing"],
    ["golden", "verify", "nonsense"],
    ["golden", "regenerate", "nonsense"],
    ["golden", "pack", "--format", "nonsense", "--out", "x"],
    ["exam", "write", "x", "--format", "nonsense"],
    ["exam", "grade", "nothing"],
    ["track", "record"],
    ["track", "compare", "a", "b"],
    ["track", "plot"],
    ["track", "check"],
    ["track", "null", "--folder", "file/x"],
]


def test_every_command_is_tried_below():
    from leakref.cli.base import app

    named = {(command.name or command.callback.__name__,) for command in app.registered_commands}
    named |= {
        (group.name, command.name)
        for group in app.registered_groups
        for command in group.typer_instance.registered_commands
    }
    assert named == {tuple(words[:2]) if words[0] in ("exam", "golden", "track") else (words[0],) for words in COMMANDS}


@pytest.mark.parametrize("words", COMMANDS, ids=lambda words: " ".join(words[:2]))
def test_no_command_that_fails_ends_with_the_version_and_0(words, tmp_path):
    (tmp_path / "file").touch()
    for given in (words, ["--version", *words]):
        done = here(*given, cwd=tmp_path)
        assert done.returncode in (1, 2, 3)
        assert "leakref 0." not in done.stdout
    assert "--version goes without a command" in " ".join(done.stderr.split())
