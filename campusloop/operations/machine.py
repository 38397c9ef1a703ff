"""Checks of the machine and the program: packages, kernels, clock."""

import platform
from collections.abc import Iterable
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, metadata, version

from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

from campusloop.kernels.compiling import uncompiled_kernels
from campusloop.kernels.groups import SERVER
from campusloop.operations.finding import Finding, bad, good, warning

# This version was written after it, so that an earlier time is wrong.
EARLIEST = datetime(2026, 1, 1, tzinfo=UTC)
LATEST = datetime(2100, 1, 1, tzinfo=UTC)


def check_packages() -> Finding:
    """Python and the installed packages against what this program declares."""
    try:
        declared = metadata("campusloop")
    except PackageNotFoundError:
        return bad("packages", "campusloop is not installed in this Python", "install it: pip install .")
    wrong = wrong_packages(declared.get_all("Requires-Dist") or ())
    python = declared["Requires-Python"]
    if platform.python_version() not in SpecifierSet(python):
        wrong = (f"Python {platform.python_version()} (needs {python})", *wrong)
    if wrong:
        return bad("packages", "; ".join(wrong), "make setup, or pip install -r requirements/run.txt")
    return good("packages", f"Python {platform.python_version()}; all packages have the versions needed")


def wrong_packages(requirements: Iterable[str]) -> tuple[str, ...]:
    """Which of these requirements are not met, each in words. Those of optional parts are left out."""
    wrong = []
    for line in requirements:
        needed = Requirement(line)
        if needed.marker is not None and not needed.marker.evaluate({"extra": ""}):
            continue
        try:
            present = version(needed.name)
        except PackageNotFoundError:
            wrong.append(f"{needed.name} is missing")
            continue
        if not needed.specifier.contains(present, prereleases=True):
            wrong.append(f"{needed.name} {present} (needs {needed.specifier})")
    return tuple(wrong)


def check_kernels() -> Finding:
    missing = uncompiled_kernels(SERVER)
    if missing:
        return warning(
            "kernels",
            f"perhaps not compiled for the present files: {', '.join(missing)}",
            "the next start takes a minute longer; campusloop warm does it now",
        )
    return good("kernels", "compiled")


def check_clock(now: datetime, newest_record: datetime | None) -> Finding:
    """newest_record: when the newest event in the database happened, None if there is none"""
    remedy = "set the clock and keep it with NTP: timedatectl set-ntp true"
    if not EARLIEST <= now <= LATEST:
        return bad("clock", f"it is {now:%Y-%m-%d} here, which cannot be", remedy)
    if newest_record is not None and newest_record > now:
        ahead_s = (newest_record - now).total_seconds()
        return bad("clock", f"the newest event in the database lies {ahead_s:.0f} s in the future", remedy)
    return good("clock", f"{now:%Y-%m-%d %H:%M:%S} UTC")
