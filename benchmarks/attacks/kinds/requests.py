"""Attacks by malformed requests. They succeed with a 500, a leak, or a server that waits."""

import asyncio
import base64
import gzip
import json
import time

from benchmarks.attacks.attack import allows, attack
from benchmarks.attacks.target import Target, bearer
from campusloop.live.connections import bounded_http
from campusloop.live.connections.bounded_http import BoundedHttp

JSON = {"Content-Type": "application/json"}
HEAD_ANSWERED_WITHIN_S = 15.0


async def _raw(target: Target, data: bytes, within_s: float = 5.0) -> bytes:
    reader, writer = await asyncio.open_connection("127.0.0.1", target.settings.port)
    try:
        writer.write(data)
        async with asyncio.timeout(within_s):
            return await reader.read(65_536)
    except (TimeoutError, ConnectionError):
        return b""
    finally:
        writer.close()


async def _fetched(target: Target, path: str) -> bytes:
    head = f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n"
    return await _raw(target, head.encode("latin-1"))


def _leaks_file(answer: bytes) -> bool:
    return b"root:" in answer or b"SQLite format" in answer


async def _body_fails(target: Target, body: bytes, headers: dict[str, str] | None = None) -> bool:
    """The server fails, or takes the body."""
    answer = await target.ask("POST", "/rides", JSON | (headers or {}), content=body)
    return answer.status_code >= 500 or answer.status_code < 400


@attack("pages are read at the start, by name")
async def a_path_leads_out_of_the_pages(target: Target) -> bool:
    return _leaks_file(await _fetched(target, "/../../../../../../etc/passwd"))


@attack("pages are read at the start, by name")
async def an_encoded_path_leads_out_of_the_pages(target: Target) -> bool:
    return _leaks_file(await _fetched(target, "/%2e%2e/%2e%2e/%2e%2e/%2e%2e/etc/passwd"))


@attack("pages are read at the start, by name")
async def a_path_leads_to_the_database(target: Target) -> bool:
    answers = [await _fetched(target, path) for path in ("/../campusloop.db", "/..%2fcampusloop.db")]
    return any(map(_leaks_file, answers))


@attack("segments are named by a hash")
async def a_segment_path_leads_out(target: Target) -> bool:
    secret = (await target.token("read")).secret
    answer = await target.ask("GET", "/runs/segments/..%2f..%2fcampusloop.db", bearer(secret))
    return answer.status_code == 200 or answer.status_code >= 500


@attack("limit of a body")
async def a_body_of_a_mebibyte_is_taken(target: Target) -> bool:
    return await _body_fails(target, b'{"from_stop":"' + b"x" * (1 << 20) + b'"}')


@attack("compressed bodies are not unpacked")
async def a_compressed_bomb_is_unpacked(target: Target) -> bool:
    bomb = gzip.compress(b" " * (10 << 20))
    return await _body_fails(target, bomb, {"Content-Encoding": "gzip"})


@attack("JSON is parsed to a depth")
async def a_nested_bomb_breaks_the_parser(target: Target) -> bool:
    return await _body_fails(target, b"[" * 30_000 + b"]" * 30_000)


@attack("numbers have bounds")
async def an_endless_number_is_taken(target: Target) -> bool:
    body = b'{"from_stop":"NN7","to_stop":"C6","party":' + b"9" * 20_000 + b"}"
    return await _body_fails(target, body)


@attack("numbers have bounds")
async def not_a_number_is_taken(target: Target) -> bool:
    return await _body_fails(target, b'{"from_stop":"NN7","to_stop":"C6","party":NaN}')


@attack("texts are text")
async def a_lone_surrogate_breaks_the_store(target: Target) -> bool:
    return await _body_fails(target, b'{"from_stop":"\\ud800","to_stop":"C6"}')


@attack("texts are text")
async def a_null_character_breaks_the_store(target: Target) -> bool:
    return await _body_fails(target, b'{"from_stop":"N\\u0000","to_stop":"C6"}')


@attack("schemas forbid what they do not know")
async def an_unknown_field_is_taken(target: Target) -> bool:
    session = await target.session("admin")
    body = {"name": target.fresh("friend"), "roles": [], "password_hash": "plain", "operator_id": "x"}
    return (await target.ask("POST", "/operators", session.headers, json=body)).status_code == 201


@attack("duplicate keys mean the same to all: the last one, of which the schema is asked")
async def a_duplicate_key_passes_the_schema(target: Target) -> bool:
    session = await target.session("admin")
    body = f'{{"name":"{target.fresh("friend")}","roles":[],"roles":["god"]}}'.encode()
    answer = await target.ask("POST", "/operators", session.headers | JSON, content=body)
    return answer.status_code == 201


@attack("parameters are bound in SQL")
async def sql_in_a_filter_finds_everything(target: Target) -> bool:
    session = await target.session("admin")
    answer = await target.ask("GET", "/audit?by=' OR 1=1 --", session.cookie)
    return answer.status_code != 200 or answer.json() != []


@attack("ids have a pattern")
async def sql_in_a_path_reaches_the_store(target: Target) -> bool:
    secret = (await target.token("read")).secret
    answer = await target.ask("GET", "/vehicles/x'; DROP TABLE rides; --", bearer(secret))
    return answer.status_code != 422


@attack("names are bound and shown as text")
async def sql_in_a_name_breaks_sign_in(target: Target) -> bool:
    body = {"name": "' OR '1'='1", "password": "' OR '1'='1"}
    return (await target.ask("POST", "/session", json=body)).status_code != 401


@attack("names hold no control characters")
async def a_name_forges_a_line_of_the_log(target: Target) -> bool:
    body = {"name": "x\n2026-01-01 00:00:00 [info] operator.logged_in", "password": "x"}
    return (await target.ask("POST", "/session", json=body)).status_code != 422


@attack("heads hold no control characters")
async def a_path_splits_the_answer(target: Target) -> bool:
    answer = await _fetched(target, "/%0d%0aSet-Cookie:%20campusloop_session=x")
    return b"\nset-cookie:" in answer.lower()


@attack("one length for one body")
async def a_request_is_smuggled(target: Target) -> bool:
    inner = b"GET /api/v1/health HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
    head = (
        b"POST /api/v1/rides HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\n"
        b"Content-Length: 5\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"
    )
    answer = await _raw(target, head + inner)
    return answer.count(b"HTTP/1.1 ") > 1 and b"200" in answer.split(b"HTTP/1.1 ")[2][:4]


@attack("one Host header")
async def two_hosts_pass_the_host_check(target: Target) -> bool:
    data = b"GET /api/v1/stops HTTP/1.1\r\nHost: 127.0.0.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n"
    return b" 200 " in (await _raw(target, data))[:20]


@attack("limit of a head", (bounded_http, "HEAD_BYTES_MAX", 1 << 40))
async def an_endless_head_is_read(target: Target) -> bool:
    head = b"GET /api/v1/stops HTTP/1.1\r\nHost: 127.0.0.1\r\n" + b"X-Filler: y\r\n" * 20_000
    return b" 431 " not in (await _raw(target, head, within_s=3.0))[:20]


@attack("time of a head", (BoundedHttp, "_expect_more_within", allows))
async def half_a_head_stays_open(target: Target) -> bool:
    begun = time.monotonic()
    await _raw(target, b"GET /api/v1/stops HTTP/1.1\r\nHost:", within_s=HEAD_ANSWERED_WITHIN_S)
    return time.monotonic() - begun >= HEAD_ANSWERED_WITHIN_S


@attack("methods are named")
async def a_header_overrides_the_method(target: Target) -> bool:
    session, vehicle_id = await target.session("admin"), await target.enrol()
    override = {"X-HTTP-Method-Override": "DELETE", "X-Method-Override": "DELETE"}
    await target.ask("GET", f"/vehicles/{vehicle_id}", session.headers | override)
    listed = await target.ask("GET", "/vehicles", session.headers)
    return vehicle_id not in listed.text


@attack("methods are named")
async def trace_echoes_the_cookie(target: Target) -> bool:
    session = await target.session("viewer")
    answer = await target.http.request("TRACE", "/api/v1/session", headers=session.cookie)
    return session.token in answer.text


@attack("cursors are read as data")
async def a_cursor_is_tampered_with(target: Target) -> bool:
    session = await target.session("admin")
    made = [json.dumps(one).encode() for one in (["' OR 1=1"], [1 << 60], [[]], {"a": 1}, [None], [-1])]
    cursors = [base64.urlsafe_b64encode(one).decode().rstrip("=") for one in made] + ["%00", "A" * 400]
    paths = [
        f"/{name}?cursor={one}" for name in ("rides", "audit", "operators", "vehicles") for one in cursors
    ]
    answers = [await target.ask("GET", path, session.cookie) for path in paths]
    return any(answer.status_code >= 500 for answer in answers)


@attack("errors name no code, path or secret")
async def an_error_shows_the_servers_insides(target: Target) -> bool:
    answers = [await target.ask("GET", path) for path in ("/rides/x", "/nothing", "/series/%ff", "/rides")]
    return any("Traceback" in answer.text or ".py" in answer.text for answer in answers)


@attack("metrics need a token")
async def a_stranger_reads_metrics(target: Target) -> bool:
    return (await target.ask("GET", "/metrics")).status_code == 200


@attack("answers tell no version of the software")
async def the_server_header_names_a_version(target: Target) -> bool:
    server = (await target.ask("GET", "/stops")).headers.get("server", "")
    return any(character.isdigit() for character in server)
