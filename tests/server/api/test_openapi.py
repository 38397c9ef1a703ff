"""The API against its own description: generated requests, every answer checked."""

import json
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

import httpx
import pytest
import schemathesis
from hypothesis import HealthCheck, Phase, settings
from schemathesis.checks import not_a_server_error
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    response_schema_conformance,
    status_code_conformance,
)

from server.api.routers import bare_app
from tests.server.api.server_under_test import ServerUnderTest

DOCUMENT = bare_app().openapi()
SCHEMA = schemathesis.openapi.from_dict(DOCUMENT)
CHECKS = [
    not_a_server_error,
    status_code_conformance,
    content_type_conformance,
    response_schema_conformance,
]
# A ride has a handful of decisions, and a run of marks; scenes are asked on by their time.
BOUNDED_LISTS = {
    "list_current_announcements",
    "explain_ride",
    "ride_history",
    "incident_history",
    "read_shift_log",
    "get_run_scenes",
    "get_run_marks",
    "get_run_onboard",
    "get_run_scans",
}
BOUNDED = settings(
    max_examples=3,
    deadline=None,
    derandomize=True,
    phases=(Phase.explicit, Phase.generate),
    suppress_health_check=list(HealthCheck),
)


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServerUnderTest]:
    server = ServerUnderTest(
        tmp_path_factory.mktemp("var"),
        bookings_per_minute=100_000,
        lookups_per_minute=100_000,
        login_tries_per_minute=100_000,
        account_login_tries_per_minute=100_000,
        commands_per_minute=100_000,
    )
    yield server
    server.close()


def send(server: ServerUnderTest, case: schemathesis.Case, headers: dict[str, str]) -> httpx.Response:
    given: dict[str, Any] = case.as_transport_kwargs(base_url="http://campus.test")
    options = {key: given[key] for key in ("params", "cookies", "json") if given.get(key) is not None}
    if given.get("data") is not None:
        options["content"] = given["data"]
    sent = {
        name: str(value).encode("utf-8")
        for name, value in {**(given.get("headers") or {}), **headers}.items()
    }
    request = server.client.build_request(given["method"], given["url"], headers=sent, **options)
    return server.run(server.client.send(request))


@SCHEMA.parametrize()
@BOUNDED
def test_whoever_is_not_signed_in_gets_answers_as_described(
    case: schemathesis.Case, running: ServerUnderTest
) -> None:
    running.client.cookies.clear()
    case.validate_response(send(running, case, {}), checks=CHECKS)


@SCHEMA.parametrize()
@BOUNDED
def test_an_operator_gets_answers_as_described(case: schemathesis.Case, running: ServerUnderTest) -> None:
    running.client.cookies.clear()
    headers = running.sign_in()
    headers["Cookie"] = f"campusloop_session={running.client.cookies['campusloop_session']}"
    case.validate_response(send(running, case, headers), checks=CHECKS)


def operations() -> Iterator[tuple[str, str, dict[str, Any]]]:
    for path, methods in DOCUMENT["paths"].items():
        for method, operation in methods.items():
            yield path, method, operation


def test_every_operation_has_a_name_of_its_own_a_tag_and_a_success() -> None:
    names = [operation["operationId"] for _, _, operation in operations()]
    assert len(set(names)) == len(names)
    for path, method, operation in operations():
        assert operation["tags"], (path, method)
        assert any(status.startswith("2") for status in operation["responses"]), (path, method)


def test_every_change_by_an_operator_needs_cookie_and_csrf_token_together() -> None:
    for _, method, operation in operations():
        schemes = [set(scheme) for scheme in operation["security"]]
        if method != "get" and any("OperatorSession" in scheme for scheme in schemes):
            assert schemes[0] == {"OperatorSession", "CsrfToken"}


def test_a_developer_token_reads_with_one_scope_and_changes_with_the_other() -> None:
    for path, method, operation in operations():
        for scheme in operation["security"]:
            if "DeveloperToken" in scheme:
                assert scheme == {"DeveloperToken": ["read" if method == "get" else "drive"]}, path


def test_every_list_can_be_read_page_by_page() -> None:
    for path, method, operation in operations():
        content = operation["responses"].get("200", {}).get("content", {}).get("application/json", {})
        is_list = content.get("schema", {}).get("type") == "array"
        if method == "get" and is_list and operation["operationId"] not in BOUNDED_LISTS:
            assert {"cursor", "limit"} <= {one["name"] for one in operation["parameters"]}, path
            assert "Link" in operation["responses"]["200"]["headers"], path


def test_every_reference_of_the_document_leads_somewhere() -> None:
    text = json.dumps(DOCUMENT)
    for name in {part.split('"')[0] for part in text.split("#/components/schemas/")[1:]}:
        assert name in DOCUMENT["components"]["schemas"]


def test_the_live_views_shapes_are_part_of_the_document() -> None:
    assert {"Scene", "Snapshot", "Delta", "Watch", "Refused"} <= set(DOCUMENT["components"]["schemas"])


def test_the_document_is_the_same_in_another_process_with_another_hash_seed() -> None:
    program = "from campusloop.commands.openapi import openapi; openapi()"
    texts = {
        subprocess.run(
            [sys.executable, "-c", program],
            env={"PYTHONHASHSEED": seed, "PATH": ""},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("1", "99")
    }
    assert len(texts) == 1
    assert json.loads(texts.pop()) == json.loads(json.dumps(DOCUMENT))
