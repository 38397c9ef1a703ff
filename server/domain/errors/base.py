"""What every refusal is."""


class DomainError(Exception):
    """A request is refused. `code` is stable and machine-readable; `detail` says what to do.

    rule   the dispatcher's binding rule if one is the reason, "" otherwise
    """

    code = "refused"
    rule = ""

    def __init__(self, detail: str) -> None:
        super().__init__(detail)
        self.detail = detail
