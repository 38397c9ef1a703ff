"""An asyncio event loop without a clock: it runs ready callbacks, and the caller moves its time.

Ties are broken by creation number, nothing runs in threads, and an exception that is never awaited fails the
run. The conductor uses it for simulation and tests.
"""

import asyncio
import contextvars
import heapq
from collections import deque
from collections.abc import Callable, Coroutine, Generator, Mapping
from concurrent.futures import Executor
from typing import Any, TypeVar, TypeVarTuple

T = TypeVar("T")
Arguments = TypeVarTuple("Arguments")
AnyHandle = asyncio.Handle | asyncio.TimerHandle

# A callback chain this long within one instant is a livelock, not work.
CALLBACKS_MAX = 1_000_000


class VirtualTimeError(AssertionError):
    """An attempt to leave virtual time: a thread, a socket, a signal, or a wait that never ends."""


class VirtualLoop(asyncio.AbstractEventLoop):
    """now_ns is the loop's time; only `run_until_idle(now_ns)` moves it, and never backwards."""

    def __init__(self) -> None:
        self.now_ns = 0
        self._ready: deque[AnyHandle] = deque()
        self._timers: list[tuple[int, int, asyncio.TimerHandle]] = []
        self._created = 0
        self._failures: list[Mapping[str, object]] = []
        self._closed = False

    # ------------------------------------------------------------ what the conductor calls

    def run_until_idle(self, now_ns: int) -> None:
        """Fire every timer due by now_ns in (due, creation) order, and run until nothing is ready.

        Raises the first exception that a callback or an unawaited task ended with.
        """
        if now_ns < self.now_ns:
            raise VirtualTimeError(f"time cannot go back from {self.now_ns} to {now_ns} ns")
        self.now_ns = now_ns
        asyncio._set_running_loop(self)
        try:
            for _ in range(CALLBACKS_MAX):
                self._move_due_timers()
                if not self._ready:
                    break
                handle = self._ready.popleft()
                if not handle.cancelled():
                    handle._run()
            else:
                raise VirtualTimeError(f"still busy after {CALLBACKS_MAX} callbacks at {now_ns} ns")
        finally:
            asyncio._set_running_loop(None)
        self._raise_failure()

    def next_due_ns(self) -> int | None:
        """When the loop has work next: its present time if callbacks are ready, None without any timer."""
        if self._ready:
            return self.now_ns
        while self._timers and self._timers[0][2].cancelled():
            heapq.heappop(self._timers)
        return self._timers[0][0] if self._timers else None

    def run_now(self, coroutine: Coroutine[object, None, T]) -> T:
        """Run a coroutine to its end without moving time; for set-up and requests, which do not wait."""
        task = self.create_task(coroutine)
        self.run_until_idle(self.now_ns)
        if not task.done():
            task.cancel()
            self.run_until_idle(self.now_ns)
            raise VirtualTimeError(f"{coroutine!r} waits for time to pass")
        return task.result()

    def _move_due_timers(self) -> None:
        while self._timers and self._timers[0][0] <= self.now_ns:
            _, _, timer = heapq.heappop(self._timers)
            if not timer.cancelled():
                self._ready.append(timer)

    def _raise_failure(self) -> None:
        if self._failures:
            failure = self._failures[0]
            self._failures = []
            exception = failure.get("exception")
            if isinstance(exception, BaseException):
                raise exception
            raise VirtualTimeError(str(failure.get("message")))

    # ------------------------------------------------------------ what asyncio calls

    def time(self) -> float:
        return self.now_ns / 1e9

    def call_soon(
        self,
        callback: Callable[[*Arguments], object],
        *args: *Arguments,
        context: contextvars.Context | None = None,
    ) -> asyncio.Handle:
        handle = asyncio.Handle(callback, args, self, context)
        self._ready.append(handle)
        return handle

    def call_later(
        self,
        delay: float,
        callback: Callable[[*Arguments], object],
        *args: *Arguments,
        context: contextvars.Context | None = None,
    ) -> asyncio.TimerHandle:
        return self._at(self.now_ns + round(delay * 1e9), callback, args, context)

    def call_at(
        self,
        when: float,
        callback: Callable[[*Arguments], object],
        *args: *Arguments,
        context: contextvars.Context | None = None,
    ) -> asyncio.TimerHandle:
        return self._at(round(when * 1e9), callback, args, context)

    def _at(
        self,
        when_ns: int,
        callback: Callable[[*Arguments], object],
        args: tuple[*Arguments],
        context: contextvars.Context | None,
    ) -> asyncio.TimerHandle:
        timer = asyncio.TimerHandle(when_ns / 1e9, callback, args, self, context)
        heapq.heappush(self._timers, (when_ns, self._created, timer))
        self._created += 1
        return timer

    def create_future(self) -> "asyncio.Future[Any]":
        return asyncio.Future(loop=self)

    def create_task(
        self,
        coro: Generator[asyncio.Future[object] | None, None, T] | Coroutine[object, None, T],
        *,
        name: str | None = None,
        context: contextvars.Context | None = None,
    ) -> "asyncio.Task[T]":
        self._created += 1
        return asyncio.Task(coro, loop=self, name=name or f"virtual-{self._created}", context=context)

    def _timer_handle_cancelled(self, handle: asyncio.TimerHandle) -> None:
        """Nothing to do: a cancelled timer is skipped when it falls due."""

    def call_exception_handler(self, context: Mapping[str, object]) -> None:
        self._failures.append(context)

    def default_exception_handler(self, context: Mapping[str, object]) -> None:
        self._failures.append(context)

    def get_debug(self) -> bool:
        return False

    def is_running(self) -> bool:
        return asyncio._get_running_loop() is self

    def is_closed(self) -> bool:
        return self._closed

    def close(self) -> None:
        self._closed = True
        self._ready.clear()
        self._timers.clear()

    # ------------------------------------------------------------ what must not happen

    def call_soon_threadsafe(
        self,
        callback: Callable[[*Arguments], object],
        *args: *Arguments,
        context: contextvars.Context | None = None,
    ) -> asyncio.Handle:
        raise VirtualTimeError("a call from another thread in virtual time")

    def run_in_executor(
        self, executor: Executor | None, func: Callable[[*Arguments], T], *args: *Arguments
    ) -> "asyncio.Future[T]":
        raise VirtualTimeError(f"{func!r} asked for an executor in virtual time (a plain def endpoint?)")
