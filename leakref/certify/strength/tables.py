"""The study of the suite's strength to be read: as the text that is committed, and as tables on the terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from leakref._output import dump, plain
from leakref.certify.checks.registry import FAMILIES

__all__ = ["pretty", "show"]


def pretty(record: Mapping[str, Any]) -> str:
    """As it is committed: an item of a list to a line, numbers to four digits, so that changes can be read."""

    def short(value: Any) -> Any:
        if isinstance(value, float):
            return float(f"{value:.4g}")
        if isinstance(value, dict):
            return {key: short(item) for key, item in value.items()}
        return [short(item) for item in value] if isinstance(value, list) else value

    def block(value: Any) -> str:
        if isinstance(value, list) and value:
            return "[\n  " + ",\n  ".join(dump(item) for item in value) + "]"
        return dump(value)

    return "{" + ",\n".join(f'"{key}": {block(short(plain(value)))}' for key, value in record.items()) + "}\n"


def show(record: Mapping[str, Any]) -> None:
    """Tables on standard output."""
    from rich.console import Console

    from leakref._tables import Table

    print_ = Console().print
    matrix = Table(title="Faults: effect over tolerance, by the family that kills", header_style="bold")
    matrix.add_column("fault")
    matrix.add_column("meant for")
    matrix.add_column("killing input")
    matrix.add_column("effect", justify="right")
    if record["full"]:
        for family in FAMILIES:
            matrix.add_column(family[:6], justify="right")
    for r in record["faults"]:
        effect = "-" if r["effect_over_tolerance"] is None else f"{r['effect_over_tolerance']:.3g}"
        row = [r["id"], r["family"], r["witness"], effect if r["killed_by"] else "[red]lives[/]"]
        cells = [f"{r['kills'][f]:.2g}" if f in r["kills"] else "" for f in FAMILIES] if record["full"] else []
        matrix.add_row(*row, *cells)
    print_(matrix)
    correct = Table(title="Variants: correct codes that must not be rejected", header_style="bold")
    for name in ("variant", "grade", "runs", "rejected"):
        correct.add_column(name, justify="right" if name in ("runs", "rejected") else "left")
    for v in record["variants"]:
        rejected = f"[red]{v['rejected']}[/]" if v["rejected"] else "0"
        correct.add_row(v["id"], v["grade"], str(v["runs"]), rejected)
    print_(correct)
    for row in record.get("families", ()):
        print_(
            f"{row['family']} kills {row['kills']} faults, {row['meant']} are meant for it and {len(row['only'])} "
            "no other family kills"
        )
    if alarms := record.get("false_alarms"):
        rate = alarms["at_margin"]
        print_(
            f"false alarms in a whole run: {rate['rate']:.2e} (95 %: {rate['interval'][0]:.1e} to "
            f"{rate['interval'][1]:.1e}) of {alarms['resamplings']} resamplings"
        )
    if alarms := record.get("sea_alarms"):
        low, high = alarms["interval"]
        print_(
            f"false alarms about random seas: {alarms['rate']:.2e} (95 %: {low:.1e} to {high:.1e}) of "
            f"{alarms['resamplings']} resamplings"
        )
    if rejections := record.get("rejections"):
        low, high = rejections["interval"]
        runs = sum(v["runs"] for v in record["variants"])
        print_(f"correct codes rejected: {rejections['alarms']} of {runs} runs (95 %: {low:.1e} to {high:.1e})")
    for line in record["problems"]:
        print_(f"[red]{line}[/]")
