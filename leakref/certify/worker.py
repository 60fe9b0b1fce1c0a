"""The program in which a Python target is judged: `python -m leakref.certify.worker TARGET`, protocol 1 with npz (guide
protocol, sections 5 and 6).

With a second word it says first when all of ours is loaded, which takes seconds on a busy machine.

It stands between a Python object and the protocol, so that such an object is judged like any other program: with
limits, and without a way to take the command down with it. `targets.connect` starts it; it can be started by hand as
well, to see what a target answers. It judges nothing.
"""

from __future__ import annotations

import faulthandler
import json
import os
import sys
import traceback
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import IO, Any

import numpy as np

from leakref._base import LeakrefError
from leakref._output import plain
from leakref.certify import targets
from leakref.certify.subject.inprocess import call, describe, offer
from leakref.certify.verdict import Unanswered, Verdict

__all__ = ["answer", "main", "ready"]

Calls = Mapping[str, Callable[..., Any]]


def main(target: str, *told: str) -> None:
    """Load `target` and answer requests on standard input until `stop` or its end.

    What the target itself prints goes to standard error, and it reads nothing: the protocol has both to itself.

    `told` is the second word of the command line, if there is one. Every request gets one line of JSON back; after
    `failed`, `stop` or anything unknown it ends.
    """
    faulthandler.enable()
    requests, answers = _taken(0, "r"), _taken(1, "w")
    calls: Calls = {}
    for line in requests:
        request = json.loads(line)
        if request["op"] == "start":
            if told:
                print(json.dumps({"op": "loading"}), file=answers, flush=True)
            said, calls = ready(target)
        elif request["op"] == "run":
            said = answer(calls, request)
        else:
            break
        print(json.dumps(said, default=_simple), file=answers, flush=True)
        if said.get("op") == "failed":
            break


def _taken(number: int, mode: str) -> IO[str]:
    """Standard input or output for the protocol alone; in its place nothing, or standard error. So neither a print of
    the target nor a library that reads can spoil the protocol.
    """
    stream = os.fdopen(os.dup(number), mode, encoding="utf-8", newline="\n")
    replacement = os.open(os.devnull, os.O_RDONLY) if mode == "r" else os.dup(2)
    os.dup2(replacement, number)
    os.close(replacement)
    return stream


def ready(target: str) -> tuple[dict[str, Any], Calls]:
    """What is said at the start, `ready` or `failed` with a fault and a remedy, and the stages that are offered.

    Whatever the target raises on import or in `describe` is caught: its traceback goes to standard error, its first
    words into the fault. `broken` is set where the declaration or the offer itself is wrong (Unanswered), which the
    command reports as a target that could not be judged.
    """
    try:
        implementation = targets.load(target)
        calls = offer(implementation)
        given = dict(implementation.describe()) if hasattr(implementation, "describe") else {}
        declaration = describe(given, calls, target)
        said = plain({"op": "ready", "protocol": 1, **declaration.record(), "format": "npz"})
        json.dumps(said)
    except LeakrefError as error:
        return {"op": "failed", "fault": error.fault, "remedy": error.remedy}, {}
    except (Exception, SystemExit) as error:
        traceback.print_exc()
        fault = str(error) if isinstance(error, Unanswered) else f"{type(error).__name__}: {error}"
        return {
            "op": "failed",
            "broken": isinstance(error, Unanswered),
            "fault": f"{target} cannot be used: {fault}",
            "remedy": "see that it can be imported, and what its describe() returns",
        }, {}
    return said, calls


def answer(calls: Calls, request: Mapping[str, Any]) -> dict[str, Any]:
    """The answer to a request; a fault of the target is in its status.

    `request` holds `id`, `stage`, the paths `input` and `output`, and `parameters` (guide protocol, section 4).
    Velocities come back on the line, all other outputs in an npz file. NotImplementedError means `unsupported`, any
    other exception `error`. Inputs that the call changed in memory are named under `altered`, since the file cannot
    show that.
    """
    stage, said = str(request["stage"]), {"id": request["id"], "status": "ok"}
    with np.load(request["input"], allow_pickle=False) as stored:
        given = {name: stored[name] for name in stored.files}
    arrays = {name: value.copy() for name, value in given.items()}
    try:
        if stage not in calls:
            raise NotImplementedError(f"does not offer {stage}")
        found = call(calls[stage], stage, arrays, request["parameters"])
        if stage == "extract":
            said |= {name: _rows(value) for name, value in found.items() if name in ("velocities", "wavenumbers")}
        else:
            _save(Path(request["output"]), found)
    except NotImplementedError as error:
        said |= {"status": "unsupported", "message": str(error) or f"{stage} is not implemented"}
    except Unanswered as nothing:
        status = "unsupported" if nothing.verdict is Verdict.UNSUPPORTED else "error"
        said |= {"status": status, "message": nothing.message}
    except (Exception, SystemExit) as error:
        traceback.print_exc()
        said |= {"status": "error", "message": f"{type(error).__name__}: {error}"}
    altered = [name for name, value in given.items() if not np.array_equal(value, arrays[name], equal_nan=True)]
    return said | ({"altered": altered} if altered else {})


def _rows(value: Any) -> Any:
    """Rows for JSON; those that are masked are null."""
    if np.ma.isMaskedArray(value) and np.ndim(value):
        return [None if np.ma.getmaskarray(row).any() else np.asarray(row).tolist() for row in value]
    return value


def _simple(value: Any) -> Any:
    """What JSON does not know: arrays as lists, numbers as floats, and anything else as the words for it."""
    if hasattr(value, "tolist"):
        return value.tolist()
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        return repr(value)


def _save(path: Path, found: Mapping[str, Any]) -> None:
    """The output variables as float64 or complex128, so that they can be read elsewhere; what is masked is NaN. It goes
    by `np.savez`, to the path that was asked for.
    """
    values = {}
    for name, value in found.items():
        array = np.ma.masked_array(value)
        wide = array.astype(np.complex128 if array.dtype.kind == "c" else np.float64)
        values[name] = np.ma.filled(wide, np.nan)
    np.savez(path, **values)  # type: ignore[arg-type]  # numpy says bool of all keywords


if __name__ == "__main__":
    main(*sys.argv[1:])
