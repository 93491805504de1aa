"""The zenoh session: queries with an answer or a reason why not, and subscriptions that only enqueue."""

from __future__ import annotations

import atexit
import contextlib
import math
import queue
import threading
import time
from collections.abc import Callable
from typing import Any

import zenoh
import zenoh.ext

from ._proto.sturz.v1 import command_pb2 as pb
from ._proto.sturz.v1 import status_pb2
from .errors import (
    AccessDenied,
    CommandError,
    DaemonDenied,
    DaemonDied,
    DaemonGone,
    DaemonHung,
    DaemonUnreachable,
    ErrorCode,
    NoAnswer,
    NotConnected,
    Timeout,
)
from .target import Loss, Target

# Longer than any run; zenoh wants a number.
_NO_LIMIT_S = 1e7
# Longest wait in one piece.
_SLICE_S = 0.5
_LAST_WORDS_S = 0.2
_LET_GO_S = 2.0
_GONE = "gone"
_END = "end"


_LOSSES: dict[Loss, type[DaemonGone]] = {
    Loss.DIED: DaemonDied,
    Loss.HUNG: DaemonHung,
    Loss.UNREACHABLE: DaemonUnreachable,
    Loss.DENIED: DaemonDenied,
    Loss.BROKEN: DaemonGone,
}


class Bus:
    """One session with one daemon."""

    def __init__(self, *, target: Target, instance: str, timeout_s: float) -> None:
        self.root = f"sturz/v1/{instance}"
        self.instance = instance
        self.target = target
        self.endpoint = endpoint = target.endpoint
        self.loss = Loss.DIED
        self._lock = threading.Lock()
        self._waiting: set[queue.SimpleQueue[Any]] = set()
        self._on_end: list[Callable[[DaemonGone | None], None]] = []
        self._alive = threading.Event()
        self._farewell: threading.Timer | None = None
        self._callbacks = 0
        self._let_go = threading.Condition()
        self.gone = False
        self.closed = False
        self._session = target.open(timeout_s)
        atexit.register(self.close)
        alive = f"{self.root}/alive"
        self._watch = self._session.liveliness().declare_subscriber(alive, self._callback(self._heard), history=True)
        if not self._alive.wait(timeout_s):
            others = self._instances()
            self.close()
            if not others and target.tls is not None:
                # Who may look sees at least the daemon that it is connected to.
                raise AccessDenied(
                    f"{endpoint} shows this client nothing, not even whether {instance!r} is there: the name in its "
                    "certificate has no role with the daemon (`sturz certs`)"
                )
            there = f"; there are {', '.join(others)}" if others else ""
            raise NotConnected(f"no simulation {instance!r} is alive at {endpoint}{there}")

    def _instances(self) -> list[str]:
        replies = self._session.liveliness().get("sturz/v1/*/alive", timeout=2.0)
        return sorted(str(reply.ok.key_expr).split("/")[2] for reply in replies if reply.ok is not None)

    def _callback(self, function: Callable[[Any], None], end: Callable[[], None] | None = None) -> Any:
        """For zenoh: `function` with everything that comes, on a thread of the bus, so it only enqueues; then `end`.

        Zenoh's other kind of callback has a thread that keeps the interpreter from ending while a stream is open.
        """

        def let_go() -> None:
            if end is not None:
                end()
            with self._let_go:
                self._callbacks -= 1
                self._let_go.notify_all()

        with self._let_go:
            self._callbacks += 1
        return zenoh.handlers.Callback(function, let_go, indirect=False)

    def _heard(self, sample: zenoh.Sample) -> None:
        if sample.kind == zenoh.SampleKind.PUT:
            self._alive.set()
            return
        with self._lock:
            if self.closed or self._farewell is not None:
                return
            # The loss overtakes the last answers and events of a daemon that ends in good order: they come first.
            farewell = threading.Timer(_LAST_WORDS_S, self._find_loss)
            farewell.daemon = True
            farewell.start()
            # Not before: others may join what is seen here.
            self._farewell = farewell

    def _find_loss(self) -> None:
        # Zenoh would connect this session again by itself, with its liveliness token, and the daemon would take this
        # client, which gives up, for one that lives and holds its lease.
        self._session.close()  # type: ignore[no-untyped-call]
        self.loss = self.target.diagnose(f"{self.root}/alive")
        self.mark_gone()

    def lost(self, what: str = "") -> DaemonGone:
        """What to raise when the daemon is gone: why, as far as that is known."""
        prefix = f"{what}: " if what else ""
        return _LOSSES[self.loss](
            f"{prefix}the daemon of {self.instance!r} at {self.endpoint} is gone: {self.loss.value}"
        )

    def mark_gone(self) -> None:
        """Wakes whoever waits: nobody will answer any more."""
        with self._lock:
            if self.gone:
                return
            self.gone = True
            waiting, listeners = list(self._waiting), list(self._on_end)
        for answers in waiting:
            answers.put(_GONE)
        for listener in listeners:
            listener(self.lost())

    def declare_token(self, key: str) -> Any:
        """A liveliness token under the instance, which vanishes with this session; `undeclare` takes it back."""
        self.check()
        return self._session.liveliness().declare_token(f"{self.root}/{key}")

    def close(self) -> None:
        """Closes the session; streams end."""
        with self._lock:
            if self.closed:
                return
            self.closed = True
            waiting, listeners = list(self._waiting), list(self._on_end)
            farewell, self._farewell = self._farewell, None
        atexit.unregister(self.close)
        if farewell is not None:
            # A thread that is the last to know this object frees what belongs to the bus, and doing so while the
            # interpreter ends aborts the process.
            farewell.cancel()
            farewell.join()
        for answers in waiting:
            answers.put(_GONE)
        for listener in listeners:
            listener(None)
        self._session.close()  # type: ignore[no-untyped-call]
        # A thread of the bus that calls into an interpreter that is ending aborts the process.
        with self._let_go:
            self._let_go.wait_for(lambda: self._callbacks == 0, _LET_GO_S)
        del self._watch

    def check(self) -> None:
        """Raises when there is nobody to talk to."""
        if self.closed:
            raise NotConnected(f"the simulation {self.instance!r} was closed")
        if self.gone:
            raise self.lost()

    def ask(
        self,
        key: str,
        *,
        payload: bytes | None = None,
        timeout_s: float | None,
        sent: Callable[[], None] | None = None,
    ) -> bytes:
        """Answer to a query on `key` (below the root of the instance). Calls `sent` when the query is on its way.

        Raises:
            CommandError: the daemon answered with an error.
            Timeout: no answer within `timeout_s`.
            DaemonGone: the daemon was lost meanwhile.
            AccessDenied: the role of this client does not allow it.
        """
        answers: queue.SimpleQueue[Any] = queue.SimpleQueue()
        with self._lock:
            self._waiting.add(answers)
        try:
            self.check()
            deadline = None if timeout_s is None else time.monotonic() + timeout_s
            try:
                self._session.get(
                    f"{self.root}/{key}",
                    self._callback(answers.put, lambda: answers.put(_END)),
                    payload=payload,
                    timeout=_NO_LIMIT_S if timeout_s is None else timeout_s + 5.0,
                    consolidation=zenoh.ConsolidationMode.NONE,
                    congestion_control=zenoh.CongestionControl.BLOCK,
                    express=True,
                )
            except zenoh.ZError:
                self._wait_for_loss()
                raise
            if sent is not None:
                sent()
            return self._answer(key, answers, deadline, timeout_s)
        finally:
            with self._lock:
                self._waiting.discard(answers)

    def _answer(
        self, key: str, answers: queue.SimpleQueue[Any], deadline: float | None, timeout_s: float | None
    ) -> bytes:
        answer = None
        while answer is None:
            left = math.inf if deadline is None else max(deadline - time.monotonic(), 0.0)
            try:
                # In slices: a Ctrl-C that comes just before a wait does not end it.
                answer = answers.get(timeout=min(left, _SLICE_S))
            except queue.Empty:
                if left <= _SLICE_S:
                    raise Timeout(f"{key}: no answer within {timeout_s:g} s") from None
        if answer is _END:
            raise self._no_answer(key)
        if answer is _GONE:
            self.check()
            raise self.lost(key)
        if answer.ok is not None:
            return bytes(answer.ok.payload.to_bytes())
        raise _refusal(key, bytes(answer.err.payload.to_bytes()))

    def _no_answer(self, key: str) -> Exception:
        """Why a question ended without an answer. Zenoh's access control denies without a word; who may come in at all
        may ask for `features`, which tell whether there is such control."""
        answers: list[Any] = []
        self._wait_for_loss(0.0)
        with contextlib.suppress(zenoh.ZError):
            answers = [reply.ok for reply in self._session.get(f"{self.root}/features", timeout=1.0) if reply.ok]
        if not answers:
            # A daemon that goes ends the query some moments before its liveliness is lost.
            self._wait_for_loss()
        elif "access_control" in status_pb2.Features.FromString(bytes(answers[0].payload.to_bytes())).capabilities:
            return AccessDenied(f"{key}: the role of this client does not allow it")
        return NoAnswer(f"{key}: the daemon gave no answer: it does not know the key, or is flooded")

    def _wait_for_loss(self, timeout_s: float = 1.0) -> None:
        """Raises when the daemon is gone, or is going within the time."""
        end = time.monotonic() + timeout_s
        while self._farewell is None and not self.gone and time.monotonic() < end:
            time.sleep(0.01)
        farewell = self._farewell
        if farewell is not None:
            farewell.join()
        self.check()

    def subscribe(
        self, key: str, receive: Callable[[bytes], None], *, missed: Callable[[int], None] | None = None
    ) -> Callable[[], None]:
        """Calls `receive` with every payload until the returned function is called.

        With `missed`, the recent past comes first, lost payloads are asked for again, and `missed` is told how many
        could not be had.
        """
        expression = f"{self.root}/{key}"

        def take(sample: zenoh.Sample) -> None:
            receive(bytes(sample.payload.to_bytes()))

        self.check()
        callback = self._callback(take)
        if missed is not None:
            events = zenoh.ext.declare_advanced_subscriber(
                self._session,
                expression,
                callback,
                history=zenoh.ext.HistoryConfig(detect_late_publishers=True),
                recovery=zenoh.ext.RecoveryConfig(heartbeat=True),  # type: ignore[call-arg]
            )
            listener = events.sample_miss_listener(self._callback(lambda miss: missed(miss.nb)))

            def stop() -> None:
                listener.undeclare()  # type: ignore[no-untyped-call]
                events.undeclare()  # type: ignore[no-untyped-call]

            return stop
        return self._session.declare_subscriber(expression, callback).undeclare

    def when_ended(self, listener: Callable[[DaemonGone | None], None]) -> Callable[[], None]:
        """Calls `listener` once, with the error when the daemon is gone and without when the session is closed; returns
        how to stop that."""
        with self._lock:
            over, gone = self.closed or self.gone, self.gone
            if not over:
                self._on_end.append(listener)
        if over:
            listener(self.lost() if gone else None)

        def forget() -> None:
            with self._lock:
                if listener in self._on_end:
                    self._on_end.remove(listener)

        return forget


def _refusal(key: str, payload: bytes) -> Exception:
    try:
        error = pb.Error.FromString(payload)
    except Exception:
        text = payload.decode(errors="replace")
        # Zenoh's own answer when its clock ran out.
        return Timeout(f"{key}: {text}")
    return CommandError(code=ErrorCode(error.code), path=error.path, message=error.message, command=key)
