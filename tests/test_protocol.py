"""Programs that break protocol 1: each breach has its own verdict, the rest goes on, and nothing is left behind."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import psutil
import pytest

from leakref import LeakrefError
from leakref.certify.subject import child, memory
from leakref.certify.subject.declaration import Declaration
from leakref.certify.subject.protocol import ProcessSubject
from leakref.certify.targets import HarnessBroken, Limits, connect
from leakref.certify.verdict import Unanswered

OFTEN = "import json, os, signal, subprocess, sys, time\n"
PROGRAM = (
    OFTEN
    + """
HERE = os.path.dirname(os.path.abspath(__file__))
CAN = {"extract": {"methods": ["nsp"], "windows": ["box"]}}
READY = {"op": "ready", "protocol": 1, "name": "small", "format": "raw", "can": CAN}
DEEDS = []  # instead of good answers, to runs 2, 4, ...; run 1 is the first, small question

def say(message):
    print(json.dumps(message), flush=True)

def good(request):
    rows = len(request["parameters"]["wavenumbers"])
    return {"id": request["id"], "status": "ok", "velocities": [[0.25, -0.5]] * rows}

def ready():
    say(READY)

#OWN

with open(os.path.join(HERE, "starts"), "a") as starts:
    starts.write(f"{os.getpid()} ")
for line in sys.stdin:
    request = json.loads(line)
    if request["op"] == "start":
        ready()
    elif request["op"] == "stop":
        break
    elif request["id"] % 2 == 0 and request["id"] // 2 <= len(DEEDS):
        exec(DEEDS[request["id"] // 2 - 1])
    else:
        say(good(request))
open(os.path.join(HERE, "stopped"), "w").close()
"""
)
LATER = "while not os.path.exists(HERE + '/go'): time.sleep(0.01)\n"
OFFSPRING = '''
def linger(*, session=False, orphan=False, bare=False):
    """A process that ignores every polite signal."""
    if os.fork() == 0:
        if session:
            os.setsid()
        if orphan and os.fork():
            os._exit(0)
        code = "import signal, time\\nfor n in (1, 2, 15): signal.signal(n, signal.SIG_IGN)\\ntime.sleep(600)"
        arguments = [sys.executable, "-S", "-c", code, HERE]
        os.execve(sys.executable, arguments, {} if bare else os.environ)
'''


@pytest.fixture
def left_behind(tmp_path, monkeypatch):
    """After the test: no process that names the test's folder, and nothing among the temporary files."""
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    yield
    assert list(temporary.iterdir()) == []
    assert running(tmp_path) == []


def running(folder):
    """The processes whose command line names the folder."""
    found = []
    for process in psutil.process_iter():
        try:
            if str(folder) in " ".join(process.cmdline()) and process.status() != psutil.STATUS_ZOMBIE:
                found.append(process)
        except psutil.Error:
            pass
    return found


def settled(folder, count):
    """Wait until there are so many of them: what forks takes its time."""
    end = time.monotonic() + 60
    while len(running(folder)) != count:
        assert time.monotonic() < end
        time.sleep(0.01)


@pytest.fixture
def session(left_behind, tmp_path):
    """The program as a context: with code of its own, and with what it does instead of answering well."""

    def start(*deeds, own="", keep=None, **limits):
        program = tmp_path / "program.py"
        program.write_text(PROGRAM.replace("#OWN", f"DEEDS = {list(deeds)!r}\n{own}"))
        return ProcessSubject([sys.executable, "-S", str(program)], limits=Limits(**limits), keep=keep)

    return start


def starts(tmp_path):
    return len((tmp_path / "starts").read_text().split())


def ask(subject, rows=2):
    """The verdict on one extraction, `ok` if there is an answer, and the message."""
    surface = np.random.default_rng(1).standard_normal((8, 9, 10))
    try:
        answer = subject.extract(surface, (0.8, 0.9, 0.7), np.linspace(0.5, 1.5, rows), window="box")
    except Unanswered as nothing:
        return str(nothing.verdict), nothing.message
    assert np.array_equal(answer.values, [[0.25, -0.5]] * rows)
    return "ok", ""


def judged(subject, deeds=1, patience=120.0):
    """Verdict and message for each bad run. After each a good one, which is answered as if nothing had happened."""
    found, limits = [], subject.limits
    for n in range(deeds):
        subject.limits = replace(limits, run=patience)
        found.append(ask(subject))
        subject.limits = limits
        assert ask(subject, rows=3) == ("ok", ""), n
    return found


def test_a_program_that_behaves_is_started_once(session, tmp_path):
    with session() as subject:
        assert judged(subject, 2) == 2 * [("ok", "")]
        assert subject.declaration.name == "small"
        assert subject.violations == []
        assert not (tmp_path / "stopped").exists()
    assert (tmp_path / "stopped").exists()
    assert starts(tmp_path) == 1


def test_a_program_that_does_not_stop_is_ended(session, monkeypatch):
    monkeypatch.setattr(child, "_GRACE", 0.3)
    with session(own="import atexit\natexit.register(time.sleep, 600)") as subject:
        assert ask(subject) == ("ok", "")


def test_a_crash_is_an_error(session, tmp_path):
    deeds = {
        "os._exit(3)": "ended by itself, with exit status 3",
        "sys.exit('no such wave')": "ended by itself, with exit status 1; its last words: no such wave",
        "os.kill(os.getpid(), signal.SIGKILL)": "was ended by signal 9 (SIGKILL)",
        "os.close(1); time.sleep(600)": "closed its standard output",
        "print('\\x1b[31mred\\x07', file=sys.stderr); os._exit(1)": (
            "ended by itself, with exit status 1; its last words: [31mred"
        ),
    }
    with session(*deeds) as subject:
        assert judged(subject, len(deeds)) == [("error", words) for words in deeds.values()]
    assert starts(tmp_path) == 1 + len(deeds)


def test_a_program_that_hangs_is_out_of_time(session):
    with session("time.sleep(600)") as subject:
        assert judged(subject, patience=0.5) == [("timeout", "gave no answer within 0.5 s")]


def test_a_program_that_does_not_read_is_out_of_time(session, tmp_path):
    with session() as subject:
        os.kill(int((tmp_path / "starts").read_text()), signal.SIGSTOP)
        limits, subject.limits = subject.limits, Limits(run=0.5)
        assert ask(subject, rows=20_000)[0] == "timeout"  # a line longer than any pipe holds
        subject.limits = limits
        assert ask(subject) == ("ok", "")


def test_one_that_forks_and_hangs_leaves_no_offspring(session, tmp_path):
    deeds = [
        f"linger({how}); time.sleep(600)"
        for how in ("session=True", "session=True, orphan=True", "bare=True, orphan=True")
    ]
    with session(*deeds, own=OFFSPRING) as subject:
        for _ in deeds:
            assert judged(subject, patience=1.0) == [("timeout", "gave no answer within 1 s")]
            assert len(running(tmp_path)) == 1  # the one that was started afterwards


def test_one_that_forks_and_ends_leaves_no_offspring(session, tmp_path):
    ends, goes_on = "; os._exit(0)", "; say(good(request))"
    deeds = [
        f"linger(session=True, orphan=True){ends}",
        f"linger(bare=True, orphan=True){ends}",
        f"linger(session=True, orphan=True){goes_on}",
    ]
    with session(*deeds, own=OFFSPRING) as subject:
        assert judged(subject, 3) == [*2 * [("error", "ended by itself, with exit status 0")], ("ok", "")]
        settled(tmp_path, 2)  # one is still waited for, beside the program: `left_behind` looks again


LOST = "linger(session=True, orphan=True, bare=True)"  # forked twice, in a session and an environment of its own
linux = pytest.mark.skipif(sys.platform != "linux", reason="elsewhere an orphan is nobody's")


@linux
def test_an_orphan_without_a_trace_is_found(session, tmp_path):
    with session(f"{LOST}; say(good(request))", own=OFFSPRING) as subject:
        assert judged(subject) == [("ok", "")]
        settled(tmp_path, 2)


@linux
def test_what_a_program_does_to_its_guardian_is_its_own_end(session, tmp_path):
    deeds = {
        "os.kill(os.getppid(), signal.SIGKILL); time.sleep(600)": ("error", "was ended by signal 9 (SIGKILL)"),
        f"{LOST}; os.kill(os.getppid(), signal.SIGSTOP); time.sleep(600)": ("timeout", "gave no answer within 3 s"),
        "[os.kill(os.getppid(), n) for n in (1, 2, 15)]; say(good(request))": ("ok", ""),
        "os.killpg(0, signal.SIGTERM); time.sleep(600)": ("error", "was ended by signal 15 (SIGTERM)"),
    }
    with session(*deeds, own=OFFSPRING) as subject:
        for expected in deeds.values():
            assert judged(subject, patience=3.0 if expected[0] == "timeout" else 120.0) == [expected]


@linux
def test_a_program_that_kills_its_guardian_leaves_no_orphan(session):  # see left_behind
    with session(f"{LOST}; os.kill(os.getppid(), signal.SIGKILL); time.sleep(600)", own=OFFSPRING) as subject:
        assert judged(subject) == [("error", "was ended by signal 9 (SIGKILL)")]


@linux
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_a_process_that_is_killed_leaves_no_program(session, tmp_path, number):
    program = session(f"{LOST}; open(HERE + '/asked', 'w').close(); time.sleep(600)", own=OFFSPRING)
    ours = tmp_path / "ours.py"
    ours.write_text(
        "import numpy as np\nfrom leakref.certify.subject.protocol import ProcessSubject\n"
        f"with ProcessSubject({program.command!r}) as subject:\n"
        "    while True: subject.extract(np.ones((4, 4, 4)), (1, 1, 1), [1.0], window='box')\n"
    )
    with subprocess.Popen([sys.executable, str(ours)], env={**os.environ, "TMPDIR": str(tmp_path)}) as process:
        try:
            while not ((tmp_path / "asked").exists() and len(running(tmp_path)) == 3):  # ours, the program, the orphan
                assert process.poll() is None
                time.sleep(0.02)
        finally:
            process.send_signal(number)
    end = time.monotonic() + 60
    while (running(tmp_path) or list(tmp_path.glob("tmp*"))) and time.monotonic() < end:
        time.sleep(0.02)
    assert (running(tmp_path), list(tmp_path.glob("tmp*"))) == ([], [])  # nor its exchange folder


def test_garbage_between_the_lines_is_ignored(session, tmp_path):
    lines = [
        "'hello'",
        "'{'",
        "'[' * 100000",
        "'{\"a\": ' * 100000",
        "'{}'",
        '\'{"status": "ok"}\'',
        "'\\0\\ud7ff'",
        "7",
        "'[{\"id\": 3}]'",
        "'x' * (9 << 20)",
        "'{\"id\": ' + '1' * 5000",
    ]
    with session(*(f"print({line}, flush=True); say(good(request))" for line in lines)) as subject:
        assert judged(subject, len(lines)) == len(lines) * [("ok", "")]
    assert starts(tmp_path) == 1


def test_nothing_but_garbage_is_out_of_time(session, monkeypatch):
    """The clock stands until enough garbage has come: how soon that is depends on what else the machine does."""
    with session("while True: os.write(1, b'garbage' * 9999)") as subject:
        noise, started = subject._child._noise, time.monotonic()
        monkeypatch.setattr(
            child,
            "time",
            SimpleNamespace(
                sleep=time.sleep, monotonic=lambda: started + 9 * any("a line of more" in said for said in noise)
            ),
        )
        before = psutil.Process().memory_info().rss
        limits, subject.limits = subject.limits, replace(subject.limits, run=1.0)
        verdict, message = ask(subject)
        monkeypatch.undo()
        subject.limits = limits
        assert ask(subject) == ("ok", "")
        assert (verdict, message[:27]) == ("timeout", "gave no answer within 1 s; ")
        assert "a line of more than 4194304 bytes" in message
        assert psutil.Process().memory_info().rss - before < 100 * 2**20  # it came to gigabytes a minute


def test_answers_twice_or_to_another_question_are_errors(session, tmp_path):
    deeds = [
        "os.write(1, 2 * (json.dumps(good(request)) + '\\n').encode())",
        "say(good(request) | {'id': request['id'] + 1})",
        "say(good(request) | {'id': True})",
        "say(good(request) | {'id': str(request['id'])})",
        "say(READY); say(good(request))",
        "say({'op': 'run'})",
    ]
    with session(*deeds) as subject:
        for verdict, message in judged(subject, len(deeds)):
            assert verdict == "error"
            assert message.startswith("answered")
    assert starts(tmp_path) == 1 + len(deeds)


def test_a_second_answer_that_comes_late_is_nobody_elses(session, tmp_path):
    with session(f"say(good(request))\n{LATER}say(good(request))") as subject:
        assert ask(subject) == ("ok", "")
        (tmp_path / "go").touch()
        assert subject._child._gather(60.0)
        verdict, message = ask(subject, rows=3)
        assert (verdict, "without being asked" in message) == ("error", True)
        assert ask(subject, rows=4) == ("ok", "")
    assert subject.violations == []


def test_what_is_said_after_the_last_answer_is_a_violation(session, tmp_path):
    with session(f"say(good(request))\n{LATER}say({{'op': 'by the way'}})") as subject:
        assert ask(subject) == ("ok", "")
        (tmp_path / "go").touch()
        assert subject._child._gather(60.0)
        assert subject.violations == []
    assert subject.violations == ["said without being asked: {'op': 'by the way'}"]


def test_only_status_ok_is_an_answer(session):
    statuses = {
        "'fine'": ("error", "answered with the status 'fine', should be ok, unsupported or error"),
        "None": ("error", "answered with the status 'None', should be ok, unsupported or error"),
        "'unsupported'": ("missing", "refused: too rough"),
        "'error'": ("error", "too rough"),
    }
    deeds = [f"say(good(request) | {{'status': {status}, 'message': 'too\\nrough'}})" for status in statuses]
    with session(*deeds) as subject:
        assert judged(subject, len(deeds)) == list(statuses.values())


def test_what_is_no_pair_of_numbers_fails(session):
    answers = [
        "[[float('nan'), 0.1], [0.1, 0.2]]",
        "[[0.1, float('inf')], [0.1, 0.2]]",
        "[[0.1, 10**400], [0.1, 0.2]]",
        "[[0.1, 0.2]]",
        "[[0.1, 0.2]] * 3",
        "[[0.1], [0.2]]",
        "[0.1, 0.2]",
        "'ab'",
        "{'0': [0.1, 0.2]}",
        "[[0.1, 'x'], [0.1, 0.2]]",
        "7",
        "None",
        "[]",
        "[{}, {}]",
        "[[[0.1, 0.2], [0.1, 0.2]]]",
        "[['0.1', '0.2'], [0.1, 0.2]]",
        "[[True, False], [0.1, 0.2]]",
        "[[0.1, True], [0.1, 0.2]]",
        "[[[0.1], [True]], [0.1, 0.2]]",
    ]
    with session(*(f"say(good(request) | {{'velocities': {rows}}})" for rows in answers)) as subject:
        for answer, (verdict, message) in zip(answers, judged(subject, len(answers)), strict=True):
            assert (verdict, "velocities" in message) == ("fail", True), answer


def test_wavenumbers_that_are_none_fail(session):
    answers = [
        "5",
        "'ab'",
        "[]",
        "['a', 'b']",
        "[1.0]",
        "[1.0, None]",
        "[0.5, float('nan')]",
        "['0.5', '1.5']",
        "[True, True]",
        "[0.5, True]",
    ]
    with session(*(f"say(good(request) | {{'wavenumbers': {at}}})" for at in answers)) as subject:
        assert [verdict for verdict, _ in judged(subject, len(answers))] == len(answers) * ["fail"]


def test_all_rows_declined_is_no_answer(session):
    with session("say(good(request) | {'velocities': [None, None]})") as subject:
        assert judged(subject) == [("missing", "gave no velocity at any of 2 wavenumbers")]


def test_neither_environment_nor_folder_says_that_this_is_a_test(session, monkeypatch, tmp_path):
    """The caller's own variables stay, whatever they are called."""
    monkeypatch.setenv("PYTEST_CURRENT_TEST", "a test")
    monkeypatch.setenv("LEAKREF_OF_THE_CALLER", "kept")
    deed = "json.dump([dict(os.environ), request['input']], open(HERE + '/seen', 'w')); say(good(request))"
    with session(deed) as subject:
        assert judged(subject) == [("ok", "")]
    seen, given = json.loads((tmp_path / "seen").read_text())
    added = seen.keys() - os.environ.keys()
    assert len(added) == 1
    assert seen["LEAKREF_OF_THE_CALLER"] == "kept"
    assert not [name for name in seen if name.startswith("PYTEST_")]
    folder = Path(given).relative_to(tempfile.gettempdir()).parts[0]
    assert not any(word in text.lower() for word in ("leakref", "test") for text in (*added, folder))


def test_one_row_declined_is_no_failure(session):
    with session("say(good(request) | {'velocities': [None, [0.25, -0.5]]})") as subject:
        answer = subject.extract(np.ones((8, 9, 10)), (1.0, 1.0, 1.0), [0.5, 1.0], window="box")
    assert answer.declined.tolist() == [True, False]


def test_another_path_than_the_one_given_is_an_error_and_a_stray_file(session):
    deed = "other = request['output'] + '-mine'; open(other, 'w').close(); say(good(request) | {'output': other})"
    with session(deed) as subject:
        ((verdict, message),) = judged(subject)
        assert subject.violations == ["extract left in the exchange folder 'run-2/out-mine'"]
    assert (verdict, "should be the path it was given" in message) == ("error", True)


def test_whatever_is_changed_in_the_exchange_folder_is_said(session, tmp_path):
    deeds = {
        "os.chmod(path, 0o644); open(path, 'r+b').write(b'x')": "altered its input in/eta.f64",
        "os.remove(path)": "removed its input in/eta.f64",
        "os.remove(path); os.mkdir(path)": "replaced its input in/eta.f64",
        "os.rename(path, path + '2'); open(path, 'wb').write(open(path + '2', 'rb').read())": (
            "replaced its input in/eta.f64"
        ),
        "open(run + '/new', 'w').close()": "left in the exchange folder 'run-10/new'",
        "os.mkdir(run + '/out/deep'); os.chmod(run + '/out', 0)": "left in the exchange folder 'run-12/out/deep'",
        "os.symlink(HERE, run + '/../link')": "left in the exchange folder 'link'",
        "shutil.rmtree(run)": "removed its input in/x.f64",
        "shutil.rmtree(os.path.dirname(run))": "removed its input in/x.f64",
    }
    before = "import shutil; run = os.path.dirname(request['input']); path = run + '/in/eta.f64'; "
    with session(*(f"{before}{deed}; say(good(request))" for deed in deeds)) as subject:
        for words in deeds.values():
            assert judged(subject) == [("ok", "")]
            assert f"extract {words}" in subject.violations
            subject.violations.clear()
    assert (tmp_path / "program.py").exists()  # a link out of the folder was not followed


def test_inputs_are_read_only(session):
    deed = (
        "path = request['input'] + '/eta.f64'; "
        "say(good(request) if os.stat(path).st_mode & 0o777 == 0o444 else {'id': 2, 'status': 'error'})"
    )
    with session(deed) as subject:
        assert judged(subject) == [("ok", "")]
        assert subject.violations == []


def test_one_that_eats_memory_is_stopped_with_its_offspring_counted(session):
    deed = (
        "if os.fork() == 0:\n    eaten = bytearray(120 << 20)\n"
        "    for n in range(0, len(eaten), 4096): eaten[n] = 1\ntime.sleep(600)"
    )
    with session(deed, memory=100 * 2**20) as subject:
        ((verdict, message),) = judged(subject)
    assert (verdict, "more than the 100 MiB allowed" in message) == ("error", True)


@linux
@pytest.mark.parametrize(
    "file",
    ["os.memfd_create('m')", "os.open(path := f'/dev/shm/{os.getpid()}', os.O_CREAT | os.O_RDWR); os.remove(path)"],
)
def test_files_of_memory_count_though_they_are_not_mapped(session, file):
    deed = f"file = {file}\nfor _ in range(120): os.write(file, bytes(1 << 20))\ntime.sleep(600)"
    with session(deed, memory=100 * 2**20) as subject:
        ((verdict, message),) = judged(subject, patience=60.0)
    assert (verdict, "more than the 100 MiB allowed" in message) == ("error", True)


@linux
def test_memory_that_is_mapped_and_open_counts_once():
    code = (
        "import mmap, os\nf = os.memfd_create('m')\nos.truncate(f, 60 << 20)\nm = mmap.mmap(f, 60 << 20)\n"
        "m.write(bytes(60 << 20))\nprint(flush=True)\ninput()"
    )
    with subprocess.Popen([sys.executable, "-S", "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        process.stdout.readline()
        found = memory.held([psutil.Process(process.pid)])
        process.stdin.close()
    assert 60 < found / 2**20 < 110


@pytest.mark.parametrize("more", [1, 1000, 2**16, 2**30])
def test_what_was_held_is_seen_to_be_more_than_what_is_allowed(more):
    held, allowed = child._told_apart(2**30 + more, 2**30)
    assert float(held) > float(allowed) == 1024


def test_a_name_that_stands_twice_is_no_answer(session):
    deeds = [
        "text = json.dumps(good(request)); print(text[:-1] + ', \"velocities\": []}', flush=True)",
        'text = json.dumps(good(request)); print(text[:-1] + \', "x": {"a": 1, "a": 1}}\', flush=True)',
        'print(\'{"a": 1, "a": 2}\', flush=True); say(good(request))',
    ]
    with session(*deeds) as subject:
        assert judged(subject, len(deeds)) == [
            ("error", "said 'velocities' twice in one object"),
            ("error", "said 'a' twice in one object"),
            ("ok", ""),
        ]


def test_what_is_too_deep_to_be_read_is_no_answer(session):
    deep = "'[' * 900 + ']' * 900"
    with session(f"print('{{\"id\": 2, \"message\": ' + {deep} + '}}', flush=True); say(good(request))") as subject:
        assert judged(subject) == [("ok", "")]


def test_messages_are_cut(session):
    long = "'x\\x1b\\u202e' * 10**5"
    deeds = [
        f"say(good(request) | {{'velocities': [{long}, None]}})",
        f"say(good(request) | {{'status': {long}}})",
        f"say(good(request) | {{'status': 'error', 'message': {long}}})",
        f"say({{'id': {long}}})",
        f"say(good(request) | {{'wavenumbers': {long}}})",
    ]
    with session(*deeds) as subject:
        for verdict, message in judged(subject, len(deeds)):
            assert verdict in ("fail", "error")
            assert len(message) <= 1500
            assert message.isprintable()


def test_one_interrupted_while_it_starts_is_not_waited_for(session):
    program = session(own="time.sleep(600)", start=300.0)
    program.interrupt()  # from another thread, before there is anything to end
    with pytest.raises(HarnessBroken, match="not asked any more"), program:
        pass


def test_a_name_is_taken_as_the_text_it_is(session):
    with session(own="READY['name'] = '<script>alert(1)</script>'") as subject:
        assert subject.declaration.name == "<script>alert(1)</script>"
        assert judged(subject) == [("ok", "")]
    with session(own="READY['name'] = 'bell\\x07' + 'x' * 10**6") as subject:
        assert subject.declaration.name == "bell " + "x" * 112 + "..."


def test_three_breaches_in_a_row_are_the_end(session, tmp_path):
    # runs 2 and 3 end it, 4 is good, 5 to 7 end it, and 8 and 9 are not even sent
    own = "def good(request, good=good): return good(request) if request['id'] in (1, 4) else os._exit(9)"
    with session(own=own) as subject:
        found = [ask(subject) for _ in range(8)]
    ended = ("error", "ended by itself, with exit status 9")
    assert found[:6] == [ended, ended, ("ok", ""), ended, ended, ended]
    assert (
        found[6]
        == found[7]
        == (
            "error",
            "is not asked any more after 3 breaches in a row, the last of which was "
            "that it ended by itself, with exit status 9",
        )
    )
    assert starts(tmp_path) == 5


def test_a_start_that_fails_is_a_breach_too(session):
    own = "READY['version'] = str(os.getpid())"
    with session("os._exit(0)", own=own) as subject:
        assert ask(subject)[0] == "error"
        assert ask(subject) == ("error", "declared something else when it was started again")
    own = "READY['axes'] = 'xyt' if not os.path.exists(HERE + '/starts') else 7"
    (Path(subject.command[-1]).parent / "starts").unlink()
    with session("os._exit(0)", own=own) as subject:
        assert ask(subject)[0] == "error"
        assert "declares axes" in ask(subject)[1]
        os.remove(subject.command[-1])
        subject.command[0] = "./no-such-program"
        assert "could not be started again: './no-such-program'" in ask(subject)[1]
        assert "is not asked any more" in ask(subject)[1]


@pytest.mark.parametrize(
    ("own", "words"),
    [
        ("def good(request): os._exit(2)", "exit status 2"),
        ("def good(request): time.sleep(600)", "gave no answer within 0.7 s"),
        ("def good(request): return {'id': 1, 'status': 'error', 'message': 'too small'}", "too small"),
        ("def good(request, good=good): return good(request) | {'id': True}", "to the request with id 1"),
        ("raise SystemExit('usage: program FILE')", "usage: program FILE"),
        ("print('usage: program FILE'); sys.exit()", "usage: program FILE"),
        ("READY['protocol'] = 2", '"protocol": 1'),
        ("READY['op'] = 'hello'", '"op": "ready"'),
        ("READY['axes'] = ['x']", "declares axes"),
        ("CAN['extract']['windows'] = ['box', 'box']", "each once"),
        (
            "def say(message): os.write(1, b'\\xef\\xbb\\xbf' + json.dumps(message).encode() + b'\\n'); os._exit(0)",
            "a line begins with a byte-order mark, ef bb bf",
        ),
        (
            "def say(message): os.write(1, (json.dumps(message) + '\\n').encode('utf-16')); os._exit(0)",
            "a line begins with a byte-order mark, ff fe",
        ),
        ("def say(message): os.write(1, (json.dumps(message) + '\\n').encode('utf-16-le')); os._exit(0)", "UTF-16?"),
        (
            "def say(message): os.write(2, b'words'); os.write(1, b'{\"op\": \"ready\\xe4\"}\\n'); os._exit(0)",
            "a line is not UTF-8: e4 at byte 13",
        ),
        (
            'def ready(): print(json.dumps(READY)[:-1] + \', "axes": "txy", "axes": "xyt"}\', flush=True)',
            "said 'axes' twice in one object",
        ),
        ("CAN['extract']['windows'] = 5", "declares windows"),
    ],
)
def test_one_that_cannot_answer_at_all_is_a_broken_harness(session, own, words):
    program = session(own=own, run=0.7 if "600" in own else 60)
    with pytest.raises(HarnessBroken, match="does not answer") as broken, program:
        pass
    assert words in str(broken.value)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("axes", "abc"),
        ("axes", ["x"]),
        ("can", []),
        ("can", {}),
        ("can", {"extract": 7}),
        ("can", {"dance": {}}),
        ("fixed", 5),
        ("fixed", "gravity"),
        ("fixed", [5]),
        ("format", "xml"),
        ("units", None),
        ("can", {"extract": {"windows": 5}}),
        ("can", {"extract": {"methods": [[]]}}),
        ("can", {"extract": {"methods": []}}),
        ("can", {"spectrum": {"windows": {}}}),
        ("can", {"window": {"names": "hann"}}),
        ("can", {"extract": {"resolves": []}}),
        ("fixed", ["dy", "dy"]),
        ("can", {"extract": {"methods": ["nsp", "ls", "nsp"]}}),
        ("can", {"extract": {"windows": ["hann", "hann\u202e"]}}),
        ("can", {"window": {"names": ["hann", "hann"]}}),
        ("can", {"extract": {"methods": ["\u202e"]}}),
        ("cube", 5),
        ("cube", {"smallest": 5}),
        ("cube", {"smallest": [8, 8]}),
        ("cube", {"smallest": [8, 8, 0]}),
        ("cube", {"smallest": [8, 8, True]}),
        ("cube", {"smallest": [8, 8, 8.0]}),
        ("cube", {"smallest": "888"}),
    ],
)
def test_a_declaration_that_makes_no_sense_is_refused(name, value):
    with pytest.raises(Unanswered, match="declares"):
        Declaration.read({name: value})


def test_declared_words_can_be_printed_anywhere():
    bad, good = "a\x1b[31m\u202e\u2066\n" + "b" * 10**5, "a [31m " + "b" * 110 + "..."
    read = Declaration.read(
        {
            "name": bad,
            "version": bad,
            "fixed": [bad],
            "can": {
                "extract": {"methods": [bad], "windows": [bad], bad: {bad: [bad, 1, None]}},
                "window": {"names": [bad]},
            },
        }
    )
    assert (read.name, read.version, read.fixed) == (good, good, (good,))
    assert read.can == {
        "extract": {"methods": [good], "windows": [good], good: {good: [good, 1, None]}},
        "window": {"names": [good]},
    }


def test_a_bad_first_answer_is_the_implementations_own_fault(session):
    own = (
        "def good(request, good=good):\n"
        "    return good(request) | ({'velocities': [[float('nan'), 0]]} if request['id'] == 1 else {})"
    )
    with session(own=own) as subject:
        assert ask(subject) == ("ok", "")


def test_silence_at_the_start_is_a_broken_harness(session):
    with pytest.raises(HarnessBroken, match=r"gave no answer within 0.4 s"), session(own="time.sleep(600)", start=0.4):
        pass


@pytest.mark.parametrize("command", [["./no-such-program"], ["."], ["a\0b"]])
def test_one_that_cannot_be_started_is_wrong_use(left_behind, command):
    with pytest.raises(LeakrefError, match="cannot be started") as refused, connect(command=command):
        pass
    assert not isinstance(refused.value, HarnessBroken)


def test_a_target_or_a_command():
    for arguments in ({}, {"target": "reference", "command": ["program"]}, {"command": []}):
        with pytest.raises(LeakrefError, match="target"):
            connect(**arguments)


def test_what_is_kept(session, tmp_path):
    with session(keep=tmp_path / "kept") as subject:
        assert judged(subject) == [("ok", "")]
        assert subject.violations == []
    (kept,) = (tmp_path / "kept").iterdir()
    request, answer = (json.loads((kept / "run-2" / f"{name}.json").read_text()) for name in ("request", "answer"))
    assert request["parameters"]["shapes"] == {"eta": [8, 9, 10], "x": [8], "y": [9], "t": [10]}
    assert answer["velocities"] == [[0.25, -0.5]] * 2
    assert (Path(request["input"]) / "eta.f64").stat().st_size == 8 * 8 * 9 * 10


def test_two_at_once(session, tmp_path):
    found = {}
    session("os._exit(0)")  # writes the program

    def work(name):
        with ProcessSubject([sys.executable, "-S", str(tmp_path / "program.py")]) as subject:
            found[name] = [ask(subject)[0] for _ in range(5)]

    threads = [threading.Thread(target=work, args=(name,)) for name in "ab"]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert found == {name: ["error", "ok", "ok", "ok", "ok"] for name in "ab"}


def test_another_thread_need_not_wait(session, tmp_path):
    with session("open(HERE + '/asked', 'w').close(); time.sleep(600)") as subject:

        def interrupt():
            while not (tmp_path / "asked").exists():
                time.sleep(0.01)
            subject.interrupt()

        thread = threading.Thread(target=interrupt)
        thread.start()
        assert ask(subject)[1] == "was ended by signal 9 (SIGKILL)"
        thread.join()
        assert ask(subject)[1].startswith("is not asked any more")
    assert starts(tmp_path) == 1


@pytest.mark.skipif(os.name != "posix", reason="Ctrl-C is sent as a signal")
def test_nothing_is_left_when_we_are_interrupted(session, tmp_path):
    session("linger(session=True); open(HERE + '/asked', 'w').close(); time.sleep(600)", own=OFFSPRING)
    ours = tmp_path / "ours.py"
    ours.write_text(
        "import signal, sys, tempfile\nimport numpy as np\n"
        "from leakref.certify.subject.protocol import ProcessSubject\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)  # a job in the background is started to ignore it\n"
        f"tempfile.tempdir = {tempfile.tempdir!r}\n"
        f"with ProcessSubject([sys.executable, '-S', {str(tmp_path / 'program.py')!r}]) as subject:\n"
        "    subject.extract(np.ones((4, 4, 4)), (1, 1, 1), [1.0], window='box')\n"
    )
    with subprocess.Popen([sys.executable, str(ours)], stderr=subprocess.PIPE, text=True) as process:
        end = time.monotonic() + 60
        while not (tmp_path / "asked").exists() and process.poll() is None and time.monotonic() < end:
            time.sleep(0.02)
        assert list(Path(tempfile.tempdir).iterdir())
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)
    assert "KeyboardInterrupt" in said
