"""The zenoh session: queries with an answer or a reason why not, and subscriptions that only enqueue."""

from __future__ import annotations

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
        self.gone = False
        self.closed = False
        self._session = _open(endpoint, timeout_s)
        self._watch = self._session.liveliness().declare_subscriber(f"{self.root}/alive", self._heard, history=True)
        if not self._alive.wait(timeout_s):
            others = self._instances()
            self.close()
            there = f"; there are {', '.join(others)}" if others else ""
            raise NotConnected(f"no simulation {instance!r} is alive at {endpoint}{there}")

    def _instances(self) -> list[str]:
        replies = self._session.liveliness().get("sturz/v1/*/alive", timeout=2.0)
        return sorted(str(reply.ok.key_expr).split("/")[2] for reply in replies if reply.ok is not None)

    def _heard(self, sample: zenoh.Sample) -> None:
        if sample.kind == zenoh.SampleKind.PUT:
            self._alive.set()
        else:
            self.mark_gone()

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

    def close(self) -> None:
        """Closes the session; streams end."""
        with self._lock:
            if self.closed:
                return
            self.closed = True
            waiting, listeners = list(self._waiting), list(self._on_end)
        for answers in waiting:
            answers.put(_GONE)
        for listener in listeners:
            listener(False)
        self._session.close()  # type: ignore[no-untyped-call]

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
                zenoh.handlers.Callback(answers.put, lambda: answers.put(_END), indirect=False),
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
            raise NoAnswer(f"{key}: the daemon gave no answer (an unknown key, or no right to ask)")
        if answer is _GONE:
            self.check()
            raise DaemonGone(f"{key}: the daemon ended before it answered")
        if answer.ok is not None:
            return bytes(answer.ok.payload.to_bytes())
        raise _refusal(key, bytes(answer.err.payload.to_bytes()))

    def subscribe(self, key: str, receive: Callable[[bytes], None], *, history: bool) -> Callable[[], None]:
        """Calls `receive` with every payload until the returned function is called."""
        expression = f"{self.root}/{key}"

        def take(sample: zenoh.Sample) -> None:
            receive(bytes(sample.payload.to_bytes()))

        self.check()
        if history:
            events = zenoh.ext.declare_advanced_subscriber(
                self._session,
                expression,
                zenoh.handlers.Callback(take),
                history=zenoh.ext.HistoryConfig(detect_late_publishers=True),
                recovery=zenoh.ext.RecoveryConfig(heartbeat=True),  # type: ignore[call-arg]
            )
            return events.undeclare
        return self._session.declare_subscriber(expression, zenoh.handlers.Callback(take)).undeclare

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
