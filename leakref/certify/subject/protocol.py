"""An implementation in another process: the loop of protocol 1 (guide protocol, section 6), with limits.

`ProcessSubject` holds one program at a time: it starts it, asks one question after the other, and starts it again after
a breach. Files go through `exchange`, lines through `child`. It decides only whether there is an answer in due form;
whether it is right is for the checks. Used by `targets.connect`.

A session, as lines of JSON on the program's standard input (`>`) and output (`<`):

    > {"op": "start", "protocol": 1, "formats": ["mat", "npz", "raw"]}
    < {"op": "ready", "protocol": 1, "units": "si", "format": "npz", "can": {"extract": {}}}
    > {"op": "run", "id": 1, "stage": "extract", "input": "PATH", "output": "PATH", "parameters": {...}}
    < {"id": 1, "status": "ok", "velocities": [[0.1, 0.0], null]}
    > {"op": "stop"}
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from leakref._base import LeakrefError, Trouble
from leakref.certify.subject.answers import accepted
from leakref.certify.subject.child import Breach, Child
from leakref.certify.subject.declaration import Declaration
from leakref.certify.subject.exchange import Exchange
from leakref.certify.subject.frames import OUTPUTS, Subject
from leakref.certify.subject.seas import Sea
from leakref.certify.verdict import Unanswered, Verdict, printable
from leakref.ending import last_resorts
from leakref.grid import Grid
from leakref.sea import aligned_waves
from leakref.synthesis import synthesize

__all__ = ["FORMATS", "PROTOCOL", "STRIKES", "HarnessBroken", "Limits", "ProcessSubject"]

PROTOCOL = 1
"""The version that is spoken; a program that answers with another is refused at the start."""
FORMATS = ("mat", "npz", "raw")
"""Of arrays in files, as they are offered to the program, which chooses one in its declaration."""
STRIKES = 3
"""Breaches in a row after which nothing more is asked."""


class HarnessBroken(LeakrefError):
    """Nothing can be judged: the program does not get as far as answering a first, small question.

    The command then ends with status 3, not judged: such a program has not been found wrong.
    """

    status = 3


@dataclass(frozen=True)
class Limits:
    """Seconds to `start` and to `run`, and bytes of resident `memory` of the program with all it has started.

    `run` is for one request; the clock starts anew with each. Values that are not positive are not looked for here.
    """

    start: float = 30.0
    run: float = 120.0
    memory: float = 8 * 2.0**30

    @classmethod
    def given(cls, timeout: float | None, start: float | None, memory: float, run: float = 120.0) -> Limits:
        """From options: `timeout` is for a run, else `run`, and for the start, unless `start` is; `memory` in GiB.

        None or 0 stands for not given. `run` is the profile's own: the full one has larger cubes.
        """
        return cls(start or timeout or cls.start, timeout or run, int(memory * 2**30))


class ProcessSubject(Subject):
    """A program that speaks protocol 1, as a context: started and tried out on entry, ended on exit with all it left.

    `command` is its argument list, `folder` where it runs (default: here), `keep` a folder in which the files exchanged
    stay; `waves` stand in place of those that it declares; `loading` are seconds until it says that it gets to what is
    its own, where its start begins. On entry LeakrefError if it cannot be started or refuses, HarnessBroken if it does
    not answer. What it changes in the exchange folder, other than its output, is added to `violations`; on exit, what
    it has said after its last answer.

    After `STRIKES` breaches in a row every further question is answered at once with Unanswered (error), so that a
    program that hangs costs three limits and not a hundred. Any proper answer sets the count back.
    """

    def __init__(
        self,
        command: Sequence[str],
        *,
        limits: Limits | None = None,
        keep: Path | None = None,
        folder: Path | None = None,
        loading: float = 0.0,
        waves: Mapping[str, Any] | None = None,
    ) -> None:
        super().__init__(Declaration())
        self._loading, self._waves = loading, waves
        self.command, self.limits, self.keep, self.folder = list(command), limits or Limits(), keep, folder
        self._child: Child | None = None
        self._run = self._strikes = 0
        self._asking = self._interrupted = False
        self._last = ""

    def __enter__(self) -> Self:
        """Start the program and ask it a first small question. HarnessBroken where either fails: then nothing can be
        judged.
        """
        self._exchange = Exchange(self.keep)
        last_resorts.add(self._abandon)
        try:
            what, remedy = (
                "",
                ("see that it speaks protocol 1 (`leakref guide protocol`); `leakref scaffold` writes one that does"),
            )
            try:
                self.declaration = self._start()
                what, remedy = (
                    " a first small question",
                    (
                        "see to that; one that knows square pixels only says "
                        '"fixed": ["dy"], and to what it cannot do "unsupported"'
                    ),
                )
                self._try_out()
            except Unanswered as nothing:
                raise HarnessBroken(
                    "certify", f"the program does not answer{what}: {self._blamed(nothing)}", remedy
                ) from None
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the program and all it has started; remove what was exchanged. It may be called again. What the program
        says unasked at the end is a violation; one that was ended in the middle of a run is not asked.
        """
        try:
            if self._child and not self._asking:
                if said := self._child.unasked():
                    self.violations.append(f"said without being asked: {printable(said[0])}")
                self._child.stop()
        finally:
            try:
                self._end()
            finally:
                self._exchange.close()
                last_resorts.discard(self._abandon)

    def _abandon(self) -> None:
        """The last resort if we are told to end: nothing of it may be left behind."""
        self.interrupt()
        self._exchange.close()

    def interrupt(self) -> None:
        """From another thread: end the program, so that whoever waits for its answer need not. There will be none.
        Nothing is started again afterwards.
        """
        self._interrupted, self._strikes = True, STRIKES
        if child := self._child:
            child.kill()

    # ------------------------------------------------------------ starting

    def _start(self) -> Declaration:
        """Start the program: what it declares. Raises Breach, or LeakrefError where it refuses to start. A worker of
        ours says `loading` when leakref itself is imported, and its start begins to count then. A program that says
        `failed` refuses with words of its own: a HarnessBroken if it says that it is broken, else LeakrefError.
        """
        self._child = child = Child(self.command, self.folder, str(self._exchange.folder), self._exchange.belongings)
        if self._interrupted:  # before it was there to be ended
            child.kill()
            raise Breach(Verdict.ERROR, "is not asked any more")
        self._asking = True
        child.send({"op": "start", "protocol": PROTOCOL, "formats": FORMATS})
        ready = child.receive(max(self.limits.start, self._loading), self.limits.memory)
        if ready.get("op") == "loading":
            ready = child.receive(self.limits.start, self.limits.memory)
        self._asking = False
        if ready.get("op") == "failed":
            refusal = HarnessBroken if ready.get("broken") else LeakrefError
            raise refusal(
                "certify",
                printable(ready.get("fault", ready.get("message", "it failed")), 1000),
                printable(ready.get("remedy", "see that it can be started")),
            )
        if ready.get("op") != "ready" or ready.get("protocol") != PROTOCOL:
            raise Breach(
                Verdict.ERROR,
                f'said {printable(ready)} when it was started, should be "op": "ready" and "protocol": {PROTOCOL}',
            )
        try:
            said = {name: value for name, value in ready.items() if name not in ("op", "protocol")}
            return Declaration.read(
                {**said, "waves": {**(said.get("waves") or {}), **self._waves}} if self._waves else said
            )
        except Unanswered as wrong:
            raise Breach(wrong.verdict, wrong.message) from None

    def _running(self) -> Child:
        """The program, started again if it was ended. A program that declares something else after a restart is in
        breach: findings before and after would be of two codes.
        """
        if self._child is None:
            try:
                declared = self._start()
            except Trouble:
                raise
            except LeakrefError as refusal:
                raise Breach(Verdict.ERROR, f"could not be started again: {refusal.fault}") from None
            if declared != self.declaration:
                raise Breach(Verdict.ERROR, "declared something else when it was started again")
        assert self._child
        if said := self._child.unasked():
            raise Breach(Verdict.ERROR, f"answered twice or without being asked: {printable(said[0])}")
        return self._child

    def _try_out(self) -> None:
        """Ask one small question, of a 16 x 12 x 10 cube, or of the smallest that it takes. Raises Unanswered only
        where there is no proper answer: so that a program that cannot answer at all is told apart from one that answers
        wrongly. The first is not judged.
        """
        declared = self.declaration
        n = declared.multiple
        least = declared.shape or [-(-max(p) // n) * n for p in zip((16, 12, 10), declared.smallest, strict=True)]
        nx, ny, nt = least
        if declared.shape is None:
            nt = max(nt, -(-int(np.ceil(declared.least_duration / (0.8 * declared.scales().time))) // n) * n)
        grid = Grid((nx, ny, nt), (0.9, 0.9 if "dy" in self.declaration.untold else 1.1, 0.8))
        waves, _ = aligned_waves(grid, [(3, 1, 2), (1, 2, 2)], gravity=1.0)
        axes = [grid.samples(axis) for axis in range(3)]
        try:
            if "extract" in declared.can:
                water = replace(self.still(), depth=2.0) if "depth" in declared.told else None  # not 100 / k0 at once
                self.extract(synthesize(waves, *axes), grid.spacing, [1.2], window=declared.windows[0], water=water)
            elif "spectrum" in declared.can:
                self.spectrum(synthesize(waves, *axes), grid.spacing, _first(declared, "spectrum", "windows"))
            elif "synthesize" in declared.can:
                self.synthesize(waves, *axes)
            elif "sea" in declared.can:
                self.sea(Sea(grid, 30.0, 120.0, 3.3, 1e-3, (0.0, 0.0), self.still()), 1)
            else:
                self.window(_first(declared, "window", "names"), 16)
        except Unanswered as nothing:
            if nothing.verdict in (Verdict.ERROR, Verdict.TIMEOUT):
                raise

    # ------------------------------------------------------------ one run

    def _work(self, stage: str, arrays: dict[str, Any], parameters: dict[str, Any]) -> Mapping[str, Any]:
        """One request and its answer. Whatever happens, what was changed in the folder is noted and the folder emptied;
        after a breach the program is ended, and started again with the next question.
        """
        if self._strikes >= STRIKES:
            raise Unanswered(
                Verdict.ERROR,
                f"is not asked any more after {STRIKES} breaches in a row, the last of which was that it {self._last}",
            )
        self._run += 1
        given, output = self._exchange.give(self._run, self.declaration.format, arrays)
        shape = self.shape_of(stage, arrays, parameters)
        if self.declaration.format == "raw":
            shapes = {name: np.shape(value) for name, value in arrays.items()}
            parameters = {**parameters, "shapes": shapes | ({OUTPUTS[stage]: shape} if shape else {})}
        request = {
            "op": "run",
            "id": self._run,
            "stage": stage,
            "input": str(given),
            "output": str(output),
            "parameters": parameters,
        }
        try:
            self._exchange.note("request.json", request)
            answer = self._asked(request)
            if shape:
                return {OUTPUTS[stage]: self._exchange.take(OUTPUTS[stage], shape)}
            return answer
        except Breach as breach:
            said = self._blamed(breach)
            self._exchange.check_space()
            self._end()
            self._strikes += 1
            self._last = breach.message
            raise Unanswered(breach.verdict, said) from None
        finally:
            self.violations += [f"{stage} {change}" for change in self._exchange.changes()]
            self._exchange.clear()

    def _asked(self, request: Mapping[str, Any]) -> dict[str, Any]:
        """The answer to a request, of status ok. Raises Unanswered for the others, Breach if it is none. An error that
        may be for want of room on our disk is looked into first (`Exchange.check_space`), and is then no fault of the
        program's.
        """
        child = self._running()
        self._asking = True
        child.send(request)
        answer = child.receive(self.limits.run, self.limits.memory)
        self._asking = False
        number = answer.get("id")
        if isinstance(number, bool) or number != request["id"]:
            raise Breach(Verdict.ERROR, f"answered {printable(answer)} to the request with id {request['id']}")
        if more := child.unasked():
            raise Breach(Verdict.ERROR, f"answered twice: after the answer came {printable(more[0])}")
        if answer.get("output", request["output"]) != request["output"]:
            raise Breach(
                Verdict.ERROR,
                f"answered with the output {printable(answer['output'])}, should be the path it was given",
            )
        self._strikes = 0
        altered = answer.get("altered")
        self.violations += [
            f"{request['stage']} altered its input {printable(name, 40)}"
            for name in (altered[:9] if isinstance(altered, list) else ())
        ]
        if answer.get("status") == "error":
            self._exchange.check_space()
        found = accepted(answer)
        self._exchange.note("answer.json", answer)
        return found

    def _blamed(self, nothing: Unanswered) -> str:
        """Why there is no answer, with the last words of the program if it still has any to say."""
        words = self._child.words() if self._child else ""
        return nothing.message + f"; its last words: {words}" * bool(words)

    def _end(self) -> None:
        if self._child:
            self._child.kill()
        self._child, self._asking = None, False


def _first(declared: Declaration, stage: str, names: str) -> str:
    """A name that it declares for a stage, for the first small question."""
    return str(next(iter(declared.can[stage].get(names, ())), "hann"))
