"""A journal: what was acknowledged survives the daemon."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

import sturz


def test_a_killed_run_goes_on(tmp_path: Path) -> None:
    journal = tmp_path / "run"
    simulation = sturz.launch("cube-heap", journal=journal)
    simulation.advance(window_s=1e-3)
    simulation.set_gravity(gravity_m_per_s2=[1.0, 0.0, -9.81])
    saved = simulation.checkpoint(token="here")
    reached = simulation.advance(window_s=1e-3)
    expected = simulation.info()
    daemon = simulation._daemon
    assert daemon is not None
    daemon.process.send_signal(signal.SIGKILL)
    daemon.process.wait()
    simulation.close()

    with sturz.launch(resume=journal, threads=2) as simulation:
        info = simulation.info()
        assert (info.step, info.state_hash) == (expected.step, expected.state_hash)
        assert info.time_s == reached.time_reached_s
        restored = simulation.restore(token="here")
        assert restored.state_hash == saved.state_hash


def test_a_run_is_begun_once(tmp_path: Path) -> None:
    with sturz.launch("bouncing-sphere", journal=tmp_path / "run"):
        pass
    with pytest.raises(sturz.LaunchFailed, match="holds a run already"):
        sturz.launch("bouncing-sphere", journal=tmp_path / "run")
    with pytest.raises(ValueError, match="one of scene, scene_text and resume"):
        sturz.launch("bouncing-sphere", resume=tmp_path / "run")
    with pytest.raises(sturz.LaunchFailed, match="holds no run"):
        sturz.launch(resume=tmp_path)
