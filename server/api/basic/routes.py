"""Forms and pages at /basic. They book, show and cancel by the same use cases as the API."""

from collections.abc import Mapping
from contextlib import suppress
from datetime import timedelta
from typing import Annotated
from urllib.parse import parse_qsl
from zoneinfo import ZoneInfo

from fastapi import APIRouter, Depends, Header, Query, Request
from pydantic import ValidationError
from starlette.responses import HTMLResponse, RedirectResponse, Response

from server.api.basic.html import FormContext, form_page, missing_page, ride_page
from server.api.basic.texts import Language, language_of, texts_of
from server.api.commands import PassengerCommand, booking_key
from server.api.formats import RideToken
from server.api.rides.schemas import RideRequest
from server.api.rides.views import booking
from server.api.security.access import Client, now_ns
from server.api.services import InjectedServices
from server.domain.errors import DestinationRefused, DomainError, RideEnded, RideUnknown
from server.usecases.fleet import campus
from server.usecases.ports.unit_of_work import UnitOfWork
from server.usecases.rides import rides
from server.usecases.rides.tickets import ride_by_token, secrets_of

router = APIRouter(prefix="/basic", include_in_schema=False)

_PRIVATE = {"Cache-Control": "no-store"}


async def _language(
    lang: Annotated[str, Query(max_length=8)] = "",
    accept_language: Annotated[str, Header(max_length=1000)] = "",
) -> Language:
    return language_of(lang, accept_language)


ReaderLanguage = Annotated[Language, Depends(_language)]


@router.get("")
async def show_form(request: Request, services: InjectedServices, language: ReaderLanguage) -> Response:
    """`?from=STOP` fills in where a printed code hangs."""
    return await _form(services, language, dict(request.query_params))


@router.post("")
async def book(
    request: Request, services: InjectedServices, language: ReaderLanguage, client: Client
) -> Response:
    services.limits.bookings.take(client, now_ns(services))
    given = dict(parse_qsl((await request.body()).decode("utf-8", "replace"), max_num_fields=20))
    try:
        now = await services.transactions.read(lambda uow: uow.now)
        minutes = int(given.get("in") or 0)
        wish = RideRequest(
            from_stop=given.get("from", ""),
            to_stop=given.get("to", ""),
            party=int(given.get("party") or 1),
            wheelchairs=int(given.get("wheelchairs") or 0),
            earliest=now + timedelta(minutes=minutes) if minutes else None,
            may_walk=False,
        )
        key = booking_key(None, given.get("key") or None)
        booked = await services.bookings.book(booking(wish, key, "passenger"))
    except DomainError as error:
        problem = texts_of(language).refused_form.format(detail=error.detail)
        return await _form(services, language, given, problem, 409)
    except (ValueError, ValidationError, OverflowError):
        problem = texts_of(language).refused_form.format(detail=texts_of(language).choose)
        return await _form(services, language, given, problem, 400)
    return _see(booked.secrets.token, language)


@router.get("/ride/{token}")
async def show_ride(token: RideToken, services: InjectedServices, language: ReaderLanguage) -> Response:
    def work(uow: UnitOfWork) -> str:
        ride = ride_by_token(uow, token)
        vehicle = None if ride.vehicle_id is None else uow.vehicles.get(ride.vehicle_id)
        return ride_page(
            language,
            ride,
            token,
            secrets_of(uow, ride).boarding_code,
            "" if vehicle is None else vehicle.name,
            campus.stops(uow),
            uow.now,
            ZoneInfo(uow.network().road_map.timezone),
        )

    try:
        return HTMLResponse(await services.transactions.read(work), headers=_PRIVATE)
    except RideUnknown:
        return HTMLResponse(missing_page(language), status_code=404, headers=_PRIVATE)


@router.post("/ride/{token}/cancel")
async def cancel(token: RideToken, command: PassengerCommand, language: ReaderLanguage) -> Response:
    """A ride that has ended meanwhile is shown as it is."""

    def work(uow: UnitOfWork) -> None:
        rides.cancel(uow, ride_by_token(uow, token).ride_id, command.kind)

    try:
        with suppress(RideEnded, DestinationRefused):
            await command.transact(type(None), work)
    except RideUnknown:
        return HTMLResponse(missing_page(language), status_code=404, headers=_PRIVATE)
    return _see(token, language)


def _see(token: str, language: Language) -> Response:
    return RedirectResponse(f"/basic/ride/{token}?lang={language}", status_code=303, headers=_PRIVATE)


async def _form(
    services: InjectedServices,
    language: Language,
    given: Mapping[str, str],
    problem: str = "",
    status: int = 200,
) -> Response:
    def work(uow: UnitOfWork) -> FormContext:
        places = max((vehicle.wheelchair_places for vehicle in uow.vehicles.all()), default=0)
        return FormContext(campus.stops(uow), uow.rules.seats_max, places, uow.ids.token())

    context = await services.transactions.read(work)
    return HTMLResponse(form_page(language, context, given, problem), status_code=status, headers=_PRIVATE)
