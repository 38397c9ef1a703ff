"""The quick start of the API's page does what it says: each block is run as it stands."""

import os
import re
import subprocess
import sys

import pytest

from tests.e2e.server_process import ROOT, ServerProcess

pytestmark = [pytest.mark.browser, pytest.mark.real, pytest.mark.usefixtures("shuttle")]

PAGE = (ROOT / "docs" / "server" / "api.md").read_text()
BLOCKS = re.findall(r"```(sh|python)\n(.*?)```", PAGE.split("## Purpose")[0], flags=re.DOTALL)
ANSWERS = ('"ride_code"', '"vehicle_id":"shuttle-1"', "assigned", '"snapshot":true')


def test_the_page_has_a_block_for_each_way() -> None:
    assert [language for language, _ in BLOCKS] == ["sh", "sh", "python", "python"]


@pytest.mark.parametrize("number", range(4))
def test_a_block_runs_as_it_stands_and_prints_its_answer(server: ServerProcess, number: int) -> None:
    language, text = BLOCKS[number]
    body = {"name": f"quick-start-{number}", "scopes": ["read", "drive"]}
    token = server.change("POST", "/developer-tokens", body)["secret"]
    program = [sys.executable, "-c"] if language == "python" else ["sh", "-ec"]
    done = subprocess.run(
        [*program, text.replace("127.0.0.1:8080", server.origin.removeprefix("http://"))],
        env=os.environ | {"CAMPUSLOOP_TOKEN": token, "PYTHONPATH": str(ROOT / "sdk" / "python")},
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert ANSWERS[number] in done.stdout, done.stdout
