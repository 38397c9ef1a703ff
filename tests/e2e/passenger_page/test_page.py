"""The passenger page around a booking: made, refused, repeated, found again."""

import re

import pytest
from playwright.sync_api import expect

from tests.e2e.conftest import PHONE, OpenPage
from tests.e2e.passenger import MOMENT, book, cancel, choose_stop, fill_booking
from tests.e2e.scripted_shuttle import ScriptedShuttle
from tests.e2e.server_process import ServerProcess
from tests.e2e.targets import sticks_out

pytestmark = [pytest.mark.browser, pytest.mark.real]


def test_a_booking_is_answered_with_vehicle_window_and_codes_and_can_be_cancelled(
    open_page: OpenPage, shuttle: ScriptedShuttle
) -> None:
    page = open_page("/", **PHONE)
    code = book(page, "Main Library", "Gymnasium")
    assert re.fullmatch(r"[A-Z0-9]{6}", code)
    expect(page.locator("[data-boarding-code]")).to_have_text(re.compile(r"^\d{4}$"))
    expect(page.locator("h1")).to_contain_text("Shuttle 1")
    expect(page.locator(".trip")).to_contain_text(re.compile(rf"Pickup between {MOMENT} and {MOMENT}"))
    expect(page.locator(".trip")).to_contain_text(re.compile(rf"Arrival by {MOMENT}"))
    assert not sticks_out(page)
    cancel(page)


def test_a_ride_comes_back_after_a_reload_and_by_its_code(
    open_page: OpenPage, shuttle: ScriptedShuttle
) -> None:
    page = open_page("/", **PHONE)
    code = book(page, "Main Library", "Gymnasium")
    page.reload()
    expect(page.locator("[data-ride-code]")).to_have_text(code)
    other = open_page("/", **PHONE)
    other.get_by_role("button", name="I have a ride code").click()
    other.get_by_label("Ride code").fill(code.lower())
    other.get_by_role("button", name="Find the ride").click()
    expect(other.locator("[data-ride-code]")).to_have_text(code)
    expect(other.locator("[data-boarding-code]")).to_have_count(0)
    cancel(page)


def test_a_ride_is_repeated_and_one_day_or_all_are_cancelled(open_page: OpenPage) -> None:
    page = open_page("/", **PHONE)
    fill_booking(page, "Main Library", "Gymnasium")
    page.get_by_role("button", name="Repeat").click()
    page.get_by_role("button", name="Saturday").click()
    page.get_by_label("Earliest pickup").fill("17:05")
    page.get_by_role("button", name="Book all these days").click()
    expect(page.get_by_role("heading", name="Your recurring booking")).to_be_visible()
    expect(page.locator(".trip")).to_contain_text("Mon Tue Wed Thu Fri Sat · 17:05")
    page.reload()
    last = page.locator("[data-day]").last
    last.get_by_role("button", name="Skip this day").click()
    expect(last).to_have_attribute("data-state", "cancelled")
    page.get_by_role("button", name="Cancel all rides").click()
    page.get_by_role("dialog").get_by_role("button", name="Cancel all rides").click()
    expect(page.get_by_text("This booking was cancelled.")).to_be_visible()


def test_a_refusal_names_the_rule_and_keeps_what_was_filled_in(
    open_page: OpenPage, server: ServerProcess, shuttle: ScriptedShuttle
) -> None:
    page = open_page("/", **PHONE)
    server.change("POST", f"/vehicles/{shuttle.vehicle_id}/recall")
    try:
        fill_booking(page, "Main Library", "Gymnasium")
        page.get_by_role("button", name="Book the ride").click()
        expect(page.get_by_role("heading", name="No shuttle can take this ride")).to_be_visible()
        expect(page.locator(".ride")).to_contain_text("busy or out of service")
        page.get_by_role("button", name="Change the booking").click()
        expect(page.get_by_role("button", name="From Main Library")).to_be_visible()
    finally:
        server.change("POST", f"/vehicles/{shuttle.vehicle_id}/release")


def test_who_is_refused_is_offered_what_could_be_had_and_books_it(
    open_page: OpenPage, shuttle: ScriptedShuttle, server: ServerProcess
) -> None:
    stops = {stop["name_en"]: stop["stop_id"] for stop in server.http.get("/stops").json()}
    wish = {"from_stop": stops["Main Library"], "to_stop": stops["Gymnasium"], "party": 6}
    others = []
    try:
        while not others or others[-1]["state"] != "refused":
            others.append(server.http.post("/rides", json=wish).json())
            assert len(others) < 20
        assert others[-1]["alternatives"]
        page = open_page("/", **PHONE)
        fill_booking(page, "Main Library", "Gymnasium")
        for _ in range(5):
            page.get_by_role("group", name="People").get_by_role("button", name="One more").click()
        page.get_by_role("button", name="Book the ride").click()
        expect(page.get_by_role("heading", name="What is possible instead")).to_be_visible()
        page.locator(".alternatives button").first.click()
        expect(page.locator("[data-boarding-code]")).to_be_visible()
        cancel(page)
    finally:
        for ride in others:
            if ride["state"] != "refused":
                server.http.post(f"/rides/{ride['token']}/cancel")


def test_a_stop_is_chosen_by_a_tap_on_the_map(open_page: OpenPage, server: ServerProcess) -> None:
    page = open_page("/", **PHONE)
    stops = server.http.get("/stops").json()
    box = page.locator(".map canvas").bounding_box()
    assert box is not None
    xs, ys = [stop["x_m"] for stop in stops], [stop["y_m"] for stop in stops]
    # The page shows all stops inside its free edge; the westernmost one lies on that edge.
    west = min(stops, key=lambda stop: stop["x_m"])
    scale = min(
        (box["width"] - 36 - 88) / (max(xs) - min(xs)), (box["height"] - 32 - 40) / (max(ys) - min(ys))
    )
    x_px = box["x"] + 36 + (box["width"] - 124) / 2 - scale * ((max(xs) + min(xs)) / 2 - west["x_m"])
    y_px = box["y"] + 32 + (box["height"] - 72) / 2 + scale * ((max(ys) + min(ys)) / 2 - west["y_m"])
    page.touchscreen.tap(x_px, y_px)
    expect(page.get_by_role("button", name=f"From {west['name_en']}")).to_be_visible()


def test_the_language_is_switched_and_remembered(open_page: OpenPage) -> None:
    page = open_page("/", **PHONE)
    page.get_by_role("button", name="中文").click()
    expect(page.locator("html")).to_have_attribute("lang", "zh-CN")
    expect(page.get_by_role("heading", name="您要去哪里？")).to_be_visible()
    page.reload()
    expect(page.get_by_role("heading", name="您要去哪里？")).to_be_visible()


def test_a_lost_connection_is_said_and_mended(open_page: OpenPage, shuttle: ScriptedShuttle) -> None:
    page = open_page("/", goes_offline=True, **PHONE)
    book(page, "Main Library", "Gymnasium")
    expect(page.locator("h1")).to_contain_text("Shuttle 1")
    page.context.set_offline(True)
    expect(page.locator("[data-stale]")).to_contain_text("Last update")
    page.context.set_offline(False)
    expect(page.locator("[data-stale]")).to_have_count(0)
    cancel(page)


@pytest.mark.usefixtures("shuttle")
def test_a_ticket_whose_live_view_never_opened_says_how_old_it_is(open_page: OpenPage) -> None:
    page = open_page("/", goes_offline=True, **PHONE)
    page.route_web_socket("**/ws/live", lambda socket: socket.close())
    book(page, "Main Library", "Gymnasium")
    expect(page.locator("[data-stale]")).to_contain_text("Last update")
    expect(page.get_by_text("Connecting to the live view")).to_have_count(0)
    cancel(page)


@pytest.mark.usefixtures("shuttle")
def test_a_cancel_without_a_connection_is_kept_and_delivered_later(open_page: OpenPage) -> None:
    page = open_page("/", goes_offline=True, **PHONE)
    book(page, "Main Library", "Gymnasium")
    title = page.locator("h1")
    expect(title).to_contain_text("Shuttle 1")
    page.context.set_offline(True)
    page.get_by_role("button", name="Cancel the ride").click()
    page.get_by_role("dialog").get_by_role("button", name="Cancel the ride").click()
    expect(page.get_by_text("Not cancelled yet")).to_be_visible()
    expect(title).to_contain_text("Shuttle 1")
    page.context.set_offline(False)
    expect(page.get_by_role("heading", name="Ride cancelled")).to_be_visible()
    expect(page.get_by_text("Not cancelled yet")).to_have_count(0)


@pytest.mark.usefixtures("shuttle")
def test_a_kept_cancel_is_delivered_by_the_next_visit(open_page: OpenPage) -> None:
    page = open_page("/", goes_offline=True, **PHONE)
    book(page, "Main Library", "Gymnasium")
    link = page.url
    page.context.set_offline(True)
    page.get_by_role("button", name="Cancel the ride").click()
    page.get_by_role("dialog").get_by_role("button", name="Cancel the ride").click()
    expect(page.get_by_text("Not cancelled yet")).to_be_visible()
    later = page.context.new_page()
    page.close()
    later.context.set_offline(False)
    with later.expect_response("**/cancel*") as delivered:
        later.goto(link.split("#", maxsplit=1)[0])
        expect(later.get_by_role("heading", name="Where to?")).to_be_visible()
    assert delivered.value.ok
    later.goto(link)
    later.reload()
    expect(later.get_by_role("heading", name="Ride cancelled")).to_be_visible()


@pytest.mark.usefixtures("shuttle")
def test_who_thinks_better_of_a_kept_cancel_keeps_the_ride(open_page: OpenPage) -> None:
    page = open_page("/", goes_offline=True, **PHONE)
    book(page, "Main Library", "Gymnasium")
    page.context.set_offline(True)
    page.get_by_role("button", name="Cancel the ride").click()
    page.get_by_role("dialog").get_by_role("button", name="Cancel the ride").click()
    page.get_by_role("button", name="Keep the ride").click()
    page.context.set_offline(False)
    expect(page.locator("[data-stale]")).to_have_count(0)
    page.reload()
    expect(page.locator("[data-ride-code]")).to_be_visible()
    cancel(page)


@pytest.mark.usefixtures("shuttle")
def test_nothing_counts_down_without_news(open_page: OpenPage) -> None:
    page = open_page("/", goes_offline=True, **PHONE)
    book(page, "Main Library", "Gymnasium")
    expect(page.locator("h1")).to_contain_text(re.compile("arrives (in|within)"))
    page.context.set_offline(True)
    expect(page.locator("h1")).to_contain_text(
        re.compile(r"arrives (at \d\d:\d\d|between \d\d:\d\d and \d\d:\d\d)")
    )
    page.context.set_offline(False)
    expect(page.locator("h1")).to_contain_text(re.compile("arrives (in|within)"))
    cancel(page)


@pytest.mark.usefixtures("shuttle")
def test_a_ticket_whose_live_view_never_opens_does_not_count_down(open_page: OpenPage) -> None:
    page = open_page("/", goes_offline=True, **PHONE)
    page.route_web_socket("**/ws/live", lambda socket: socket.close())
    book(page, "Main Library", "Gymnasium")
    expect(page.locator("h1")).to_contain_text(
        re.compile(r"arrives (at \d\d:\d\d|between \d\d:\d\d and \d\d:\d\d)")
    )
    page.unroute_all()
    cancel(page)


def test_a_held_shuttle_promises_no_time(
    open_page: OpenPage, server: ServerProcess, shuttle: ScriptedShuttle
) -> None:
    page = open_page("/", **PHONE)
    book(page, "Main Library", "Gymnasium")
    expect(page.locator("h1")).to_contain_text(re.compile("arrives (in|within)"))
    server.change("POST", "/vehicles/shuttle-1/hold")
    told = page.get_by_text("The operators have stopped the shuttle")
    expect(told).to_contain_text(
        re.compile(r"standing since \d\d:\d\d\. It continues when they release it\.")
    )
    expect(page.locator("h1")).to_have_text("Shuttle 1 has stopped")
    server.change("POST", "/vehicles/shuttle-1/resume")
    expect(page.locator("h1")).to_contain_text(re.compile("arrives (in|within)"))
    cancel(page)


@pytest.mark.usefixtures("shuttle")
def test_booking_does_not_wait_for_the_map(open_page: OpenPage) -> None:
    page = open_page("/", **PHONE)
    # Neither answered nor refused.
    page.route("**/api/v1/campus/map", lambda _route: None)
    page.reload()
    book(page, "Main Library", "Gymnasium")
    expect(page.get_by_text("Loading the map")).to_be_visible()
    cancel(page)


def test_a_map_that_does_not_come_is_said_and_fetched_again(open_page: OpenPage) -> None:
    page = open_page("/", allowed=(503,), **PHONE)
    page.route("**/api/v1/campus/map", lambda route: route.fulfill(status=503, json={}))
    page.reload()
    expect(page.get_by_text("The map could not be loaded")).to_be_visible()
    page.unroute("**/api/v1/campus/map")
    page.get_by_role("button", name="Try again").click()
    expect(page.locator("canvas")).to_be_visible()


def test_a_map_on_which_nothing_moves_is_not_drawn_again(open_page: OpenPage) -> None:
    page = open_page("/", **PHONE)
    page.add_init_script(
        """
        window.frames_asked = 0;
        const ask = window.requestAnimationFrame.bind(window);
        window.requestAnimationFrame = (draw) => { window.frames_asked += 1; return ask(draw); };
        """
    )
    page.reload()
    expect(page.locator("canvas")).to_be_visible()
    page.wait_for_timeout(1500)
    before = page.evaluate("window.frames_asked")
    assert before > 0
    page.wait_for_timeout(4000)
    assert page.evaluate("window.frames_asked") - before <= 4


def test_later_opens_in_front_of_the_bar_with_the_button(open_page: OpenPage) -> None:
    page = open_page("/", **PHONE)
    fill_booking(page, "Main Library", "Gymnasium")
    page.get_by_role("button", name="Later").click()
    field = page.get_by_label("Earliest pickup")
    expect(field).to_be_in_viewport(ratio=1.0)
    field_box, bar_box = field.bounding_box(), page.locator(".book-bar").bounding_box()
    assert field_box is not None
    assert bar_box is not None
    assert field_box["y"] + field_box["height"] <= bar_box["y"]


def test_a_phone_held_sideways_shows_from_and_to_beside_the_map(open_page: OpenPage) -> None:
    page = open_page("/", **(PHONE | {"viewport": {"width": 844, "height": 390}}))
    expect(page.get_by_role("button", name=re.compile("^From"))).to_be_in_viewport(ratio=1.0)
    expect(page.get_by_role("button", name=re.compile("^To"))).to_be_in_viewport(ratio=1.0)
    expect(page.locator("canvas")).to_be_in_viewport()


@pytest.mark.usefixtures("shuttle")
def test_the_focus_stays_with_what_is_done(open_page: OpenPage) -> None:
    page = open_page("/", **PHONE)
    choose_stop(page, "From", "Main Library")
    expect(page.get_by_role("button", name=re.compile("^To"))).to_be_focused()
    choose_stop(page, "To", "Gymnasium")
    expect(page.get_by_role("button", name=re.compile("^To"))).to_be_focused()
    page.get_by_role("button", name="Book the ride").click()
    expect(page.locator("[data-ride-code]")).to_be_visible()
    expect(page.locator("h1")).to_be_focused()
    cancel(page)


def test_a_link_that_is_not_whole_says_so(open_page: OpenPage) -> None:
    page = open_page("/#ride=q3Jv0", **PHONE)
    expect(page.get_by_text("This link is not complete")).to_be_visible()
    page.get_by_role("button", name="I have a ride code").click()
    expect(page.locator("input.code")).to_be_visible()


def test_an_unknown_link_is_explained(open_page: OpenPage) -> None:
    page = open_page("/#ride=AAAAAAAAAAAAAAAAAAAAAAAA", allowed=(404,))
    expect(page.get_by_role("alert")).to_contain_text("There is no ride with this code or link")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_sticks_out_of_a_narrow_phone(open_page: OpenPage, scheme: str) -> None:
    page = open_page("/", **(PHONE | {"viewport": {"width": 360, "height": 640}, "color_scheme": scheme}))
    expect(page.get_by_role("heading", name="Where to?")).to_be_visible()
    choose_stop(page, "From", "Precision")
    assert not sticks_out(page)
