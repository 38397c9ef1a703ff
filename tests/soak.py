"""Long and random campaigns: `python -m tests.soak [NAME ...]`. Seeds are printed; exit 1 when one fails."""

import os
import secrets
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
CAMPUSLOOP = (sys.executable, "-m", "campusloop")
SNOW_LION = str(ROOT / "maps" / "snow-lion" / "map.json")
# Days of 20 shuttles, with 40 minutes at the end of each: together a year of one shuttle. Separate runs keep
# little in memory, and each is repeated alone.
YEAR_DAYS = 18
PROPERTY_SEED = secrets.randbelow(2**32)


@dataclass(frozen=True, slots=True)
class Campaign:
    name: str
    what: str
    command: tuple[str, ...]
    environment: dict[str, str] = field(default_factory=dict)


CAMPAIGNS = (
    *(
        Campaign(
            f"rides-{seed}",
            f"six rides among people, seed {seed}",
            (*CAMPUSLOOP, "demo", "--headless", "--rides", "6", "--seed", str(seed)),
        )
        for seed in range(1, 6)
    ),
    Campaign(
        "morning",
        "Table 1's morning on the schematic map, seed 1",
        (*CAMPUSLOOP, "demo", "--headless", "--map", SNOW_LION, "--from", "07:58", "--to", "10:05"),
    ),
    Campaign(
        "kilometres",
        "1,000 km on both shipped campuses, seed 1; nobody may be touched",
        (*CAMPUSLOOP, "simulate", "--km", "1000", "--seed", "1", "--out", str(ROOT / "var" / "kilometres")),
    ),
    *(
        Campaign(
            f"service-{seed}",
            f"a day of 20 shuttles with every fault, seed {seed}; no rule may be broken",
            (*CAMPUSLOOP, "simulate-service", "--seed", str(seed), "--vehicles", "20", "--hours", "24"),
        )
        for seed in range(1, YEAR_DAYS + 1)
    ),
    Campaign(
        "fleet",
        "an hour of 20 vehicles on a real server, on each database; no rule may be broken",
        (sys.executable, "-m", "benchmarks.fleet_soak"),
    ),
    Campaign(
        "bounds",
        "every hundredth protection cell on every profile, by kernels that check the bounds of their arrays",
        (sys.executable, "-m", "tests.scenarios.checked_cells", "--every", "100"),
        {"NUMBA_BOUNDSCHECK": "1", "NUMBA_CACHE_DIR": str(ROOT / "var" / "checked-kernels")},
    ),
    Campaign(
        "protocol",
        "wrong changes to the protocol; the simulation or a named test notices each one",
        (sys.executable, "-m", "benchmarks.protocol_mutations"),
    ),
    Campaign(
        "properties",
        f"every property test on new examples, seed {PROPERTY_SEED}",
        (sys.executable, "-m", "pytest", "-m", "hypothesis", f"--hypothesis-seed={PROPERTY_SEED}"),
        {"CAMPUSLOOP_NEW_EXAMPLES": "1"},
    ),
    Campaign(
        "stories",
        "200 random stories of rides, vehicles, links and clocks; no ride may be lost",
        (sys.executable, "-m", "pytest", "-q", "tests/server/usecases/rides/test_ride_machine.py"),
        {"CAMPUSLOOP_STORIES": "200"},
    ),
    Campaign(
        "promises",
        "a million random events for the dispatcher, seed 1; no promise may be broken",
        (sys.executable, "-m", "tests.server.dispatch.promise_campaign", "--events", "1000000"),
    ),
    Campaign(
        "noise",
        "20,000 rides on drives that take up to a fifth more or less than planned; 1 % of promises may break",
        (sys.executable, "-m", "tests.server.dispatch.noise_campaign", "--rides", "20000"),
    ),
    Campaign(
        "mutants",
        "1,000 wrong changes, seed 1: the short tests notice nearly all of them; survivors are listed",
        (
            sys.executable,
            "-m",
            "benchmarks.mutants",
            "--sample",
            "1000",
            "--floor",
            "95",
            "--room-floor",
            "75",
        ),
    ),
    Campaign(
        "missions",
        "1,000 random missions for three shuttles on the shipped and on generated maps",
        (sys.executable, "-m", "tests.contract.roads.random_missions", "--missions", "1000"),
    ),
)


def main() -> None:
    wanted = sys.argv[1:]
    unknown = set(wanted) - {campaign.name for campaign in CAMPAIGNS}
    if unknown:
        names = ", ".join(campaign.name for campaign in CAMPAIGNS)
        sys.exit(f"no campaign {', '.join(sorted(unknown))}; there are: {names}")
    failed = []
    for campaign in CAMPAIGNS:
        if wanted and campaign.name not in wanted:
            continue
        print(f"== {campaign.name}: {campaign.what}", flush=True)
        begun = time.monotonic()
        environment = os.environ | campaign.environment
        code = subprocess.run(campaign.command, cwd=ROOT, env=environment, check=False).returncode
        print(f"== {campaign.name}: exit {code} after {time.monotonic() - begun:.0f} s", flush=True)
        if code != 0:
            failed.append(campaign.name)
    if failed:
        sys.exit(f"failed: {', '.join(failed)}")


if __name__ == "__main__":
    main()
