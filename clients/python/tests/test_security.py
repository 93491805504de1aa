"""Certificates and roles, and daemons that stop: what the Python client says of each."""

import contextlib
import json
import os
import re
import signal
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from conftest import SPACE, Background, drop, wait_for_state

import sturz

Serve = Callable[..., "Served"]


class Served:
    """A daemon by its command line."""

    def __init__(self, process: "subprocess.Popen[str]") -> None:
        assert process.stdout is not None
        line = next(line for line in process.stdout if line.startswith("ready "))
        ready = json.loads(line.removeprefix("ready "))
        self.process = process
        self.endpoint: str = ready["endpoint"]
        self.instance: str = ready["instance"]

    def connect(self, tls: Path | None = None, timeout_s: float = 30.0) -> sturz.Simulation:
        """A client of it."""
        return sturz.connect(self.instance, endpoint=self.endpoint, tls=tls, timeout_s=timeout_s)


@pytest.fixture
def serve(binary: Path, tmp_path: Path) -> Iterator[Serve]:
    """Starts daemons that end with the test."""
    scene = tmp_path / "scene.toml"
    scene.write_text(SPACE)
    with contextlib.ExitStack() as stack:

        def start(*arguments: str) -> Served:
            command = [str(binary), "serve", str(scene), "--name", "space", "--paused", "--json", *arguments]
            process = subprocess.Popen(command, text=True, stdout=subprocess.PIPE, stdin=subprocess.DEVNULL)
            stack.enter_context(process)
            stack.callback(process.kill)
            return Served(process)

        yield start


def certs(binary: Path, lab: Path, *arguments: str) -> None:
    """Makes certificates."""
    subprocess.run([str(binary), "certs", str(lab), *arguments], check=True, capture_output=True)


@pytest.fixture
def lab(binary: Path, tmp_path: Path) -> Path:
    """A lab with a client of each role, and one without."""
    folder = tmp_path / "lab"
    certs(binary, folder, *(f"--client={client}" for client in ("eve:view", "sam:steer", "ada:admin", "rex:admin")))
    certs(binary, folder, "--revoke", "rex")
    return folder


def test_each_role_may_what_it_may(serve: Serve, lab: Path) -> None:
    daemon = serve("--listen", "auto", "--tls", str(lab))
    with (
        daemon.connect(lab / "clients/eve") as eve,
        daemon.connect(lab / "clients/sam") as sam,
        daemon.connect(lab / "clients/ada") as ada,
        eve.events() as events,
        eve.states() as states,
    ):
        drop(sam)
        sam.acquire_lease()
        assert eve.state().step == 0
        assert sam.step().step == 1
        assert states.next_frame(30.0) is not None
        assert events.next_frame(30.0) is not None
        for denied in (eve.step, eve.resume, eve.acquire_lease, sam.stop, eve.stop):
            with pytest.raises(sturz.AccessDenied, match="role of this client"):
                denied()
        assert eve.info().step == 1
        ada.stop()
    assert daemon.process.wait(30.0) == 0


def test_who_has_no_certificate_or_no_role_is_told_so(serve: Serve, lab: Path, binary: Path, tmp_path: Path) -> None:
    daemon = serve("--listen", "auto", "--tls", str(lab))
    with pytest.raises(sturz.AccessDenied, match="wants a certificate"):
        daemon.connect(timeout_s=0.1)
    foreign = tmp_path / "foreign"
    certs(binary, foreign, "--client=ada:admin")
    with pytest.raises(sturz.AccessDenied, match="another authority"):
        daemon.connect(foreign / "clients/ada", timeout_s=0.1)
    files = sturz.Tls(lab / "server/ca.pem", foreign / "clients/ada/certificate.pem", foreign / "clients/ada/key.pem")
    with pytest.raises(sturz.AccessDenied, match="another authority"):
        sturz.connect("space", endpoint=daemon.endpoint, tls=files, timeout_s=0.1)
    with pytest.raises(sturz.AccessDenied, match="no role"):
        daemon.connect(lab / "clients/rex", timeout_s=0.5)
    with pytest.raises(FileNotFoundError, match=r"certificate\.pem is missing.*lab/clients/alice"):
        daemon.connect(lab)
    with daemon.connect(lab / "clients/eve") as eve:
        assert eve.info().state is sturz.RunState.PAUSED


def test_a_killed_daemon_has_died_and_the_next_one_is_another_run(serve: Serve) -> None:
    daemon = serve("--listen", "auto")
    with daemon.connect() as simulation, simulation.states() as states:
        first = simulation.info()
        window = Background(lambda: simulation.advance(window_s=1e4))
        wait_for_state(simulation, sturz.RunState.ADVANCING)
        daemon.process.kill()
        daemon.process.wait()
        assert isinstance(window.join(30.0).error, sturz.DaemonDied)
        with pytest.raises(sturz.DaemonDied, match="has ended or was killed"):
            list(states)
        with pytest.raises(sturz.NotConnected):
            simulation.reconnect(timeout_s=0.0)
        with pytest.raises(sturz.DaemonDied):
            simulation.info()
        serve("--listen", daemon.endpoint)
        assert simulation.reconnect(timeout_s=30.0).run_id != first.run_id
        simulation.acquire_lease()
        assert simulation.step().step == 1


def test_a_stopped_daemon_hangs_and_goes_on_where_it_was(serve: Serve, tmp_path: Path) -> None:
    config = tmp_path / "lease.json5"
    config.write_text("{ transport: { link: { tx: { lease: 1000 } } } }")
    daemon = serve("--listen", "auto", "--config", str(config))
    with daemon.connect() as simulation:
        simulation.acquire_lease()
        run_id = simulation.info().run_id
        window = Background(lambda: simulation.advance(window_s=1e4))
        wait_for_state(simulation, sturz.RunState.ADVANCING)
        os.kill(daemon.process.pid, signal.SIGSTOP)
        error = window.join(60.0).error
        assert isinstance(error, sturz.DaemonHung), error
        assert re.search("answers nothing", str(error))
        with pytest.raises(sturz.NotConnected, match="answers nothing"):
            simulation.reconnect(timeout_s=0.0)
        os.kill(daemon.process.pid, signal.SIGCONT)
        assert simulation.reconnect(timeout_s=30.0).run_id == run_id
        # The daemon took the silence for the end of the holder of the lease.
        wait_for_state(simulation, sturz.RunState.PAUSED)
        simulation.acquire_lease()
        simulation.step()
