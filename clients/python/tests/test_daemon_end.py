"""How daemons start, refuse to start, and end."""

import signal
import subprocess
import sysconfig
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import SPACE, Background, drop, fill, kill, wait_for_state, wait_until

import sturz
from sturz.daemon import find_binary


def test_a_killed_daemon_is_told_to_every_blocked_call_and_stream(drum: sturz.Simulation) -> None:
    fill(drum, beads=5, crosses=2)
    with sturz.connect(drum.instance, endpoint=drum.endpoint) as other:
        states, events = other.states(), other.events()
        seen: list[sturz.Report] = []
        each = other.reports().for_each(seen.append)
        window = Background(lambda: drum.advance(window_s=1000.0))
        later = drum.later(500.0, drum.set_gravity, gravity_m_per_s2=(0, 0, 0))
        wait_for_state(other, sturz.RunState.ADVANCING)
        reading = Background(lambda: list(states))
        wait_until(lambda: seen, what="a report")
        kill(drum)
        assert isinstance(window.join(10.0).error, sturz.DaemonGone)
        assert isinstance(later.exception(10.0), sturz.DaemonGone)
        assert isinstance(reading.join(10.0).error, sturz.DaemonGone)
        with pytest.raises(sturz.DaemonGone):
            while events.next_frame(timeout_s=10.0) is not None:
                pass
        each.close()
        for call in (other.info, other.state, other.pause, other.states):
            start = time.monotonic()
            with pytest.raises(sturz.DaemonGone):
                call()
            assert time.monotonic() - start < 5.0
    drum.close()
    assert drum.daemon is not None
    assert drum.daemon.process.returncode == -signal.SIGKILL


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_the_daemon_cleanly(space: sturz.Simulation, how: signal.Signals) -> None:
    drop(space)
    assert space.daemon is not None
    states = space.states(keep=10_000)
    window = Background(lambda: space.advance(window_s=1000.0, columns=["all"]))
    wait_for_state(space, sturz.RunState.ADVANCING)
    kill(space, how)
    # Who waits for steps is told how far it came.
    result = window.join(10.0).result
    assert isinstance(result, sturz.Advanced), window.error
    assert result.stop_reason == "stopped"
    assert 0 < result.steps_done < result.window_steps
    assert result.state is not None
    assert result.state.step == result.step
    assert space.daemon.process.wait(timeout=10.0) == 0
    with pytest.raises(sturz.DaemonGone):
        space.info()
    with pytest.raises(sturz.DaemonGone):
        list(states)


def test_the_command_stop_ends_the_daemon_for_all(space: sturz.Simulation) -> None:
    assert space.daemon is not None
    with sturz.connect(space.instance, endpoint=space.endpoint) as other, other.events() as events:
        first = events.next_frame(timeout_s=10.0)
        assert first is not None
        assert first.kind is sturz.EventKind.STARTED
        space.stop()
        assert space.daemon.process.returncode == 0
        seen: list[sturz.EventKind] = []
        with pytest.raises(sturz.DaemonGone):
            while (event := events.next_frame(timeout_s=10.0)) is not None:
                seen.append(event.kind)
        assert sturz.EventKind.ENDED in seen
        with pytest.raises(sturz.DaemonGone):
            other.info()
    space.close()


def test_closing_ends_a_daemon_of_ones_own_quickly() -> None:
    simulation = sturz.launch(scene_text=SPACE)
    start = time.monotonic()
    simulation.close()
    assert time.monotonic() - start < 3.0
    assert simulation.daemon is not None
    assert simulation.daemon.process.returncode == 0
    simulation.close()


@pytest.mark.parametrize("seconds", [1, 2])
def test_ends_are_clean_with_commands_for_later_and_open_streams(seconds: int) -> None:
    simulation = sturz.launch(scene_text=SPACE)
    states, events = simulation.states(), simulation.events()
    waiting = simulation.later(float(seconds), simulation.set_gravity, gravity_m_per_s2=(0, 0, 0))
    simulation.close()
    assert isinstance(waiting.exception(5.0), sturz.SturzError)
    assert simulation.daemon is not None
    assert simulation.daemon.process.returncode == 0
    assert all(isinstance(state, sturz.State) for state in states)
    assert all(isinstance(event, sturz.Event) for event in events)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda text: text.replace("restitution = 0.8", "restitution = 1.8"), "restitution"),
        (lambda text: text.replace("time_step_s = 1e-5", "time_step_s = 1.0"), "time_step_s"),
        (lambda text: text.replace("seed = 7", "sead = 7"), "sead"),
        (lambda text: text + "\n[[", "TOML"),
    ],
)
def test_a_scene_that_cannot_be_used_is_refused_with_the_reason(change: Callable[[str], str], said: str) -> None:
    with pytest.raises(sturz.LaunchFailed, match=f"(?s)status 3.*{said}"):
        sturz.launch(scene_text=change(SPACE))


def test_launching_what_is_not_there_says_so(tmp_path: Path) -> None:
    with pytest.raises(sturz.LaunchFailed, match="no-such-scene"):
        sturz.launch("no-such-scene")
    with pytest.raises(sturz.LaunchFailed, match="does not exist"):
        sturz.launch("drum-crosses", binary=tmp_path / "sturz")
    with pytest.raises(ValueError, match="one of scene, scene_text and resume"):
        sturz.launch()


def test_the_daemon_beside_the_interpreter_comes_before_the_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for folder in ("scripts", "path"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "sturz").touch(mode=0o755)
    monkeypatch.delenv("STURZ_BINARY", raising=False)
    monkeypatch.setattr(sturz.daemon, "_REPOSITORY", tmp_path)
    monkeypatch.setattr(sysconfig, "get_path", lambda name: str(tmp_path / name))
    monkeypatch.setenv("PATH", str(tmp_path / "path"))
    assert find_binary() == tmp_path / "scripts" / "sturz"
    (tmp_path / "scripts" / "sturz").unlink()
    assert find_binary() == tmp_path / "path" / "sturz"
    (tmp_path / "path" / "sturz").unlink()
    with pytest.raises(sturz.LaunchFailed, match="no daemon found"):
        find_binary()


def serve(binary: Path, tmp_path: Path, *arguments: str) -> "subprocess.CompletedProcess[str]":
    """A daemon that is expected to refuse."""
    scene = tmp_path / "scene.toml"
    scene.write_text(SPACE)
    command = [str(binary), "serve", str(scene), "--paused", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=30, stdin=subprocess.DEVNULL, check=False)


def test_a_second_daemon_of_the_same_name_on_the_same_bus_refuses(
    binary: Path, tmp_path: Path, space: sturz.Simulation
) -> None:
    options = ("--listen", "tcp/127.0.0.1:0", "--connect", space.endpoint)
    refused = serve(binary, tmp_path, "--name", space.instance, *options)
    assert refused.returncode == 5, refused.stderr
    assert space.instance in refused.stderr
    assert "choose another --name" in refused.stderr
    assert space.info().state is sturz.RunState.PAUSED


def test_a_second_daemon_at_the_same_endpoint_refuses(binary: Path, tmp_path: Path, space: sturz.Simulation) -> None:
    refused = serve(binary, tmp_path, "--name", "other", "--listen", space.endpoint)
    assert refused.returncode == 5, refused.stderr
    assert space.endpoint in refused.stderr
    assert space.info().state is sturz.RunState.PAUSED


def test_the_same_name_on_another_bus_is_free(space: sturz.Simulation) -> None:
    with sturz.launch(scene_text=SPACE, name=space.instance) as twin:
        drop(twin)
        assert (twin.info().particles, space.info().particles) == (1, 0)
