import importlib
import pkgutil

import server.api
from server.api.problems import STATUS
from server.domain.errors import DomainError
from tests.server.api.server_under_test import ServerUnderTest


def all_errors() -> set[type[DomainError]]:
    for module in pkgutil.walk_packages(server.api.__path__, "server.api."):
        importlib.import_module(module.name)
    found: set[type[DomainError]] = set()
    waiting = [DomainError]
    while waiting:
        for child in waiting.pop().__subclasses__():
            # Of the loops no client hears.
            if child.__module__.startswith("server.") and not child.__module__.startswith("server.loops."):
                found.add(child)
                waiting.append(child)
    return found


def test_every_refusal_of_the_house_has_a_row_in_the_table() -> None:
    assert {kind.__name__ for kind in all_errors() - set(STATUS)} == set()


def test_codes_are_unique_and_no_refusal_is_a_422() -> None:
    codes = [kind.code for kind in STATUS]
    assert len(set(codes)) == len(codes)
    assert 422 not in STATUS.values()


def test_a_payload_that_does_not_fit_is_a_422_that_names_the_field(server: ServerUnderTest) -> None:
    problem = server.post("/rides", {"from_stop": "NN7", "party": 0})
    assert problem.status_code == 422
    assert problem.headers["content-type"] == "application/problem+json"
    assert {field["where"] for field in problem.json()["errors"]} == {"body.to_stop", "body.party"}


def test_a_body_that_is_no_json_is_a_422(server: ServerUnderTest) -> None:
    headers = {"Content-Type": "application/json"}
    for content in (b"{", b"\xff\xfe", b"[" * 50_000):
        answer = server.request("POST", "/rides", content=content, headers=headers)
        assert answer.status_code in (400, 422), content[:10]
        assert answer.headers["content-type"] == "application/problem+json"


def test_a_body_larger_than_any_request_is_refused(server: ServerUnderTest) -> None:
    answer = server.post("/rides", {"from_stop": "a" * 100_000, "to_stop": "b"})
    assert answer.status_code == 413
    assert answer.headers["content-type"] == "application/problem+json"


def test_a_method_that_a_path_does_not_know_is_a_405(server: ServerUnderTest) -> None:
    answer = server.request("DELETE", "/campus")
    assert answer.status_code == 405
    assert answer.json()["code"] == "method_not_allowed"
