"""What the audit log says of a request: where it came from, what it asked for."""

from fastapi import Request
from starlette.requests import HTTPConnection

TARGET_CHARACTERS_MAX = 500


def address_of(connection: HTTPConnection) -> str:
    """The client's own address, not the network whose budget it takes from."""
    return connection.client.host if connection.client else ""


def operation_of(request: Request) -> str:
    """The operation id of the endpoint."""
    return str(request.scope["route"].operation_id)


def subject_of(request: Request) -> str:
    """The ids in the path. A passenger's link would be among them: only for endpoints of operators."""
    return " ".join(request.path_params.values())


def target_of(request: Request) -> str:
    query = f"?{request.url.query}" if request.url.query else ""
    return f"{request.method} {request.url.path}{query}"[:TARGET_CHARACTERS_MAX]
