"""Are protocol mistakes of our own found? `python -m benchmarks.protocol_mutations --json F`.

Each wrong change of the table is made in a private copy of the tree. `campusloop simulate-service` runs there
over a few seeds: a broken rule or an exception has caught the change. Else the named short test runs. The
unchanged tree must be clean over the same seeds.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue

from benchmarks.mutants.importers import ImportGraph
from benchmarks.mutants.private_copy import PrivateCopy
from benchmarks.mutants.rooms import ROOT
from benchmarks.protocol_mutations.table import MUTATIONS, ProtocolMutation
from benchmarks.reporting.report import Row, RunReport

SEEDS = (1, 2, 3)
_SIMULATED = (
    *("--map", "maps/snow-lion/map.json", "--vehicles", "6", "--hours", "0.4"),
    *("--settle-minutes", "15", "--rides-per-hour", "60", "--faults", "all"),
)
_RUN_LIMIT_S = 900.0
_TEST_LIMIT_S = 600.0


class TableOutdated(Exception):
    """A line of the table is not in its file any more, or is there more than once."""


@dataclass(frozen=True, slots=True)
class Verdict:
    mutation: ProtocolMutation
    by: str
    how: str

    def row(self) -> Row:
        return {"mutation": self.mutation.name, "caught_by": self.by or "nothing", "how": self.how}


def changed_text(mutation: ProtocolMutation, text: str) -> str:
    """The file's text with the change. Raises TableOutdated."""
    if text.count(mutation.was) != 1:
        raise TableOutdated(f"{mutation.name}: {text.count(mutation.was)} times in {mutation.path}")
    return text.replace(mutation.was, mutation.now)


def verdict(copy: PrivateCopy, mutation: ProtocolMutation, seeds: Sequence[int]) -> Verdict:
    with copy.changed(mutation.path, changed_text(mutation, copy.text(mutation.path))):
        for seed in seeds:
            broken = broken_rules(copy.folder, seed)
            if broken:
                return Verdict(mutation, f"seed {seed}", broken)
        if mutation.test and copy.failure([mutation.test], _TEST_LIMIT_S, on_postgresql=False):
            return Verdict(mutation, "test", mutation.test)
    return Verdict(mutation, "", mutation.danger)


def broken_rules(folder: Path, seed: int) -> str:
    """What the simulation of this tree says is broken; "" for nothing."""
    result = folder / "simulated.json"
    result.unlink(missing_ok=True)
    command = [sys.executable, "-m", "campusloop", "simulate-service", "--seed", str(seed), *_SIMULATED]
    try:
        done = subprocess.run(
            [*command, "--json", str(result)],
            cwd=folder,
            env=os.environ | {"PYTHONPATH": ""},
            capture_output=True,
            text=True,
            timeout=_RUN_LIMIT_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"not over after {_RUN_LIMIT_S:.0f} s"
    if done.returncode == 0:
        return ""
    if not result.exists():
        return f"exit {done.returncode}: {done.stderr.strip().splitlines()[-1:]}"
    violations = json.loads(result.read_bytes())["violations"]
    return ", ".join(sorted({violation["rule"] for violation in violations}))


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.protocol_mutations", description=__doc__)
    parser.add_argument("--json", type=Path, help="write the report there")
    parser.add_argument("--only", nargs="*", default=[], help="names of mutations")
    parser.add_argument("--seeds", nargs="*", type=int, default=list(SEEDS))
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    chosen = [m for m in MUTATIONS if not arguments.only or m.name in arguments.only]
    report = RunReport()
    with tempfile.TemporaryDirectory() as folder:
        graph = ImportGraph(ROOT)
        copies: SimpleQueue[PrivateCopy] = SimpleQueue()
        for number in range(arguments.jobs):
            copies.put(PrivateCopy(Path(folder) / f"tree-{number}", graph))
        unchanged = copies.get()
        flaws = [flaw for seed in arguments.seeds if (flaw := broken_rules(unchanged.folder, seed))]
        copies.put(unchanged)
        if flaws:
            sys.exit(f"the unchanged tree is not clean: {'; '.join(flaws)}")

        def judge(mutation: ProtocolMutation) -> Verdict:
            copy = copies.get()
            try:
                found = verdict(copy, mutation, arguments.seeds)
            finally:
                copies.put(copy)
            print(f"{mutation.name}: {found.by or 'NOT CAUGHT'} ({found.how})", flush=True)
            return found

        with ThreadPoolExecutor(arguments.jobs) as pool:
            verdicts = list(pool.map(judge, chosen))
    caught = [found for found in verdicts if found.by]
    summary: Row = {
        "mutations": len(verdicts),
        "mutations_caught": len(caught),
        "caught_in_simulation": sum(found.by.startswith("seed") for found in caught),
    }
    given = {"seeds": arguments.seeds, "only": arguments.only, "jobs": arguments.jobs}
    report.write(arguments.json, "protocol_mutations", given, [found.row() for found in verdicts], summary)
    if len(caught) < len(verdicts):
        sys.exit(1)


if __name__ == "__main__":
    main()
