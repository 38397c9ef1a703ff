"""The node tools of web/, and what they say of a document."""

import json
import os
import subprocess
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[4]
WEB = ROOT / "web"
TOOLS = WEB / "tools"
QUIET = {"REDOCLY_TELEMETRY": "off", "REDOCLY_SUPPRESS_UPDATE_NOTICE": "true"}
TIME_LIMIT_S = 120
needs_web_tools = pytest.mark.skipif(
    not (TOOLS / "node_modules").exists(),
    reason="the specifications' linters are not installed: make generators",
)


def run_tool(*command: str | Path, folder: Path = WEB) -> subprocess.CompletedProcess[str]:
    """Raises FileNotFoundError if a tool is not installed."""
    places = [home / "node_modules" / ".bin" / str(command[0]) for home in (WEB, TOOLS)]
    tool = next((place for place in places if place.exists()), places[0])
    program = ["node", *command[1:]] if command[0] == "node" else [tool, *command[1:]]
    return subprocess.run(
        program, cwd=folder, env=os.environ | QUIET, capture_output=True, text=True, timeout=TIME_LIMIT_S
    )


def openapi_problems(document: dict[str, Any], folder: Path) -> list[str]:
    """What Redocly's linter finds, with the rules of web/tools/redocly.yaml."""
    path = folder / "openapi.json"
    path.write_text(json.dumps(document))
    said = run_tool("redocly", "lint", path, "--config", TOOLS / "redocly.yaml", "--format", "json")
    report = json.loads(said.stdout)
    problems = [f"{one['location'][0].get('pointer')}: {one['message']}" for one in report["problems"]]
    assert (said.returncode == 0) == (not problems), said.stderr
    return problems


def asyncapi_problems(document: str, folder: Path) -> list[str]:
    """What the official AsyncAPI parser finds."""
    path = folder / "document.yaml"
    path.write_text(document, encoding="utf-8")
    said = run_tool("node", TOOLS / "asyncapi.mjs", path)
    problems = said.stderr.splitlines()
    assert (said.returncode == 0) == (not problems), said.stderr
    return problems
