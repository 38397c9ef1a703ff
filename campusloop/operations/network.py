"""Checks of what others answer: the bus, the store of run segments, and a server on the port."""

import socket
from urllib.parse import urlsplit

import httpx

from campusloop.live.server import listen
from campusloop.operations.finding import Finding, bad, good
from server.live_ports import BUS_TIMEOUT_S, NATS_PORT, CannotStart
from server.settings import Settings
from server.store.segments.choice import open_segment_store
from server.store.segments.segment_store import SegmentStoreError

_ANYWHERE = {"0.0.0.0": "127.0.0.1", "": "127.0.0.1", "::": "::1"}
ANSWER_TIMEOUT_S = 5.0


def check_bus(settings: Settings) -> Finding:
    if not settings.bus_url:
        return good("bus", "in-process, for one server")
    remedy = "start the NATS server, or leave CAMPUSLOOP_BUS_URL empty if there is one server only"
    try:
        address = urlsplit(settings.bus_url)
        place = (address.hostname or "", address.port or NATS_PORT)
        with socket.create_connection(place, timeout=BUS_TIMEOUT_S) as connection:
            # A NATS server speaks first.
            greeting = connection.recv(4)
    except (OSError, ValueError) as error:
        return bad("bus", f"no answer at {_shown(settings.bus_url)} ({error})", remedy)
    if greeting != b"INFO":
        return bad("bus", f"{_shown(settings.bus_url)} is not a NATS server", remedy)
    return good("bus", f"{_shown(settings.bus_url)} answers")


def check_segments(settings: Settings) -> Finding:
    """The store of run segments answers."""
    if not settings.segments_url:
        return good("segments", f"under {settings.var_dir}, for one server")
    try:
        open_segment_store(settings.segments_url, settings.var_dir, settings.segment_bytes_max).has("0" * 64)
    except SegmentStoreError as error:
        remedy = "correct CAMPUSLOOP_SEGMENTS_URL, or the cloud's own variables (AWS_ACCESS_KEY_ID, ...)"
        return bad("segments", f"{_shown(settings.segments_url)}: {error}", remedy)
    return good("segments", f"{_shown(settings.segments_url)} answers")


def check_port(settings: Settings) -> Finding:
    """The port is free, or a server of ours answers on it and says that it is ready."""
    try:
        listen(settings.host, settings.port).close()
    except CannotStart as error:
        return _check_server(settings, str(error))
    return good("port", f"{settings.port} on {settings.host} is free: no server runs here")


def _check_server(settings: Settings, refusal: str) -> Finding:
    host = _ANYWHERE.get(settings.host, settings.host)
    place = f"{f'[{host}]' if ':' in host else host}:{settings.port}"
    # The likely one first: a server logs a warning for the other one.
    is_plain = settings.is_loopback() and not settings.has_tls()
    schemes = ("http", "https") if is_plain else ("https", "http")
    # The certificate is checked elsewhere, and names other addresses than this one.
    with httpx.Client(verify=False, trust_env=False, timeout=ANSWER_TIMEOUT_S) as client:
        for scheme in schemes:
            try:
                alive = client.get(f"{scheme}://{place}/api/v1/health")
                if alive.status_code != httpx.codes.OK or alive.json() != {"status": "ok"}:
                    continue
                ready = client.get(f"{scheme}://{place}/api/v1/ready").json()
            except (httpx.HTTPError, ValueError):
                continue
            return readiness(f"{scheme}://{place}", ready)
    return bad("port", refusal, "stop what uses it, or set CAMPUSLOOP_PORT")


def readiness(origin: str, ready: dict[str, object]) -> Finding:
    """The finding for an answer of /ready (server/api/health/schemas.py)."""
    if ready.get("ready"):
        return good("port", f"a server answers at {origin} and is ready")
    tasks = ready.get("tasks")
    reasons = [
        f"task {task['name']} is {task['state']} ({task['failures']} failures)"
        for task in (tasks if isinstance(tasks, list) else [])
        if task["state"] != "good"
    ]
    if ready.get("leaving"):
        reasons.append("it is stopping")
    if ready.get("database") != "good":
        reasons.append(f"database {ready.get('database')}")
    if not ready.get("disk_has_room"):
        reasons.append("too little room on the disk")
    if not ready.get("map_version"):
        reasons.append("no active map")
    return bad(
        "port",
        f"a server answers at {origin} and is not ready: {'; '.join(reasons)}",
        "see its log for the cause of each; docs/server/operations.md",
    )


def _shown(url: str) -> str:
    """The address without its password."""
    return url.rsplit("@", 1)[-1]
