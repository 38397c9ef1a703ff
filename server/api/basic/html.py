"""The pages themselves. Everything that comes from elsewhere is escaped."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from html import escape
from zoneinfo import ZoneInfo

from server.api.basic.texts import Language, Texts, texts_of
from server.domain.rides.rides import Ride
from server.domain.roads.stops import CampusStop

SOON_MIN = (15, 30, 60)
RENEWED_S = 20

_STYLE = """
:root { color-scheme: light dark; }
body { max-width: 32rem; margin: 0 auto; padding: 1rem; font: 1.125rem/1.5 system-ui, sans-serif; }
label, dt { display: block; margin-top: 1rem; font-weight: 600; }
select, input, button { width: 100%; min-height: 48px; box-sizing: border-box; font: inherit; }
button { margin-top: 1.5rem; font-weight: 600; }
dd { margin: 0; font-size: 1.5rem; }
.problem { padding: 0.75rem; border: 2px solid; }
a { display: inline-block; min-height: 48px; line-height: 48px; }
"""


@dataclass(frozen=True, slots=True)
class FormContext:
    """key: against a second ride by a form that is sent twice."""

    stops: Sequence[CampusStop]
    seats_max: int
    wheelchairs_max: int
    key: str


def form_page(language: Language, context: FormContext, given: Mapping[str, str], problem: str = "") -> str:
    """given: what was filled in before; it stays."""
    t = texts_of(language)
    times = {"0": t.now} | {str(m): t.in_minutes.format(minutes=m) for m in SOON_MIN}
    body = [
        f"<p class='problem' role='alert'>{escape(problem)}</p>" if problem else "",
        f"<form method='post' action='/basic?lang={language}'>",
        f"<input type='hidden' name='key' value='{escape(context.key)}'>",
        _select("from", t.from_stop, _named(context.stops, language, t), given.get("from", "")),
        _select("to", t.to_stop, _named(context.stops, language, t), given.get("to", "")),
        _number("party", t.people, 1, context.seats_max, given.get("party", "1")),
        _number("wheelchairs", t.wheelchairs, 0, context.wheelchairs_max, given.get("wheelchairs", "0")),
        _select("in", t.when, times, given.get("in", "0")),
        f"<button>{escape(t.book)}</button></form>",
    ]
    return _document(language, t.title, "\n".join(body), f"/basic?lang={_other(language)}")


def ride_page(
    language: Language,
    ride: Ride,
    token: str,
    boarding_code: str,
    vehicle: str,
    stops: Sequence[CampusStop],
    now: datetime,
    zone: ZoneInfo,
) -> str:
    t = texts_of(language)
    names = {stop.stop_id: _name(stop, language) for stop in stops}
    where = f"{names.get(ride.from_stop, ride.from_stop)} – {names.get(ride.to_stop, ride.to_stop)}"
    facts: list[tuple[str, str]] = [(t.ride_code, ride.ride_code)]
    if not ride.has_ended:
        facts = [(t.boarding_code, boarding_code), *facts]
        if vehicle:
            facts.append((t.vehicle, vehicle))
    reason = t.reasons.get(ride.reason, "")
    body = [
        f"<p>{escape(where)}</p>",
        f"<p>{escape(reason)}</p>" if reason else "",
        *_times(ride, t, zone),
        "<dl>",
        *(f"<dt>{escape(name)}</dt><dd>{escape(value)}</dd>" for name, value in facts),
        "</dl>",
    ]
    here = f"/basic/ride/{token}"
    if not ride.has_ended:
        body += [
            f"<p>{escape(t.boarding_hint)}</p>",
            f"<form method='post' action='{here}/cancel?lang={language}'>",
            f"<button>{escape(t.cancel)}</button></form>",
            f"<p><small>{escape(t.renewed.format(time=_clock(now, zone, seconds=True)))}</small></p>",
        ]
    body.append(f"<p><a href='/basic?lang={language}'>{escape(t.book_another)}</a></p>")
    refresh = "" if ride.has_ended else f"<meta http-equiv='refresh' content='{RENEWED_S}'>"
    title = t.states.get(str(ride.state), t.title)
    return _document(language, title, "\n".join(body), f"{here}?lang={_other(language)}", refresh)


def missing_page(language: Language) -> str:
    t = texts_of(language)
    link = f"<p><a href='/basic?lang={language}'>{escape(t.book_another)}</a></p>"
    return _document(language, t.title, f"<p class='problem'>{escape(t.no_such_ride)}</p>{link}", "/basic")


def _times(ride: Ride, t: Texts, zone: ZoneInfo) -> Iterable[str]:
    promise = ride.promise
    if promise is None or ride.has_ended:
        return
    if ride.pickup_eta is not None and ride.boarded_at is None:
        yield f"<p>{escape(t.expected.format(time=_clock(ride.pickup_eta, zone)))}</p>"
    begins, ends = _clock(promise.pickup_from, zone), _clock(promise.pickup_to, zone)
    yield f"<p>{escape(t.pickup.format(begins=begins, ends=ends))}</p>"
    yield f"<p>{escape(t.arrival.format(time=_clock(promise.arrive_by, zone)))}</p>"


def _clock(at: datetime, zone: ZoneInfo, *, seconds: bool = False) -> str:
    return at.astimezone(zone).strftime("%H:%M:%S" if seconds else "%H:%M")


def _named(stops: Sequence[CampusStop], language: Language, t: Texts) -> dict[str, str]:
    return {"": t.choose} | {stop.stop_id: _name(stop, language) for stop in stops}


def _name(stop: CampusStop, language: Language) -> str:
    return (stop.name or stop.name_en) if language == "zh" else (stop.name_en or stop.name)


def _select(name: str, label: str, options: Mapping[str, str], chosen: str) -> str:
    shown = "".join(
        f"<option value='{escape(value)}'{' selected' if value == chosen else ''}>{escape(text)}</option>"
        for value, text in options.items()
    )
    required = " required" if "" in options else ""
    return (
        f"<label for='{name}'>{escape(label)}</label>"
        f"<select id='{name}' name='{name}'{required}>{shown}</select>"
    )


def _number(name: str, label: str, least: int, most: int, value: str) -> str:
    return (
        f"<label for='{name}'>{escape(label)}</label><input id='{name}' name='{name}' type='number' "
        f"min='{least}' max='{max(least, most)}' value='{escape(value)}' inputmode='numeric' required>"
    )


def _other(language: Language) -> Language:
    return "en" if language == "zh" else "zh"


def _document(language: Language, title: str, body: str, other: str, head: str = "") -> str:
    t = texts_of(language)
    code = "zh-CN" if language == "zh" else "en"
    other_code = "en" if language == "zh" else "zh-CN"
    return (
        f"<!doctype html><html lang='{code}'><head><meta charset='utf-8'>"
        "<meta name='viewport' content='width=device-width, initial-scale=1'>"
        f"<title>{escape(title)}</title><link rel='icon' href='/icon.svg'><style>{_STYLE}</style>{head}"
        "</head><body>"
        f"<nav><a href='{escape(other)}' lang='{other_code}'>{escape(t.other_language)}</a></nav>"
        f"<main><h1>{escape(title)}</h1>\n{body}</main></body></html>"
    )
