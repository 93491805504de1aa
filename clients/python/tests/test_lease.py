"""One client lets time go on, others observe; its loss pauses the run."""

import pytest
from conftest import Background, wait_for_state

import sturz


def test_others_observe_while_one_holds_the_lease(space: sturz.Simulation) -> None:
    with sturz.connect(space.instance, endpoint=space.endpoint) as other:
        space.acquire_lease()
        space.acquire_lease()
        assert other.info().lease_holder == space.client_id
        for refused in (other.step, other.resume, other.acquire_lease, other.release_lease):
            with pytest.raises(sturz.CommandError, match=space.client_id) as error:
                refused()
            assert error.value.code is sturz.ErrorCode.LEASE
        other.set_gravity(gravity_m_per_s2=(0, 0, -1))
        assert space.step(steps=2).step == 2
        space.release_lease()
        assert other.info().lease_holder == ""
        assert other.step().step == 3


def test_the_loss_of_the_holder_pauses_the_run_and_ends_its_window(space: sturz.Simulation) -> None:
    holder = sturz.connect(space.instance, endpoint=space.endpoint)
    holder.acquire_lease()
    window = Background(lambda: holder.advance(window_s=1e4))
    wait_for_state(space, sturz.RunState.ADVANCING)
    holder.close()
    window.join()
    wait_for_state(space, sturz.RunState.PAUSED)
    lost = next(event for event in space.events() if event.severity is sturz.Severity.WARNING)
    assert (lost.kind, lost.name) == (sturz.EventKind.LEASE, holder.client_id)
    assert "was lost" in lost.message
    space.step()
