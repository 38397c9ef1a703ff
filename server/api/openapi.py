"""The OpenAPI document: what FastAPI derives, with problem details and the live view's shapes made exact."""

from typing import Any

import msgspec
from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from pydantic.json_schema import models_json_schema

from server.api.problems import MEDIA_TYPE, Problem
from server.api.sockets.live import Refused, Watch
from server.live.scene import Delta, Scene, Snapshot

DESCRIPTION = """Book rides, follow them, run the fleet.

Passengers need no account: a booking's answer holds a `token`, which is the secret of the ride's link.
Operators sign in at `/session`; every change then needs the header `X-CSRF-Token`.
Refusals are problem details (RFC 9457): programs read `code`, people read `detail`.

`/ws/live` sends `Snapshot`, then `Delta`; its first frame from the client is `Watch`. See docs/protocol for
the three websockets.
"""
SCHEMA_REF = "#/components/schemas/{name}"


def openapi_of(app: FastAPI, version: str) -> dict[str, Any]:
    """The whole document; the same bytes for the same code."""
    document = get_openapi(
        title="Campusloop", version=version, description=DESCRIPTION, routes=app.routes, servers=None
    )
    schemas = document.setdefault("components", {}).setdefault("schemas", {})
    schemas.update(_problem_schemas())
    schemas.update(_live_schemas())
    for unused in ("HTTPValidationError", "ValidationError"):
        schemas.pop(unused, None)
    document["components"]["schemas"] = dict(sorted(schemas.items()))
    for operations in document["paths"].values():
        for operation in operations.values():
            _declare_invalid_payload(operation)
            _need_all_schemes(operation)
    return document


def _problem_schemas() -> dict[str, Any]:
    _, definitions = models_json_schema(
        [(Problem, "serialization")], ref_template="#/components/schemas/{model}"
    )
    schemas: dict[str, Any] = definitions["$defs"]
    return schemas


def _live_schemas() -> dict[str, Any]:
    _, schemas = msgspec.json.schema_components(
        [Scene, Snapshot, Delta, Watch, Refused], ref_template=SCHEMA_REF
    )
    return schemas


def _declare_invalid_payload(operation: dict[str, Any]) -> None:
    responses = operation.get("responses", {})
    if "422" in responses:
        responses["422"] = _problem_response("The request does not fit its schema.")
    if "requestBody" in operation:
        responses.setdefault("400", _problem_response("The body is not text."))
        responses.setdefault("413", _problem_response("The body is larger than allowed."))
        operation["responses"] = dict(sorted(responses.items()))


def _problem_response(description: str) -> dict[str, Any]:
    schema = {"$ref": SCHEMA_REF.format(name="Problem")}
    return {"description": description, "content": {MEDIA_TYPE: {"schema": schema}}}


def _need_all_schemes(operation: dict[str, Any]) -> None:
    # Listed apart, schemes would be alternatives; a change needs cookie and token together.
    if len(operation.get("security", [])) > 1:
        operation["security"] = [{name: [] for scheme in operation["security"] for name in scheme}]
