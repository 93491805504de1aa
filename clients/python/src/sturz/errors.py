"""What can go wrong, one class per question that a program may ask about it."""

from __future__ import annotations

import enum


class ErrorCode(enum.IntEnum):
    """Why the daemon refused, as in the schema."""

    UNSPECIFIED = 0
    UNDECODABLE = 1
    INVALID_INPUT = 2
    TOO_LARGE = 3
    BUSY = 4
    NOT_PAUSED = 5
    WINDOW_IN_FLIGHT = 6
    WRONG_TIME = 7
    REQUEST_ID_REUSED = 8
    NOT_FOUND = 9
    RUN_FAILED = 10
    STOPPING = 11
    INTERNAL = 12
    UNUSABLE_CHECKPOINT = 13
    DISK = 14
    LEASE = 15
    RECORDING = 16

    @classmethod
    def _missing_(cls, value: object) -> ErrorCode:
        # A newer daemon may know more codes; its text still says what happened.
        return cls.UNSPECIFIED


class SturzError(Exception):
    """Every error of this package."""


class LaunchFailed(SturzError):
    """The daemon could not be started; the text holds the end of what it said."""


class NotConnected(SturzError):
    """No daemon was reached at the endpoint, or the simulation was closed."""


class AccessDenied(SturzError):
    """This client may not come in, or may not do that: its certificate or its role does not allow it."""


class DaemonGone(SturzError):
    """The daemon ended, or the connection to it broke; `Simulation.reconnect` goes on where it still or again lives.

    Where more is known, one of the classes below is raised.
    """


class DaemonDied(DaemonGone):
    """The daemon has ended or was killed: nobody listens there any more, or who does does not know it."""


class DaemonHung(DaemonGone):
    """The daemon's machine takes connections for it, and it answers nothing: it is stopped, or swamped."""


class DaemonUnreachable(DaemonGone):
    """The daemon's machine cannot be reached."""


class DaemonDenied(DaemonGone, AccessDenied):
    """The daemon lives, and does not let this client in any more, such as when its certificate has run out."""


class Timeout(SturzError, TimeoutError):
    """No answer in time. The request may have been applied: the same call with the same request id finds out."""


class NoAnswer(SturzError):
    """The daemon lives, and nobody answers this key: it does not know it, or is flooded."""


class ProtocolError(SturzError):
    """An answer that this client cannot read."""


class CommandError(SturzError):
    """The daemon refused; its state is as it was.

    Attributes:
        code: why.
        path: into the request, such as ``placement.random.count``; empty when there is none.
        message: what is wrong, and what would be right.
        command: what was asked, such as ``set_gravity`` or ``state/latest``.
        step: steps done when it was refused; None for queries.
    """

    def __init__(self, *, code: ErrorCode, path: str, message: str, command: str, step: int | None = None) -> None:
        self.code = code
        self.path = path
        self.message = message
        self.command = command
        self.step = step
        place = f" at {path}" if path else ""
        super().__init__(f"{command} refused ({code.name}{place}): {message}")
