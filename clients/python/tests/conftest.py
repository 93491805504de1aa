"""Scenes and daemons for the end-to-end tests: the real binary, the real bus, on a free port each."""

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from hypothesis import settings

import sturz
from sturz.daemon import find_binary

settings.register_profile("suite", max_examples=60, deadline=None)
settings.load_profile("suite")

# A free sphere and a free cube in empty space.
SPACE = """
[scene]
name = "space"
gravity_m_per_s2 = [0.0, 0.0, -9.81]
time_step_s = 1e-5
seed = 7
[[material]]
name = "glass"
density_kg_per_m3 = 2500.0
[[material_pair]]
materials = ["glass", "glass"]
stiffness_n_per_m = 1e3
restitution = 0.8
friction = 0.3
[[shape]]
name = "bead"
geometry = { kind = "sphere", radius_m = 1e-3 }
[[shape]]
name = "cube"
geometry = { kind = "cube", edge_m = 2e-3 }
"""

# A drum of 20 mm with a periodic axis, beads and crosses of some millimetres.
DRUM = (
    SPACE.replace('name = "space"', 'name = "small-drum"')
    + """
[domain]
min_m = [0.0, 0.0, 0.0]
max_m = [0.0, 0.012, 0.0]
periodic = [false, true, false]
[[shape]]
name = "cross"
geometry = { kind = "cross_3d", beam_length_m = 4e-3, beam_width_m = 1e-3 }
[[material]]
name = "steel"
[[material_pair]]
materials = ["glass", "steel"]
stiffness_n_per_m = 1e3
restitution = 0.5
friction = 0.5
[[boundary]]
name = "drum"
material = "steel"
geometry = { kind = "cylinder_inside", point_m = [0.0, 0.0, 0.0], axis = [0.0, 1.0, 0.0], radius_m = 0.02 }
[output]
state_rate_hz = 50.0
field_rate_hz = 50.0
report_rate_hz = 20.0
"""
)

TIME_STEP_S = 1e-5
DRUM_REGION = sturz.Cylinder((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), radius_m=0.019, length_m=0.012)


@pytest.fixture(scope="session", autouse=True)
def binary() -> Path:
    """The daemon; without it nothing here can be tested."""
    return find_binary()


@pytest.fixture
def space() -> Iterator[sturz.Simulation]:
    """Empty space, paused."""
    with sturz.launch(scene_text=SPACE) as simulation:
        yield simulation


@pytest.fixture
def drum() -> Iterator[sturz.Simulation]:
    """An empty drum, paused."""
    with sturz.launch(scene_text=DRUM) as simulation:
        yield simulation


def fill(simulation: sturz.Simulation, beads: int = 30, crosses: int = 10) -> None:
    """Puts particles into the drum."""
    for shape, count in (("cross", crosses), ("bead", beads)):
        simulation.insert_random(shape=shape, material="glass", region=DRUM_REGION, count=count)


def drop(simulation: sturz.Simulation, **arguments: object) -> int:
    """One bead at the origin unless told otherwise; its id."""
    given: dict[str, object] = {"shape": "bead", "material": "glass", "positions_m": [[0, 0, 0]], **arguments}
    return int(simulation.insert_poses(**given)[0])  # type: ignore[arg-type]


def wait_until(condition: Callable[[], object], timeout_s: float = 20.0, what: str = "it") -> None:
    """Waits for another process or thread."""
    end = time.monotonic() + timeout_s
    while not condition():
        assert time.monotonic() < end, f"{what} never came true"
        time.sleep(0.01)


def wait_for_state(simulation: sturz.Simulation, state: sturz.RunState) -> None:
    """Waits until the daemon does that."""
    wait_until(lambda: simulation.info().state is state, what=state.name)


def kill(simulation: sturz.Simulation, how: signal.Signals = signal.SIGKILL) -> None:
    """Sends its daemon a signal."""
    assert simulation.daemon is not None
    os.kill(simulation.daemon.process.pid, how)


class Background:
    """A call in another thread, and what became of it."""

    def __init__(self, function: Callable[[], object]) -> None:
        self.result: object = None
        self.error: BaseException | None = None
        self.wall_s = 0.0
        self._thread = threading.Thread(target=self._work, args=(function,), daemon=True)
        self._thread.start()

    def _work(self, function: Callable[[], object]) -> None:
        start = time.monotonic()
        try:
            self.result = function()
        except BaseException as error:
            self.error = error
        self.wall_s = time.monotonic() - start

    @property
    def running(self) -> bool:
        """Whether it goes on."""
        return self._thread.is_alive()

    def join(self, timeout_s: float = 20.0) -> "Background":
        """Waits for its end."""
        self._thread.join(timeout_s)
        assert not self._thread.is_alive(), "the call does not return"
        return self
