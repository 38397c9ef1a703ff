"""Redocly's linter on the OpenAPI document, and clients that other people's generators make of it."""

import asyncio
import copy
import json
import os
import subprocess
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest

from server.api.routers import bare_app
from tests.campusloop.live.live_server import live_server
from tests.server.api.specifications.web_tools import (
    ROOT,
    TIME_LIMIT_S,
    WEB,
    needs_web_tools,
    openapi_problems,
    run_tool,
)

pytestmark = pytest.mark.real
HERE = Path(__file__).parent
DOCUMENT: dict[str, Any] = json.loads(json.dumps(bare_app().openapi()))
OPTIONS = ("--meta", "none", "--output-path", "campus_client", "--fail-on-warning", "--config", "config.json")
# It knows no pictures and videos, and is told to hand them on as they are.
OPAQUE = ("image/svg+xml", "image/png", "application/zip", "video/webm")
CONFIG = {"content_type_overrides": dict.fromkeys(OPAQUE, "application/octet-stream")}
GENERATORS = ROOT / "var" / "generators" / "bin"


@needs_web_tools
def test_the_linter_finds_nothing(tmp_path: Path) -> None:
    assert openapi_problems(DOCUMENT, tmp_path) == []


@needs_web_tools
def test_the_linter_finds_an_example_that_breaks_its_schema_and_an_operation_without_security(
    tmp_path: Path,
) -> None:
    broken = copy.deepcopy(DOCUMENT)
    del broken["components"]["schemas"]["StopView"]["example"]["name"]
    del broken["paths"]["/api/v1/health"]["get"]["security"]
    problems = openapi_problems(broken, tmp_path)
    assert len(problems) == 2
    assert any("required property 'name'" in problem for problem in problems)
    assert any("security" in problem for problem in problems)


def test_openapi_typescript_makes_a_client_that_books_a_ride(tmp_path: Path) -> None:
    (tmp_path / "openapi.json").write_text(json.dumps(DOCUMENT))
    (tmp_path / "node_modules").symlink_to(WEB / "node_modules")
    (tmp_path / "package.json").write_text('{"type": "module"}')
    (tmp_path / "call.ts").write_text((HERE / "call.ts").read_text())
    options = ("--strict", "--target", "es2022", "--module", "nodenext", "--types", "node", "call.ts")
    for command in (("openapi-typescript", "openapi.json", "-o", "schema.ts"), ("tsc", *options)):
        said = run_tool(*command, folder=tmp_path)
        assert said.returncode == 0, said.stdout + said.stderr
    assert_books_a_ride("node", str(tmp_path / "call.js"), var_dir=tmp_path / "var")


def test_openapi_python_client_makes_a_client_that_books_a_ride(tmp_path: Path) -> None:
    if not GENERATORS.exists():
        pytest.skip("openapi-python-client is not installed: make generators")
    (tmp_path / "openapi.json").write_text(json.dumps(DOCUMENT))
    (tmp_path / "config.json").write_text(json.dumps(CONFIG))
    (tmp_path / "call.py").write_text((HERE / "call.py").read_text())
    # In its environment it finds the formatter that it calls.
    made = subprocess.run(
        [GENERATORS / "openapi-python-client", "generate", "--path", "openapi.json", *OPTIONS],
        cwd=tmp_path,
        env={"PATH": str(GENERATORS)},
        capture_output=True,
        text=True,
        timeout=TIME_LIMIT_S,
    )
    assert made.returncode == 0, made.stdout + made.stderr
    assert_books_a_ride(str(GENERATORS / "python"), str(tmp_path / "call.py"), var_dir=tmp_path / "var")


def assert_books_a_ride(*program: str, var_dir: Path) -> None:
    """Run a client's program against a server of its own: it prints the ride that it has booked."""

    async def claim(origin: str, secret: str) -> None:
        client = await asyncio.create_subprocess_exec(
            *program,
            origin,
            secret,
            env={"PATH": os.environ["PATH"], "NO_PROXY": "*"},
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.PIPE,
        )
        said, complaint = await client.communicate()
        assert client.returncode == 0, complaint.decode()
        ride = json.loads(said)
        # The campus has no shuttle: the answer is a ride that is refused.
        assert ride["ride_id"]
        assert (ride["source"], ride["state"]) == ("developer", "refused")

    against_server(var_dir, claim)


def against_server(var_dir: Path, claim: Callable[[str, str], Awaitable[None]]) -> None:
    async def run() -> None:
        async with asyncio.timeout(TIME_LIMIT_S), live_server(var_dir) as server:
            secret, _ = await server.developer_token("read", "drive")
            await claim(server.origin, secret)

    asyncio.run(run())
