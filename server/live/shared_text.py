"""The text of a message that many viewers get: encoded once."""

import msgspec

from server.live.scene import Delta, Snapshot


class SharedText:
    """Keeps the text of the last message. Viewers of one moment are served one after the other."""

    def __init__(self) -> None:
        self._last: tuple[Snapshot | Delta, str] | None = None

    def of(self, message: Snapshot | Delta) -> str:
        if self._last is None or self._last[0] is not message:
            self._last = message, msgspec.json.encode(message).decode()
        return self._last[1]
