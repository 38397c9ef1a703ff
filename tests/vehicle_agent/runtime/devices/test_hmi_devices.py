"""Screens and loudspeaker against a matrix and a player that write down what they are told."""

import socket
import stat
import time
from importlib.util import find_spec
from pathlib import Path

import msgspec
import numpy as np
import pytest

from vehicle_agent.device_feed import DatagramPort, DeviceOutputs
from vehicle_agent.hmi import texts
from vehicle_agent.runtime.devices import led_text
from vehicle_agent.runtime.devices.audio import AudioError, AudioSettings, Loudspeaker
from vehicle_agent.runtime.devices.hmi_devices import (
    HmiDeviceError,
    HmiDeviceProcess,
    HmiDeviceSettings,
    ScreenSettings,
    output_devices,
)
from vehicle_agent.runtime.devices.led_ddp import HEADER, PAYLOAD_BYTES_MAX, DdpMatrix
from vehicle_agent.runtime.devices.led_text import (
    FontError,
    Panel,
    Pixels,
    TextPanel,
)
from vehicle_agent.runtime.processes.agent_files import AgentFolder
from vehicle_agent.signals import HmiOutput

PLOTS = find_spec("matplotlib")
assert PLOTS is not None
assert PLOTS.origin is not None
LATIN = str(Path(PLOTS.origin).parent / "mpl-data" / "fonts" / "ttf" / "DejaVuSans.ttf")
PANEL = Panel(64, 32, ("en",), (LATIN,))


class FakeMatrix:
    """A DDP controller: puts the packets together, lights the frame at the push."""

    def __init__(self, panel: Panel) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.settimeout(2.0)
        self.port: int = self._socket.getsockname()[1]
        self._shape = (panel.height_px, panel.width_px, 3)
        self._store = bytearray(panel.height_px * panel.width_px * 3)
        self.sequences: list[int] = []

    def frame(self) -> Pixels:
        """The next frame that is pushed; TimeoutError when none is."""
        for _ in range(1000):
            packet = self._socket.recv(2000)
            flags, sequence, kind, output, offset, length = HEADER.unpack(packet[: HEADER.size])
            assert (flags & 0xC0, kind, output) == (0x40, 0x0B, 1)
            assert length == len(packet) - HEADER.size <= PAYLOAD_BYTES_MAX
            self._store[offset : offset + length] = packet[HEADER.size :]
            self.sequences.append(sequence)
            if flags & 1:
                return np.frombuffer(bytes(self._store), np.uint8).reshape(self._shape)
        raise AssertionError("no packet says that the frame is complete")

    def is_quiet(self) -> bool:
        self._socket.settimeout(0.05)
        try:
            self._socket.recv(2000)
        except TimeoutError:
            return True
        finally:
            self._socket.settimeout(2.0)
        return False

    def close(self) -> None:
        self._socket.close()


def says(screen: str, announce: str = "", rear: str = "") -> HmiOutput:
    return HmiOutput(screen, screen, announce, "", False, rear, rear)


def test_a_frame_arrives_as_it_was_lit_whatever_its_size() -> None:
    panel = msgspec.structs.replace(PANEL, width_px=128, height_px=64)
    matrix, frame = FakeMatrix(panel), np.random.default_rng(1).integers(0, 255, (64, 128, 3), np.uint8)
    sender = DdpMatrix("127.0.0.1", matrix.port)
    for _ in range(17):
        sender.send_frame(frame)
        assert (matrix.frame() == frame).all()
    assert set(matrix.sequences) == set(range(1, 16))
    sender.close()
    matrix.close()


def test_a_text_that_fits_stands_still_in_the_middle() -> None:
    text = TextPanel(PANEL)
    assert not text.is_scrolling(("GO",))
    frame = text.frame(("GO",), 0.0)
    assert (frame == text.frame(("GO",), 7.3)).all()
    columns = np.flatnonzero(frame.any(axis=(0, 2)))
    assert abs((columns[0] + columns[-1]) / 2 - 31.5) < 3
    assert set(map(tuple, frame.reshape(-1, 3).tolist())) == {(0, 0, 0), PANEL.colour}


def test_a_long_text_comes_round_again() -> None:
    text = TextPanel(PANEL)
    line = ("PLEASE STEP ASIDE",)
    assert text.is_scrolling(line)
    first = text.frame(line, 0.0)
    moved = text.frame(line, 0.25)
    assert (first[:, 10:] == moved[:, :-10]).all()
    assert any((text.frame(line, t).tobytes() == first.tobytes()) for t in np.arange(1.0, 20.0, 0.025))


def test_different_words_look_different() -> None:
    text = TextPanel(msgspec.structs.replace(PANEL, width_px=600))
    shown = [texts.MANUAL, texts.AFTER_YOU, texts.STEP_ASIDE, texts.SLOWING, texts.PASSING, texts.DOORS_OPEN]
    assert len({text.frame((english,), 0.0).tobytes() for english, _ in shown}) == len(shown)


def test_a_font_without_chinese_is_refused_for_chinese() -> None:
    panel = msgspec.structs.replace(PANEL, languages=("zh",))
    with pytest.raises(FontError, match=r"DejaVuSans\.ttf lacks .*fonts-noto-cjk"):
        TextPanel(panel, (texts.every_text("zh"),))
    TextPanel(PANEL, (texts.every_text("en"),))


def test_both_languages_share_a_panel() -> None:
    text = TextPanel(Panel(128, 32, ("zh", "en")), (texts.every_text("zh"), texts.every_text("en")))
    both = text.frame(("请您先行", "AFTER YOU"), 0.0)
    assert both[:16].any()
    assert both[16:].any()
    assert not text.frame(("", "AFTER YOU"), 0.0)[:16].any()


def a_wide_panel(language: str, height_px: int) -> TextPanel:
    panel = Panel(1200, height_px, (language,))
    return TextPanel(panel, (texts.every_text(language),))


@pytest.mark.parametrize("height_px", [16, 32])
@pytest.mark.parametrize(("at", "language"), [(0, "en"), (1, "zh")])
def test_every_text_is_written_out_at_the_height_of_a_matrix(at: int, language: str, height_px: int) -> None:
    """Every mark has pixels, none is the font's box for the missing, and none is cut off."""
    text = a_wide_panel(language, height_px)
    box = lit(text, "\U0010fffd")
    for shown in texts.screen_texts("图书馆", "Main Library"):
        assert len(shown[at].strip()) > 1
        marks = [lit(text, mark) for mark in sorted(set(shown[at])) if not mark.isspace()]
        assert all(mark.any() for mark in marks), shown
        assert not any(mark.shape == box.shape and (mark == box).all() for mark in marks), shown
        written = lit(text, shown[at])
        high = TextPanel(Panel(1200, 3 * height_px, (language,)), (texts.every_text(language),))
        high._fonts = text._fonts
        assert written.sum() == lit(high, shown[at]).sum(), f"{shown[at]} is cut off"
        assert written.any(axis=1).sum() >= 0.6 * height_px


def lit(text: TextPanel, line: str) -> Pixels:
    """Which pixels of the panel are on, without the dark columns beside the text."""
    on: Pixels = text.frame((line,), 0.0).any(axis=2)
    columns = np.flatnonzero(on.any(axis=0))
    return on[:, columns[0] : columns[-1] + 1] if len(columns) else on[:, :0]


def test_a_stop_with_high_letters_is_written_smaller_and_not_cut() -> None:
    plain, high = (lit(a_wide_panel("en", 16), text) for text in ("STOPPING AT AQ", "STOPPING AT ẤQ"))
    assert high.shape[1] < plain.shape[1]
    assert 12 <= high.any(axis=1).sum() <= 16


def test_everything_said_has_words_in_both_languages() -> None:
    for english, chinese in texts.sentences("图书馆", "Main Library"):
        assert english.isascii()
        assert english.endswith(".")
        assert chinese.endswith("。")
        assert not any(mark.isascii() and mark.isalpha() for mark in chinese)


def test_without_the_shipped_font_a_panel_must_name_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(led_text, "_FONT_PACKAGE", "a_package_that_is_not_there")
    with pytest.raises(FontError, match=r"a_package_that_is_not_there is not installed.*`fonts`"):
        TextPanel(Panel())
    TextPanel(PANEL)


@pytest.mark.parametrize(
    ("panel", "told"),
    [
        (Panel(64, 32, ("en",), ("/nowhere.ttf",)), "no font at /nowhere.ttf"),
        (Panel(64, 32, ("en", "zh"), (LATIN,)), "2 languages need as many fonts"),
        (Panel(64, 4, ("en",), (LATIN,)), "too low to write in"),
    ],
)
def test_a_panel_that_cannot_be_drawn_says_why(panel: Panel, told: str) -> None:
    with pytest.raises(HmiDeviceError, match=rf"\[rear\].*{told}"):
        output_devices(HmiDeviceSettings(rear=ScreenSettings("127.0.0.1", panel=panel)))


def test_front_and_rear_show_their_own_text_and_repeat_it() -> None:
    front, rear = FakeMatrix(PANEL), FakeMatrix(PANEL)
    settings = HmiDeviceSettings(
        port=0,
        front=ScreenSettings("127.0.0.1", front.port, PANEL),
        rear=ScreenSettings("127.0.0.1", rear.port, PANEL),
    )
    process, tick = HmiDeviceProcess(settings), DatagramPort()
    tick.send(process.port, DeviceOutputs(says("GO", rear="STOP")))
    time.sleep(0.05)
    process.run_step(10.0)
    text = TextPanel(PANEL, (texts.every_text("en"),))
    assert (front.frame() == text.frame(("GO",), 0.0)).all()
    assert (rear.frame() == text.frame(("STOP",), 0.0)).all()
    process.run_step(10.5)
    assert front.is_quiet()
    process.run_step(11.1)
    assert (front.frame() == text.frame(("GO",), 0.0)).all()
    process.close()
    front.close()
    rear.close()
    tick.close()


def test_a_matrix_that_is_away_does_not_hold_the_other_one_up() -> None:
    rear = FakeMatrix(PANEL)
    settings = HmiDeviceSettings(
        port=0,
        front=ScreenSettings("127.0.0.1", 9, PANEL),
        rear=ScreenSettings("127.0.0.1", rear.port, PANEL),
    )
    process, tick = HmiDeviceProcess(settings), DatagramPort()
    text = TextPanel(PANEL, (texts.every_text("en"),))
    for k, said in enumerate(("GO", "OK", "GO")):
        tick.send(process.port, DeviceOutputs(says("OK", rear=said)))
        time.sleep(0.05)
        process.run_step(float(k))
        assert (rear.frame() == text.frame((said,), 0.0)).all()
    process.close()
    rear.close()
    tick.close()


def player(folder: Path, seconds: float = 0.0, code: int = 0, until: Path = Path("/")) -> tuple[str, Path]:
    """A program that writes its last argument to a file, takes its time and ends with a code.

    until  it does not end before there is this file
    """
    log, path = folder / "heard.txt", folder / "player"
    waits = f"while [ ! -e {until} ]; do sleep 0.01; done"
    lines = ("#!/bin/sh", "for last; do :; done", f'echo "$last" >> {log}', waits, f"sleep {seconds}")
    path.write_text("\n".join((*lines, f"exit {code}", "")))
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return str(path), log


def heard(log: Path, count: int, loudspeaker: Loudspeaker) -> list[str]:
    until_s = time.monotonic() + 5.0
    while time.monotonic() < until_s:
        loudspeaker.update()
        lines = log.read_text().splitlines() if log.exists() else []
        if len(lines) >= count and not loudspeaker.is_speaking:
            return lines
        time.sleep(0.01)
    raise AssertionError(f"{count} sentences expected, heard {lines}")


def test_sentences_are_spoken_one_after_the_other_in_both_languages(tmp_path: Path) -> None:
    program, log = player(tmp_path, until=tmp_path / "spoken")
    speaker = Loudspeaker(AudioSettings(speech=(program, "-v", "{voice}")))
    speaker.say("Doors are opening.", "车门正在打开。")
    speaker.update()
    speaker.update()
    assert speaker.is_speaking, "it does not wait for the end of the sentence"
    (tmp_path / "spoken").touch()
    assert heard(log, 2, speaker) == ["车门正在打开。", "Doors are opening."]
    speaker.close()


def test_a_recording_is_played_where_there_is_one(tmp_path: Path) -> None:
    program, log = player(tmp_path)
    (tmp_path / "doors.wav").write_bytes(b"RIFF")
    (tmp_path / "sentences.toml").write_text('"Doors are opening." = "doors.wav"\n')
    settings = AudioSettings(("en",), (program, "-q"), str(tmp_path), (program,), ("en",))
    speaker = Loudspeaker(settings)
    speaker.say("Doors are opening.", "")
    speaker.say("Next stop: Library.", "")
    assert heard(log, 2, speaker) == [str(tmp_path / "doors.wav"), "Next stop: Library."]
    speaker.close()


def test_a_player_that_fails_or_hangs_does_not_silence_the_next(tmp_path: Path) -> None:
    program, log = player(tmp_path, 20.0)
    now_s = [0.0]
    speaker = Loudspeaker(AudioSettings(("en",), speech=(program,), voices=("en",)), lambda: now_s[0])
    speaker.say("one", "")
    speaker.update()
    assert speaker.is_speaking
    until_s = time.monotonic() + 5.0
    while not (log.exists() and log.read_text()):
        assert time.monotonic() < until_s, "the player was never started"
        time.sleep(0.01)
    player(tmp_path, 0.0, code=3)
    now_s[0] = 60.0
    speaker.say("two", "")
    speaker.say("three", "")
    assert heard(log, 3, speaker) == ["one", "two", "three"]
    speaker.close()


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        (AudioSettings(speech=("no-such-program",)), "no program 'no-such-program'"),
        (AudioSettings(speech=()), "nothing to speak with"),
        (AudioSettings(recordings="/nowhere"), "/nowhere/sentences.toml"),
        (AudioSettings(voices=("en",)), "one voice for each"),
    ],
)
def test_a_loudspeaker_that_cannot_speak_says_why(settings: AudioSettings, told: str) -> None:
    with pytest.raises(AudioError, match=told):
        Loudspeaker(settings)


def test_the_settings_are_a_file_of_the_vehicle(tmp_path: Path) -> None:
    files = AgentFolder(tmp_path)
    assert files.hmi_devices() is None
    (tmp_path / "speaking.toml").write_text(
        '[front]\nhost = "10.0.0.7"\n[front.panel]\nwidth_px = 128\nlanguages = ["zh", "en"]\n'
    )
    settings = files.hmi_devices()
    assert settings is not None
    assert settings.front is not None
    assert (settings.front.panel.width_px, settings.front.port, settings.rear) == (128, 4048, None)
    (tmp_path / "speaking.toml").write_text("[front]\nport = 1\n")
    with pytest.raises(HmiDeviceError, match="host"):
        files.hmi_devices()
