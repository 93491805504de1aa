"""Streams of frames: a bounded queue that forgets the oldest, and counts what was lost where."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from types import TracebackType
from typing import Any, Generic, Self, TypeVar

from .errors import DaemonGone, ProtocolError, Timeout

T = TypeVar("T")


class Stream(Generic[T]):
    """Frames as they come. Iterate over it, or ask `next_frame` and `latest`; close it, or use it in a `with`.

    A slow reader loses the oldest frames, never the newest, and slows nobody down. The iteration ends when the
    stream or the simulation is closed, and raises `DaemonGone` when the daemon is lost.

    Attributes:
        received: frames that reached this process.
        dropped_on_the_way: frames that did not, by gaps in their sequence numbers.
        missed: events that did not come, nor could be had from the daemon's memory: gaps that zenoh has told of.
        dropped_here: frames that were overwritten in the queue before they were read.
    """

    def __init__(
        self,
        *,
        name: str,
        decode: Callable[[bytes], Any],
        convert: Callable[[Any], T],
        keep: int,
        counted: bool = True,
    ) -> None:
        if keep < 1:
            raise ValueError(f"keep is {keep}; at least 1 frame is needed")
        self.name = name
        self.received = 0
        self.dropped_on_the_way = 0
        self.missed = 0
        self.dropped_here = 0
        self._decode = decode
        self._convert = convert
        self._keep = keep
        self._counted = counted
        self._frames: deque[Any] = deque()
        self._changed = threading.Condition()
        self._last: tuple[str, int] | None = None
        self._failure: BaseException | None = None
        self._ended = False
        self._stop: list[Callable[[], None]] = []
        self._worker: threading.Thread | None = None
        self._listener: Callable[[], None] | None = None

    def __repr__(self) -> str:
        return f"Stream({self.name!r}, received={self.received}, dropped={self.dropped})"

    @property
    def dropped(self) -> int:
        """Frames lost in all."""
        return self.dropped_on_the_way + self.missed + self.dropped_here

    # Called by the bus, on its threads: enqueues, and nothing else.

    def receive(self, payload: bytes) -> None:
        """Takes one payload."""
        try:
            message = self._decode(payload)
        except Exception as error:
            self.fail(ProtocolError(f"{self.name}: {len(payload)} bytes are no such message: {error}"))
            return
        with self._changed:
            if self._ended:
                return
            self.received += 1
            if self._counted:
                self._count(message.header.run_id, message.header.seq)
            if len(self._frames) == self._keep:
                self._frames.popleft()
                self.dropped_here += 1
            self._frames.append(message)
            self._announce()

    def _count(self, run_id: str, seq: int) -> None:
        if self._last is not None and self._last[0] == run_id and seq > self._last[1]:
            self.dropped_on_the_way += seq - self._last[1] - 1
        self._last = (run_id, seq)

    def _announce(self) -> None:
        """Wakes the reader. With the lock held."""
        self._changed.notify_all()
        if self._listener is not None:
            self._listener()

    def when_changed(self, listener: Callable[[], None]) -> None:
        """Calls `listener` on threads of the bus at every frame and at the end; it must only enqueue."""
        with self._changed:
            self._listener = listener

    def miss(self, count: int) -> None:
        """So many will not come."""
        with self._changed:
            self.missed += count

    def fail(self, error: BaseException) -> None:
        """Ends the stream; `error` is raised in its reader."""
        with self._changed:
            self._failure = self._failure or error
            self._ended = True
            self._announce()

    def end(self, lost: DaemonGone | None) -> None:
        """Ends the stream; the reader gets the error when there is one."""
        if lost is not None:
            self.fail(lost)
            return
        with self._changed:
            self._ended = True
            self._announce()

    def at_close(self, stop: Callable[[], None]) -> None:
        """Has `stop` called by `close`."""
        self._stop.append(stop)

    # Called by the reader.

    def next_frame(self, timeout_s: float | None = None) -> T | None:
        """The oldest frame that was not read; None when the stream has ended.

        Raises:
            Timeout: none came within `timeout_s`.
            DaemonGone: the daemon is lost, and all that came before was read.
        """
        deadline = None if timeout_s is None else time.monotonic() + timeout_s
        with self._changed:
            while not self._frames:
                if self._failure is not None:
                    raise self._failure
                if self._ended:
                    return None
                rest = None if deadline is None else deadline - time.monotonic()
                if rest is not None and rest <= 0:
                    raise Timeout(f"{self.name}: no frame within {timeout_s:g} s")
                self._changed.wait(rest)
            message = self._frames.popleft()
        return self._convert(message)

    def latest(self) -> T | None:
        """The newest frame that was not read, and none older; None when there is none."""
        with self._changed:
            if not self._frames:
                return None
            message = self._frames.pop()
            self.dropped_here += len(self._frames)
            self._frames.clear()
        return self._convert(message)

    def __iter__(self) -> Iterator[T]:
        while True:
            frame = self.next_frame()
            if frame is None:
                return
            yield frame

    def for_each(self, function: Callable[[T], object]) -> Self:
        """Calls `function` with every frame, on a thread of this stream's own.

        Its exception ends the stream and is raised by `close` (or at the end of the `with`).
        """
        if self._worker is not None:
            raise RuntimeError(f"{self.name}: for_each was called before")

        def work() -> None:
            try:
                for frame in self:
                    function(frame)
            except BaseException as error:
                # A lost daemon is told by whatever the program asks next; all else must not vanish in a thread.
                if not isinstance(error, DaemonGone):
                    self.fail(error)

        self._worker = threading.Thread(target=work, name=f"sturz {self.name}", daemon=True)
        self._worker.start()
        return self

    def close(self) -> None:
        """Ends the stream. Raises what a function given to `for_each` has raised."""
        stop, self._stop = self._stop, []
        for function in stop:
            function()
        with self._changed:
            self._ended = True
            self._announce()
        worker, self._worker = self._worker, None
        if worker is not None and worker is not threading.current_thread():
            worker.join()
            if self._failure is not None and not isinstance(self._failure, DaemonGone):
                raise self._failure

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            self.close()
        except BaseException:
            # The exception that is already on its way says more.
            if error is None:
                raise
