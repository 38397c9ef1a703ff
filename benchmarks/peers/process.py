"""An open planner in a process of its own, with its own interpreter, on the same core as all others."""

import os
import select
import subprocess
import time
from pathlib import Path
from types import TracebackType

import msgspec

from benchmarks.peers.messages import FromPlanner, Plan, PlanRequest, Ready, Road

ROOT = Path(__file__).resolve().parents[2]
ANSWER_WALL_S = 300.0


class PeerError(Exception):
    """A planner's process does not answer; the message says what it did last."""


class PeerProcess:
    """`begin` a scene, then `plan` in it; `ready` describes the planner. The context ends the process."""

    def __init__(self, command: list[str], answer_s: float = ANSWER_WALL_S) -> None:
        """Raises PeerError if the process does not start."""
        self._command = " ".join(command)
        self._answer_s = answer_s
        threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        try:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                cwd=ROOT,
                env={**os.environ, **threads, "PYTHONHASHSEED": "0"},
            )
        except OSError as error:
            raise PeerError(f"{self._command}: {error}") from error
        self._decoder = msgspec.json.Decoder(FromPlanner)
        self._received = b""
        try:
            ready = self._answer()
        except PeerError:
            self.close()
            raise
        if not isinstance(ready, Ready):
            self.close()
            raise PeerError(f"{self._command}: did not begin with its name and version")
        self.ready = ready

    def begin(self, road: Road) -> None:
        self._send(road)

    def plan(self, request: PlanRequest) -> Plan:
        """Raises PeerError if the process ends, sends another message or does not answer in time."""
        self._send(request)
        plan = self._answer()
        if not isinstance(plan, Plan):
            raise PeerError(f"{self._command}: was asked for a plan and sent {type(plan).__name__}")
        return plan

    def close(self) -> None:
        """End the process."""
        process = self._process
        if process.poll() is None:
            process.kill()
        process.wait()
        for pipe in (process.stdin, process.stdout):
            assert pipe is not None
            pipe.close()

    def __enter__(self) -> "PeerProcess":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _send(self, message: Road | PlanRequest) -> None:
        pipe = self._process.stdin
        assert pipe is not None
        try:
            pipe.write(msgspec.json.encode(message) + b"\n")
            pipe.flush()
        except BrokenPipeError as error:
            raise PeerError(f"{self._command}: has ended with status {self._process.wait()}") from error

    def _answer(self) -> FromPlanner:
        pipe = self._process.stdout
        assert pipe is not None
        until_s = time.monotonic() + self._answer_s
        while b"\n" not in self._received:
            left_s = until_s - time.monotonic()
            if left_s <= 0.0 or not select.select([pipe], [], [], left_s)[0]:
                raise PeerError(f"{self._command}: no answer in {self._answer_s:g} s")
            piece = os.read(pipe.fileno(), 1 << 16)
            if not piece:
                raise PeerError(f"{self._command}: has ended with status {self._process.wait()}")
            self._received += piece
        line, _, self._received = self._received.partition(b"\n")
        try:
            return self._decoder.decode(line)
        except msgspec.MsgspecError as error:
            raise PeerError(f"{self._command}: said something else: {line[:120]!r} ({error})") from error
