"""Sending to addresses of developers."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True, slots=True)
class WebhookAnswer:
    """status 0: nothing came back, and cause says why. It never holds the address."""

    status: int
    cause: str = ""

    @property
    def failure(self) -> str:
        """Empty if the message has arrived."""
        if 200 <= self.status < 300:
            return ""
        return self.cause or f"it answered {self.status}"

    @property
    def is_gone(self) -> bool:
        return self.status == 410


class WebhookSender(Protocol):
    async def send(self, url: str, headers: Mapping[str, str], body: bytes) -> WebhookAnswer:
        """One attempt, within a limited time. It raises nothing that the address or network causes."""
        ...
