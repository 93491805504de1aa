"""Where a daemon is, how this client proves who it is, and why a daemon is gone."""

from __future__ import annotations

import enum
import json
import os
import socket
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import zenoh

from .errors import AccessDenied, NotConnected

_RETRY_S = 0.05
# Least and most time for one attempt: who hangs does not say no.
_ATTEMPT_S = (1.0, 10.0)
_KNOCK_S = 2.0
# One that hangs is given up by the bus only after its lease, so it has had its time.
_PROBE_S = 3.0


class Loss(enum.Enum):
    """Why a daemon is gone, as far as it can be known from here."""

    DIED = "it has ended or was killed"
    HUNG = "it hangs: its machine takes connections, and it answers nothing"
    UNREACHABLE = "its machine cannot be reached"
    DENIED = "it lives, and does not let this client in any more"
    BROKEN = "it lives, and the connection broke: `reconnect` goes on"


@dataclass(frozen=True)
class Tls:
    """Certificates by which client and daemon know each other.

    Attributes:
        authority: certificate of the authority that has signed the daemon's.
        certificate: this client's.
        key: its key.
    """

    authority: Path
    certificate: Path
    key: Path

    @staticmethod
    def from_folder(folder: str | os.PathLike[str]) -> Tls:
        """The folder of one client that `sturz certs` has made, such as ``lab/clients/alice``.

        Raises:
            FileNotFoundError: a file is missing.
        """
        files = [Path(folder) / name for name in ("ca.pem", "certificate.pem", "key.pem")]
        for file in files:
            if not file.is_file():
                raise FileNotFoundError(
                    f"{file} is missing: give the folder of one client, such as lab/clients/alice, "
                    "which `sturz certs` makes"
                )
        return Tls(*files)


@dataclass(frozen=True)
class Target:
    """Where a daemon is, and how this client comes in."""

    endpoint: str
    tls: Tls | None = None
    config: Path | None = None

    def _settings(self, patience_s: float) -> zenoh.Config:
        config = zenoh.Config() if self.config is None else zenoh.Config.from_file(self.config)
        # Two peers cannot reach each other through the daemon; a client can.
        settings: dict[str, Any] = {
            "mode": "client",
            "connect/endpoints": [self.endpoint],
            "connect/timeout_ms": 0,
            "scouting/multicast/enabled": False,
            "scouting/gossip/enabled": False,
            "transport/unicast/open_timeout": int(patience_s * 1000),
        }
        if self.tls is not None:
            settings["transport/link/tls"] = {
                "root_ca_certificate": str(self.tls.authority),
                "enable_mtls": True,
                "connect_certificate": str(self.tls.certificate),
                "connect_private_key": str(self.tls.key),
            }
        for key, value in settings.items():
            config.insert_json5(key, json.dumps(value))
        return config

    def open(self, timeout_s: float) -> zenoh.Session:
        """A session with whoever listens there.

        Raises:
            NotConnected: nobody does, or it hangs.
            AccessDenied: it wants a certificate, or another one.
        """
        zenoh.init_log_from_env_or("off")
        deadline = time.monotonic() + timeout_s
        while True:
            start = time.monotonic()
            patience_s = min(max(deadline - start, _ATTEMPT_S[0]), _ATTEMPT_S[1])
            try:
                return zenoh.open(self._settings(patience_s))
            except zenoh.ZError as error:
                now = time.monotonic()
                if now >= deadline:
                    raise self._refusal(said_no=now - start < patience_s) from error
                time.sleep(_RETRY_S)

    def _refusal(self, *, said_no: bool) -> Exception:
        if knock(self.endpoint) is not True:
            return NotConnected(f"no daemon listens at {self.endpoint}")
        if not said_no:
            return NotConnected(
                f"{self.endpoint} takes connections and answers nothing: the daemon hangs, or it is none"
            )
        crowd = "as many clients as its limit `clients` allows"
        if not self.endpoint.startswith("tls/"):
            return NotConnected(f"{self.endpoint} turns this client away: it is no Sturz daemon, or has {crowd}")
        if self.tls is None:
            return AccessDenied(f"{self.endpoint} wants a certificate of its authority: give its folder as `tls`")
        return AccessDenied(
            f"{self.endpoint} turns this client away: the certificate, or the daemon's, is of another authority, "
            f"for another host or out of date; or it has {crowd}"
        )

    def diagnose(self, alive: str) -> Loss:
        """Why the instance with this liveliness token is gone. Takes some seconds where it hangs."""
        answer = knock(self.endpoint)
        if answer is False:
            return Loss.DIED
        if isinstance(answer, OSError):
            return Loss.UNREACHABLE
        start = time.monotonic()
        try:
            session = zenoh.open(self._settings(_PROBE_S))
        except zenoh.ZError:
            said_no = time.monotonic() - start < _PROBE_S
            # A process that ends may have taken the first knock and nothing after it.
            if knock(self.endpoint) is False:
                return Loss.DIED
            return Loss.DENIED if said_no else Loss.HUNG
        try:
            replies = list(session.liveliness().get(alive, timeout=_PROBE_S))
        finally:
            session.close()  # type: ignore[no-untyped-call]
        return Loss.BROKEN if any(reply.ok is not None for reply in replies) else Loss.DIED


def knock(endpoint: str) -> bool | OSError | None:
    """Whether somebody listens at an endpoint such as ``tls/host:7447``; the error where there is no way to it, and
    None where it is not a matter of TCP."""
    protocol, _, address = endpoint.partition("/")
    host, _, port = address.split("?")[0].split("#")[0].rpartition(":")
    if protocol not in ("tcp", "tls") or not port.isdecimal():
        return None
    try:
        socket.create_connection((host.strip("[]"), int(port)), _KNOCK_S).close()
    except ConnectionRefusedError:
        return False
    except OSError as error:
        return error
    return True
