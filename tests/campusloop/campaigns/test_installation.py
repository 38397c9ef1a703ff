"""What a worker checks before its first job."""

from dataclasses import replace
from pathlib import Path

import pytest

from campusloop.campaigns.installation import CheckedCall, WorkerDiffers, file_digests, installation
from tests.campusloop.campaigns.jobs import squared


def test_the_same_installation_computes(tmp_path: Path) -> None:
    (tmp_path / "map.json").write_text("{}")
    assert CheckedCall(squared, installation(), file_digests([tmp_path]))(3) == 9


def test_another_library_is_named_with_both_versions() -> None:
    here = installation()
    other = replace(here, libraries=here.libraries | {"numpy": "1.0"})
    with pytest.raises(WorkerDiffers, match=f"numpy {here.libraries['numpy']} instead of 1.0"):
        CheckedCall(squared, other)(3)


def test_other_sources_are_named() -> None:
    with pytest.raises(WorkerDiffers, match="other sources of Campusloop"):
        CheckedCall(squared, replace(installation(), code="0"))(3)


def test_a_missing_and_a_changed_input_are_named(tmp_path: Path) -> None:
    path = tmp_path / "map.json"
    path.write_text("{}")
    call = CheckedCall(squared, installation(), file_digests([path]))
    path.write_text("[]")
    with pytest.raises(WorkerDiffers, match=r"other content in .*map\.json"):
        call(3)
    path.unlink()
    with pytest.raises(WorkerDiffers, match=r"cannot read .*map\.json"):
        call(3)
