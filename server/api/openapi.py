"""The OpenAPI document: what FastAPI derives, with problem details, security, examples and the live view's
shapes made exact, so that linters and client generators accept it.
"""

from collections.abc import Iterator
from typing import Any

import msgspec
from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

from server.api.problems import MEDIA_TYPE, Problem
from server.api.sockets.live import Refused, Watch
from server.domain.record.statistics import DrivingFigures, ServiceFigures
from server.live.camera_pictures import ShownCamera
from server.live.onboard_scenes import ShownScene
from server.live.past import FleetPast, FleetPositions
from server.live.recorded_onboard import OnboardMoment
from server.live.recorded_scans import ScanMoment
from server.live.scene import Delta, Scene, Snapshot

DESCRIPTION = """Book rides, follow them, run the fleet.

Passengers need no account: a booking's answer holds a `token`, which is the secret of the ride's link.
Operators sign in at `/session`; every change then needs the header `X-CSRF-Token`.
Refusals are problem details (RFC 9457): programs read `code`, people read `detail`.

`/ws/live` sends `Snapshot`, then `Delta`; its first frame from the client is `Watch`. See docs/protocol for
the three websockets.
"""
SCHEMA_REF = "#/components/schemas/{name}"
SERVERS = [{"url": "/", "description": "The server that this document comes from."}]
LICENSE = {"name": "Apache-2.0", "identifier": "Apache-2.0"}
SESSION_SCHEME, DEVELOPER_SCHEME = "OperatorSession", "DeveloperToken"


def openapi_of(app: FastAPI, version: str) -> dict[str, Any]:
    """The whole document; the same bytes for the same code."""
    document = get_openapi(
        title="Campusloop",
        version=version,
        description=DESCRIPTION,
        routes=app.routes,
        servers=SERVERS,
        license_info=LICENSE,
    )
    schemas = document.setdefault("components", {}).setdefault("schemas", {})
    for more in (_problem_schemas(), _live_schemas()):
        clashing = {name for name in more if schemas.get(name, more[name]) != more[name]}
        assert not clashing, f"two schemas have one name: {sorted(clashing)}"
        schemas.update(more)
    for unused in ("HTTPValidationError", "ValidationError"):
        schemas.pop(unused, None)
    _give_examples(schemas)
    document["components"]["schemas"] = dict(sorted(schemas.items()))
    for operations in document["paths"].values():
        for operation in operations.values():
            _declare_invalid_payload(operation)
            _declare_security(operation)
    return document


def _give_examples(schemas: dict[str, Any]) -> None:
    # FastAPI leaves nulls out of examples, also those of required fields.
    for model in _models(BaseModel):
        extra = model.model_config.get("json_schema_extra")
        if isinstance(extra, dict) and "example" in extra and model.__name__ in schemas:
            schemas[model.__name__]["example"] = extra["example"]


def _models(kind: type[BaseModel]) -> Iterator[type[BaseModel]]:
    """The API's own models that are derived from `kind`."""
    for model in kind.__subclasses__():
        if model.__module__.startswith("server.api."):
            yield model
        yield from _models(model)


def _problem_schemas() -> dict[str, Any]:
    _, definitions = models_json_schema(
        [(Problem, "serialization")], ref_template="#/components/schemas/{model}"
    )
    schemas: dict[str, Any] = definitions["$defs"]
    return schemas


def _live_schemas() -> dict[str, Any]:
    _, schemas = msgspec.json.schema_components(
        [
            Scene,
            Snapshot,
            Delta,
            Watch,
            Refused,
            FleetPast,
            FleetPositions,
            OnboardMoment,
            ScanMoment,
            ShownScene,
            ShownCamera,
            ServiceFigures,
            DrivingFigures,
        ],
        ref_template=SCHEMA_REF,
    )
    _end_tuples(schemas)
    return schemas


def _end_tuples(node: object) -> None:
    """Say how long a tuple is by `maxItems` alone: client generators refuse `items: false`."""
    if isinstance(node, dict):
        if node.get("items") is False and node.get("maxItems") == len(node.get("prefixItems", ())):
            del node["items"]
        for value in node.values():
            _end_tuples(value)
    elif isinstance(node, list):
        for value in node:
            _end_tuples(value)


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


def _declare_security(operation: dict[str, Any]) -> None:
    """Say which schemes are alternatives: cookie and CSRF token together, a developer token, or none.

    FastAPI lists every scheme alone, and nothing for an endpoint without one.
    """
    schemes = {name: roles for scheme in operation.get("security", []) for name, roles in scheme.items()}
    developer = {name: schemes.pop(name) for name in (DEVELOPER_SCHEME,) if name in schemes}
    alternatives = [schemes] if schemes else []
    if len(schemes.get(SESSION_SCHEME, ())) > 1:
        # OpenAPI would ask for all the roles of one entry.
        alternatives = [schemes | {SESSION_SCHEME: [role]} for role in schemes[SESSION_SCHEME]]
    operation["security"] = [*alternatives, developer] if developer else alternatives
