"""axe-core finds nothing in any state of both pages. `python -m benchmarks.web` has more looks of them."""

import pytest
from playwright.sync_api import Browser

from benchmarks.web.accessibility import AXE, Audit, rows_of
from tests.e2e.server_process import ServerProcess

pytestmark = [pytest.mark.browser, pytest.mark.real, pytest.mark.usefixtures("shuttle")]

LOOKS = (("en-GB", "light", "plain"), ("zh-CN", "dark", "text-200"))


def test_every_state_is_accessible(browser: Browser, server: ServerProcess) -> None:
    assert AXE.exists(), "axe-core is not installed: run `npm ci` in web/"
    audit = Audit(browser, server, None)
    audit.run(LOOKS)
    assert list(rows_of(audit.violations)) == []
    assert audit.states == 68
