"""Why a vehicle keeps what it has of a kind of map, when the server announces another one."""


class NotTaken(Exception):
    """The vehicle keeps the map that it has: a stable code, and what was wrong."""

    def __init__(self, code: str, detail: str) -> None:
        super().__init__(f"{code}: {detail}")
        self.code = code
        self.detail = detail
