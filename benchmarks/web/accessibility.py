"""axe-core on every state of both pages: both languages, light and dark, large text, without motion."""

import itertools
import re
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, Page, expect

from benchmarks.web.passenger import PHONE
from tests.e2e.server_process import PASSWORD, ROOT, ServerProcess

AXE = ROOT / "web" / "node_modules" / "axe-core" / "axe.min.js"
# WCAG 2.2 on levels A and AA, and what axe calls best practice.
_TAGS = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]
_LANGUAGES = ("en-GB", "zh-CN")
_SCHEMES = ("light", "dark")
_VARIANTS = ("plain", "text-200", "reduced-motion")
ALL_LOOKS = tuple(itertools.product(_LANGUAGES, _SCHEMES, _VARIANTS))
_DESKTOP: dict[str, Any] = {"viewport": {"width": 1440, "height": 900}}
_SETTLE_MS = 350

Shown = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Violation:
    """where: state, language, colours, variant."""

    where: str
    rule: str
    nodes: int
    example: str


class Audit:
    """Counts the states that were looked at, and what was found in them."""

    def __init__(self, browser: Browser, server: ServerProcess, screenshots: Path | None) -> None:
        self.states = 0
        self.violations: list[Violation] = []
        self._browser, self._server, self._screenshots = browser, server, screenshots

    def run(self, looks: Iterable[tuple[str, str, str]] = ALL_LOOKS) -> None:
        """looks: language, colours, variant; every state of both pages in each of them."""
        for language, scheme, variant in looks:
            for shape, walk in ((PHONE, _walk_passenger), (_DESKTOP, _walk_console)):
                self._walk(shape | {"locale": language, "color_scheme": scheme}, variant, walk)

    def _walk(
        self, shape: dict[str, Any], variant: str, walk: Callable[[Page, ServerProcess, Shown], None]
    ) -> None:
        motion = "reduce" if variant == "reduced-motion" else "no-preference"
        context = self._browser.new_context(**(shape | {"reduced_motion": motion}))
        if variant == "text-200":
            context.add_init_script(
                "addEventListener('DOMContentLoaded',"
                " () => document.documentElement.style.setProperty('font-size', '200%'))"
            )
        page = context.new_page()
        place = f"{shape['locale']} {shape['color_scheme']} {variant}"
        walk(page, self._server, lambda state: self._look(page, f"{state} {place}"))
        context.close()

    def _look(self, page: Page, where: str) -> None:
        # Bars that stay at the edges cover what is scrolled under them; as a page begins, they cover nothing.
        page.evaluate("scrollTo(0, 0)")
        page.wait_for_timeout(_SETTLE_MS)
        if not page.evaluate("'axe' in window"):
            page.evaluate(AXE.read_text())
        found = page.evaluate("(tags) => axe.run({ runOnly: tags })", _TAGS)
        self.states += 1
        for violation in found["violations"]:
            example = str(violation["nodes"][0]["html"])[:160]
            self.violations.append(Violation(where, violation["id"], len(violation["nodes"]), example))
        if self._screenshots is not None:
            page.screenshot(path=self._screenshots / f"{where.replace(' ', '_')}.png")


def _walk_passenger(page: Page, server: ServerProcess, shown: Shown) -> None:
    page.goto(server.origin)
    page.locator("canvas").wait_for()
    shown("form")
    for number, state in enumerate(("pickup-list", "destination-list")):
        page.locator(".stop-field").nth(number).click()
        page.get_by_role("searchbox").wait_for()
        shown(state)
        page.locator(".stop-choice").nth(2 + number).click()
    shown("form-filled")
    for number, state in ((1, "later"), (2, "repeat"), (0, "now")):
        page.locator(".pickup-time .switch button").nth(number).click()
        shown(state)
    page.locator(".book-bar button").click()
    page.locator("[data-ride-code]").wait_for()
    shown("ride")
    page.get_by_role("button", name=re.compile("^(Help|求助)$")).click()
    page.get_by_role("dialog").wait_for()
    shown("help")
    page.keyboard.press("Escape")
    page.get_by_role("dialog").wait_for(state="detached")
    page.locator(".secondary-actions .danger").click()
    shown("cancel")
    page.get_by_role("dialog").locator(".danger").click()
    page.locator(".ticket.ended").wait_for()
    shown("ride-cancelled")
    for address, state in _ADDRESSES:
        page.goto(f"{server.origin}/#{address}")
        page.reload()
        expect(page.locator("h1, h2, .alert").first).to_be_visible()
        shown(state)
    page.goto(f"{server.origin}/#ride={_refused(server)}")
    page.locator("h1").wait_for()
    shown("refused")


_ADDRESSES = (("code=", "find"), ("ride=x", "broken-link"), ("ride=" + "x" * 24, "unknown-link"))


def _refused(server: ServerProcess) -> str:
    ends = [stop["stop_id"] for stop in server.http.get("/stops").json()[:2]]
    wish = {"from_stop": ends[0], "to_stop": ends[1], "party": 2, "wheelchairs": 2}
    token: str = server.change("POST", "/rides", wish)["token"]
    return token


def _walk_console(page: Page, server: ServerProcess, shown: Shown) -> None:
    page.goto(f"{server.origin}/console")
    page.locator("input[type=password]").wait_for()
    shown("sign-in")
    page.locator("form input").first.fill("operator")
    page.locator("input[type=password]").fill(PASSWORD)
    page.locator("form .button.main").click()
    page.locator(".row").first.wait_for()
    shown("live")
    page.locator(".row").first.click()
    page.locator(".vehicle").wait_for()
    shown("vehicle")
    for summary in page.locator("details.recording summary").all():
        summary.click()
    page.get_by_role("button", name=re.compile("^(Show what it sees|显示车辆所见)$")).click()
    page.locator(".st-graph").wait_for()
    shown("vehicle-scene")
    page.get_by_role("button", name=re.compile("^(Hold|暂停)$")).click()
    page.locator("dialog .button.danger").wait_for()
    shown("hold-preview")
    page.keyboard.press("Escape")
    for place in _PLACES:
        page.goto(f"{server.origin}/console#/{place}")
        page.locator("main h1, main h2").first.wait_for()
        shown(place)
        if place == "service":
            page.locator(".announcements input[required]").first.fill("今天在东侧上车")
            page.locator(".announcements input[required]").last.fill("Board at the east side today")
            page.locator(".announcements .button.main").click()
            page.locator("dialog [data-preview]").first.wait_for()
            shown("announcement-preview")
            page.keyboard.press("Escape")
            page.get_by_role("button", name=re.compile("^(Edit the timetable|编辑时刻表)$")).click()
            page.get_by_role("button", name=re.compile("^(New trip|新班次)$")).click()
            page.locator(".trip-form").wait_for()
            shown("timetable-editor")
    begun_ms = round(time.time() * 1000) - 3_600_000
    page.goto(f"{server.origin}/console#/runs/@fleet/{begun_ms}/7200/{begun_ms + 3_590_000}")
    page.locator(".timeline").wait_for()
    page.locator(".row").first.wait_for()
    shown("fleet-replay")
    draft = server.change("POST", "/maps/drafts", {"name": "Draft"})
    page.goto(f"{server.origin}/console#/maps/{draft['draft_id']}")
    page.locator(".map-side .alert.good").wait_for()
    shown("map-editor")
    page.get_by_role("application").press("Enter")
    shown("map-editor-chosen")
    # A campus keeps so many drafts at a time.
    server.http.delete(f"/maps/drafts/{draft['draft_id']}").raise_for_status()
    page.goto(f"{server.origin}/board/{server.http.get('/stops').json()[0]['stop_id']}")
    page.locator("img.code").wait_for()
    shown("stop-board")


_PLACES = ("rides", "service", "maps", "incidents", "runs", "statistics", "audit", "access")


def rows_of(violations: list[Violation]) -> Iterator[dict[str, str | int]]:
    """One row a rule, with where it was found first."""
    by_rule: dict[str, list[Violation]] = {}
    for violation in violations:
        by_rule.setdefault(violation.rule, []).append(violation)
    for rule, found in by_rule.items():
        first = found[0]
        yield {"axe_rule": rule, "states": len(found), "first_in": first.where, "example": first.example}
