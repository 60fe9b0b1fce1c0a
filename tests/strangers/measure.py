"""How the suite judges strangers: how many mistakes it sees and names, and how many right codes it rejects.

    cd tests; python -m strangers.measure mistakes FOLDER [ID...]     # all mistakes: rejected? by what? named?
    python -m strangers.measure right FOLDER [ID...] --seeds 1 2 3    # all right codes
    cd tests; python -m strangers.measure shared FOLDER --seeds 2 1001 --workers 2    # a seed each, in turn

Results are kept in FOLDER, a JSON file each, and not made again: take another folder for another state of leakref.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import re
import warnings
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from scipy.stats import beta

from leakref import runs
from leakref.certify.runner import certify, select
from leakref.certify.strength.diagnosis import explain
from leakref.certify.strength.study import variant_record
from leakref.certify.subject.inprocess import InProcess
from leakref.certify.verdict import Verdict
from strangers.mistakes import HERE, MISTAKES, Mistake
from strangers.right import RIGHT

NOTHING = re.compile("unexplained|too little to go on|another algorithm: it differs")
VAGUE = {"scale-dependent"}  # true of many mistakes, and the name of none


def judge(code: Any, name: str, *, seed: int = 1, diagnosis: bool = True) -> dict[str, Any]:
    """What a quick run says of a code, and what the diagnosis says of that."""
    pairs, start = select(profile="quick", seed=seed), process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a code that warns is not broken
        found = certify(name, [nullcontext(InProcess(code))], pairs, profile="quick", seed=seed)
        judged = process_time() - start
        if diagnosis and found.wrong:
            found = explain(found, InProcess(code))
    return {
        "id": name,
        "seed": seed,
        "grade": found.grade,
        "coverage": found.coverage,
        "wrong": {f.id: [f.over, f.message[:300]] for f in found.wrong},
        "missing": [f.id for f in found.findings if f.verdict is Verdict.MISSING],
        "faults": [one["fault"] for one in found.diagnosis],
        "symptoms": [one["fault"] for one in found.diagnosis if one["kind"] == "symptom"],
        "explanation": found.explanation,
        "seconds": [round(judged, 1), round(process_time() - start - judged, 1)],
    }


def told(record: dict[str, Any], mistake: Mistake) -> str:
    """Whether the explanation is `right`, `unexplained` or `false`; `unseen` where there is nothing to explain."""
    if not record["wrong"]:
        return "unseen"
    named = mistake.named & set(record["faults"])
    if named or (mistake.says and re.search(mistake.says, record["explanation"], re.IGNORECASE)):
        return "right"
    named = set(record["faults"]) - set(record.get("symptoms", ()))  # what stands in the findings blames nothing
    silent = named <= VAGUE and (record["faults"] or not record["explanation"] or NOTHING.search(record["explanation"]))
    return "unexplained" if silent else "false"


def kept(folder: Path | None, name: str, text: str, make: Any) -> dict[str, Any]:
    """The record of that name, made if there is none yet of the same text."""
    digest = hashlib.sha256(text.encode()).hexdigest()[:16]
    path = folder / f"{name}.json" if folder else None
    if path and path.exists() and (record := json.loads(path.read_text()))["digest"] == digest:
        return record
    record = make() | {"digest": digest}
    if path:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(record, indent=1))
    return record


def of_mistake(mistake: Mistake, folder: Path | None = None) -> dict[str, Any]:
    text = (HERE / f"{mistake.file}.py").read_text().replace(mistake.old, mistake.new)
    record = kept(folder, mistake.id, text, lambda: judge(mistake.plant().Extractor(), mistake.id))
    return record | {"told": told(record, mistake), "rejected": record["grade"] == "rejected"}


def of_right(name: str, seed: int, folder: Path | None = None) -> dict[str, Any]:
    text = "".join((HERE / f"{part}.py").read_text() for part in ("right", "parts"))
    return kept(folder, f"{name}-{seed}", text, lambda: judge(RIGHT[name](), name, seed=seed, diagnosis=False))


def of_shared(seed: int, folder: Path) -> dict[str, Any]:
    """The questions that a seed draws, asked of the right code whose turn it is, as the study asks its variants."""
    name = list(RIGHT)[seed % len(RIGHT)]
    text = "".join((HERE / f"{part}.py").read_text() for part in ("right", "parts"))

    def asked() -> dict[str, Any]:
        with runs.one_thread(), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a code that warns is not broken
            return variant_record(f"right {name}", seed, make=lambda _: RIGHT[name]())

    return kept(folder, f"{name}-{seed}", text, asked)


def shares(records: list[dict[str, Any]]) -> dict[str, Any]:
    """Of the mistakes that are not mild: the share rejected; of all with something wrong: named rightly; told false."""
    grave = [r for r in records if not MISTAKES[r["id"]].mild]
    seen = [r for r in records if r["wrong"]]
    return {
        "rejected": sum(r["rejected"] for r in grave) / max(len(grave), 1),
        "survivors": [r["id"] for r in grave if not r["rejected"]],
        "named": sum(r["told"] == "right" for r in seen) / max(len(seen), 1),
        "unexplained": [r["id"] for r in seen if r["told"] == "unexplained"],
        "false": [r["id"] for r in seen if r["told"] == "false"],
    }


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("what", choices=("mistakes", "right", "shared"))
    parser.add_argument("folder", type=Path)
    parser.add_argument("ids", nargs="*")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    parser.add_argument("--workers", type=int, default=1)
    given = parser.parse_args()
    if given.what == "shared":
        seeds = range(given.seeds[0], given.seeds[-1] + 1)
        with ProcessPoolExecutor(given.workers) as pool:
            records = list(pool.map(of_shared, seeds, [given.folder] * len(seeds)))
        rejected = [r for r in records if r["wrong"]]
        low, high = beta.ppf([0.025, 0.975], [len(rejected) or np.nan, len(rejected) + 1],
                             [len(records) - len(rejected) + 1, len(records) - len(rejected)])  # fmt: skip
        print(json.dumps(rejected, indent=1))
        print(f"{len(rejected)} of {len(records)} runs with something wrong, {sum(r['checks'] for r in records)} "
              f"answers judged; 95 %: {np.nan_to_num(low):.1e} to {high:.1e}")  # fmt: skip
        return
    if given.what == "mistakes":
        records = []
        for name in given.ids or MISTAKES:
            records.append(r := of_mistake(MISTAKES[name], given.folder))
            wrong = f"{len(r['wrong'])} wrong: {', '.join(list(r['wrong'])[:3])}"
            print(f"{name:24} {r['grade']!s:10} {r['told']:11} {wrong}\n{'':24} {r['explanation']}", flush=True)
        print(json.dumps(shares(records), indent=1))
        return
    for name in given.ids or RIGHT:
        for seed in given.seeds:
            r = of_right(name, seed, given.folder)
            wrong = "; ".join(f"{i} {over or 0:.2g}" for i, (over, _) in r["wrong"].items())
            print(f"{name:24} {seed:4} {r['grade']!s:10} missing {len(r['missing'])}  {wrong}", flush=True)


if __name__ == "__main__":
    main()
