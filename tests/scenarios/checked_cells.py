"""Every N-th protection cell on every shipped profile: prints what each cell came to.

With `NUMBA_BOUNDSCHECK=1` a kernel that leaves an array ends the program. Without it the kernel reads what
lies behind the array in memory, and the vehicle acts on it.
"""

import argparse
from itertools import islice
from pathlib import Path

from benchmarks.ncap.drives import CellDrive, drive_cell
from benchmarks.reporting.run_logs import LogChoice
from campusloop.scenes.protection.cells import cells
from vehicle_agent.config import load_profile

PROFILES = Path(__file__).resolve().parents[2] / "vehicle_agent" / "profiles"
# Of sensor noise and of the vehicle's dynamics.
SEED = 1


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--every", type=int, default=700)
    every = parser.parse_args().every
    for path in sorted(PROFILES.glob("*.toml")):
        profile = load_profile(path)
        for cell in islice(cells(profile.body), 0, None, every):
            row = drive_cell(CellDrive(cell, profile, SEED, SEED, None, LogChoice(None)))
            print(f"{path.stem} {cell.name}: clearance {row['clearance_m']} m", flush=True)


if __name__ == "__main__":
    main()
