"""The zenoh session: queries with an answer or a reason why not, and subscriptions that only enqueue."""

from __future__ import annotations

import atexit
import json
import queue
import threading
import time
from collections.abc import Callable
from typing import Any

import zenoh
import zenoh.ext

from ._proto.sturz.v1 import command_pb2 as pb
from .errors import CommandError, DaemonGone, ErrorCode, NoAnswer, NotConnected, Timeout

# Longer than any run; zenoh wants a number.
_NO_LIMIT_S = 1e7
_LAST_WORDS_S = 0.2
_LET_GO_S = 2.0
_GONE = "gone"
_END = "end"


def _open(endpoint: str, timeout_s: float) -> zenoh.Session:
    zenoh.init_log_from_env_or("off")
    config = zenoh.Config()
    # Two peers cannot reach each other through the daemon; a client can.
    for key, value in {
        "mode": "client",
        "connect/endpoints": [endpoint],
        "connect/timeout_ms": 0,
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
    }.items():
        config.insert_json5(key, json.dumps(value))
    deadline = time.monotonic() + timeout_s
    while True:
        try:
            return zenoh.open(config)
        except zenoh.ZError as error:
            if time.monotonic() >= deadline:
                raise NotConnected(f"no daemon listens at {endpoint}") from error
            time.sleep(0.05)


class Bus:
    """One session with one daemon."""

    def __init__(self, *, endpoint: str, instance: str, timeout_s: float) -> None:
        self.root = f"sturz/v1/{instance}"
        self.instance = instance
        self.endpoint = endpoint
        self._lock = threading.Lock()
        self._waiting: set[queue.SimpleQueue[Any]] = set()
        self._on_end: list[Callable[[bool], None]] = []
        self._alive = threading.Event()
        self._farewell: threading.Timer | None = None
        self._callbacks = 0
        self._let_go = threading.Condition()
        self.gone = False
        self.closed = False
        self._session = _open(endpoint, timeout_s)
        atexit.register(self.close)
        alive = f"{self.root}/alive"
        self._watch = self._session.liveliness().declare_subscriber(alive, self._callback(self._heard), history=True)
        if not self._alive.wait(timeout_s):
            others = self._instances()
            self.close()
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
            self._farewell = threading.Timer(_LAST_WORDS_S, self.mark_gone)
            self._farewell.daemon = True
            self._farewell.start()

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
            listener(True)

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
            listener(False)
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
            raise DaemonGone(f"the daemon of {self.instance!r} has ended, or the connection to {self.endpoint} broke")

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
            DaemonGone: the daemon ended meanwhile.
        """
        answers: queue.SimpleQueue[Any] = queue.SimpleQueue()
        with self._lock:
            self._waiting.add(answers)
        try:
            self.check()
            deadline = None if timeout_s is None else time.monotonic() + timeout_s
            self._session.get(
                f"{self.root}/{key}",
                self._callback(answers.put, lambda: answers.put(_END)),
                payload=payload,
                timeout=_NO_LIMIT_S if timeout_s is None else timeout_s + 5.0,
                consolidation=zenoh.ConsolidationMode.NONE,
                congestion_control=zenoh.CongestionControl.BLOCK,
                express=True,
            )
            if sent is not None:
                sent()
            return self._answer(key, answers, deadline, timeout_s)
        finally:
            with self._lock:
                self._waiting.discard(answers)

    def _answer(
        self, key: str, answers: queue.SimpleQueue[Any], deadline: float | None, timeout_s: float | None
    ) -> bytes:
        try:
            answer = answers.get(timeout=None if deadline is None else max(deadline - time.monotonic(), 0.0))
        except queue.Empty:
            raise Timeout(f"{key}: no answer within {timeout_s:g} s") from None
        if answer is _END:
            # A daemon that goes ends the query some moments before its liveliness is lost.
            end = time.monotonic() + 1.0
            while not self.gone and time.monotonic() < end:
                time.sleep(0.01)
            self.check()
            raise NoAnswer(f"{key}: the daemon gave no answer: it does not know the key, is flooded, or denies access")
        if answer is _GONE:
            self.check()
            raise DaemonGone(f"{key}: the daemon ended before it answered")
        if answer.ok is not None:
            return bytes(answer.ok.payload.to_bytes())
        raise _refusal(key, bytes(answer.err.payload.to_bytes()))

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
                listener.undeclare()
                events.undeclare()

            return stop
        return self._session.declare_subscriber(expression, callback).undeclare

    def when_ended(self, listener: Callable[[bool], None]) -> Callable[[], None]:
        """Calls `listener(gone)` once when the daemon is gone or the session is closed; returns how to stop that."""
        with self._lock:
            over, gone = self.closed or self.gone, self.gone
            if not over:
                self._on_end.append(listener)
        if over:
            listener(gone)

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
