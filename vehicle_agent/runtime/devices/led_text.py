"""Texts as pixels for an LED matrix: one line a language, scrolled when it is wider than the panel."""

import math
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

Pixels = NDArray[np.uint8]
# A private character that no font has: fonts draw their box for missing characters.
_MISSING = "\U0010fffd"
# Noto Sans SC (OFL-1.1), which has Latin letters too; installed with the agent.
_FONT_PACKAGE, _FONT_FILE = "pylopdf_fonts_zh_cn", "NotoSansSC-Regular.otf"
# Sizes are chosen by this text when no required texts are given.
_SAMPLE = "AQÉgj国龘"
_SIZE_PX_MIN = 6


class FontError(Exception):
    """A font cannot be read or lacks characters; the message names the file and what to do."""


class Panel(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """width_px, height_px  of the matrix
    languages     one line each, from top to bottom: "en", "zh"
    fonts         a TrueType or OpenType file for each language, in that order; none: Noto Sans SC for all
    colour        red, green, blue of lit pixels, 0..255
    scroll_pxps   of texts that are wider than the panel; gap_px between their end and their beginning
    """

    width_px: int = 64
    height_px: int = 32
    languages: tuple[str, ...] = ("en",)
    fonts: tuple[str, ...] = ()
    colour: tuple[int, int, int] = (255, 160, 0)
    scroll_pxps: float = 40.0
    gap_px: int = 24


class TextPanel:
    """Draws lines of text as pixels; equal texts at equal times give equal pixels."""

    def __init__(self, panel: Panel, required_texts: tuple[str, ...] = ()) -> None:
        """required_texts: one a language; its font must have all their characters. Raises FontError."""
        fonts = panel.fonts or (str(shipped_font()),) * len(panel.languages)
        if len(fonts) != len(panel.languages) or not panel.languages:
            raise FontError(
                f"{len(panel.languages)} languages need as many fonts, not {len(panel.fonts)}; "
                "set `fonts` to one file for each of `languages`"
            )
        self.panel = panel
        self.line_px = panel.height_px // len(panel.languages)
        self._names = fonts
        samples = required_texts or (_SAMPLE,) * len(fonts)
        self._fonts = [_largest(name, text, self.line_px) for name, text in zip(fonts, samples, strict=True)]
        for number, text in enumerate(required_texts):
            self._check(number, text)
        self._cached_line = lru_cache(maxsize=64)(self._line)

    def is_scrolling(self, lines: tuple[str, ...]) -> bool:
        """True if a line is wider than the panel, so that its pixels change with time."""
        return any(
            text and self._cached_line(number, text).shape[1] > self.panel.width_px
            for number, text in enumerate(lines)
        )

    def frame(self, lines: tuple[str, ...], t_s: float) -> Pixels:
        """(height, width, 3) pixels t_s after the texts were set; lines: one text for each language."""
        panel = self.panel
        lit = np.zeros((panel.height_px, panel.width_px), dtype=bool)
        for number, text in enumerate(lines):
            if text:
                top = number * self.line_px
                lit[top : top + self.line_px] = self._window(self._cached_line(number, text), t_s)
        frame: Pixels = lit[:, :, None] * np.array(panel.colour, dtype=np.uint8)
        return frame

    def _window(self, line: NDArray[np.bool_], t_s: float) -> NDArray[np.bool_]:
        """The visible part of a line: centred if it fits, otherwise scrolling to the left."""
        width = self.panel.width_px
        out = np.zeros((self.line_px, width), dtype=bool)
        if line.shape[1] <= width:
            left = (width - line.shape[1]) // 2
            out[:, left : left + line.shape[1]] = line
            return out
        period = line.shape[1] + self.panel.gap_px
        columns = (np.arange(width) + math.floor(t_s * self.panel.scroll_pxps)) % period
        inside = columns < line.shape[1]
        out[:, inside] = line[:, columns[inside]]
        return out

    def _line(self, number: int, text: str) -> NDArray[np.bool_]:
        """A text's pixels; a text that is higher than the line (É in a stop's name) is drawn smaller."""
        font = self._fonts[number]
        if _ink_px(font, text) > self.line_px:
            font = _largest(self._names[number], text, self.line_px)
        left, top, right, bottom = font.getbbox(text, anchor="ls")
        image = Image.new("1", (max(1, math.ceil(right - left)), self.line_px))
        baseline = (self.line_px - math.ceil(bottom - top)) // 2 - math.floor(top)
        ImageDraw.Draw(image).text((-left, baseline), text, fill=1, font=font, anchor="ls")
        return np.asarray(image, dtype=bool)

    def _check(self, number: int, text: str) -> None:
        font = self._fonts[number]
        box = bytes(font.getmask(_MISSING, mode="1"))
        missing = sorted(
            {
                character
                for character in text
                if not character.isspace() and bytes(font.getmask(character, mode="1")) == box
            }
        )
        if missing:
            raise FontError(
                f"{self._names[number]} lacks {''.join(missing[:20])}; give a font that has them for "
                f"{self.panel.languages[number]!r} (for Chinese, Debian's fonts-noto-cjk)"
            )


def shipped_font() -> Path:
    """The path of the shipped font. Raises FontError if it is not installed."""
    found = find_spec(_FONT_PACKAGE)
    if found is None or found.origin is None:
        raise FontError(
            f"the panel names no `fonts` and the package {_FONT_PACKAGE} is not installed; install it or set "
            "`fonts` to one TrueType or OpenType file for each of `languages`"
        )
    return Path(found.origin).parent / _FONT_FILE


def _ink_px(font: ImageFont.FreeTypeFont, text: str) -> int:
    """Height of the text's own characters; a font reserves more."""
    _, top, _, bottom = font.getbbox(text, anchor="ls")
    return math.ceil(bottom - top)


def _largest(path: str, text: str, line_px: int) -> ImageFont.FreeTypeFont:
    """The font in the largest size in which the text fits the line."""
    try:
        for size in range(2 * line_px, _SIZE_PX_MIN - 1, -1):
            font = ImageFont.truetype(path, size)
            if _ink_px(font, text) <= line_px:
                return font
    except OSError as error:
        raise FontError(f"no font at {path} ({error}); set `fonts` to a TrueType or OpenType file") from error
    raise FontError(f"lines of {line_px} pixels are too low to write in; take a higher panel or one language")
