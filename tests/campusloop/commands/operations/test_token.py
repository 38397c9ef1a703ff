"""`campusloop token` on the database of a server that runs, and on what is no database of one."""

import asyncio
import json
from collections.abc import Awaitable, Callable
from pathlib import Path

import httpx
import pytest
from typer.testing import CliRunner, Result

from campusloop.cli import app_of
from campusloop.operations.audit_log import audit_findings
from server.store.engine import open_engine
from tests.campusloop.live.live_server import LiveServer, live_server

RUN = CliRunner()
TIME_LIMIT_S = 60


def token(*arguments: str) -> Result:
    return RUN.invoke(app_of(("token",)), ["token", *arguments])


async def token_beside(*arguments: str) -> Result:
    """While the server of this event loop answers."""
    return await asyncio.to_thread(token, *arguments)


@pytest.fixture
def var_dir(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Commands and servers use this folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("CAMPUSLOOP_DATABASE_URL", raising=False)
    folder = tmp_path / "var"
    folder.mkdir()
    return folder


def beside_server(folder: Path, claim: Callable[[LiveServer], Awaitable[None]]) -> None:
    async def run() -> None:
        async with asyncio.timeout(TIME_LIMIT_S), live_server(folder) as server:
            await claim(server)

    asyncio.run(run())


def bearer(secret: str) -> dict[str, str]:
    return {"Authorization": f"Bearer {secret}"}


def test_a_token_opens_the_running_server_until_it_is_revoked(var_dir: Path) -> None:
    async def claim(server: LiveServer) -> None:
        made = await token_beside("create", "--user", "operator", "--name", "ci")
        assert made.exit_code == 0, made.output
        secret = made.stdout.strip()
        assert secret not in made.stderr
        async with httpx.AsyncClient(base_url=server.http.base_url, trust_env=False, timeout=30.0) as script:
            assert (await script.get("/vehicles", headers=bearer(secret))).status_code == 200
            closure = {"lane_ids": ["x"], "reason": "r"}
            refused = await script.post("/closures", json=closure, headers=bearer(secret))
            assert refused.status_code == 403, "only `read` was given"
            (listed,) = json.loads((await token_beside("list", "--json")).stdout)
            assert (listed["name"], listed["scopes"], listed["state"]) == ("ci", ["read"], "valid")
            revoked = await token_beside("revoke", listed["token_id"], "--user", "operator")
            assert revoked.exit_code == 0, revoked.output
            assert (await script.get("/vehicles", headers=bearer(secret))).status_code == 401
        assert "revoked" in (await token_beside("list")).stdout
        entries = (await server.http.get("/audit")).json()
        assert [entry["action"] for entry in entries][:2] == ["revoke_token", "make_token"]
        assert secret not in json.dumps(entries)

    beside_server(var_dir, claim)
    (chain,) = audit_findings(open_engine(f"sqlite:///{var_dir / 'campusloop.db'}"))
    assert chain.broken is None


def test_the_secret_is_on_no_disk(var_dir: Path) -> None:
    async def claim(_: LiveServer) -> None:
        made = await token_beside("create", "--user", "operator", "--scope", "read", "--scope", "drive")
        secrets.append(made.stdout.strip())

    secrets: list[str] = []
    beside_server(var_dir, claim)
    assert len(secrets[0]) >= 32
    files = [path for path in var_dir.rglob("*") if path.is_file()]
    assert any(b"command-line" in path.read_bytes() for path in files)
    assert not [path for path in files if secrets[0].encode() in path.read_bytes()]


def test_the_demos_database_is_found_and_two_databases_are_refused(var_dir: Path) -> None:
    async def claim(_: LiveServer) -> None:
        made = await token_beside("create", "--user", "operator")
        assert made.exit_code == 0, made.output
        assert "var/demo/campusloop.db" in made.stderr

    (var_dir / "demo").mkdir()
    beside_server(var_dir / "demo", claim)
    (var_dir / "campusloop.db").write_bytes(b"")
    refused = token("create", "--user", "operator")
    assert refused.exit_code == 2
    assert "--database" in refused.stderr
    chosen = token("list", "--json", "--database", "sqlite:///var/demo/campusloop.db")
    assert [one["name"] for one in json.loads(chosen.stdout)] == ["command-line"]


def test_who_is_no_admin_and_what_is_no_token_end_with_2_and_what_to_do(var_dir: Path) -> None:
    async def claim(server: LiveServer) -> None:
        await server.change("POST", "/operators", {"name": "vera", "roles": ["viewer"]})
        for user in ("vera", "nobody"):
            refused = await token_beside("create", "--user", user)
            assert refused.exit_code == 2, refused.output
            assert "its admins are: operator" in refused.stderr
            assert refused.stdout == ""
        unknown = await token_beside("revoke", "token-9", "--user", "operator")
        assert unknown.exit_code == 2
        assert "campusloop token list" in unknown.stderr
        assert json.loads((await token_beside("list", "--json")).stdout) == []

    beside_server(var_dir, claim)


@pytest.mark.parametrize(
    ("arguments", "remedy"),
    [
        (["create", "--user", "operator"], "run this where the server runs"),
        (["create", "--user", "operator", "--days", "0"], "--days"),
        (["create", "--user", "operator", "--scope", "write"], "read, drive, infrastructure"),
        (["create", "--user", "operator", "--name", "two words"], "--name"),
        (["list", "--database", "mysql://x"], "use sqlite:///FILE"),
        (["list"], "run this where the server runs"),
    ],
)
def test_bad_input_ends_with_2_and_what_to_do(var_dir: Path, arguments: list[str], remedy: str) -> None:
    done = token(*arguments)
    assert done.exit_code == 2, done.output
    assert remedy in done.stderr
    assert done.stdout == ""
