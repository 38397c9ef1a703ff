"""The one table from error code to status, and problem details (RFC 9457) for everything refused.

422 is for payloads that do not fit their schema, and for nothing else.
"""

from collections.abc import Mapping
from http import HTTPStatus
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from pydantic import BaseModel, ConfigDict, Field
from starlette.exceptions import HTTPException

from server.api.request_ids import REQUEST_HEADER, current_request_id
from server.api.security.rate_limit import TooManyTries
from server.domain import errors
from server.domain.errors import DomainError

MEDIA_TYPE = "application/problem+json"
TYPE_PREFIX = "urn:campusloop:problem:"


class CsrfMissing(DomainError):
    """A change needs the session's CSRF token in the header X-CSRF-Token, not only the cookie."""

    code = "csrf_missing"


class CursorInvalid(DomainError):
    """The cursor is not one that this list has given."""

    code = "cursor_invalid"


class TokenUnknown(DomainError):
    """No developer token has this id."""

    code = "token_unknown"


class SignatureWrong(DomainError):
    """The upload is not signed by the vehicle's enrolled key."""

    code = "signature_wrong"


class SegmentHashWrong(DomainError):
    """The received bytes do not have the hash in the path; send them again."""

    code = "segment_hash_wrong"


class SegmentStoreUnavailable(DomainError):
    """The store of run segments cannot be reached; everything else works. Try again later."""

    code = "segment_store_unavailable"


class SegmentTooLarge(DomainError):
    """The segment is larger than this server takes."""

    code = "segment_too_large"


class SegmentUnreadable(DomainError):
    """The bytes are not a run segment."""

    code = "segment_unreadable"


class TileHashWrong(DomainError):
    """The received bytes do not have the hash in the path; send them again."""

    code = "tile_hash_wrong"


class TileStoreUnavailable(DomainError):
    """The store of localization maps' tiles cannot be reached; everything else works. Try again later."""

    code = "tile_store_unavailable"


class ParcelHashWrong(DomainError):
    """The received bytes do not have the hash in the path; send them again."""

    code = "parcel_hash_wrong"


class ParcelTooLarge(DomainError):
    """The parcel of scans is larger than this server takes."""

    code = "parcel_too_large"


class ParcelUnreadable(DomainError):
    """The bytes are no parcel of scans, or it has no scan."""

    code = "parcel_unreadable"


class ScanStoreUnavailable(DomainError):
    """The store of scans cannot be reached or is full; everything else works. Try again later."""

    code = "scan_store_unavailable"


class VideoHashWrong(DomainError):
    """The received bytes do not have the hash in the path; send them again."""

    code = "video_hash_wrong"


class VideoTooLarge(DomainError):
    """The video segment is larger than this server takes."""

    code = "video_too_large"


class VideoUnreadable(DomainError):
    """The bytes are no WebM file, or their name is not that of a finished segment."""

    code = "video_unreadable"


class VideoStoreUnavailable(DomainError):
    """The store of videos cannot be reached or is full; everything else works. Try again later."""

    code = "video_store_unavailable"


STATUS: Mapping[type[DomainError], int] = {
    errors.RideUnknown: 404,
    errors.RideAlreadyAboard: 409,
    errors.RideNotAboard: 409,
    errors.RideEnded: 409,
    errors.RideNotAssigned: 409,
    errors.RideNotEnded: 409,
    errors.RideNotCompleted: 409,
    errors.IllegalTransition: 409,
    errors.NoticesUnavailable: 409,
    errors.PushSubscriptionInvalid: 400,
    errors.PartyTooLarge: 409,
    errors.PartyInvalid: 400,
    errors.SameStop: 400,
    errors.NoService: 409,
    errors.DestinationRefused: 409,
    errors.RideRefused: 409,
    errors.ReassignmentRefused: 409,
    errors.SeriesUnknown: 404,
    errors.SeriesEnded: 409,
    errors.SeriesInvalid: 400,
    errors.OccurrenceEnded: 409,
    errors.PatternUnknown: 404,
    errors.PatternInvalid: 400,
    errors.PatternInUse: 409,
    errors.ExceptionUnknown: 404,
    errors.TimetableInvalid: 400,
    errors.TimetableChanged: 412,
    errors.TimetableUnknown: 404,
    errors.ShiftsInvalid: 400,
    errors.LaneUnknown: 404,
    errors.SectionUnknown: 404,
    errors.AnnouncementInvalid: 400,
    errors.AnnouncementUnknown: 404,
    errors.AnnouncementOver: 409,
    errors.ClosureInvalid: 400,
    errors.ClosureUnknown: 404,
    errors.ClosureOver: 409,
    errors.BookingTooFarAhead: 409,
    errors.IdempotencyMismatch: 409,
    errors.NoVehicleFree: 409,
    errors.CampusUnknown: 404,
    errors.MapUnknown: 404,
    errors.MapInvalid: 400,
    errors.MapInUse: 409,
    errors.DraftUnknown: 404,
    errors.DraftChanged: 412,
    errors.DraftUnsound: 409,
    errors.TooManyDrafts: 409,
    errors.MapElsewhere: 409,
    errors.LocalizationMapUnknown: 404,
    errors.LocalizationMapInvalid: 400,
    errors.LocalizationMapElsewhere: 409,
    errors.LocalizationMapIncomplete: 409,
    errors.LocalizationMapInForce: 409,
    errors.TooManyLocalizationMaps: 409,
    errors.LocalizationTileUnknown: 404,
    errors.LocalizationTileInvalid: 400,
    errors.NoSuchFix: 409,
    errors.AreaUnknown: 404,
    errors.StopUnknown: 404,
    errors.StopUnreachable: 409,
    errors.VehicleUnknown: 404,
    errors.VehicleNotPlaced: 409,
    errors.NobodyAboard: 409,
    errors.VehicleOutOfService: 409,
    errors.VehicleMoves: 409,
    errors.VehicleNotConnected: 409,
    errors.PlanChanged: 409,
    errors.VisitUnknown: 404,
    errors.OrderUnknown: 404,
    errors.NoRestingPlaceFree: 409,
    errors.SectionsTaken: 409,
    errors.CommandUnknown: 404,
    errors.LeaseLost: 409,
    errors.StoreFailure: 503,
    errors.StoreUnavailable: 503,
    errors.OutcomeUnknown: 503,
    errors.SessionFenced: 409,
    errors.ForkImpossible: 409,
    errors.ForkStopped: 409,
    errors.ForkUnknown: 404,
    errors.ForksBusy: 409,
    errors.RecordingUnknown: 404,
    errors.RecordingUnderWay: 409,
    errors.RecordingOver: 409,
    errors.ScanAreaInvalid: 400,
    errors.ScanAreaTaken: 409,
    errors.ScanRequestUnknown: 404,
    errors.ScanRequestOver: 409,
    errors.ParcelRefused: 409,
    errors.NoScansYet: 409,
    errors.ProposalUnderWay: 409,
    errors.ProposalUnknown: 404,
    errors.ProposalNotReady: 409,
    errors.ProposalOutdated: 409,
    errors.ScanMapsUnavailable: 409,
    ParcelHashWrong: 400,
    ParcelTooLarge: 413,
    ParcelUnreadable: 400,
    ScanStoreUnavailable: 503,
    errors.VideoUnknown: 404,
    errors.VideoSpanInvalid: 400,
    VideoHashWrong: 400,
    VideoTooLarge: 413,
    VideoUnreadable: 400,
    VideoStoreUnavailable: 503,
    errors.RunUnknown: 404,
    errors.RunMapUnreadable: 404,
    errors.SegmentUnknown: 404,
    errors.SegmentConflict: 409,
    errors.AuditEntryUnknown: 404,
    errors.WebhookUnknown: 404,
    errors.WebhookInvalid: 400,
    errors.WebhookDisabled: 409,
    errors.TooManyWebhooks: 409,
    errors.IncidentUnknown: 404,
    errors.IncidentClosed: 409,
    errors.KeyUnknown: 404,
    errors.KeyInvalid: 400,
    errors.EnrolmentCodeUnknown: 403,
    errors.EnrolmentCodeUsed: 409,
    errors.NameTaken: 409,
    errors.WrongCredentials: 401,
    errors.SessionExpired: 401,
    errors.TokenInvalid: 401,
    errors.ScopeMissing: 403,
    errors.RoleMissing: 403,
    errors.OperatorUnknown: 404,
    errors.LastAdmin: 409,
    errors.PasswordChangeNeeded: 403,
    errors.PasswordInSettings: 409,
    errors.SecondFactorNeeded: 403,
    errors.SecondFactorMissing: 403,
    errors.SecondFactorLocked: 403,
    errors.WrongCode: 403,
    errors.TicketKeyMissing: 503,
    TooManyTries: 429,
    CsrfMissing: 403,
    CursorInvalid: 400,
    TokenUnknown: 404,
    SignatureWrong: 403,
    SegmentHashWrong: 400,
    SegmentStoreUnavailable: 503,
    SegmentTooLarge: 413,
    SegmentUnreadable: 400,
    TileHashWrong: 400,
    TileStoreUnavailable: 503,
}


class FieldProblem(BaseModel):
    """One field of the payload that does not fit."""

    where: str = Field(examples=["body.party"])
    message: str = Field(examples=["Input should be greater than or equal to 1"])


class Problem(BaseModel):
    """Why a request was refused (RFC 9457). Programs read `code`, people read `detail`."""

    model_config = ConfigDict(
        json_schema_extra={
            "example": {
                "type": "urn:campusloop:problem:stop_unknown",
                "title": "Not Found",
                "status": 404,
                "code": "stop_unknown",
                "detail": "the map has no stop 'library'; see /api/v1/stops",
                "rule": "",
                "errors": [],
                "request_id": "request-5f3c1a9be07d24681357",
            }
        }
    )

    type: str
    title: str
    status: int
    code: str
    detail: str
    rule: str = Field("", description="The dispatcher's rule that binds, if one is the reason.")
    errors: list[FieldProblem] = []
    request_id: str = Field("", description="As in X-Request-Id: the log of the server names it.")


def problems(*kinds: type[DomainError]) -> dict[int | str, dict[str, Any]]:
    """The `responses` of an endpoint that may refuse for these reasons, with an example of each."""
    responses: dict[int | str, dict[str, Any]] = {}
    for kind in kinds:
        status = STATUS[kind]
        meaning = (kind.__doc__ or kind.code).strip()
        response = responses.setdefault(
            status,
            {
                "description": HTTPStatus(status).phrase,
                "content": {MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/Problem"}, "examples": {}}},
            },
        )
        example = {"value": _body(status, kind.code, meaning).model_dump()}
        response["content"][MEDIA_TYPE]["examples"][kind.code] = example
    return responses


def install(app: FastAPI) -> None:
    """Answer every refusal and every crash of `app` with problem details."""
    app.add_exception_handler(DomainError, _refused)
    app.add_exception_handler(RequestValidationError, _not_valid)
    app.add_exception_handler(HTTPException, _http)
    app.add_exception_handler(Exception, _crashed)


def http_problem(status: HTTPStatus, detail: str, headers: Mapping[str, str] | None = None) -> JSONResponse:
    """A refusal by HTTP itself; its code is made of the status phrase: `not_found`."""
    code = status.phrase.lower().replace(" ", "_").replace("-", "_")
    return _response(_body(status, code, detail), headers)


def status_of(error: DomainError) -> int:
    """Raises KeyError for an error that has no row in the table."""
    return STATUS[type(error)]


async def _refused(_: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, DomainError)
    headers = {}
    if isinstance(error, TooManyTries | errors.StoreFailure):
        headers["Retry-After"] = str(max(1, round(error.retry_after_s)))
    status = status_of(error)
    if status == 401:
        headers["WWW-Authenticate"] = "Bearer" if isinstance(error, errors.TokenInvalid) else "Session"
    return _response(_body(status, error.code, error.detail, error.rule), headers)


async def _not_valid(_: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, RequestValidationError)
    fields = [
        FieldProblem(where=".".join(str(part) for part in item["loc"]), message=str(item["msg"]))
        for item in error.errors()
    ]
    body = _body(422, "payload_invalid", "the request does not fit its schema; see errors")
    return _response(body.model_copy(update={"errors": fields}))


async def _http(_: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, HTTPException)
    return http_problem(HTTPStatus(error.status_code), str(error.detail), error.headers)


async def _crashed(_: Request, __: Exception) -> JSONResponse:
    body = _body(500, "server_fault", "the server failed; its log names the cause")
    # This answer is given outside of the layer that adds the header to all others.
    return _response(body, {REQUEST_HEADER: body.request_id} if body.request_id else None)


def _body(status: int, code: str, detail: str, rule: str = "") -> Problem:
    return Problem(
        type=TYPE_PREFIX + code,
        title=HTTPStatus(status).phrase,
        status=status,
        code=code,
        detail=detail,
        rule=rule,
        request_id=current_request_id(),
    )


def _response(body: Problem, headers: Mapping[str, str] | None = None) -> JSONResponse:
    return JSONResponse(body.model_dump(), status_code=body.status, headers=headers, media_type=MEDIA_TYPE)
