"""A program that is given lines and gives lines: in a session of its own, watched, and ended with all its offspring.

Three threads stand between us and the program: one writes, one reads its standard output, one its standard error; so
that it can neither fill a pipe that nobody empties nor stop us by not reading. It speaks no protocol but that a message
is an object in JSON with `op` or `id`; everything else it prints is kept as its last words. What messages mean is for
`protocol`.
"""

from __future__ import annotations

import json
import os
import queue
import signal
import socket
import subprocess
import sys
import threading
import time
from collections import Counter, deque
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

import psutil

from leakref._base import refusal
from leakref._output import dump
from leakref.certify.subject import guardian, memory
from leakref.certify.subject.exchange import too_deep
from leakref.certify.verdict import Unanswered, Verdict, printable

__all__ = ["Breach", "Child"]

LONGEST = 1 << 22
"""Bytes of a line: what goes on for longer is dropped up to its end."""
_CHUNK, _UNREAD, _TAIL = 1 << 16, 16, 1 << 12
_POLL = 0.05  # seconds between two looks at the memory
_GRACE = 2.0  # seconds to end after `stop`
_PATIENCE = 60.0  # seconds for the guardian to be there, on a busy machine
_ROUNDS = 60  # of killing what is left: it may fork while it is looked for
_MARK = "SESSION_FILES"  # in the environment: handed down to whatever it starts; not to tell that this is a test


class Breach(Unanswered):
    """It broke the protocol or a limit, or is gone: it has to be started again.

    It is raised for silence beyond the limit, too much memory, an exit, and whatever is said out of turn. `protocol`
    ends the program on it and counts it; the check that asked sees the Unanswered.
    """


Message = dict[str, Any] | Breach


class Child:
    """A running program, started from an argument list without a shell. `mark` is a text no other process has.

    `belongings` is a folder that goes with this process, if it should be killed.

    On Linux a guardian starts it, which ends with it and as it does: what becomes an orphan stays below the guardian,
    and it ends them all if this process is gone, however it went. Raises LeakrefError if it cannot be started at all.

    `folder` is where it runs. The environment is ours, with `mark` in it, by which offspring are found that have left
    the session.
    """

    def __init__(self, command: Sequence[str], folder: Path | None, mark: str, belongings: str = "") -> None:
        self._mark, self._belongings = mark, belongings
        self._guardians: set[psutil.Process] = set()
        self._control: socket.socket | None = None
        try:
            self._popen = (self._guarded if sys.platform == "linux" else self._started)(command, folder)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise refusal(
                "certify",
                f"{printable(command[0])!r} cannot be started ({reason})",
                "give the program and its arguments as in a shell, with a path if need be",
                error,
            ) from None
        self._process = psutil.Process(self._popen.pid)
        self._guardians |= {self._process} if self._control else set()
        self._seen = {self._process}
        self._batches: queue.Queue[list[Message] | None] = queue.Queue()
        self._waiting: deque[Message] = deque()
        self._silent = False  # its standard output has ended
        self._noise: deque[str] = deque(maxlen=20)
        self._unreadable = ""
        self._errors = b""
        self._threads = [
            threading.Thread(target=work, args=(stream,), daemon=True)
            for work, stream in ((self._read_lines, self._popen.stdout), (self._read_errors, self._popen.stderr))
        ]
        for thread in self._threads:
            thread.start()

    def _started(self, command: Sequence[str], folder: Path | None, **how: Any) -> subprocess.Popen[bytes]:
        group: dict[str, Any] = (
            {"start_new_session": True}
            if os.name == "posix"
            else {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}  # type: ignore[attr-defined]  # Windows
        )
        return subprocess.Popen(
            list(command),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            bufsize=0,
            cwd=folder,
            env={name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
            | {_MARK: self._mark},
            **group,
            **how,
        )

    def _guarded(self, command: Sequence[str], folder: Path | None) -> subprocess.Popen[bytes]:
        """Likewise, by a guardian. It lives as long as the socket to it is open here, and no other process has it."""
        words = [os.fsencode(word) for word in command]
        if any(b"\0" in word for word in words):
            raise ValueError("embedded null byte")
        self._control, theirs = socket.socketpair()
        with theirs:
            number = theirs.fileno()
            popen = self._started(
                [sys.executable, "-I", "-S", guardian.__file__, str(number)], folder, pass_fds=(number,)
            )
        said = b"\0".join([os.fsencode(self._belongings), *words])
        try:
            self._control.settimeout(_PATIENCE)
            self._control.sendall(len(said).to_bytes(8, "big") + said)
            told = self._control.recv(8, socket.MSG_WAITALL).ljust(8, b"\1")
            if fault := int.from_bytes(told[:4], "big"):
                raise OSError(fault, os.strerror(fault))
            with suppress(psutil.Error):
                self._guardians.add(psutil.Process(int.from_bytes(told[4:], "big")))
        except BaseException:
            self._control.close()
            with popen:  # it ends now
                pass
            raise
        return popen

    # ------------------------------------------------------------ talking

    def send(self, message: Mapping[str, Any]) -> None:
        """A line to its standard input, by a thread: a program that does not read must not hold us up.

        It returns at once. That the program has gone shows when its answer is waited for.
        """
        writer = threading.Thread(target=self._write, args=(dump(message).encode() + b"\n",), daemon=True)
        writer.start()
        self._threads = [*(thread for thread in self._threads if thread.is_alive()), writer]

    def receive(self, seconds: float, limit: float) -> dict[str, Any]:
        """Its next message, an object with `op` or `id`. Raises Breach after `seconds`, or above `limit` bytes."""
        end = time.monotonic() + seconds
        while not self._waiting:
            gone, left = self._silent or self._ended(), end - time.monotonic()
            if left <= 0 and not gone:
                raise Breach(Verdict.TIMEOUT, f"gave no answer within {seconds:g} s")
            if not self._gather(min(max(left, 0.0), _POLL)):
                if gone:
                    raise Breach(Verdict.ERROR, self._farewell())
                if (held := self._held()) > limit:
                    is_, allowed = _told_apart(held, limit)
                    raise Breach(
                        Verdict.ERROR,
                        f"held {is_} MiB of memory with its offspring, more than the {allowed} MiB allowed",
                    )
        message = self._waiting.popleft()
        if isinstance(message, Breach):
            raise message
        return message

    def unasked(self) -> list[Message]:
        """What it has said since the last `receive`, without being asked."""
        while self._gather(0.0):
            pass
        said = list(self._waiting)
        self._waiting.clear()
        return said

    def words(self) -> str:
        """The last of what it wrote to standard error, or else of what it printed beside the protocol; maybe empty.

        Before it what kept a line from being read as one of the protocol: that cannot be seen in the line itself. At
        most three lines, joined by bars and cleaned by `printable`.
        """
        lines = self._errors.decode("utf-8", "replace").strip().splitlines()[-3:] or list(self._noise)[-3:]
        return printable(" | ".join([*[self._unreadable] * bool(self._unreadable), *lines]))

    def _gather(self, seconds: float) -> bool:
        """Wait for the next messages and keep them; whether there were any."""
        try:
            batch = self._batches.get(timeout=seconds) if seconds else self._batches.get_nowait()
        except queue.Empty:
            return False
        self._silent |= batch is None
        self._waiting.extend(batch or ())
        return batch is not None

    # ------------------------------------------------------------ threads, one a stream

    def _write(self, line: bytes) -> None:
        assert self._popen.stdin
        with suppress(OSError, ValueError):  # it may be gone: that is seen where its answer is waited for
            while line:
                line = line[self._popen.stdin.write(line) :]

    def _read_errors(self, stream: BinaryIO) -> None:
        with stream:
            while chunk := stream.read(_CHUNK):
                self._errors = (self._errors + chunk)[-_TAIL:]

    def _read_lines(self, stream: BinaryIO) -> None:
        """Messages of one read together: what was written in one go is never seen in part."""
        begun, dropping = b"", False
        with stream:
            while chunk := stream.read(_CHUNK):
                *lines, begun = (begun + chunk).split(b"\n")
                if lines and dropping:
                    del lines[0]
                    dropping = False
                if len(begun) > LONGEST or dropping:
                    if not dropping:
                        self._noise.append(f"(a line of more than {LONGEST} bytes)")
                    begun, dropping = b"", True
                messages = [message for line in lines if (message := self._message(line))]
                if messages and self._batches.qsize() < _UNREAD:  # whoever says more without being asked is out anyway
                    self._batches.put(messages)
        self._batches.put(None)

    def _message(self, line: bytes) -> Message | None:
        """The object on a line; None, and a note of it, if it is not one with `op` or `id`."""
        message: Any = None
        repeated: list[str] = []
        try:
            text = line.decode("utf-8")
            if text.lstrip()[:1] in ("{", "\ufeff", "\0"):
                message = json.loads(text, parse_int=_whole, object_pairs_hook=partial(_object, repeated))
        except (ValueError, RecursionError):
            self._unreadable = _encoding(line) or self._unreadable
        if isinstance(message, dict) and ("op" in message or "id" in message) and not too_deep(message):
            return Breach(Verdict.ERROR, f"said {repeated[0]!r} twice in one object") if repeated else message
        self._noise.append(line[:300].decode("utf-8", "replace"))
        return None

    # ------------------------------------------------------------ watching and ending

    def _ended(self) -> bool:
        """Whether the program itself has ended, without waiting for it: `kill` says why."""
        try:
            return self._process.status() in (psutil.STATUS_ZOMBIE, psutil.STATUS_DEAD)
        except psutil.Error:
            return True

    def _family(self) -> set[psutil.Process]:
        """The program and its offspring; those once seen to be so count even where a parent is gone."""
        found: set[psutil.Process] = {self._process}
        for start in (self._process, *self._seen):
            if start not in found or start is self._process:
                with suppress(psutil.Error):
                    found |= {start, *start.children(recursive=True)}
        self._seen = {process for process in found if process.is_running()}
        return self._seen

    def _held(self) -> int:
        """Bytes of memory of the program and its offspring."""
        return memory.held(self._family() - self._guardians)

    def _alive(self) -> list[psutil.Process]:
        """All that is left of it: its family, its session, and whoever carries its mark."""
        found = set(self._family())
        for number in psutil.pids():
            with suppress(psutil.Error, OSError):
                process = psutil.Process(number)
                if (os.name == "posix" and os.getsid(number) == self._popen.pid) or process.environ().get(
                    _MARK
                ) == self._mark:
                    found.add(process)
        return [process for process in found if _runs(process)]

    def _farewell(self) -> str:
        """How it went, once it did not answer and never will."""
        for _ in range(40):  # its output may close a little before it ends
            if self._ended():
                break
            time.sleep(_POLL / 2)
        by_itself = self._ended()
        self.kill()
        code = self._popen.returncode
        if not by_itself:
            return "closed its standard output"
        if code is not None and code < 0:
            with suppress(ValueError):
                return f"was ended by signal {-code} ({signal.Signals(-code).name})"
        return f"ended by itself, with exit status {code}"

    def kill(self) -> None:
        """End it with all its offspring, at once. Its number is its own until it is waited for, here at the end."""
        if self._popen.returncode is not None:
            return
        if self._control:
            with suppress(OSError):
                self._control.send(b".")  # we are here: what belongs to us stays
            self._control.close()  # the guardian does it, unless the program has done something to it
            self._wait(_GRACE)
        for n in range(_ROUNDS):
            left = self._alive()
            if not left:
                break
            if self._control and len(left) > 1:  # the guardian last: it keeps the others together
                left = [process for process in left if process != self._process]
            elif os.name == "posix":
                with suppress(OSError):
                    os.killpg(self._popen.pid, signal.SIGKILL)
            for process in left:
                with suppress(psutil.Error):
                    process.kill()
            time.sleep(min(0.002 * 2**n, 0.1))
        with suppress(subprocess.TimeoutExpired):
            self._popen.wait(_GRACE)
        for thread in self._threads:
            thread.join(_GRACE)
        self._close_input()

    def _wait(self, seconds: float) -> None:
        """For its end, or as long as that; without asking for its status."""
        end, pause = time.monotonic() + seconds, 0.001
        while not self._ended() and time.monotonic() < end:
            time.sleep(pause)
            pause = min(2 * pause, 0.02)

    def _close_input(self) -> None:
        assert self._popen.stdin
        with suppress(OSError):
            self._popen.stdin.close()

    def stop(self) -> None:
        """Ask it to end, give it a little time, and end what is left."""
        self.send({"op": "stop"})
        self._threads[-1].join(_GRACE)
        if not self._threads[-1].is_alive():
            self._close_input()
        self._wait(_GRACE)
        self.kill()


def _runs(process: psutil.Process) -> bool:
    try:
        return process.is_running() and process.status() not in (psutil.STATUS_ZOMBIE, psutil.STATUS_DEAD)
    except psutil.Error:
        return False


def _told_apart(held: float, limit: float) -> tuple[str, str]:
    """Two amounts in MiB, the first in as many digits as it takes to see that it is larger."""
    allowed = f"{limit / 2**20:.6g}"
    texts = [f"{held / 2**20:.{digits}f}" for digits in range(10)]
    return next((text for text in texts if float(text) > float(allowed)), texts[-1]), allowed


def _object(repeated: list[str], pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object in JSON; names that stand in it twice are noted: readers differ in which of the values they take."""
    found = dict(pairs)
    if len(found) < len(pairs):
        repeated += [name for name, count in Counter(name for name, _ in pairs).items() if count > 1]
    return found


def _encoding(line: bytes) -> str:
    """What keeps the characters of a line from being UTF-8 as it should be; empty if nothing does."""
    if mark := next((m for m in (b"\xef\xbb\xbf", b"\xff\xfe", b"\xfe\xff") if line.startswith(m)), b""):
        return f"(a line begins with a byte-order mark, {mark.hex(' ')})"
    try:
        line.decode("utf-8")
    except UnicodeDecodeError as error:
        return f"(a line is not UTF-8: {line[error.start]:02x} at byte {error.start})"
    return "(a line holds zero bytes: UTF-16?)" if b"\0" in line else ""


def _whole(digits: str) -> int | float:
    """A whole number in JSON; one too long for an id becomes a float, infinite if need be, as in other languages."""
    return int(digits) if len(digits) < 16 else float(digits)
