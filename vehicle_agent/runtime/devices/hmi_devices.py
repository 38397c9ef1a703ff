"""Screens and loudspeaker as a process of the vehicle computer: takes the HMI output, drives the devices.

Each device is an `OutputDevice`; `speaking.toml` in the vehicle's folder lists them.
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
# A frame is repeated for a controller that was away or goes dark.
REPEAT_S = 1.0


class HmiDeviceError(Exception):
    """speaking.toml cannot be used; the message names the field or line."""


class ScreenSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A matrix behind a DDP controller."""

    host: str
    port: int = DDP_PORT
    panel: Panel = Panel()


class HmiDeviceSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """port: loopback port for the HMI output; devices that are left out are not driven."""

    port: int = 47_600
    front: ScreenSettings | None = None
    rear: ScreenSettings | None = None
    audio: AudioSettings | None = None


class OutputDevice(Protocol):
    """Shows or speaks the HMI output. No call waits for a device."""

    def take(self, hmi_output: HmiOutput, now_s: float) -> None:
        """Takes an HMI output, new or repeated."""
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

    def take(self, hmi_output: HmiOutput, now_s: float) -> None:
        by_language = (
            {"en": hmi_output.rear, "zh": hmi_output.rear_zh}
            if self._rear
            else {"en": hmi_output.screen, "zh": hmi_output.screen_zh}
        )
        lines = tuple(by_language[name] for name in self._languages)
        if lines != self._lines:
            self._lines, self._since_s, self._sent_s = lines, now_s, None
            self.step(now_s)

    def step(self, now_s: float) -> None:
        due = self._sent_s is None or now_s - self._sent_s >= REPEAT_S
        if due or self._text.is_scrolling(self._lines):
            self._sent_s = now_s
            self._matrix.send_frame(self._text.frame(self._lines, now_s - self._since_s))

    def close(self) -> None:
        self._matrix.close()


class SpeechOutput:
    """The loudspeaker."""

    def __init__(self, settings: AudioSettings) -> None:
        """Raises AudioError."""
        self._loudspeaker = Loudspeaker(settings)

    def take(self, hmi_output: HmiOutput, now_s: float) -> None:
        if hmi_output.announce or hmi_output.announce_zh:
            self._loudspeaker.say(hmi_output.announce, hmi_output.announce_zh)
        self._loudspeaker.update()

    def step(self, now_s: float) -> None:
        self._loudspeaker.update()

    def close(self) -> None:
        self._loudspeaker.close()


def load_hmi_devices(path: Path) -> HmiDeviceSettings | None:
    """The settings; None without the file: the vehicle's devices read the HMI output themselves."""
    try:
        return msgspec.toml.decode(path.read_bytes(), type=HmiDeviceSettings)
    except FileNotFoundError:
        return None
    except msgspec.DecodeError as error:
        raise HmiDeviceError(f"{path}: {error}") from error


def output_devices(settings: HmiDeviceSettings) -> list[OutputDevice]:
    """The devices of these settings. Raises HmiDeviceError."""
    devices: list[OutputDevice] = []
    name = ""
    try:
        for name, screen in (("front", settings.front), ("rear", settings.rear)):
            if screen is not None:
                devices.append(Screen(screen, rear=name == "rear"))
        if settings.audio is not None:
            name = "audio"
            devices.append(SpeechOutput(settings.audio))
    except (FontError, AudioError) as error:
        for device in devices:
            device.close()
        raise HmiDeviceError(f"speaking.toml, [{name}]: {error}") from error
    return devices


class HmiDeviceProcess:
    """Takes HMI outputs and drives the devices; the tick never waits for it."""

    def __init__(self, settings: HmiDeviceSettings) -> None:
        """Raises HmiDeviceError, DeviceFeedError."""
        self._devices = output_devices(settings)
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
        """Gives received outputs to the devices, then steps each device."""
        for datagram in self._port.take():
            if isinstance(datagram, DeviceOutputs):
                for device in self._devices:
                    device.take(datagram.hmi, now_s)
        for device in self._devices:
            device.step(now_s)

    @property
    def port(self) -> int:
        return self._port.port

    def close(self) -> None:
        for device in self._devices:
            device.close()
        self._port.close()

    def _stop(self, _number: int, _frame: FrameType | None) -> None:
        self._stopping = True
