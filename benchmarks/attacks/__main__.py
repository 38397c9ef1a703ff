"""Attacks on a real server: `python -m benchmarks.attacks [--json FILE] [--fuzz REQUESTS]`.

First the authorization matrix: every endpoint of the OpenAPI document and every method of the developer
socket, tried by everyone who may come. Then each scripted attack, twice: it must fail, and it must succeed
once the control is taken away that it names.
"""

import argparse
import asyncio
import sys
import tempfile
from pathlib import Path

import structlog

from benchmarks.attacks.attack import ATTACKS, Attack
from benchmarks.attacks.kinds import browsers, operators, records, requests, tokens, vehicles
from benchmarks.attacks.matrix import matrix
from benchmarks.attacks.target import GENEROUS, Target, a_target
from benchmarks.reporting.report import Row, RunReport

WITHIN_S = 60.0
KINDS = (browsers, operators, tokens, vehicles, requests, records)


def main() -> None:
    report = RunReport()
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--only", nargs="*", default=[], help="names of attacks; default: all")
    parser.add_argument(
        "--fuzz", type=int, default=0, help="so many requests, and messages of sockets, from the documents"
    )
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    unknown = sorted(set(arguments.only) - {attack.name for attack in ATTACKS})
    if unknown:
        parser.error(f"no attack is called {', '.join(unknown)}")
    structlog.configure(wrapper_class=structlog.make_filtering_bound_logger(50))
    rows, summary = asyncio.run(_run(arguments.only, arguments.fuzz, arguments.seed))
    report.write(
        arguments.json,
        "attacks",
        {"only": arguments.only, "fuzz": arguments.fuzz, "seed": arguments.seed},
        rows,
        summary,
    )
    sys.exit(1 if summary["leaks"] or summary["server_errors"] else 0)


async def _run(only: list[str], fuzz_requests: int, seed: int) -> tuple[list[Row], Row]:
    chosen = [one for one in ATTACKS if not only or one.name in only]
    with tempfile.TemporaryDirectory() as folder:
        async with (
            a_target(Path(folder, "generous"), **GENEROUS) as generous,
            a_target(Path(folder, "default")) as default,
        ):
            cells, leaks = (0, []) if only else await matrix(generous)
            for kind in (operators, tokens):
                await kind.prepare(generous)
            rows = [await _tried(one, default if one.budgets else generous) for one in chosen]
            fuzzed, spoken = (
                {"requests": 0, "server_errors": 0},
                {"messages": 0, "server_errors": 0, "ended_without_close": 0},
            )
            if fuzz_requests:
                from benchmarks.attacks.fuzz import fuzz
                from benchmarks.attacks.socket_fuzz import fuzz_sockets

                spoken = await fuzz_sockets(generous, fuzz_requests, seed)
                fuzzed = await fuzz(generous, fuzz_requests, seed)
    for leak in leaks:
        print("leak:", leak)
    return rows, {
        "attacks": len(rows),
        "matrix_cells": cells,
        "leaks": len(leaks) + sum(row["leaked"] is True for row in rows),
        "succeed_without_control": sum(row["succeeds_without_control"] is True for row in rows),
        "controls_that_were_taken_away": sum(row["succeeds_without_control"] is not None for row in rows),
        "fuzz_requests": fuzzed["requests"],
        "fuzz_socket_messages": spoken["messages"],
        "fuzz_ended_without_close": spoken["ended_without_close"],
        "server_errors": fuzzed["server_errors"] + spoken["server_errors"],
    }


async def _tried(one: Attack, target: Target) -> Row:
    leaked = await _succeeds(one, target)
    without = None
    if one.without:
        with one.unprotected():
            without = await _succeeds(one, target)
    return {
        "attack": one.name,
        "control": one.control,
        "leaked": leaked,
        "succeeds_without_control": without,
    }


async def _succeeds(one: Attack, target: Target) -> bool | str:
    async with asyncio.timeout(WITHIN_S):
        return await one.attempt(target)


if __name__ == "__main__":
    main()
