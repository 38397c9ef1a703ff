"""Content codings of bodies that are made once and sent often: brotli and gzip (RFC 9110, 8.4 and 12.5.3).

Only what is the same for everybody is compressed. Answers that hold secrets beside what a client sent are
not: their compressed lengths would tell of the secrets (BREACH).
"""

import gzip
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from starlette.responses import Response

Coding = Literal["br", "gzip"]
_CODINGS: tuple[Coding, ...] = ("br", "gzip")
# Below this a packet is sent either way.
_SMALLEST_BYTES = 1_000


@dataclass(frozen=True, slots=True)
class CodedBody:
    """A body, and the same in the codings that make it smaller."""

    plain: bytes
    coded: Mapping[Coding, bytes] = field(default_factory=dict)

    def response(
        self, accept_encoding: str, media_type: str, etag: str, headers: Mapping[str, str]
    ) -> Response:
        """In the best coding that the client takes. A coded body has an entity tag of its own."""
        coding = best_coding(accept_encoding, self.coded)
        own = {**headers, "ETag": tag_of(etag, coding), "Vary": "Accept-Encoding"}
        if coding is not None:
            own["Content-Encoding"] = coding
        body = self.plain if coding is None else self.coded[coding]
        return Response(body, media_type=media_type, headers=own)


def coded_body(plain: bytes, brotli: bytes | None = None) -> CodedBody:
    """brotli: the body in that coding, if somebody has made it."""
    found: dict[Coding, bytes] = {}
    if len(plain) >= _SMALLEST_BYTES:
        # mtime: the same body gives the same bytes.
        made = {"br": brotli, "gzip": gzip.compress(plain, 9, mtime=0)}
        for coding in _CODINGS:
            body = made[coding]
            if body is not None and len(body) < len(plain):
                found[coding] = body
    return CodedBody(plain, found)


def tag_of(etag: str, coding: Coding | None) -> str:
    """etag: of the plain body, in quotation marks"""
    return etag if coding is None else f'{etag[:-1]}-{coding}"'


def best_coding(accept_encoding: str, available: Mapping[Coding, bytes]) -> Coding | None:
    """The smallest available one that the header allows; None for the plain body."""
    weights: dict[str, float] = {}
    for part in accept_encoding.split(","):
        name, _, parameters = part.partition(";")
        weights[name.strip().lower()] = _weight(parameters)
    otherwise = weights.get("*", 0.0)
    return next((c for c in _CODINGS if c in available and weights.get(c, otherwise) > 0.0), None)


def _weight(parameters: str) -> float:
    """Of `q=0.5`; 1 without one, 0 for what is none."""
    name, _, value = parameters.partition("=")
    if name.strip().lower() != "q":
        return 1.0
    try:
        return float(value)
    except ValueError:
        return 0.0
