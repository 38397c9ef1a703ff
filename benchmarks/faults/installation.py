"""`campusloop serve` as a service manager runs it: a process that is started again when it ends."""

import asyncio
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx
import psutil

MAP = Path(__file__).resolve().parents[2] / "maps" / "shanghai-university" / "map.json"
PASSWORD = "faults are tried on purpose"
READY_WITHIN_S = 90.0
RESTART_AFTER_S = 0.5
STOP_WITHIN_S = 60.0


@dataclass(frozen=True, slots=True)
class Readiness:
    """status: of the HTTP answer, 0 for none; sick: standing tasks that do not work."""

    status: int
    sick: tuple[str, ...] = ()


class Installation:
    """One server on loopback, its database, and an operator who is signed in.

    database_url  empty for an SQLite file in the folder
    variables     further variables of its environment
    starts        how often the process has been started
    """

    def __init__(
        self,
        folder: Path,
        database_url: str,
        campus_map: Path = MAP,
        variables: Mapping[str, str] | None = None,
    ) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.folder, self.database_url = folder, database_url
        self.campus_map, self.variables = campus_map, variables or {}
        self.starts = 0
        self.port = free_port()
        self.origin = f"http://127.0.0.1:{self.port}"
        self.http = httpx.AsyncClient(base_url=f"{self.origin}/api/v1", trust_env=False, timeout=30.0)
        self._process: asyncio.subprocess.Process | None = None
        self._runs = True

    @property
    def is_sqlite(self) -> bool:
        return not self.database_url

    @property
    def sqlite_file(self) -> Path:
        return self.folder / "campusloop.db"

    @property
    def url(self) -> str:
        """Of the database, as SQLAlchemy has it."""
        return self.database_url or f"sqlite:///{self.sqlite_file}"

    @property
    def process(self) -> psutil.Process:
        assert self._process is not None
        return psutil.Process(self._process.pid)

    def websocket(self, path: str) -> str:
        return f"ws://127.0.0.1:{self.port}{path}"

    def environment(self) -> dict[str, str]:
        return os.environ | {
            "CAMPUSLOOP_VAR_DIR": str(self.folder),
            "CAMPUSLOOP_DATABASE_URL": self.database_url,
            "CAMPUSLOOP_OPERATOR_PASSWORD": PASSWORD,
            "CAMPUSLOOP_LOGIN_TRIES_PER_MINUTE": "600",
            "CAMPUSLOOP_ACCOUNT_LOGIN_TRIES_PER_MINUTE": "600",
            "CAMPUSLOOP_COMMANDS_PER_MINUTE": "100000",
            "CAMPUSLOOP_BOOKINGS_PER_MINUTE": "100000",
            "CAMPUSLOOP_LOOKUPS_PER_MINUTE": "100000",
            **self.variables,
        }

    def command(self, port: int) -> list[str]:
        return [
            sys.executable,
            "-m",
            "campusloop",
            "serve",
            "--port",
            str(port),
            "--map",
            str(self.campus_map),
        ]

    async def keep_running(self) -> None:
        """Start the process, and start it again whenever it has ended."""
        while self._runs:
            with (self.folder / "server.log").open("ab") as journal:
                self._process = await asyncio.create_subprocess_exec(
                    *self.command(self.port),
                    env=self.environment(),
                    stdout=journal,
                    stderr=subprocess.STDOUT,
                )
            self.starts += 1
            await self._process.wait()
            await asyncio.sleep(RESTART_AFTER_S)

    def orphans(self) -> list[psutil.Process]:
        """Processes that earlier servers have started, and that still run."""
        mine = {os.getpid(), *(child.pid for child in psutil.Process().children(recursive=True))}
        return [
            process for process in psutil.process_iter() if process.pid not in mine and self._made(process)
        ]

    def _made(self, process: psutil.Process) -> bool:
        try:
            alive = process.status() != psutil.STATUS_ZOMBIE
            return alive and process.environ().get("CAMPUSLOOP_VAR_DIR") == str(self.folder)
        except psutil.Error:
            return False

    def kill(self, number: signal.Signals = signal.SIGKILL) -> None:
        self.process.send_signal(number)

    async def readiness(self) -> Readiness:
        try:
            answer = await self.http.get("/ready", timeout=5.0)
            tasks = answer.json()["tasks"]
        except (httpx.HTTPError, ValueError, KeyError):
            return Readiness(0)
        return Readiness(answer.status_code, tuple(t["name"] for t in tasks if t["state"] != "good"))

    async def until_ready(self, within_s: float = READY_WITHIN_S) -> float:
        """Seconds until the server says that all of it works. Raises TimeoutError with what does not."""
        begun = time.monotonic()
        while (ready := await self.readiness()).status != 200:
            if time.monotonic() - begun > within_s:
                raise TimeoutError(f"not ready within {within_s:.0f} s: {ready}")
            await asyncio.sleep(0.2)
        return time.monotonic() - begun

    async def replace(self) -> float:
        """End the process in order; seconds until the next one works. Raises TimeoutError."""
        begun, starts = time.monotonic(), self.starts
        self.kill(signal.SIGTERM)
        async with asyncio.timeout(STOP_WITHIN_S):
            while self.starts == starts:  # noqa: ASYNC110 - it is a process
                await asyncio.sleep(0.05)
        await self.until_ready()
        return time.monotonic() - begun

    async def sign_in(self) -> None:
        answer = await self.http.post("/session", json={"name": "operator", "password": PASSWORD})
        answer.raise_for_status()
        self.http.headers["X-CSRF-Token"] = answer.json()["csrf_token"]

    async def ask(self, method: str, path: str, body: object = None) -> Any:
        answer = await self.http.request(method, path, json=body)
        answer.raise_for_status()
        return answer.json()

    async def enrol(self, vehicle_id: str, public_key: str) -> None:
        """By a code, as an operator does."""
        new = {"vehicle_id": vehicle_id, "name": vehicle_id, "seats": 6, "wheelchair_places": 1}
        code = (await self.ask("POST", "/enrolments/codes", new))["code"]
        enrolment = {"code": code, "vehicle_id": vehicle_id, "public_key": public_key}
        await self.ask("POST", "/enrolments", enrolment)

    async def close(self) -> None:
        self._runs = False
        await self.http.aclose()
        if self._process is None or self._process.returncode is not None:
            return
        self._process.send_signal(signal.SIGCONT)
        self._process.terminate()
        try:
            async with asyncio.timeout(STOP_WITHIN_S):
                await self._process.wait()
        except TimeoutError:
            self._process.kill()
            await self._process.wait()


@asynccontextmanager
async def an_installation(
    folder: Path,
    database_url: str,
    campus_map: Path = MAP,
    variables: Mapping[str, str] | None = None,
) -> AsyncIterator[Installation]:
    """Ready, and signed in; stopped at the end."""
    installation = Installation(folder, database_url, campus_map, variables)
    running = asyncio.create_task(installation.keep_running())
    try:
        await installation.until_ready()
        await installation.sign_in()
        yield installation
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
        await installation.close()


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port
