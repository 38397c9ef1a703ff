"""Steps of an operator on the console."""

from playwright.sync_api import Locator, Page, expect

from tests.e2e.server_process import PASSWORD


def sign_in(page: Page, password: str = PASSWORD, name: str = "operator") -> None:
    page.get_by_label("Name").fill(name)
    page.get_by_label("Password").fill(password)
    page.get_by_role("button", name="Sign in").click()


def show_vehicle(page: Page, name: str) -> Locator:
    """The vehicle's panel."""
    page.locator(".row", has_text=name).click()
    panel = page.get_by_role("region", name=name)
    expect(panel).to_be_visible()
    return panel
