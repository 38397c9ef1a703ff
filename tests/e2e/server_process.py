"""`campusloop serve` as a process of its own, with the shipped campus and a database in a folder."""

import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from types import TracebackType
from typing import Any

import httpx

from contract.roads.load import load_map
from contract.roads.network import RoadNetwork
from tests.e2e.scripted_shuttle import ScriptedShuttle
from vehicle_agent.mission.order_line import LanePoint

ROOT = Path(__file__).resolve().parents[2]
CAMPUS_MAP = ROOT / "maps" / "shanghai-university" / "map.json"
PASSWORD = "correct horse battery"
REQUEST_LIMIT_S = 120.0
READY_WITHIN_S = 240.0
PLACED_WITHIN_S = 120.0
OPEN_STATES = ("requested", "assigned", "boarding", "aboard")


class ServerProcess:
    """`with ServerProcess(folder) as server`: up and ready inside, gone afterwards."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._port = free_port()
        self.origin = f"http://127.0.0.1:{self._port}"
        self.http = httpx.Client(base_url=f"{self.origin}/api/v1", trust_env=False, timeout=REQUEST_LIMIT_S)
        self.network = RoadNetwork(load_map(CAMPUS_MAP))
        self._shuttles: list[ScriptedShuttle] = []

    def __enter__(self) -> "ServerProcess":
        environment = os.environ | {
            "CAMPUSLOOP_VAR_DIR": str(self._folder),
            "CAMPUSLOOP_OPERATOR_PASSWORD": PASSWORD,
            "CAMPUSLOOP_WEB_DIST": str(ROOT / "web" / "dist"),
            "CAMPUSLOOP_LOGIN_TRIES_PER_MINUTE": "600",
            "CAMPUSLOOP_ACCOUNT_LOGIN_TRIES_PER_MINUTE": "600",
            "CAMPUSLOOP_COMMANDS_PER_MINUTE": "100000",
            # Where the tests have push services of their own.
            "CAMPUSLOOP_WEBHOOK_ALLOWED_NETWORKS": "127.0.0.0/8",
        }
        arguments = ["serve", "--port", str(self._port), "--map", str(CAMPUS_MAP)]
        with (self._folder / "server.log").open("wb") as journal:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "campusloop", *arguments],
                cwd=ROOT,
                env=environment,
                stdout=journal,
                stderr=subprocess.STDOUT,
            )
        self._await_ready()
        self._sign_in()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for shuttle in self._shuttles:
            shuttle.stop()
        self.http.close()
        self._process.send_signal(signal.SIGINT)
        try:
            self._process.wait(15)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def change(self, method: str, path: str, body: object = None) -> Any:
        answer = self.http.request(method, path, json=body)
        assert answer.is_success, answer.text
        return answer.json()

    def add_shuttle(self, vehicle_id: str, name: str, resting_place: int) -> ScriptedShuttle:
        """Enrolled, connected, standing at a resting place, and released by the operator."""
        rest = self.network.road_map.resting_places[resting_place]
        folder = self._folder / vehicle_id
        folder.mkdir()
        shuttle = ScriptedShuttle(folder, vehicle_id, self.network, LanePoint(rest.lane_id, rest.s_m))
        new = {"vehicle_id": vehicle_id, "name": name, "seats": 6, "wheelchair_places": 1}
        code = self.change("POST", "/enrolments/codes", new)["code"]
        key = {"code": code, "vehicle_id": vehicle_id, "public_key": shuttle.public_key}
        self.change("POST", "/enrolments", key)
        shuttle.start(self.origin.replace("http", "ws", 1) + "/ws/vehicle")
        self._shuttles.append(shuttle)
        self.await_vehicle(vehicle_id, placed=True)
        self.change("POST", f"/vehicles/{vehicle_id}/resume")
        self.await_vehicle(vehicle_id, held=False)
        return shuttle

    def cancel_rides(self) -> None:
        """Every ride that has not ended; who is on board gets out as soon as the shuttle can stop."""
        for ride in self.http.get("/rides", params={"state": OPEN_STATES}).raise_for_status().json():
            cancelled = self.http.post(f"/rides/id/{ride['ride_id']}/cancel")
            # 409: it ended meanwhile, or the shuttle that carries it can go nowhere.
            assert cancelled.is_success or cancelled.status_code == 409, cancelled.text

    def enter_vehicle(self, vehicle_id: str, name: str) -> None:
        """One that has never been heard."""
        new = {"vehicle_id": vehicle_id, "name": name, "seats": 6, "wheelchair_places": 1}
        self.change("POST", "/enrolments/codes", new)

    def new_viewer(self, name: str = "viewer") -> tuple[str, str]:
        """Name and password of an operator who only looks."""
        made = self.change("POST", "/operators", {"name": name, "roles": ["viewer"]})
        with httpx.Client(base_url=self.http.base_url, trust_env=False, timeout=REQUEST_LIMIT_S) as http:
            first = {"name": name, "password": made["initial_password"]}
            session = http.post("/session", json=first).raise_for_status().json()
            chosen = {"password": made["initial_password"], "new_password": PASSWORD}
            headers = {"X-CSRF-Token": session["csrf_token"]}
            http.post("/session/password", json=chosen, headers=headers).raise_for_status()
        return name, PASSWORD

    def await_vehicle(self, vehicle_id: str, **facts: object) -> None:
        until_s = time.monotonic() + PLACED_WITHIN_S
        vehicle: dict[str, object] = {}
        while time.monotonic() < until_s:
            vehicle = self.http.get(f"/vehicles/{vehicle_id}").json()
            if all(vehicle[name] == value for name, value in facts.items()):
                return
            time.sleep(0.1)
        raise AssertionError(f"{vehicle_id} did not become {facts}: {vehicle}")

    def _await_ready(self) -> None:
        until_s = time.monotonic() + READY_WITHIN_S
        while time.monotonic() < until_s:
            if self._process.poll() is not None:
                raise AssertionError((self._folder / "server.log").read_text())
            try:
                if self.http.get("/ready").is_success:
                    return
            except httpx.TransportError:
                time.sleep(0.1)
        raise AssertionError(
            "the server was not ready in time:\n" + (self._folder / "server.log").read_text()
        )

    def _sign_in(self) -> None:
        session = self.change("POST", "/session", {"name": "operator", "password": PASSWORD})
        self.http.headers["X-CSRF-Token"] = session["csrf_token"]


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port
