"""The token that a websocket was opened with."""

from fastapi import WebSocket


def bearer_of(websocket: WebSocket) -> str:
    """The secret of `Authorization: Bearer SECRET`, empty without one."""
    kind, _, secret = websocket.headers.get("authorization", "").partition(" ")
    return secret.strip() if kind.lower() == "bearer" else ""
