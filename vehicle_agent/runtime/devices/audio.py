"""The loudspeaker: recorded sentences by a player program, all others by text-to-speech.

Programs are started and monitored without waiting; one speaks at a time.
"""

import shutil
import subprocess
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path

import msgspec
import structlog

log = structlog.get_logger()

# When the queue is full, the oldest sentence is dropped.
WAITING_MAX = 4
SPEAKS_S_MAX = 30.0
Clock = Callable[[], float]


class AudioError(Exception):
    """The loudspeaker cannot be used; the message names the missing program or file."""


class AudioSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """languages   in which order each sentence is spoken: "en", "zh"
    player         program and options; the WAV file's path comes last
    recordings     folder with `sentences.toml`: `"sentence" = "file.wav"`; empty: no recordings
    speech         program and options of the text-to-speech, `{voice}` replaced, the text comes last; or none
    voices         of the text-to-speech, in the order of `languages`
    """

    languages: tuple[str, ...] = ("zh", "en")
    player: tuple[str, ...] = ("aplay", "-q")
    recordings: str = ""
    speech: tuple[str, ...] = ("espeak-ng", "-v", "{voice}")
    voices: tuple[str, ...] = ("cmn", "en")


class Loudspeaker:
    """`say` queues a sentence; `update` starts the next one when none is spoken. Call `update` often."""

    def __init__(self, settings: AudioSettings, clock: Clock = time.monotonic) -> None:
        """Raises AudioError if a program or a recording in the settings is missing."""
        if len(settings.voices) != len(settings.languages):
            raise AudioError("`voices` must name one voice for each of `languages`")
        if not settings.recordings and not settings.speech:
            raise AudioError("neither `recordings` nor `speech` is set: there is nothing to speak with")
        self._settings = settings
        self._clock = clock
        self._recordings = _recordings(Path(settings.recordings)) if settings.recordings else {}
        for command in (settings.player if self._recordings else (), settings.speech):
            if command and shutil.which(command[0]) is None:
                raise AudioError(f"no program {command[0]!r}; install it (Debian: alsa-utils, espeak-ng)")
        self._waiting: deque[tuple[str, tuple[str, ...]]] = deque(maxlen=WAITING_MAX)
        self._program: subprocess.Popen[bytes] | None = None
        self._begun_s = 0.0

    @property
    def is_speaking(self) -> bool:
        return self._program is not None

    def say(self, english: str, chinese: str) -> None:
        """Queues a sentence; a text that is the same in both languages is spoken once."""
        texts = {"en": english, "zh": chinese}
        queued = set()
        for language, voice in zip(self._settings.languages, self._settings.voices, strict=True):
            text = texts[language]
            if text and text not in queued:
                queued.add(text)
                command = self._command(text, voice)
                if command:
                    self._waiting.append((text, command))
                else:
                    log.warning("voice.no_recording", text=text)

    def update(self) -> None:
        """Checks the running program, ends one that hangs, starts the next. Never waits."""
        if self._program is not None and not self._has_ended(self._program):
            return
        self._program = None
        if self._waiting:
            text, command = self._waiting.popleft()
            try:
                self._program = subprocess.Popen(
                    command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
                )
            except OSError as error:
                log.error("voice.failed", text=text, error=str(error))
            self._begun_s = self._clock()

    def close(self) -> None:
        """Ends speech and clears the queue."""
        self._waiting.clear()
        if self._program is not None:
            self._program.kill()
            self._program.wait()
            self._program = None

    def _has_ended(self, program: subprocess.Popen[bytes]) -> bool:
        code = program.poll()
        if code is None and self._clock() - self._begun_s > SPEAKS_S_MAX:
            program.kill()
            program.wait()
            log.error("voice.hung", program=str(program.args))
            return True
        if code:
            log.error("voice.failed", program=str(program.args), code=code)
        return code is not None

    def _command(self, text: str, voice: str) -> tuple[str, ...]:
        recorded = self._recordings.get(text)
        if recorded is not None:
            return (*self._settings.player, str(recorded))
        if not self._settings.speech:
            return ()
        return (*(part.replace("{voice}", voice) for part in self._settings.speech), text)


def _recordings(folder: Path) -> dict[str, Path]:
    """The WAV file of each sentence; every file exists."""
    index = folder / "sentences.toml"
    try:
        names = msgspec.toml.decode(index.read_bytes(), type=dict[str, str])
    except (OSError, msgspec.DecodeError) as error:
        raise AudioError(f'{index}: {error}; it holds lines of "sentence" = "file.wav"') from error
    missing = [name for name in names.values() if not (folder / name).is_file()]
    if missing:
        raise AudioError(f"{index} names {missing[0]}, which is not in {folder}")
    return {text: folder / name for text, name in names.items()}
