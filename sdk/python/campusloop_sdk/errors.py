"""The errors of the client.

Exception
 +-- RequestRefused   the server answered with a JSON-RPC error
 +-- ConnectionLost   the connection is closed; connect again with `connect`
"""


class RequestRefused(Exception):
    """The server refused a request.

    number  of the JSON-RPC error; code: the problem's code, "" when the error has none
    """

    def __init__(self, number: int, message: str, data: object = None) -> None:
        super().__init__(message)
        self.number, self.message, self.data = number, message, data
        self.code = data.get("code", "") if isinstance(data, dict) else ""


class ConnectionLost(Exception):
    """The server closed the connection; the text says why."""
