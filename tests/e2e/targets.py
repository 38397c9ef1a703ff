"""The boxes of everything that can be clicked or tapped on a page, and of the page itself."""

from playwright.sync_api import Page

# A checkbox or radio button counts with its label, which is clicked as well. Half a pixel is rounding.
_SMALL_TARGETS = """(least) => {
  const shown = (element) => {
    const box = element.getBoundingClientRect();
    const style = getComputedStyle(element);
    return box.width > 1 && box.height > 1 && style.visibility === "visible" && !element.closest("[inert]");
  };
  const box_of = (element) => {
    const is_tick = element.matches("input[type=checkbox], input[type=radio]");
    const label = is_tick ? element.closest("label") ?? element.labels?.[0] : null;
    return (label ?? element).getBoundingClientRect();
  };
  const all = "a[href], button, input, select, textarea, summary, [role=button], [role=link]";
  return [...document.querySelectorAll(all)]
    .filter(shown)
    .map((element) => [element, box_of(element)])
    .filter(([, box]) => box.width < least - 0.5 || box.height < least - 0.5)
    .map(([element, box]) =>
      `${element.tagName} "${(element.getAttribute("aria-label") ?? element.textContent ?? "").trim()}" ` +
      `${box.width.toFixed(0)} x ${box.height.toFixed(0)}`);
}"""


def small_targets(page: Page, least_px: float) -> list[str]:
    """Those that are narrower or lower than this."""
    found: list[str] = page.evaluate(_SMALL_TARGETS, least_px)
    return found


def sticks_out(page: Page) -> bool:
    """A phone's own width counts: a page that sticks out makes its window wider."""
    assert page.viewport_size is not None
    width: int = page.evaluate("document.documentElement.scrollWidth")
    return width > page.viewport_size["width"]
