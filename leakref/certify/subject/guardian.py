"""Linux: starts a program, and ends all that has come of it when the program ends, or whoever asked for it is gone.

It is run as a script of its own, and imports nothing of the package: `guardian.py N`, N the number of a socket. On it
come a folder and the argument list, with their length before them; it answers with the error number of a start that
failed, or 0, and the number of the process that waits for the program. Orphans of the program, in whatever session and
environment, become its children, and there is nobody else for whom it could reap them. It exits as the program did.

There are two of it, one the parent of the other, so that a program that kills its parent does not get away with what it
has started. If the socket closes without a word before, whoever held it is gone, and the folder with it.
"""

import ctypes
import os
import resource
import select
import shutil
import signal
import socket
import sys
import time
from contextlib import suppress

__all__ = ["guard"]

_DEATH_SIGNAL, _SUBREAPER = 1, 36  # of prctl
_LONGEST = 10.0  # seconds of killing, at most: one that hangs in a device does not die


def guard(control: socket.socket) -> int:
    """Let a second one start the program and wait; its status as `waitpid` gives it.

    `control` is the socket, from which the command is read first. Signals that ask it to end are received and do
    nothing: it ends when the program does or when the socket closes. Returned is a status for `_exit_as`.
    """
    folder, *command = _command(control)
    ctypes.CDLL(None).prctl(_SUBREAPER, 1, 0, 0, 0)
    for number in (signal.SIGHUP, signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: None)  # not ignored: that would be handed down to the program
    inner = os.fork()
    if inner == 0:
        _exit_as(_watch(control, command, folder))
    control.close()
    _close_streams()
    status = os.waitpid(inner, 0)[1]
    _end_all({})  # what the second one could not end, since the program has killed it
    return status


def _watch(control: socket.socket, command: list[bytes], folder: bytes) -> int:
    """Start the program and wait; its status, or 0."""
    ctypes.CDLL(None).prctl(_SUBREAPER, 1, 0, 0, 0)
    wakeup, writer = os.pipe()
    os.set_blocking(writer, False)
    signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    program, fault = _started(command)
    control.sendall(fault.to_bytes(4, "big") + os.getpid().to_bytes(4, "big"))
    _close_streams()
    ended: dict[int, int] = {}
    forsaken = False
    while not fault and program not in ended:
        heard = select.select([control.fileno(), wakeup], [], [])[0]
        if wakeup in heard:
            os.read(wakeup, 4096)
        if control.fileno() in heard:  # a last word, or it is closed
            with suppress(OSError):
                forsaken = not control.recv(1)
            break
        _reap(ended)
    _end_all(ended)
    if forsaken and folder:
        shutil.rmtree(folder, ignore_errors=True)
    return ended.get(program, 0)


def _close_streams() -> None:
    """They are the program's alone, and are to end with it."""
    for stream in range(3):
        os.dup2(os.open(os.devnull, os.O_RDWR), stream)


def _command(control: socket.socket) -> list[bytes]:
    """The folder and the argument list, as bytes: what is handed over is not decoded."""
    with control.makefile("rb") as stream:
        return stream.read(int.from_bytes(stream.read(8), "big")).split(b"\0")


def _started(command: list[bytes]) -> tuple[int, int]:
    """The number of the program's process, in a session of its own, and of the error that kept it from starting. The
    program is killed when this process ends, which the kernel sees to; should it have ended already the program is not
    run at all.
    """
    reader, writer = os.pipe()
    guardian = os.getpid()
    process = os.fork()
    if process == 0:
        try:
            os.setsid()
            ctypes.CDLL(None).prctl(_DEATH_SIGNAL, signal.SIGKILL, 0, 0, 0)
            if os.getppid() == guardian:
                for number in (signal.SIGPIPE, signal.SIGXFSZ):  # which Python ignores
                    signal.signal(number, signal.SIG_DFL)
                os.execvp(command[0], command)
        except OSError as error:
            os.write(writer, (error.errno or 1).to_bytes(4, "big"))
        finally:
            os._exit(127)
    os.close(writer)
    with open(reader, "rb") as stream:
        return process, int.from_bytes(stream.read(), "big")


def _reap(ended: dict[int, int]) -> bool:
    """Take note of all that have ended; whether there are any others."""
    with suppress(ChildProcessError):
        while (found := os.waitpid(-1, os.WNOHANG))[0]:
            ended.update([found])
        return True
    return False


def _end_all(ended: dict[int, int]) -> None:
    """Kill what there is until there is nothing: whatever loses its parent comes here, and may fork meanwhile."""
    end, pause = time.monotonic() + _LONGEST, 0.0
    while _reap(ended) and time.monotonic() < end:
        for process, group in _children():
            with suppress(OSError):
                os.kill(process, signal.SIGKILL)
                if group not in (0, os.getpgrp()):  # at once: a chain of forks is faster than we are
                    os.killpg(group, signal.SIGKILL)
        time.sleep(pause)
        pause = min(pause + 0.0005, 0.05)


def _children() -> list[tuple[int, int]]:
    """Number and group of each child."""
    found = []
    for name in os.listdir("/proc"):
        if name.isdecimal():
            with suppress(OSError, ValueError), open(f"/proc/{name}/stat", "rb") as stream:
                _, parent, group = stream.read().rpartition(b")")[2].split()[:3]
                if int(parent) == os.getpid():
                    found.append((int(name), int(group)))
    return found


def _exit_as(status: int) -> None:
    """End as a process of this status did, by the same signal if it was one."""
    if os.WIFSIGNALED(status):
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        with suppress(OSError):  # SIGKILL has no other disposition
            signal.signal(os.WTERMSIG(status), signal.SIG_DFL)
        os.kill(os.getpid(), os.WTERMSIG(status))
        signal.pause()
    os._exit(os.WEXITSTATUS(status))


if __name__ == "__main__":
    _exit_as(guard(socket.socket(fileno=int(sys.argv[1]))))
