"""Without PyTorch the command says how to install it, and makes nothing."""

import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from campusloop.commands.workshop import app


def test_without_pytorch_the_command_says_how_to_install_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "torch", None)
    out = tmp_path / "detector.onnx"
    result = CliRunner().invoke(app, ["train-detector", "--out", str(out), "--work", str(tmp_path / "work")])
    assert result.exit_code == 2
    assert "make training" in result.output
    assert list(tmp_path.iterdir()) == []
