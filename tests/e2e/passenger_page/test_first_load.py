"""What a phone loads before the first booking, and what happens when a later part does not come."""

import re

import pytest
from playwright.sync_api import Page, expect

from tests.e2e.conftest import PHONE, OpenPage
from tests.e2e.passenger import fill_booking

pytestmark = [pytest.mark.browser, pytest.mark.real]

LANGUAGES = re.compile(r"/assets/(english|chinese)-")


def languages_of(page: Page) -> list[str]:
    loaded = page.evaluate("performance.getEntriesByType('resource').map((entry) => entry.name)")
    return sorted({match[1] for url in loaded if (match := LANGUAGES.search(url))})


def test_a_phone_loads_one_language_and_the_other_when_it_is_chosen(open_page: OpenPage) -> None:
    page = open_page("/", **PHONE)
    expect(page.get_by_role("heading", name="Where to?")).to_be_visible()
    assert languages_of(page) == ["english"]
    page.get_by_role("button", name="中文").click()
    expect(page.locator("html")).to_have_attribute("lang", "zh-CN")
    assert languages_of(page) == ["chinese", "english"]
    chinese = open_page("/", **(PHONE | {"locale": "zh-CN"}))
    expect(chinese.get_by_role("heading", level=1)).to_be_visible()
    assert languages_of(chinese) == ["chinese"]


def test_a_language_that_does_not_come_leaves_the_page_as_it_is(open_page: OpenPage) -> None:
    page = open_page("/", goes_offline=True, **PHONE)
    fill_booking(page, "Main Library", "Gymnasium")
    page.route("**/assets/chinese-*", lambda route: route.abort("internetdisconnected"))
    page.get_by_role("button", name="中文").click()
    expect(page.get_by_text("The other language could not be loaded.")).to_be_visible()
    expect(page.locator("html")).to_have_attribute("lang", "en")
    expect(page.get_by_role("button", name="Book the ride")).to_be_enabled()


def test_a_view_that_does_not_come_says_so_and_a_reload_brings_it(open_page: OpenPage) -> None:
    page = open_page("/", goes_offline=True, **PHONE)
    expect(page.get_by_role("heading", name="Where to?")).to_be_visible()
    page.route("**/assets/views-*", lambda route: route.abort("internetdisconnected"))
    with page.expect_event("requestfailed", lambda request: "/assets/views-" in request.url):
        page.reload()
    # To go there is another try.
    with page.expect_event("requestfailed", lambda request: "/assets/views-" in request.url):
        page.get_by_role("button", name="I have a ride code").click()
    expect(page.get_by_text("This view could not be loaded.")).to_be_visible()
    page.unroute("**/assets/views-*")
    page.get_by_role("button", name="Reload the page").click()
    expect(page.get_by_label("Ride code")).to_be_visible()


def test_without_any_texts_the_page_says_so_in_every_language(open_page: OpenPage) -> None:
    page = open_page("/", goes_offline=True, **PHONE)
    page.route("**/assets/english-*", lambda route: route.abort("internetdisconnected"))
    page.reload()
    expect(page.get_by_text("The page could not be loaded.")).to_be_visible()
    expect(page.get_by_text("页面加载失败")).to_be_visible()
    page.unroute("**/assets/english-*")
    page.get_by_role("button", name="Reload").click()
    expect(page.get_by_role("heading", name="Where to?")).to_be_visible()
