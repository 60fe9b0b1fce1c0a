"""What `leakref track ...` does and prints.

Each function is one action of the command, with its exit status: 0 holds, 1 worse, 3 nothing to judge. Words and
colours are here; what is compared with what is in `changes`.
"""

from __future__ import annotations

import shlex
from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from json import loads
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape

from leakref import LeakrefError, runs
from leakref._output import console, dump, envelope, folder, progress_bar, write_whole
from leakref._tables import Table
from leakref.certify.targets import HarnessBroken, Limits, connect
from leakref.golden.beside import noted
from leakref.methods import DEFAULT
from leakref.track import history, tracking
from leakref.track.changes import ALPHA, POWER, VERDICTS, Change, Comparison, compare
from leakref.track.timings import compare_timings, timings
from leakref.track.tracking import Scene, Series

__all__ = ["Request", "run_check", "run_compare", "run_plot", "run_record"]

NOTHING_TO_JUDGE = 3
_RESERVED = ("last", "previous")
_COLOUR = {"worse": "red", "better": "green", "undecided": "yellow", "slower": "red", "faster": "green"}


@dataclass(frozen=True)
class Request:
    """What is to be recorded, as asked for on the command line.

    - `target` or `command`: one of the two, as typed; `path`: of the history.
    - `label`: of the version, else its version or name; `cases`: ids of scenes, else those recorded by default.
    - `realizations`, `first`: how many, and the number of the first.
    - `source`: further files and folders that the target is made of.
    - `timings`, `yardstick`: JSON of pytest-benchmark, and the benchmark that the others are held against.
    - `methods`: of the reference; another target has those it declares.
    - `timeout`, `start`: seconds, None for the defaults; `memory`: GiB; `workers`: processes, for the reference only.
    """

    target: str | None
    command: str | None
    path: Path
    label: str | None = None
    cases: Sequence[str] = ()
    realizations: int = 100
    first: int = 0
    source: Sequence[Path] = ()
    timings: Path | None = None
    yardstick: str | None = None
    timeout: float | None = None
    memory: float = 8.0
    workers: int = 1
    start: float | None = None
    methods: Sequence[str] = DEFAULT


def run_record(request: Request, *, json: bool) -> int:
    """Measure, append, print: 0, or 3 if the target answers nothing (then nothing is recorded).

    LeakrefError is raised for a target and a command, or neither; a label that stands for entries; an unknown case; a
    file of timings without its yardstick; a history that cannot be written.
    """
    words = _words(request)
    timed = _timed(request)
    is_reference = request.target == "reference"
    names = request.cases or (tracking.PAPER if is_reference else tracking.COARSE)
    scenes = [tracking.scene(name) for name in dict.fromkeys(names)]
    numbers = range(request.first, request.first + request.realizations)
    try:
        if is_reference:
            said, series, silent = _reference(scenes, numbers, request)
            source = tracking.source_of_reference()
        else:
            said, series, silent = _any(request, words, scenes, numbers)
            source = (
                tracking.source_of_program(words, request.source)
                if words
                else tracking.source_of(str(request.target), request.source)
            )
    except HarnessBroken as broken:
        console().print(f"[red]Could not judge:[/] {escape(str(broken))}", soft_wrap=True)
        return NOTHING_TO_JUDGE
    for line in silent:
        console().print(f"[yellow]{escape(line)}[/]", soft_wrap=True)
    if not series:
        console().print("[red]Nothing was recorded:[/] the target gave no answer at all.")
        return NOTHING_TO_JUDGE
    label = request.label or str(said["version"] or said["name"])
    target = request.target or str(request.command)
    entry, repaired = history.append(request.path, tracking.fields(label, target, said, source, series, timed))
    noted(request.path)
    if repaired:
        console().print(f"[yellow]{request.path}: {repaired}[/]", soft_wrap=True)
    if json:
        print(dump(envelope("track", True, action="record", entries=[_summary(entry)], silent=silent)))
    else:
        Console().print(_recorded(entry, series))
        Console().print(
            f"Recorded as {escape(str(entry))} of {request.path}; source: {escape(source['of'])}", soft_wrap=True
        )
    return 0


def _words(request: Request) -> list[str]:
    """The command's argument list, empty for a Python target. Raises LeakrefError for wrong use."""
    if bool(request.target) == bool(request.command):
        raise LeakrefError(
            "track",
            f"{'a target and a --command' if request.target else 'no target'} was given",
            'name reference or package.module:object, or pass --command "program arguments"',
        )
    if request.label in _RESERVED or (request.label is not None and not request.label.strip().isprintable()):
        raise LeakrefError(
            "track",
            f"the label {request.label!r} cannot be used",
            "choose another: last and previous stand for entries, and it has to be printable",
        )
    if request.label == "":
        raise LeakrefError("track", "the label is empty", "an empty variable? Leave --label out, or name the version")
    try:
        return shlex.split(request.command) if request.command else []
    except ValueError as error:
        raise LeakrefError("track", f"--command cannot be split ({error})", "quote it as for a shell") from None


def _timed(request: Request) -> dict[str, Any] | None:
    """The timings of a file of pytest-benchmark, None if none is given. Raises LeakrefError if it has no yardstick."""
    if request.timings is None:
        return None
    if request.yardstick is None:
        raise LeakrefError("track", "--timings without --yardstick", "name the benchmark to divide the others by")
    try:
        return timings(loads(request.timings.read_text(encoding="utf-8")), request.yardstick)
    except (OSError, ValueError) as error:
        if isinstance(error, LeakrefError):
            raise
        raise LeakrefError(
            "track",
            f"{request.timings} cannot be read ({error})",
            "write it with `pytest --benchmark-only --benchmark-json FILE`",
        ) from None


Measured = tuple[Mapping[str, Any], list[Series], list[str]]


def _reference(scenes: Sequence[Scene], numbers: range, request: Request) -> Measured:
    """By the compiled twin, over processes."""
    from leakref.chain import reference

    # a pool takes seconds to start, and a hundred realisations of a case on one core take twenty
    with progress_bar("realisations", len(scenes) * len(numbers)) as step, runs.pool(request.workers) as executor:
        series = tracking.measure_reference(
            scenes, numbers, methods=request.methods, executor=executor, after_each=step
        )
    return reference.describe(), series, []


def _any(request: Request, words: Sequence[str], scenes: Sequence[Scene], numbers: range) -> Measured:
    """Any other target, in a process of its own, shown the cubes one after the other. Raises HarnessBroken if it has no
    `extract`, besides what `connect` raises.
    """
    limits = Limits.given(request.timeout, request.start, request.memory)
    with connect(request.target, words, limits=limits) as subject:
        if not subject.offers("extract"):
            raise HarnessBroken("track", "it offers no extract", "bias is that of velocities: offer extract")
        with progress_bar("realisations", len(scenes) * len(numbers)) as step:
            series, silent = tracking.measure(subject, scenes, numbers, after_each=step)
        return subject.declaration.record(), series, silent


def _summary(entry: history.Entry) -> dict[str, Any]:
    """An entry without the errors of single realisations, and whether it is whole."""
    record = {**entry.record}
    record["measurements"] = [
        {name: value for name, value in one.items() if name != "errors"} for one in record.get("measurements", ())
    ]
    return {"line": entry.line, "fault": entry.fault, **record}


def _recorded(entry: history.Entry, series: Sequence[Series]) -> Table:
    """Bias and random part at about four wavenumbers of each series, as a glance at what was recorded."""
    table = Table(title=f"{escape(entry.target)}, {escape(entry.label)}: mean error ± standard deviation, in c0")
    for name in ("case", "window", "method"):
        table.add_column(name)
    for name in ("k / k0", "resolution", "error"):
        table.add_column(name, justify="right")
    for one in series:
        bias, random, middle = one.bias, one.random, range(0, one.wavenumbers.size, max(1, one.wavenumbers.size // 4))
        for row, n in enumerate(middle):
            table.add_row(
                *(one.key if row == 0 else ("", "", "")),
                f"{one.wavenumbers[n]:.2f}",
                f"{one.resolution[n]:.4f}",
                f"{bias[n]:.4f} ± {random[n]:.4f}",
            )
    return table


# ------------------------------------------------------------ comparing


def run_compare(first: str, second: str, path: Path, *, margin: float, json: bool) -> int:
    """The exit status of `Comparison`; 3 also if one of the entries is not whole.

    `first` and `second` name entries as `History.entry` takes them. LeakrefError is raised for names that are none, and
    for two of one entry. The JSON has both entries without their errors, `comparisons` (records of `Change`), what was
    `unlike` or `alone`, `timings`, and `faults` of the file.
    """
    kept = history.read(path)
    _say_faults(kept)
    try:
        a, b = kept.entry(first), kept.entry(second)
    except history.Damaged as damaged:
        console().print(f"[red]Could not judge:[/] {escape(str(damaged))}", soft_wrap=True)
        if json:
            print(dump(envelope("track", False, action="compare", comparisons=[], faults=kept.faults)))
        return NOTHING_TO_JUDGE
    if a.line == b.line:
        raise LeakrefError("track", f"{first} and {second} are the same entry, line {a.line}", "name two")
    found = compare(*([Series.read(one) for one in entry.record["measurements"]] for entry in (a, b)), margin=margin)
    timed = compare_timings(a.record["timings"], b.record["timings"])
    if json:
        print(
            dump(
                envelope(
                    "track",
                    found.status == 0,
                    action="compare",
                    before=_summary(a),
                    after=_summary(b),
                    comparisons=[change.record() for change in found.changes],
                    unlike=found.unlike,
                    alone=found.alone,
                    timings=timed,
                    faults=kept.faults,
                )
            )
        )
    else:
        _print(a, b, found, timed)
    return found.status


def _say_faults(kept: history.History) -> None:
    """On standard error, whatever the action makes of them."""
    for fault in kept.faults:
        console().print(f"[red]{escape(str(kept.path))}: {escape(fault)}[/]", soft_wrap=True)


def _print(a: history.Entry, b: history.Entry, found: Comparison, timed: Sequence[Mapping[str, Any]]) -> None:
    """Comparisons of one wavenumber are left out where they are equal or undecided: there are too many of them."""
    show = Console()
    show.print(f"{escape(str(a))} and {escape(str(b))}: mean errors in c0", soft_wrap=True)
    for key in dict.fromkeys((c.case, c.window, c.method) for c in found.changes):
        show.print(f"[bold]{escape(', '.join(key))}[/]", soft_wrap=True)
        for c in found.changes:
            if (c.case, c.window, c.method) == key and not (c.single and c.verdict in ("equal", "undecided")):
                show.print(_row(c), style=_COLOUR.get(c.verdict), highlight=False, soft_wrap=True)
    for line in (*found.unlike, *found.alone):
        show.print(f"[yellow]{escape(line)}[/]", soft_wrap=True)
    for row in timed:
        low, high = row["interval"]
        show.print(
            f"timing of {escape(row['name'])}: {100 * row['change']:+.0f} % ({100 * low:+.0f} to "
            f"{100 * high:+.0f}), {row['verdict']}",
            soft_wrap=True,
        )
    counts = ", ".join(f"{sum(c.verdict == v for c in found.changes)} {v}" for v in VERDICTS)
    colour = {0: "green", 1: "red"}.get(found.status, "yellow")
    words = {0: "no rise", 1: "worse", 3: "could not judge"}[found.status]
    show.print(
        f"[bold {colour}]{words}[/]: {len(found.changes)} comparisons, {counts}. Their intervals hold together "
        f"with a confidence of {100 * (1 - ALPHA):g} % (Bonferroni); a rise is seen with a probability of "
        f"{100 * POWER:g} % from the figure at the end of a line on.",
        soft_wrap=True,
    )


def _row(c: Change) -> str:
    """A change in a line: both means, the change with half its interval, and from where on a rise would be seen."""
    reach = (c.interval[1] - c.interval[0]) / 2
    return (
        f"  {c.band:10}  {c.before:.5f} -> {c.after:.5f}  {c.change:+.5f} ± {reach:.5f}  {c.verdict:9}  "
        f"seen from {c.smallest:.5f}"
    )


# ------------------------------------------------------------ looking


def run_check(path: Path, *, json: bool) -> bool:
    """Whether every line is whole, there once, and follows on one that is there. A history without entries is not
    whole.
    """
    kept = history.read(path)
    ok = bool(kept.entries) and not kept.faults
    if json:
        print(
            dump(
                envelope(
                    "track", ok, action="check", entries=[_summary(line) for line in kept.lines], faults=kept.faults
                )
            )
        )
        return ok
    _say_faults(kept)
    faults = f"{len(kept.faults) or 'no'} fault{'s' * (len(kept.faults) != 1)}"
    Console().print(f"{len(kept.entries)} whole entries in {path}, {faults}", soft_wrap=True)
    return ok


def run_plot(path: Path, *, cases: Sequence[str], target: str | None, out: Path, json: bool) -> int:
    """Pictures and a page of the entries of one target (default: that of the last): 0, or 3 if there is none. `cases`
    are those drawn, by default all that the entries have. Faults of the file are said, and the entries used that are
    whole.
    """
    from leakref.figures import save
    from leakref.track import page

    kept = history.read(path)
    _say_faults(kept)
    wanted = target or (kept.entries[-1].target if kept.entries else "")
    others = list(dict.fromkeys(entry.target for entry in kept.entries if entry.target != wanted))
    entries = [entry for entry in kept.entries if entry.target == wanted]
    there = list(dict.fromkeys(one["case"] for entry in entries for one in entry.record["measurements"]))
    if not there:
        console().print(
            f"[red]Nothing to show:[/] {escape(str(path))} has no whole entry" + f" of {escape(wanted)}" * bool(wanted)
        )
        return NOTHING_TO_JUDGE
    if missing := [name for name in cases if name not in there]:
        raise LeakrefError("track", f"{path} has nothing of {', '.join(missing)}", f"choose among {', '.join(there)}")
    shown, present = page.versions(entries, cases), [name for name in there if not cases or name in cases]
    folder(out)
    pictures, paths = [], []
    for case in present:
        name = "".join(letter if letter.isalnum() or letter in ".-" else "_" for letter in case)
        kinds = [("levels", page.levels_figure, _LEVELS), ("curves", page.curves_figure, _CURVES)]
        for kind, draw, words in kinds[len(shown) == 1 :]:  # of one version there is no line from version to version
            files = save(draw(shown, case), out / f"{kind}_{name}")
            pictures.append(
                {"title": f"{case}: {_TITLES[kind]}", "words": words, "data": b64encode(files[0].read_bytes()).decode()}
            )
            paths += files
    text = page.page(kept, shown, pictures)
    paths.insert(0, write_whole(out / "history.html", partial(_write_text, text)))
    if json:
        print(
            dump(
                envelope(
                    "track",
                    True,
                    action="plot",
                    target=wanted,
                    other_targets=others,
                    entries=[_summary(entry) for entry in entries],
                    paths=paths,
                    faults=kept.faults,
                )
            )
        )
    else:
        of = f"of {wanted}, the last entry's" if others and not target else f"of {wanted}"
        Console().print(f"Drawn: {len(shown)} version{'s' * (len(shown) > 1)} {escape(of)}.", soft_wrap=True)
        if others:
            Console().print(f"Also in {escape(str(path))}: {escape(', '.join(others))}; see --target.", soft_wrap=True)
        if len(shown) == 1:
            Console().print("Bias against version is drawn from two versions on.")
        Console().print(
            f"Page: {paths[0]}; beside it {len(paths) - 1} pictures of {', '.join(present)}", soft_wrap=True
        )
    return 0


_TITLES = {"levels": "bias against version", "curves": "bias against wavenumber"}
_LEVELS = (
    "Mean error in each band of wavenumbers, in units of the mean smaller resolution there, with its standard "
    "error (that of a change is smaller: realisations are paired). A triangle marks a step since the version "
    "before."
)
_CURVES = "Mean error at each wavenumber: the first version, the last, and those with the latest steps between them."


def _write_text(text: str, path: Path) -> None:
    path.write_text(text, encoding="utf-8")
