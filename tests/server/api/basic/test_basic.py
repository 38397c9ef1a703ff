"""Booking by plain forms."""

import re

import pytest
from httpx import Response

from tests.server.api.rides.test_rides import campus
from tests.server.api.server_under_test import ServerUnderTest

__all__ = ["campus"]

FORM = {"Content-Type": "application/x-www-form-urlencoded"}


def send(server: ServerUnderTest, body: str, path: str = "/basic?lang=en") -> Response:
    return server.raw("POST", path, content=body, headers=FORM)


def key_of(page: str) -> str:
    found = re.search(r"name='key' value='([^']+)'", page)
    assert found is not None
    return found[1]


def test_a_ride_is_booked_shown_and_cancelled_without_a_script(campus: ServerUnderTest) -> None:
    form = campus.raw("GET", "/basic?lang=en")
    assert form.status_code == 200
    assert "<script" not in form.text
    body = f"from=NN20&to=C6&party=2&wheelchairs=0&in=0&key={key_of(form.text)}"
    booked = send(campus, body)
    assert booked.status_code == 303
    place = booked.headers["location"]
    assert send(campus, body).headers["location"] == place, "sent twice, booked once"
    ride = campus.raw("GET", place)
    assert "Your ride is booked" in ride.text
    assert re.search(r"<dt>Boarding code</dt><dd>\d{4}</dd>", ride.text)
    assert ride.headers["cache-control"] == "no-store"
    path = place.partition("?")[0]
    assert send(campus, "", f"{path}/cancel?lang=en").status_code == 303
    over = campus.raw("GET", place).text
    assert "Ride cancelled" in over
    assert "Boarding code" not in over
    assert "refresh" not in over


def test_what_was_filled_in_stays_when_it_is_refused(campus: ServerUnderTest) -> None:
    same = send(campus, "from=NN20&to=NN20&party=2")
    assert same.status_code == 409
    assert "role='alert'" in same.text
    assert "<option value='NN20' selected>" in same.text
    assert send(campus, "from=&to=C6").status_code == 400
    assert send(campus, "from=NN20&to=C6&party=many").status_code == 400
    assert send(campus, "from=<b>&to=C6").text.count("<b>") == 0


@pytest.mark.parametrize(("accepted", "title"), [("zh-CN,zh;q=0.9", "校园班车"), ("fr,en", "Campus shuttle")])
def test_the_form_speaks_the_browsers_language(campus: ServerUnderTest, accepted: str, title: str) -> None:
    assert f"<h1>{title}</h1>" in campus.raw("GET", "/basic", headers={"Accept-Language": accepted}).text


def test_a_printed_code_fills_in_its_stop_and_an_unknown_ride_is_explained(campus: ServerUnderTest) -> None:
    assert "<option value='C6' selected>" in campus.raw("GET", "/basic?lang=en&from=C6").text
    missing = campus.raw("GET", f"/basic/ride/{'x' * 32}?lang=en")
    assert missing.status_code == 404
    assert "There is no ride with this link" in missing.text
