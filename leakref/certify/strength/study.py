"""The strength of the suite itself: which checks kill which faults, and how often a correct code is rejected.

Faults are mutants: each must exceed the tolerance of its killing input ten times and be killed by the family of checks
meant for it; with that family switched off it is reported as alive, whoever else sees it. Variants are correct codes:
none may be rejected, on the published questions or on those of other seeds. The statistical checks are resampled under
their null hypothesis.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, as_completed
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from leakref import kept, runs, sources
from leakref._output import dump, envelope, folder, plain, progress_bar, write_whole
from leakref.certify.checks.criteria import NEVER
from leakref.certify.checks.draw import DRAWN, PUBLISHED
from leakref.certify.checks.identity import identify
from leakref.certify.checks.registry import FAMILIES, Case, Check
from leakref.certify.checks.sea import CASES
from leakref.certify.runner import select
from leakref.certify.strength import faults, variants
from leakref.certify.strength.alarms import errors_of, false_alarms, rate_of, sea_alarms, seas, seas_of
from leakref.certify.strength.fault import Fault
from leakref.certify.strength.faults import FAULTS
from leakref.certify.strength.tables import pretty, show
from leakref.certify.strength.variants import VARIANTS
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.verdict import WRONG, Finding, Verdict
from leakref.golden.beside import noted
from leakref.golden.sets import locate

__all__ = ["BY_CHANCE", "DISTINCT", "SEEDS", "Job", "classes", "compute", "jobs", "run", "study"]

SEEDS = 1000
"""Seeds of the full study other than that of the published questions, shared among the variants."""
DISTINCT = 10.0
"""Effect over tolerance that every fault must have on its killing input."""
BY_CHANCE = 1.5
"""The same where the tolerance is what chance does to a mean of some realisations (family `sea`), which more of them
would make smaller, at a cost."""
_COUNTED = "leakage.bias"
_SEEN = (*DRAWN, "metamorphic", "shear", "scale")  # families that look at seas


@dataclass(frozen=True)
class Job:
    """A part of the study for one worker: `kind` is fault, variant or null; `seed` None are the published questions.

    - `id`: of the fault, the variant, or the sea of the null hypothesis, a random one where `kind` is sea.
    - `full`: for a fault, whether all quick checks are asked and not only those meant for it.
    """

    kind: str
    id: str
    seed: int | None = None
    full: bool = False

    def path(self, work: Path) -> Path:
        """Where its result is kept: another source of anything that it depends on is another folder."""
        name = f"{self.kind}-{self.id}" + ("-full" if self.full else "") + f"-{self.seed}" * (self.seed is not None)
        return work / source_digest()[:20] / f"{name}.json"

    @property
    def about(self) -> dict[str, Any]:
        """What its result depends on."""
        return {**asdict(self), "source": source_digest()}


def jobs(*, full: bool = False) -> list[Job]:
    """What there is to do, in the order in which it is reported.

    Faults first, then variants on the published questions; in the full study also variants on `SEEDS` other seeds in
    turn, and the seas of the statistical checks.
    """
    seeds = range(PUBLISHED + 1, PUBLISHED + 1 + SEEDS) if full else ()
    shared = [Job("variant", list(VARIANTS)[seed % len(VARIANTS)], seed) for seed in seeds]
    nulls = [Job("null", name) for name in seas()] if full else []
    nulls += [Job("sea", case.id) for case in CASES] if full else []
    return [
        *(Job("fault", name, full=full) for name in FAULTS),
        *(Job("variant", name) for name in VARIANTS),
        *shared,
        *nulls,
    ]


@cache
def source_digest() -> str:
    """SHA-256 of the sources of the chain, the checks, faults, variants and what they lean on, and the golden set."""
    return sources.digest(__name__, more=locate().joinpath("manifest.json").read_bytes())


def compute(job: Job) -> dict[str, Any]:
    """The record of one job, the same in any process.

    It runs with one thread of BLAS. Of a fault `fault_record`, of a variant `variant_record`, of a sea its `errors`.
    """
    with runs.one_thread():
        if job.kind == "fault":
            return fault_record(FAULTS[job.id], full=job.full)
        if job.kind == "variant":
            return variant_record(job.id, job.seed)
        return {"id": job.id, "errors": (seas_of if job.kind == "sea" else errors_of)(job.id)}


def fault_record(
    fault: Fault, *, full: bool = False, make: Callable[[str], Any] = faults.implementation
) -> dict[str, Any]:
    """What kills a fault, and by how much it exceeds the tolerance of its killing input.

    Its killing input is asked first, then the family meant for it until something there kills it; with `full` every
    check of the quick profile is asked. `over` holds the effect over tolerance by finding.

    `make` gives the faulty code by the fault's id. `killed_by` is the id of the first finding of the family meant for
    it with an effect above the tolerance, None if it survives; `effect_over_tolerance` is that on its killing input.
    """
    everything = select(profile="full")
    killing = [pair for pair in everything if _name(pair) == fault.killing_input]
    asked = [*killing, *(select(profile="quick") if full else ())]
    own = sorted((pair for pair in everything if pair[0].family == fault.family), key=lambda pair: not pair[1].quick)
    over: dict[str, float] = {}
    fresh = _subjects(lambda: make(fault.id))
    for pair in [*asked, *own]:
        if _name(pair) not in over and (pair in asked or not _killers(over, fault.family)):
            over[_name(pair)] = _over(pair[0](fresh(), pair[1]))
    killers = _killers(over, fault.family)
    return {
        "id": fault.id,
        "family": fault.family,
        "killed_by": killers[0] if killers else None,
        "effect_over_tolerance": over.get(fault.killing_input),
        "witness": fault.killing_input,
        "over": over,
    }


def _subjects(make: Callable[[], Any]) -> Callable[[], InProcess]:
    """Makes a new session with a new code each time, so that no question hears of another; what it was found to
    reproduce is asked once.
    """
    first = InProcess(make())
    alike = identify(first)

    def fresh() -> InProcess:
        subject = InProcess(make())
        subject.alike, subject.reproduces = alike, first.reproduces
        return subject

    return fresh


def _name(pair: tuple[Check, Case]) -> str:
    return f"{pair[0].id}[{pair[1].id}]"


def _over(finding: Finding) -> float:
    """Effect over tolerance; what broke or gave no number is `NEVER`, which JSON can hold, what was not judged none."""
    if finding.verdict in (Verdict.MISSING, Verdict.UNSUPPORTED):
        return 0.0
    if finding.over is None or not np.isfinite(finding.over):
        return NEVER
    return min(finding.over, NEVER)


def _killers(over: Mapping[str, float], family: str) -> list[str]:
    """Findings of a family with an effect above the tolerance, in the order in which they were asked."""
    return [name for name, value in over.items() if value > 1 and name.partition(".")[0] == family]


def _kills(record: Mapping[str, Any]) -> dict[str, float]:
    """Families that kill it, with their largest effect over tolerance."""
    found: dict[str, float] = {}
    for name, value in record["over"].items():
        family = name.partition(".")[0]
        if value > 1:
            found[family] = max(value, found.get(family, 0.0))
    return found


def classes(records: Iterable[Mapping[str, Any]]) -> list[list[str]]:
    """Faults that no check tells apart: the same effect on every finding, to a thousandth of it or a hundredth of a
    tolerance.

    `records` are those of `fault_record`, asked the same findings. Returned are lists of ids, for each class of two or
    more.
    """
    groups: list[tuple[Mapping[str, float], list[str]]] = []
    for record in records:
        over = record["over"]
        for first, members in groups:
            if first.keys() == over.keys() and np.allclose(
                [first[name] for name in over], list(over.values()), rtol=1e-3, atol=1e-2
            ):
                members.append(record["id"])
                break
        else:
            groups.append((over, [record["id"]]))
    return [members for _, members in groups if len(members) > 1]


def _families(records: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """For each family: how many faults are meant for it, how many it kills, and which `only` it kills.

    Conformance is left out of that count, but for the faults meant for it: another algorithm than the reference's is
    not held to it, and has the other families alone to find its mistakes.
    """
    kills = {r["id"]: set(_kills(r)) - ({"conformance"} if r["family"] != "conformance" else set()) for r in records}
    return [
        {
            "family": family,
            "meant": sum(r["family"] == family for r in records),
            "kills": sum(family in _kills(r) for r in records),
            "only": [name for name, by in kills.items() if by == {family}],
        }
        for family in FAMILIES
    ]


def variant_record(
    identifier: str, seed: int | None = None, *, make: Callable[[str], Any] = variants.implementation
) -> dict[str, Any]:
    """The checks of the quick profile that a variant should pass and does not, as published or drawn from a seed.

    Those of conformance only count for variants that deserve that grade. Of another `seed` than None only families that
    look at seas are asked: of the first seed of each variant also those that a run asks as they are published, and the
    statistical check, whose alarms are counted in many more draws by themselves (`alarms`).
    """
    exact = identifier in VARIANTS and VARIANTS[identifier].grade == "conformant"
    pairs = select(profile="quick")
    if seed is None:
        asked = [pair for pair in pairs if exact or pair[0].family != "conformance"]
    else:
        first = seed <= PUBLISHED + len(VARIANTS)
        asked = [
            (check, replace(case, seed=seed))
            for check, case in pairs
            if check.family in (_SEEN if first else DRAWN) and (first or check.id != _COUNTED)
        ]
    fresh = _subjects(lambda: make(identifier))
    found = [check(fresh(), case) for check, case in asked]
    wrong = [f for f in found if f.verdict in WRONG]
    return {
        "id": identifier,
        "seed": seed,
        "checks": sum(f.verdict is Verdict.PASS for f in found) + len(wrong),
        "wrong": {f.id: f.message for f in wrong},
    }


def study(
    *,
    full: bool = False,
    work: Path | None = None,
    executor: Executor | None = None,
    after_each: Callable[[], object] = lambda: None,
) -> dict[str, Any]:
    """The record of the whole study (guide protocol, section 14).

    Jobs go to `executor` (default: this process). With a folder `work` each result is written there as it comes, and
    what is already there is not computed again. Results do not depend on the executor or the order of completion.
    """
    todo = jobs(full=full)
    done = {job: record for job in todo if work and (record := kept.record(job.path(work), job.about)) is not None}
    for _ in done:
        after_each()
    for job, record in _computed([job for job in todo if job not in done], executor):
        done[job] = record
        if work is not None:
            kept.keep_record(job.path(work), job.about, record)
        after_each()
    by_kind = {kind: [done[job] for job in todo if job.kind == kind] for kind in ("fault", "variant", "null", "sea")}
    errors, random = ({r["id"]: r["errors"] for r in by_kind[kind]} for kind in ("null", "sea"))
    return _summary(by_kind["fault"], by_kind["variant"], errors, random, full=full)


def _computed(waiting: Sequence[Job], executor: Executor | None) -> Iterator[tuple[Job, dict[str, Any]]]:
    if executor is None:
        yield from ((job, plain(compute(job))) for job in waiting)
        return
    futures = {executor.submit(compute, job): job for job in waiting}
    for future in as_completed(futures):
        yield futures[future], plain(future.result())


def _summary(
    killed: Sequence[Mapping[str, Any]],
    trials: Sequence[Mapping[str, Any]],
    errors: Mapping[str, Any],
    random: Mapping[str, Any],
    *,
    full: bool,
) -> dict[str, Any]:
    """What golden/strength.json holds: of each fault what kills it and by how much, of each variant how often it was
    rejected, of each family what it alone sees, faults that no answer tells apart, and what is not as it should be.
    """
    mutants = [
        {
            **{key: value for key, value in r.items() if key != "over"},
            "words": FAULTS[r["id"]].words,
            "kills": _kills(r),
        }
        for r in killed
    ]
    judged = [
        {
            "id": name,
            "grade": VARIANTS[name].grade,
            "words": VARIANTS[name].words,
            "rejected": sum(bool(t["wrong"]) for t in own),
            "runs": len(own),
            "checks": sum(t["checks"] for t in own),
            "wrong": [{"seed": t["seed"], **{"id": k, "message": v}} for t in own for k, v in t["wrong"].items()],
        }
        for name in VARIANTS
        if (own := [t for t in trials if t["id"] == name])
    ]
    record: dict[str, Any] = {"full": full, "faults": mutants, "variants": judged}
    if full:
        record |= {"families": _families(killed), "classes": classes(killed), "false_alarms": false_alarms(errors)}
        record["sea_alarms"] = sea_alarms(random)
        record["rejections"] = rate_of(sum(v["rejected"] for v in judged), sum(v["runs"] for v in judged))
    return record | {"problems": problems(record)}


def problems(record: Mapping[str, Any]) -> list[str]:
    """Where the suite falls short, in words; empty if it holds.

    That is: a fault that its family lets live, an effect below `DISTINCT` on the killing input, a fault meant for
    conformance that makes other families reject, a variant that was rejected, a family that no fault is meant for, and
    more false alarms than nominal beyond the confidence interval.
    """
    said = []
    for r in record["faults"]:
        effect = r["effect_over_tolerance"]
        others = sorted(set(r["kills"]) - {"conformance"})
        if r["killed_by"] is None:
            said.append(f"the fault {r['id']} survives the checks of {r['family']}")
        elif effect is None or effect < (BY_CHANCE if r["family"] == "sea" else DISTINCT):
            on = r["witness"] or "no killing input"
            said.append(f"the effect of {r['id']} on {on} is {effect} times the tolerance")
        if r["family"] == "conformance" and others:
            said.append(f"the fault {r['id']} leaves a code sound, and {', '.join(others)} rejects it")
    for v in record["variants"]:
        if v["rejected"]:
            said.append(
                f"the variant {v['id']} was rejected {v['rejected']} times in {v['runs']} runs, by "
                f"{', '.join(sorted({row['id'] for row in v['wrong']}))}"
            )
    said += [f"no fault is meant for {row['family']}" for row in record.get("families", ()) if not row["meant"]]
    alarms = record.get("false_alarms")
    if alarms and alarms["at_margin"]["interval"][0] > alarms["nominal"]:
        said.append(f"false alarms are at {alarms['at_margin']['rate']:.1e}, above {alarms['nominal']}")
    alarms = record.get("sea_alarms")
    if alarms and alarms["interval"][0] > alarms["nominal"]:
        said.append(f"false alarms of random seas are at {alarms['rate']:.1e}, above {alarms['nominal']}")
    return said


def run(
    *, full: bool = False, out: Path = Path("leakref-results/strength"), workers: int = 2, json: bool = False
) -> int:
    """The command: study, print, write `strength.json` into `out`; 0 if the suite holds, 1 if it falls short.

    `workers` is the number of processes; results of jobs are kept in `out/work`, from where an interrupted study goes
    on.
    """
    work = folder(out) / "work"
    with runs.pool(workers) as executor, progress_bar("strength", len(jobs(full=full))) as step:
        found = study(full=full, work=work, executor=executor, after_each=step)
    record = envelope("strength", not found["problems"], **found)
    noted(write_whole(out / "strength.json", lambda path: path.write_text(pretty(record), encoding="utf-8")))
    if json:
        print(dump(record))
    else:
        show(record)
    return 0 if record["ok"] else 1
