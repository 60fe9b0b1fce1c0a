"""The commands. Nothing heavy is imported before a command needs it."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Annotated, Any

import typer

from leakref import __version__, _caches, _exits, ending

__all__ = ["app", "main"]

JUDGE, DATA, PAPER, UPKEEP = "Judge a code", "Your data", "The paper", "Upkeep"
app = typer.Typer(name="leakref", no_args_is_help=True, add_completion=False, rich_markup_mode="rich",
                  pretty_exceptions_enable=False, context_settings={"help_option_names": ["-h", "--help"]},
                  help="A reference and test oracle for measuring near-surface currents from images of waves.")
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")]



@app.callback(invoke_without_command=True)
def _options(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False,
    traceback: Annotated[bool, typer.Option("--traceback", help="Where something breaks, show where in the code; also "
                                                                "LEAKREF_TRACEBACK=1.")] = False,
) -> None:
    if traceback:
        os.environ[ending.TRACEBACK] = "1"
    if context.invoked_subcommand is None and version is True:
        typer.echo(f"leakref {__version__}")
    elif context.invoked_subcommand is None:
        context.fail("Missing command.")
    elif version is True:  # status 0 is the verdict of a command that ran, and of nothing else
        context.fail("--version goes without a command.")


def command(panel: str | None, name: str | None = None,
            group: typer.Typer = app) -> Callable[[Callable[..., bool | int]], Callable[..., None]]:
    """A command of `group` whose body returns whether it holds, exit status 0 or 1, or the status itself."""

    def register(body: Callable[..., bool | int]) -> Callable[..., None]:
        @group.command(name, rich_help_panel=panel)
        @wraps(body)
        def run(*args: Any, **kwargs: Any) -> None:
            _caches.prepare()
            raise typer.Exit(_exits.status_of(body.__name__.replace("_", " "), lambda: body(*args, **kwargs)))

        return run

    return register


golden_app = typer.Typer(no_args_is_help=True, context_settings={"help_option_names": ["-h", "--help"]})
app.add_typer(golden_app, name="golden", rich_help_panel=UPKEEP, help="The golden values: unchanged? still reproduced?")
GoldenNumber = Annotated[int, typer.Option("--golden", help="Which set, 1 for golden/v1.")]
GoldenFolder = Annotated[Path | None, typer.Option("--set", help="Folder of a set, instead of the installed one.")]
GoldenWork = Annotated[Path, typer.Option(help="Folder where long runs are kept, and resumed from.")]
Timeout = Annotated[float | None, typer.Option(min=0.1, help="Seconds for a run, default 120 (in full 600), and for "
                                                              "the start, default 30.")]
StartTimeout = Annotated[float | None, typer.Option(min=0.1, help="Seconds for the start, if other than --timeout.")]
Workers = Annotated[int, typer.Option(min=0, help="Processes; 0: one for each core.")]


@command(JUDGE)
def certify(
    target: Annotated[str | None, typer.Argument(help="package.module:object, reference, fault:ID or variant:ID.")
                      ] = None,
    program: Annotated[str | None, typer.Option("--command", help="A program in any language, with its arguments."
                                                )] = None,
    profile: Annotated[str, typer.Option(help="quick (about a minute) or full (about ten).")] = "quick",
    only: Annotated[list[str] | None, typer.Option(help="A finding, check or family, or a pattern; may be repeated.")
                    ] = None,
    report: Annotated[Path | None, typer.Option(help="Folder for the certificate: JSON and JUnit XML.")] = None,
    known: Annotated[Path | None, typer.Option(help="Known failures: TOML, id = {reason, issue}.")] = None,
    golden: GoldenNumber = 1,
    timeout: Timeout = None,
    start_timeout: StartTimeout = None,
    memory: Annotated[float, typer.Option(min=0.01, help="GiB that the program may hold.")] = 8.0,
    workers: Annotated[int, typer.Option(min=0, help="Sessions side by side; 0: one for each core.")] = 0,
    keep: Annotated[Path | None, typer.Option(help="Keep what is exchanged with the program in this folder.")] = None,
    deep: Annotated[bool, typer.Option("--deep", help="Diagnosis: try pairs of faults as well (minutes).")] = False,
    listing: Annotated[bool, typer.Option("--list", help="Print the ids of all findings and stop.")] = False,
    schema: Annotated[bool, typer.Option("--schema", help="Print the certificate's JSON schema and stop.")] = False,
    json: Json = False,
) -> int:
    """Is this code right? Its signs, axes, scales, leakage and digits; a grade, and what fell short."""
    from leakref import LeakrefError
    from leakref.certify import commands

    if profile not in ("quick", "full"):
        raise LeakrefError("certify", f"no profile {profile!r}", "choose quick or full")
    if schema:
        commands.show_schema()
        return 0
    if listing:
        return commands.show_list(profile, only or [], json=json)
    return commands.run(commands.Request(target, program, profile, only or [], report, known, golden, timeout, memory,
                                         workers or os.cpu_count() or 1, keep, deep, start_timeout), json=json)


@command(JUDGE)
def strength(
    full: Annotated[bool, typer.Option("--full", help="The whole matrix, 200 fresh seeds, the rate of false alarms: up "
                                                      "to an hour; it goes on where it stopped.")] = False,
    out: Annotated[Path, typer.Option(help="Folder for the result and what it is resumed from.")
                   ] = Path("leakref-results/strength"),
    workers: Workers = 0,
    json: Json = False,
) -> int:
    """What the checks catch: every fault planted, every correct variant passed, and what is rejected wrongly."""
    from leakref.certify.strength.study import run

    return run(full=full, out=out, workers=workers or os.cpu_count() or 1, json=json)


@command(JUDGE)
def scaffold(
    kind: Annotated[str, typer.Argument(help="python, octave, shell or cpp: an adapter; ci: files for CI.")],
    place: Annotated[Path, typer.Argument(metavar="DIR", help="Folder to write it to.")],
    json: Json = False,
) -> bool:
    """A working adapter for a code in some language, or CI files, to start from."""
    from leakref._output import dump, envelope
    from leakref.certify.scaffold import NEXT, write

    paths = write(kind, place)
    if json:
        typer.echo(dump(envelope("scaffold", True, paths=paths, next=NEXT[kind])))
    else:
        typer.echo("\n".join(map(str, paths)) + f"\nNext, in {place}: {NEXT[kind]}")
    return True


@command(JUDGE)
def explain(
    identifier: Annotated[str | None, typer.Argument(metavar="[ID]", help="Of a check, fault, variant, claim, "
                                                                          "decision, golden value. None prints which "
                                                                          "there are.")] = None,
    json: Json = False,
) -> bool:
    """What an id stands for, in words: why a check is there, what a fault is, how a claim is tested."""
    from leakref.explain import run

    return run(identifier, json=json)


@command(JUDGE)
def guide(
    topic: Annotated[str | None, typer.Argument(metavar="[TOPIC]", help="None prints which there are.")] = None,
    json: Json = False,
) -> bool:
    """Short guides: a certificate read, a code of yours plugged in, pytest and CI, bias over versions."""
    from leakref.guides import run

    return run(topic, json=json)


@command(DATA)
def extract(
    file: Annotated[Path, typer.Argument(help="A cube: npz, mat (v5 to v7), NetCDF, or npy with --spacing.")],
    window: Annotated[str, typer.Option(help="box (none), hann, blackman or kaiser-bessel.")] = "hann",
    method: Annotated[str, typer.Option(help="nsp or ls.")] = "nsp",
    wavenumbers: Annotated[str | None, typer.Option(help="0.4,0.5 or first:last:step, in the file's units; default: "
                                                         "every dk from 4 dk up where there is signal.")] = None,
    screen: Annotated[bool, typer.Option("--screen", help="Is leakage at work? Untapered against tapered.")] = False,
    rotate: Annotated[float | None, typer.Option(help="With --screen: also turn the images, degrees.")] = None,
    spacing: Annotated[str | None, typer.Option(help="dx,dy,dt, instead of coordinates in the file.")] = None,
    axes: Annotated[str | None, typer.Option(help="Order in which eta is stored, such as txy.")] = None,
    gravity: Annotated[float | None, typer.Option(help="In the file's units, if it does not say.")] = None,
    detrend: Annotated[str, typer.Option(help="Remove first: none, mean, or linear (a plane in x, y, t).")] = "none",
    out: Annotated[Path | None, typer.Option(help="Folder for JSON, CSV, NetCDF and figures.")] = None,
    json: Json = False,
) -> bool:
    """The chain on your own cube: a Doppler shift velocity for each wavenumber, in the file's units."""
    from leakref.cubes.commands import extract as run

    return run(file, window=window, method=method, wavenumbers=wavenumbers, screening=screen, rotate=rotate,
               spacing=spacing, axes=axes, gravity=gravity, detrend=detrend, out=out, json=json)


@command(DATA)
def export(
    case: Annotated[str, typer.Argument(help="One configuration, as in `leakref reproduce --list`.")],
    out: Annotated[Path, typer.Option(help="File to write.")],
    realization: Annotated[int, typer.Option(min=0, help="Which realisation.")] = 0,
    format: Annotated[str | None, typer.Option(help="npz, mat (v5) or netcdf; default: as the file's name says, else "
                                                    "npz.")] = None,
    peak_wavenumber: Annotated[float | None, typer.Option(help="k0 in rad/m, with --gravity: SI units.")] = None,
    gravity: Annotated[float | None, typer.Option(help="In m/s2, with --peak-wavenumber.")] = None,
    json: Json = False,
) -> bool:
    """A cube of a paper case with its truth, for any code to try."""
    from leakref.cubes.exporting import export as run

    return run(case, realization=realization, format=format, out=out, peak_wavenumber=peak_wavenumber, gravity=gravity,
               json=json)


@command(DATA)
def plan(
    field_of_view: Annotated[str, typer.Option(help="Side of the area, 128m, or both: '128m x 96m'.")],
    duration: Annotated[str, typer.Option(help="Of the video, 30s.")],
    peak_wavelength: Annotated[str, typer.Option(help="Of the waves, 15m.")],
    direction: Annotated[str, typer.Option(help="Where the waves go, anticlockwise from x; along an axis is kindest."
                                           )] = "90deg",
    spread: Annotated[str, typer.Option(help="Full width of the cosine-square spreading.")] = "60deg",
    gamma: Annotated[str, typer.Option(help="JONSWAP peakedness.")] = "3.3",
    current: Annotated[str, typer.Option(help="The true current, 0.3m/s.")] = "0m/s",
    current_direction: Annotated[str | None, typer.Option(help="Where it goes; default: with the waves.")] = None,
    pixel: Annotated[str | None, typer.Option(help="Default: 1/28 of the peak's wavelength.")] = None,
    frame_rate: Annotated[str | None, typer.Option(help="2Hz; default: 14 images in a period of the peak.")] = None,
    sweep: Annotated[str | None, typer.Option(help="Also over any one of these: spread=15deg:90deg:6, first, last and "
                                                   "how many.")] = None,
    realizations: Annotated[int | None, typer.Option(min=2, help="Simulated flights; default: 8 to 30.")] = None,
    out: Annotated[Path, typer.Option(help="Folder for the tables, the data and the pictures.")] = Path("leakref-plan"),
    workers: Workers = 0,
    json: Json = False,
) -> bool:
    """What a campaign will measure: expected errors at each wavelength, in m/s, and what would improve them."""
    from leakref.planning.command import run

    given = {"field-of-view": field_of_view, "duration": duration, "peak-wavelength": peak_wavelength,
             "direction": direction, "spread": spread, "gamma": gamma, "current": current,
             "current-direction": current_direction, "pixel": pixel, "frame-rate": frame_rate}
    return run(given, sweep=sweep, realizations=realizations, out=out, workers=workers, cores=os.cpu_count() or 1,
               json=json)


@command(PAPER)
def demo(
    out: Annotated[Path, typer.Option(help="Folder for the picture and the table.")] = Path("leakref-demo"),
    json: Json = False,
) -> bool:
    """The first run: a spurious current in still water, by two routes, and what a window does about it."""
    from leakref.demo import run

    return run(out, json=json)


@command(PAPER)
def reproduce(
    case: Annotated[list[str] | None, typer.Argument(help="Cases or single configurations, as in --list; or shear: "
                                                             "currents that vary with depth.")] = None,
    everything: Annotated[bool, typer.Option("--all", help="Every case of the paper.")] = False,
    realizations: Annotated[int, typer.Option(min=1, help="How many of each configuration.")] = 100,
    figures: Annotated[bool, typer.Option("--figures", help="Draw them as well; without a case every figure of the "
                                                              "paper, results from golden/ (seconds).")] = False,
    out: Annotated[Path, typer.Option(help="Folder for tables, data and figures.")] = Path("leakref-results"),
    route: Annotated[str, typer.Option(help="A: surface and FFT, B: closed form.")] = "B",
    workers: Annotated[int, typer.Option(min=0, help="Processes; 0: one for each core.")] = 0,
    scheduler: Annotated[str, typer.Option(help="Address of a dask.distributed scheduler to use instead.")] = "",
    listing: Annotated[bool, typer.Option("--list", help="Print the ids of all cases and stop.")] = False,
    json: Json = False,
) -> bool:
    """The paper's cases: bias and random part of the measured velocity at each wavenumber."""
    from leakref import LeakrefError, _output
    from leakref.cases import CASES

    if listing:
        ids = [c.id for members in CASES.values() for c in members]
        typer.echo(_output.dump(_output.envelope("reproduce", True, ids=ids)) if json else "\n".join(ids))
        return True
    if figures and not everything and not case:
        from leakref.paper.figures import run as run_figures

        return run_figures(out, json=json)
    if everything == bool(case):
        raise LeakrefError("reproduce", "both --all and cases were given" if case else "no case was named",
                           f"name some of {', '.join(CASES)}, or pass --all")
    from leakref.paper.reproduce import run

    return run(list(CASES) if everything else case or [], realizations=realizations, figures=figures, out=out,
               route=route.upper(), json=json, workers=workers or os.cpu_count() or 1, scheduler=scheduler,
               everything=everything)


@command(PAPER)
def claims(
    ids: Annotated[list[str] | None, typer.Argument(help="Claims (A4), groups of them (A), or with --decisions "
                                                         "decisions (D4); default: all.")] = None,
    decisions: Annotated[bool, typer.Option("--decisions", help="How far each decision moves the velocities, as kept "
                                                                "in golden/; with --out or --full computed.")] = False,
    full: Annotated[bool, typer.Option("--full", help="With --decisions: all claims judged under each variant that "
                                                      "matters (an hour or more; goes on where it stopped).")] = False,
    realizations: Annotated[int | None, typer.Option(min=2, help="How many of each configuration; default 100, with "
                                                                 "--decisions 20.")] = None,
    judged: Annotated[int | None, typer.Option("--judged-with", min=2, help="With --decisions: how many for the claims "
                                               "judged again; default as many.")] = None,
    place: Annotated[Path, typer.Option("--folder", help="Where realisations are kept, as by reproduce --out.")
                     ] = Path("leakref-results"),
    figures: Annotated[bool, typer.Option("--figures", help="A picture of each claim, in the folder.")] = False,
    out: Annotated[Path | None, typer.Option(help="File for the JSON.")] = None,
    workers: Annotated[int, typer.Option(min=0, help="Processes; 0: one for each core.")] = 0,
    json: Json = False,
) -> bool:
    """The paper's statements: which are reproduced, which are not, which depend on how they are read."""
    from leakref import LeakrefError

    if full and not decisions:
        raise LeakrefError("claims", "--full without --decisions", "add --decisions; without it all claims are judged")
    if decisions:
        from leakref.claims.decisionscommand import run as run_decisions

        return run_decisions(ids or [], realizations=realizations or 20, judged=judged or realizations or 20,
                             place=place, figures=figures, out=out, workers=workers or os.cpu_count() or 1, full=full,
                             json=json)
    from leakref.claims.command import run

    return run(ids or [], realizations=realizations or 100, place=place, figures=figures, out=out,
               workers=workers or os.cpu_count() or 1, json=json)


@command(None, "lint", golden_app)
def golden_lint(golden: GoldenNumber = 1, place: GoldenFolder = None, json: Json = False) -> bool:
    """Whole and unchanged? Schemas, counts, ids, digests of every entry."""
    from leakref.golden.commands import run_lint

    return run_lint(golden, place, json=json)


@command(None, "verify", golden_app)
def golden_verify(
    ids: Annotated[list[str] | None, typer.Argument(help="Entries to look at, or patterns such as 'ensemble-U*'; none: "
                                                         "the quick ones, or all with --full.")] = None,
    full: Annotated[bool, typer.Option("--full", help="By every route, all realisations and ensembles.")] = False,
    route: Annotated[str, typer.Option(help="For ensembles: B, or A to confirm some by the surface and the FFT (16 s "
                                            "a realisation; resumed where it stopped).")] = "B",
    golden: GoldenNumber = 1,
    place: GoldenFolder = None,
    work: GoldenWork = Path("leakref-golden"),
    workers: Workers = 0,
    json: Json = False,
) -> int:
    """Still reproduced? Compute again and compare: vectors and a few realisations, or everything."""
    from leakref.golden.commands import run_verify

    return run_verify(ids or [], golden, place, full=full, route=route.upper(), work=work,
                      workers=workers or os.cpu_count() or 1, json=json)


@command(None, "regenerate", golden_app)
def golden_regenerate(
    ids: Annotated[list[str] | None, typer.Argument(help="Entries to write; 'realization-*' adds what is missing. "
                                                         "None: compare all, write beside.")] = None,
    golden: GoldenNumber = 1,
    place: GoldenFolder = None,
    work: GoldenWork = Path("leakref-golden"),
    workers: Workers = 0,
    json: Json = False,
) -> bool:
    """Compute entries again, show what differs; replaces only the ids that are named."""
    from leakref.golden.commands import run_regenerate

    return run_regenerate(ids or [], golden, place, work=work, workers=workers or os.cpu_count() or 1, json=json)


@command(UPKEEP)
def bench(
    out: Annotated[Path, typer.Option(help="Folder for the table and the picture.")] = Path("leakref-bench"),
    json: Json = False,
) -> bool:
    """Timings of every stage, as ratios within one run (a few minutes)."""
    from leakref.bench import run

    return run(out, json=json)


track_app = typer.Typer(no_args_is_help=True, context_settings={"help_option_names": ["-h", "--help"]})
app.add_typer(track_app, name="track", rich_help_panel=UPKEEP, help="Bias over versions: recorded, compared, drawn.")
HistoryFile = Annotated[Path, typer.Option("--history", help="JSON lines, one an entry; made if it is not there.")]
HISTORY = Path("leakref-history.jsonl")


@command(None, "record", track_app)
def track_record(
    target: Annotated[str | None, typer.Argument(help="reference, package.module:object, fault:ID or variant:ID.")
                      ] = None,
    program: Annotated[str | None, typer.Option("--command", help="A program in any language, with its arguments."
                                                )] = None,
    label: Annotated[str | None, typer.Option(help="What this version is called; default: as the target says.")] = None,
    path: HistoryFile = HISTORY,
    case: Annotated[list[str] | None, typer.Option(help="A configuration (`leakref reproduce --list`), or one of the "
                                                        "coarser seas broad, directional, peaked, following, narrow, "
                                                        "crossing, small; may be repeated. Default: nsp-ls and one of "
                                                        "U for the reference, else broad and following.")] = None,
    realizations: Annotated[int, typer.Option(min=2, help="How many of each case.")] = 100,
    first: Annotated[int, typer.Option(min=0, help="The first of them.")] = 0,
    source: Annotated[list[Path] | None, typer.Option(help="A file or folder that also belongs to the source of what "
                                                           "is measured; may be repeated.")] = None,
    timings: Annotated[Path | None, typer.Option(help="JSON of pytest-benchmark, to be recorded with it.")] = None,
    yardstick: Annotated[str | None, typer.Option(help="The benchmark in it that the others are divided by.")] = None,
    timeout: Timeout = None,
    start_timeout: StartTimeout = None,
    memory: Annotated[float, typer.Option(min=0.01, help="GiB that the program may hold.")] = 8.0,
    workers: Annotated[int, typer.Option(min=0, help="Processes, for the reference; 0: one for each core.")] = 0,
    json: Json = False,
) -> int:
    """Measure a version and append it to the history."""
    from leakref.track.commands import Request, run_record

    return run_record(Request(target, program, path, label, case or [], realizations, first, source or [], timings,
                              yardstick, timeout, memory, workers or os.cpu_count() or 1, start_timeout), json=json)


@command(None, "compare", track_app)
def track_compare(
    first: Annotated[str, typer.Argument(metavar="A", help="last, previous, a label (the last of that name) or the "
                                                           "beginning of a digest.")],
    second: Annotated[str, typer.Argument(metavar="B", help="Likewise: better or worse than A?")],
    path: HistoryFile = HISTORY,
    margin: Annotated[float, typer.Option(min=0.0, help="A change within this share of the smaller velocity resolution "
                                                        "is none.")] = 0.01,
    json: Json = False,
) -> int:
    """Has the bias risen? Exit status 1 if it has, beyond the margin; 3 if nothing could be compared."""
    from leakref.track.commands import run_compare

    return run_compare(first, second, path, margin=margin, json=json)


@command(None, "plot", track_app)
def track_plot(
    path: HistoryFile = HISTORY,
    case: Annotated[list[str] | None, typer.Option(help="Only this case; may be repeated.")] = None,
    target: Annotated[str | None, typer.Option(help="Whose versions; default: of the last entry's target.")] = None,
    out: Annotated[Path, typer.Option(help="Folder for the page and the pictures.")] = Path("leakref-track"),
    json: Json = False,
) -> int:
    """Bias against version, with its steps, and against wavenumber: a page and pictures."""
    from leakref.track.commands import run_plot

    return run_plot(path, cases=case or [], target=target, out=out, json=json)


@command(None, "null", track_app)
def track_null(
    out: Annotated[Path | None, typer.Option(help="File for the JSON; the committed one is golden/tracking.json.")
                   ] = None,
    place: Annotated[Path, typer.Option("--folder", help="Where realisations are kept, as by reproduce --out.")
                     ] = Path("leakref-results"),
    workers: Workers = 0,
    json: Json = False,
) -> bool:
    """How often compare cries wolf, and what it sees: 2,150 comparisons without a change (half an hour; resumed)."""
    from leakref.track.falsealarms import run

    return run(out, place=place, workers=workers or os.cpu_count() or 1, json=json)


@command(None, "check", track_app)
def track_check(path: HistoryFile = HISTORY, json: Json = False) -> bool:
    """Is the history as it was written? Nothing edited, cut off, repeated or missing."""
    from leakref.track.commands import run_check

    return run_check(path, json=json)


def main() -> None:
    """Entry point of the `leakref` command."""
    _exits.plugged()
    for stream in (sys.stdout, sys.stderr):  # a pipe may be ASCII, and figures carry degrees and deltas
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(encoding="utf-8", errors="replace")
    ending.install()
    status = _exits.status_of("", _typed)
    ending.over()
    sys.exit(status)


def _typed() -> int:
    """What is on the command line, done: typer ends everything by a SystemExit."""
    try:
        app()
    except SystemExit as end:
        if isinstance(end.code, int) and not isinstance(end.__context__, BrokenPipeError):
            return end.code
        raise
    return 0
