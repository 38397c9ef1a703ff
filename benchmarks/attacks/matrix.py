"""The authorization matrix: everyone at every endpoint and socket method, against one table of who may.

The table is written by hand, and knows nothing of the server's own permissions. An endpoint that it does not
name is a leak.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field

from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from benchmarks.attacks.target import ROLES, Session, Target, bearer
from server.api.routers import PREFIX, bare_app
from server.domain.record.identity import Scope

SCOPE_SETS: tuple[tuple[Scope, ...], ...] = (
    ("read",),
    ("drive",),
    ("infrastructure",),
    ("read", "drive"),
    ("read", "drive", "infrastructure"),
)

PUBLIC = """get_campus list_stops get_campus_map find_ride look_for_ride get_timetable sign_in get_health
get_readiness get_notice_key get_stop_board get_stop_code
list_current_announcements"""
# By a link; by a code; by a signature: everybody may try, and only the holder gets anything.
BY_LINK = """get_ride cancel_ride change_destination tap_aboard tap_alighted get_tap call_help give_feedback
ask_for_notices stop_notices get_series cancel_series cancel_series_day"""
BY_SECRET = """enrol_vehicle put_segment get_map_for_vehicle get_localization_manifest_for_vehicle
get_localization_tile_for_vehicle put_scan_parcel put_video_segment"""
# For passengers; a token that is sent along must be good for driving.
BOOKINGS = "book_ride book_series"
OWN_SESSION = """get_session sign_out choose_password begin_second_factor remove_second_factor
confirm_second_factor check_second_factor"""

# operation ids: roles of operators, scope of tokens
GUARDED: tuple[tuple[str, frozenset[str], str], ...] = (
    (
        """list_rides get_ride_record explain_ride ride_history list_series get_service list_closures
        list_announcements
        get_service_trips get_timetable_version get_travel_times list_vehicles get_vehicle
        get_vehicle_shifts list_incidents get_segment list_runs
        get_run get_run_scenes get_run_map get_run_marks get_run_onboard get_run_scans get_scene
        list_recordings
        get_fleet_past get_fleet_positions get_service_figures
        get_driving_figures get_metrics list_webhooks list_maps list_localization_maps get_localization_map
        get_localization_manifest get_localization_tile export_map list_map_drafts get_map_draft
        check_map_draft compare_map_draft try_map_draft export_map_draft list_scan_requests list_map_proposals
        get_map_proposal get_map_proposal_picture get_map_proposal_file""",
        frozenset(ROLES),
        "read",
    ),
    ("incident_history read_shift_log", frozenset(ROLES), ""),
    (
        """cancel_ride_by_operator change_destination_by_operator cancel_series_by_operator close_road
        lift_closure preview_closure make_announcement end_announcement
        announce_in_vehicle reassign_rides book_for_caller""",
        frozenset({"dispatcher"}),
        "drive",
    ),
    (
        """put_service_trips preview_timetable put_service_pattern delete_service_pattern
        put_service_exception delete_service_exception
        put_vehicle_shifts delete_vehicle_shifts""",
        frozenset({"dispatcher"}),
        "",
    ),
    (
        "hold_vehicle resume_vehicle stop_vehicle_now recall_vehicle release_vehicle send_vehicle",
        frozenset({"safety"}),
        "drive",
    ),
    (
        "make_webhook rotate_webhook enable_webhook test_webhook delete_webhook",
        frozenset({"admin"}),
        "drive",
    ),
    (
        """preview_intervention preview_ride_delays mark_recording start_recording stop_recording
        ask_for_scene fork_the_past stop_fork store_localization_map put_localization_tile""",
        frozenset({"dispatcher", "safety"}),
        "drive",
    ),
    (
        """acknowledge_incident close_incident note_on_incident write_shift_log make_map_draft
        import_map_draft change_map_draft mend_map_draft discard_map_draft request_scans end_scan_request
        propose_map stop_map_proposal dismiss_map_proposal watch_video get_video_segment
        ask_for_camera get_camera_picture""",
        frozenset({"dispatcher", "safety"}),
        "",
    ),
    (
        """evacuate_vehicle place_vehicle set_vehicle_position publish_map_draft activate_map
        activate_localization_map remove_localization_map publish_map_proposal""",
        frozenset({"safety"}),
        "",
    ),
    (
        """erase_ride erase_series list_operators create_operator change_operator reset_operator_password
        reset_operator_second_factor list_audit_entries verify_audit_log follow_audit_entry retire_vehicle
        revoke_vehicle_key make_enrolment_code list_tokens make_token revoke_token""",
        frozenset({"admin"}),
        "",
    ),
)
METHODS: Mapping[str, str] = {
    "list_vehicles": "read",
    "list_stops": "read",
    "list_rides": "read",
    "subscribe": "read",
    "unsubscribe": "read",
    "send_to_stop": "drive",
    "pause": "drive",
    "resume": "drive",
}
REFUSED = ("session_expired", "token_invalid", "scope_missing", "role_missing", "csrf_missing")
NOTHING = {"day": "2030-01-01", "sha256": 64 * "0", "number": "1", "map_version": 64 * "0"}


@dataclass(frozen=True)
class Visitor:
    """roles: of an operator, None for others; scopes: of a token that is good."""

    name: str
    headers: Mapping[str, str] = field(default_factory=dict)
    roles: frozenset[str] | None = None
    scopes: frozenset[str] = frozenset()
    with_csrf: bool = True
    has_bad_token: bool = False


async def matrix(target: Target) -> tuple[int, list[str]]:
    """How many cells were measured, and those that were otherwise than the table says."""
    visitors = await _visitors(target)
    cells, leaks = 0, []
    for method, path, operation_id in _operations():
        for visitor in visitors:
            cells += 1
            found = await _is_let_in(target, method, path, visitor)
            if found != _may(operation_id, method, visitor):
                leaks.append(f"{method} {path} by {visitor.name}: {'let in' if found else 'refused'}")
    for measured in (_links, _developer_socket, _live_socket):
        more, found_leaks = await measured(target, visitors)
        cells, leaks = cells + more, leaks + found_leaks
    return cells, leaks


def _operations() -> list[tuple[str, str, str]]:
    return [
        (method.upper(), path.removeprefix(PREFIX), operation["operationId"])
        for path, methods in bare_app().openapi()["paths"].items()
        for method, operation in methods.items()
    ]


async def _visitors(target: Target) -> list[Visitor]:
    ride, vehicle_id = await target.book(), await target.enrol()
    gone = await target.session("admin", "safety", "dispatcher")
    await target.ask("DELETE", "/session", gone.headers)
    initial = await target.session("admin", "safety", "dispatcher", initial=True)
    everything = await target.session(*ROLES)
    signature = hashlib.sha256(b"of another").hexdigest()
    visitors = [
        Visitor("a stranger"),
        Visitor("a rider with a link", bearer(ride["token"]), has_bad_token=True),
        Visitor("a vehicle's key", {"Vehicle-Id": vehicle_id, "Vehicle-Signature": signature}),
        Visitor("a signed-out operator", gone.headers),
        Visitor("an operator with an initial password", initial.headers, frozenset({"own session"})),
        Visitor("a cookie without CSRF token", everything.cookie, frozenset(ROLES), with_csrf=False),
        Visitor("a revoked token", bearer(await target.revoked("read", "drive")), has_bad_token=True),
        Visitor("an expired token", bearer(await target.expired("read", "drive")), has_bad_token=True),
    ]
    for role in ROLES:
        session = await target.session(role)
        visitors.append(Visitor(f"operator: {role}", session.headers, frozenset({role, "viewer"})))
    visitors.append(Visitor("operator: all roles", everything.headers, frozenset(ROLES)))
    for scopes in SCOPE_SETS:
        secret = (await target.token(*scopes)).secret
        visitors.append(Visitor(f"token: {' '.join(scopes)}", bearer(secret), scopes=frozenset(scopes)))
    return visitors


def _may(operation_id: str, method: str, visitor: Visitor) -> bool | None:
    """None for an operation that the table does not name: never what is found."""
    if operation_id in PUBLIC.split() + BY_LINK.split() + BY_SECRET.split():
        return True
    if operation_id in BOOKINGS.split():
        return not visitor.has_bad_token and (not visitor.scopes or "drive" in visitor.scopes)
    has_csrf = method == "GET" or visitor.with_csrf
    if operation_id in OWN_SESSION.split():
        return visitor.roles is not None and has_csrf
    for operation_ids, roles, scope in GUARDED:
        if operation_id in operation_ids.split():
            return scope in visitor.scopes or bool(has_csrf and roles & (visitor.roles or frozenset()))
    return None


async def _is_let_in(target: Target, method: str, path: str, visitor: Visitor) -> bool:
    for name, example in NOTHING.items():
        path = path.replace("{" + name + "}", example)
    if (method, path) == ("DELETE", "/session") and visitor.roles is not None:
        visitor = await _with_a_session_to_lose(target, visitor)
    answer = await target.ask(method, path.replace("{", "nothing-").replace("}", ""), dict(visitor.headers))
    if answer.status_code >= 500:
        raise AssertionError(f"{method} {path} by {visitor.name}: {answer.text[:200]}")
    if answer.status_code not in (401, 403) or "json" not in answer.headers.get("content-type", ""):
        return True
    return answer.json()["code"] not in (*REFUSED, "password_change_needed")


async def _with_a_session_to_lose(target: Target, visitor: Visitor) -> Visitor:
    session: Session = await target.session("viewer")
    headers = session.headers if visitor.with_csrf else session.cookie
    return Visitor(visitor.name, headers, visitor.roles, with_csrf=visitor.with_csrf)


async def _links(target: Target, _: list[Visitor]) -> tuple[int, list[str]]:
    """Ownership: the holder's link, another ride's, and another's with this ride's id."""
    mine, theirs = await target.book(), await target.book()
    forged = mine["token"][:24] + theirs["token"][24:]
    leaks, cells = [], 0
    changes = ("", "/cancel", "/board", "/alight", "/help", "/destination", "/taps/tap-1")
    for change in changes:
        cells += 1
        method = "GET" if change in ("", "/taps/tap-1") else "POST"
        body = {"to_stop": "C6"} if change == "/destination" else {}
        answer = await target.ask(method, f"/rides/{forged}{change}", json=body)
        if answer.json().get("code") not in ("ride_unknown", "payload_invalid"):
            leaks.append(f"{method} /rides/(forged){change}: {answer.text[:100]}")
    cells += 1
    shown = (await target.ask("GET", f"/rides/{mine['token']}")).json()
    if shown["ride_code"] != mine["ride_code"]:
        leaks.append("a link shows another ride")
    return cells, leaks


async def _developer_socket(target: Target, visitors: list[Visitor]) -> tuple[int, list[str]]:
    leaks, cells = [], 0
    for visitor in visitors:
        for method, scope in METHODS.items():
            cells += 1
            # The connection itself needs the scope read.
            allowed = {"read", scope} <= visitor.scopes
            if await _calls(target, visitor, method) != allowed:
                leaks.append(f"/ws/developer {method} by {visitor.name}")
    return cells, leaks


async def _calls(target: Target, visitor: Visitor, method: str) -> bool:
    request = {"jsonrpc": "2.0", "id": 1, "method": method, "params": {}}
    url = target.websocket("/ws/developer")
    try:
        async with connect(url, additional_headers=dict(visitor.headers), proxy=None) as socket:
            await socket.send(json.dumps(request))
            answer = json.loads(await socket.recv())
    except ConnectionClosed:
        return False
    return answer.get("id") == 1 and answer.get("error", {}).get("code") != -32001


async def _live_socket(target: Target, visitors: list[Visitor]) -> tuple[int, list[str]]:
    leaks = []
    for visitor in visitors:
        url = target.websocket("/ws/live")
        async with connect(url, additional_headers=dict(visitor.headers), proxy=None) as socket:
            await socket.send('{"type":"watch"}')
            found = '"refused"' not in str(await socket.recv())[:60]
        if found != bool(frozenset(ROLES) & (visitor.roles or frozenset())):
            leaks.append(f"/ws/live by {visitor.name}: {'let in' if found else 'refused'}")
    return len(visitors), leaks
