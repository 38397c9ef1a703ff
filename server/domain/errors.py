"""What can be refused, by name. `api/problems.py` maps each code to a status."""


class DomainError(Exception):
    """A rule of the house said no. `code` is stable and machine-readable; `detail` says what to do."""

    code = "refused"

    def __init__(self, detail: str) -> None:
        super().__init__(detail)
        self.detail = detail
