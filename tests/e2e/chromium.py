"""An installed Chromium or Chrome; no browser is downloaded."""

import os
import shutil

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "microsoft-edge")
# Playwright's own list, which this one replaces, and at last what costs a page a third of its time: Chromium
# without a screen, too, makes a whole window for each page, with two more pages that suggest addresses.
DISABLED_FEATURES = (
    "AvoidUnnecessaryBeforeUnloadCheckSync",
    "DestroyProfileOnBrowserClose",
    "HttpsUpgrades",
    "HttpsFirstBalancedModeAutoEnable",
    "LensOverlay",
    "MediaRouter",
    "PaintHolding",
    "ThirdPartyStoragePartitioning",
    "AvoidCorsURLLoaderRestartOnRedirect",
    "OptimizationHints",
    "NetworkTimeServiceQuerying",
    "AimEnabled",
    "PreconnectToSearch",
    "WebUIOmniboxPopup",
    "WebUIOmniboxAimPopup",
)
LAUNCH_FLAGS = (
    f"--disable-features={','.join(DISABLED_FEATURES)}",
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)


class NoBrowser(Exception):
    """The message says what to install."""


def chromium_path() -> str:
    """CAMPUSLOOP_CHROMIUM, else the first installed one of NAMES. Raises NoBrowser."""
    given = os.environ.get("CAMPUSLOOP_CHROMIUM")
    if given:
        if shutil.which(given) is None:
            raise NoBrowser(f"CAMPUSLOOP_CHROMIUM names {given}, which is no program")
        return given
    for name in NAMES:
        found = shutil.which(name)
        if found is not None:
            return found
    raise NoBrowser(
        "the browser tests need Chromium or Chrome: install one (Debian, Ubuntu: apt-get install chromium; "
        "macOS: brew install --cask chromium) or name one in CAMPUSLOOP_CHROMIUM"
    )
