"""Screens and loudspeaker as a process of the vehicle computer: takes the tick's words, drives the devices.

Whatever shows or speaks is an `Outlet`; which ones a vehicle has is said by `speaking.toml` in its folder.
"""

import select
import signal
import time
from pathlib import Path
from types import FrameType
from typing import Protocol

import msgspec
import structlog

from vehicle_agent.device_feed import DatagramPort, DeviceOutputs
from vehicle_agent.hmi import texts
from vehicle_agent.runtime.devices.audio import AudioError, AudioSettings, Loudspeaker
from vehicle_agent.runtime.devices.led_ddp import DDP_PORT, DdpMatrix
from vehicle_agent.runtime.devices.led_text import FontError, Panel, TextPanel
from vehicle_agent.signals import HmiOutput

log = structlog.get_logger()

FRAME_S = 0.05
# A controller that was away, or goes dark without news, is told again.
REPEAT_S = 1.0


class SpeakingError(Exception):
    """speaking.toml cannot be used; the message says which line of it to mend."""


class ScreenSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A matrix behind a DDP controller."""

    host: str
    port: int = DDP_PORT
    panel: Panel = Panel()


class SpeakingSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """port: loopback port on which the tick's words come; devices that are left out are not driven."""

    port: int = 47_600
    front: ScreenSettings | None = None
    rear: ScreenSettings | None = None
    audio: AudioSettings | None = None


class Outlet(Protocol):
    """Shows or speaks what a vehicle says. Neither call ever waits for a device."""

    def take(self, says: HmiOutput, now_s: float) -> None:
        """New words, or the same again."""
        ...

    def step(self, now_s: float) -> None:
        """Called every FRAME_S."""
        ...

    def close(self) -> None: ...


class Screen:
    """One LED matrix, front or rear."""

    def __init__(self, settings: ScreenSettings, rear: bool) -> None:
        """Raises FontError."""
        self._rear = rear
        self._languages = settings.panel.languages
        self._text = TextPanel(settings.panel, tuple(texts.every_text(name) for name in self._languages))
        self._matrix = DdpMatrix(settings.host, settings.port)
        self._lines: tuple[str, ...] = tuple("" for _ in self._languages)
        self._since_s = 0.0
        self._sent_s: float | None = None

    def take(self, says: HmiOutput, now_s: float) -> None:
        by_language = (
            {"en": says.rear, "zh": says.rear_zh} if self._rear else {"en": says.screen, "zh": says.screen_zh}
        )
        lines = tuple(by_language[name] for name in self._languages)
        if lines != self._lines:
            self._lines, self._since_s, self._sent_s = lines, now_s, None
            self.step(now_s)

    def step(self, now_s: float) -> None:
        due = self._sent_s is None or now_s - self._sent_s >= REPEAT_S
        if due or self._text.moves(self._lines):
            self._sent_s = now_s
            self._matrix.light(self._text.frame(self._lines, now_s - self._since_s))

    def close(self) -> None:
        self._matrix.close()


class Voice:
    """The loudspeaker."""

    def __init__(self, settings: AudioSettings) -> None:
        """Raises AudioError."""
        self._loudspeaker = Loudspeaker(settings)

    def take(self, says: HmiOutput, now_s: float) -> None:
        if says.announce or says.announce_zh:
            self._loudspeaker.say(says.announce, says.announce_zh)
        self._loudspeaker.look()

    def step(self, now_s: float) -> None:
        self._loudspeaker.look()

    def close(self) -> None:
        self._loudspeaker.close()


def load_speaking(path: Path) -> SpeakingSettings | None:
    """None when there is no such file: the vehicle's devices take the words themselves."""
    try:
        return msgspec.toml.decode(path.read_bytes(), type=SpeakingSettings)
    except FileNotFoundError:
        return None
    except msgspec.DecodeError as error:
        raise SpeakingError(f"{path}: {error}") from error


def outlets(settings: SpeakingSettings) -> list[Outlet]:
    """The devices of these settings. Raises SpeakingError."""
    made: list[Outlet] = []
    name = ""
    try:
        for name, screen in (("front", settings.front), ("rear", settings.rear)):
            if screen is not None:
                made.append(Screen(screen, rear=name == "rear"))
        if settings.audio is not None:
            name = "audio"
            made.append(Voice(settings.audio))
    except (FontError, AudioError) as error:
        for outlet in made:
            outlet.close()
        raise SpeakingError(f"speaking.toml, [{name}]: {error}") from error
    return made


class SpeakingProcess:
    """Nothing but a socket and a beat; the tick never waits for it."""

    def __init__(self, settings: SpeakingSettings) -> None:
        """Raises SpeakingError, DeviceFeedError."""
        self._outlets = outlets(settings)
        self._port = DatagramPort(settings.port)
        self._stopping = False

    def run(self) -> None:
        """Until SIGTERM."""
        signal.signal(signal.SIGTERM, self._stop)
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        while not self._stopping:
            select.select([self._port.fileno()], [], [], FRAME_S)
            self.run_step(time.monotonic())
        self.close()

    def run_step(self, now_s: float) -> None:
        """Hand out what has come, then move what moves."""
        for datagram in self._port.take():
            if isinstance(datagram, DeviceOutputs):
                for outlet in self._outlets:
                    outlet.take(datagram.hmi, now_s)
        for outlet in self._outlets:
            outlet.step(now_s)

    @property
    def port(self) -> int:
        return self._port.port

    def close(self) -> None:
        for outlet in self._outlets:
            outlet.close()
        self._port.close()

    def _stop(self, _number: int, _frame: FrameType | None) -> None:
        self._stopping = True
