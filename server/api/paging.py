"""Lists in pages: a cursor stands for the last item of a page; the header `Link` leads to the next one.

A cursor names the item by what the list is sorted by, so that items which come or go meanwhile neither
repeat nor hide others.
"""

import base64
import binascii
from collections.abc import Callable, Iterable, Sequence
from datetime import UTC, datetime, timedelta
from typing import Annotated, Any, TypeVar

import msgspec
from fastapi import Depends, Query, Request, Response

from server.api.problems import CursorInvalid, problems
from server.domain.errors import DomainError

T = TypeVar("T")
Position = tuple[int | str, ...]

LIMIT_MAX = 500
_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
_MICROSECOND = timedelta(microseconds=1)
# The year 2200: no list has anything later.
_MICROSECONDS_MAX = 7_258_118_400_000_000
# What JavaScript and every column hold exactly; no text that a database refuses.
_Number = Annotated[int, msgspec.Meta(ge=-(1 << 53), le=1 << 53)]
_Text = Annotated[str, msgspec.Meta(max_length=200, pattern=r"^[^\x00-\x1f]*$")]
_Steps = Annotated[tuple[_Number | _Text, ...], msgspec.Meta(min_length=1, max_length=5)]

Cursor = Annotated[
    str | None,
    Query(max_length=400, description="From the previous page's header `Link` (rel=next); opaque."),
]
ListLimit = Annotated[
    int | None, Query(ge=1, le=LIMIT_MAX, description="How many at most; left out: all, in one page.")
]
_LINK: dict[str, Any] = {
    "Link": {
        "description": 'The next page, if there is one (RFC 8288): `<...?cursor=...>; rel="next"`.',
        "schema": {"type": "string"},
    }
}


def paged(*kinds: type[DomainError]) -> dict[int | str, dict[str, Any]]:
    """The `responses` of a list that may refuse for these reasons, its link to the next page included."""
    return problems(CursorInvalid, *kinds) | {200: {"headers": _LINK}}


class PageOfList:
    """The page that a request asks for."""

    def __init__(self, request: Request, response: Response, cursor: str | None) -> None:
        self._request, self._response = request, response
        self._after = None if cursor is None else position_of(cursor)

    def after(self, *kinds: type) -> Position | None:
        """Where the previous page ended, as values of these kinds; None for the first page.

        Raises CursorInvalid.
        """
        return None if self._after is None else of_kinds(self._after, *kinds)

    def first(self, found: Sequence[T], limit: int, position: Callable[[T], Position]) -> list[T]:
        """The first `limit` of what was found from `after` on, one more than the limit being looked for."""
        shown = list(found[:limit])
        if len(found) > limit:
            self._lead_to(position(shown[-1]))
        return shown

    def cut(self, items: Iterable[T], limit: int | None, position: Callable[[T], Position]) -> list[T]:
        """This page of a list that is known whole, sorted by `position`."""
        ordered = sorted(items, key=position)
        if self._after is not None and ordered:
            after = self.after(*(type(value) for value in position(ordered[0])))
            ordered = [item for item in ordered if position(item) > (after or ())]
        return ordered if limit is None else self.first(ordered, limit, position)

    def _lead_to(self, position: Position) -> None:
        url = self._request.url.include_query_params(cursor=cursor_of(position))
        self._response.headers["Link"] = f'<{url.path}?{url.query}>; rel="next"'


async def _page(request: Request, response: Response, cursor: Cursor = None) -> PageOfList:
    return PageOfList(request, response, cursor)


Page = Annotated[PageOfList, Depends(_page)]


def microseconds_of(moment: datetime) -> int:
    """Since the Unix epoch; positions hold no other form of time."""
    return (moment - _EPOCH) // _MICROSECOND


def moment_of(microseconds: int | str) -> datetime:
    """Raises CursorInvalid."""
    if not isinstance(microseconds, int) or not 0 <= microseconds <= _MICROSECONDS_MAX:
        raise CursorInvalid("this cursor names no moment; begin without one")
    return _EPOCH + microseconds * _MICROSECOND


def of_kinds(position: Position, *kinds: type) -> Position:
    """The position, if its values are of these kinds. Raises CursorInvalid."""
    if [type(value) for value in position] != list(kinds):
        raise CursorInvalid("this list did not give this cursor; begin without one")
    return position


def cursor_of(position: Position) -> str:
    return base64.urlsafe_b64encode(msgspec.json.encode(position)).decode().rstrip("=")


def position_of(cursor: str) -> Position:
    """Raises CursorInvalid."""
    try:
        text = base64.b64decode(cursor + "=" * (-len(cursor) % 4), altchars="-_", validate=True)
        position: Position = msgspec.json.decode(text, type=_Steps)
    except (binascii.Error, ValueError) as error:
        raise CursorInvalid("the cursor cannot be read; take it from the header Link as it is") from error
    return position
