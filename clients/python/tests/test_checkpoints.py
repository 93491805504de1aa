"""Saving a run and going back to it: bit for bit, in memory and on disk."""

from pathlib import Path

import numpy as np
import pytest
from conftest import DRUM, fill, kill

import sturz


def hashes(simulation: sturz.Simulation, windows: int = 3) -> list[int]:
    """Of the state after each of some windows."""
    found = []
    for _ in range(windows):
        simulation.advance(window_s=1.2345e-3)
        found.append(simulation.info().state_hash)
    return found


def test_windows_are_repeated_bit_for_bit(drum: sturz.Simulation) -> None:
    fill(drum)
    drum.set_rotation(boundary="drum", angular_velocity_rad_per_s=4.0)
    drum.advance(window_s=0.15)
    report = drum.report()
    assert report.touching_pairs + report.touching_boundary_pairs > 5, "there must be springs to save"
    before = drum.state()
    saved = drum.checkpoint(token="here")
    assert (saved.token, saved.step, saved.time_s, saved.on_disk) == ("here", before.step, before.time_s, False)
    first = hashes(drum)
    for _ in range(2):
        assert drum.restore(token="here") == saved
        # the client knows that time went back: the next window starts there, checked to the bit
        assert hashes(drum) == first
    drum.restore(token="here")
    after = drum.state()
    assert np.array_equal(after.positions_m, before.positions_m)
    assert np.array_equal(after.orientations_wxyz, before.orientations_wxyz)
    assert drum.checkpoints() == (saved,)
    drum.drop_checkpoint(token="here")
    assert drum.checkpoints() == ()


def test_a_killed_daemon_goes_on_from_its_file(tmp_path: Path) -> None:
    with sturz.launch(scene_text=DRUM, checkpoints=tmp_path / "deep" / "folder") as simulation:
        fill(simulation)
        simulation.advance(window_s=0.12)
        saved = simulation.checkpoint(token="safe", on_disk=True)
        expected = hashes(simulation)
        kill(simulation)
    with sturz.launch(scene_text=DRUM, checkpoints=tmp_path / "deep" / "folder", threads=2) as simulation:
        assert simulation.checkpoints() == (saved,)
        assert simulation.restore(token="safe") == saved
        assert simulation.info().particles == 40
        assert hashes(simulation) == expected


def test_what_cannot_be_restored_is_refused_with_the_reason(tmp_path: Path, drum: sturz.Simulation) -> None:
    with pytest.raises(sturz.CommandError) as refused:
        drum.restore(token="nothing")
    assert (refused.value.code, refused.value.path) == (sturz.ErrorCode.NOT_FOUND, "token")
    with pytest.raises(sturz.CommandError, match="--checkpoints DIR"):
        drum.checkpoint(token="a", on_disk=True)
    with pytest.raises(sturz.CommandError, match="no usable name"):
        drum.checkpoint(token="a/b")
    with sturz.launch(scene_text=DRUM, checkpoints=tmp_path) as simulation:
        simulation.checkpoint(token="a", on_disk=True)
        file = tmp_path / "a.checkpoint"
        file.write_bytes(file.read_bytes()[:-1])
        before = simulation.info().state_hash
        with pytest.raises(sturz.CommandError, match="cut short") as refused:
            simulation.restore(token="a")
        assert refused.value.code == sturz.ErrorCode.UNUSABLE_CHECKPOINT
        assert simulation.info().state_hash == before


def test_listeners_hear_of_it(drum: sturz.Simulation) -> None:
    drum.checkpoint(token="a")
    drum.restore(token="a")
    kinds = []
    for event in drum.events():
        if event.kind in (sturz.EventKind.CHECKPOINT, sturz.EventKind.RESTORED):
            assert event.name == "a"
            kinds.append(event.kind)
        if event.kind == sturz.EventKind.RESTORED:
            break
    assert kinds == [sturz.EventKind.CHECKPOINT, sturz.EventKind.RESTORED]
