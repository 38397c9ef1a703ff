"""A fork of the fleet's past in the browser."""

from pathlib import Path

import pytest
from playwright.sync_api import expect

from tests.e2e.conftest import OpenPage
from tests.e2e.operator import sign_in
from tests.e2e.passenger import book, cancel
from tests.e2e.scripted_shuttle import ScriptedShuttle

pytestmark = pytest.mark.browser


def test_a_moment_is_forked_with_one_shuttle_more_and_compared(
    open_page: OpenPage, shuttle: ScriptedShuttle, screenshots: Path | None
) -> None:
    shuttle.speed_mps = 0.0
    phones = open_page("/"), open_page("/")
    book(phones[0], "Main Library", "Life Sciences")
    # The same way: a shuttle that rides of other tests keep busy has room for it, too.
    book(phones[1], "Main Library", "Gymnasium")
    # 404: the comparison is stopped before the server has read its rides, and is asked again.
    console = open_page("/console", allowed=(404, 409))
    sign_in(console)
    console.get_by_role("link", name="Runs").click()
    console.get_by_role("button", name="Replay the fleet").click()
    fork = console.get_by_role("region", name="What if")
    # At the day's beginning all rides of the day are still to come; it is longer ago than two hours.
    fork.get_by_label("Rides of the next").select_option("12 hours")
    console.get_by_role("region", name="What happened").get_by_role("button").first.click()
    fork.get_by_label("Policy").select_option("insert only")
    # Its process has to start first, which takes some seconds.
    fork.get_by_role("button", name="Compare from").click()
    fork.get_by_role("button", name="Stop").click()
    expect(fork.get_by_text("The comparison was stopped.")).to_be_visible()
    fork.get_by_role("button", name="Compare from").click()
    table = fork.get_by_role("table")
    expect(table).to_be_visible(timeout=240_000)
    shuttles = table.get_by_role("row", name="Shuttles").get_by_role("cell")
    again, changed = (int(shuttles.nth(k).inner_text()) for k in (1, 2))
    assert changed == again + 1
    served = table.get_by_role("row", name="Rides served").get_by_role("cell")
    # The two booked here, and those of tests before on the same server.
    assert all(int(served.nth(k).inner_text()) >= 2 for k in (1, 2))
    expect(fork).to_contain_text("Compare them with each other.")
    expect(fork).to_contain_text("s of one processor")
    if screenshots is not None:
        fork.scroll_into_view_if_needed()
        console.screenshot(path=screenshots / "fork.png")
    fork.get_by_label("Shuttles more").fill("-50")
    fork.get_by_role("button", name="Compare from").click()
    expect(fork.get_by_text("There is nothing to compare at this moment, or too much.")).to_be_visible()
    # Later tests on the same server have the shuttle to themselves.
    for phone in phones:
        cancel(phone)
