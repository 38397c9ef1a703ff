"""What a headless demo says about the runs it recorded."""

from pathlib import Path

from rich.console import Console

from campusloop.virtual.run_proof import RunProof, flaws
from campusloop.virtual.solo_drive import SoloDrive
from contract.roads.load import load_map
from tests.server.feeds.roads.shipped import CAMPUS_MAP


def test_a_damaged_segment_is_told_and_the_others_are_still_proven(tmp_path: Path) -> None:
    paths = [_recorded(tmp_path / name) for name in ("damaged", "whole")]
    data = bytearray(paths[0].read_bytes())
    data[len(data) // 2] ^= 1
    paths[0].write_bytes(data)
    with RunProof(tmp_path) as proof:
        damaged, whole = proof.results(Console(quiet=True))
    assert not whole.flaw
    assert whole.ticks == 50
    (told,) = flaws([damaged, whole])
    assert told.startswith(str(paths[0]))


def _recorded(folder: Path) -> Path:
    drive = SoloDrive(load_map(CAMPUS_MAP), folder, 1)
    for _ in range(50):
        drive.step()
    drive.vehicle.shut_down()
    (path,) = folder.rglob("*.mcap")
    return path
