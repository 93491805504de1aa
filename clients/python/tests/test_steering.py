"""Inserting, rotating, tilting and advancing by command does what mechanics says."""

import math

import numpy as np
import pytest
from conftest import DRUM_REGION, SPACE, TIME_STEP_S, drop, fill, wait_for_state

import sturz

G = np.array([0.0, 0.0, -9.81])


def test_a_sphere_flies_on_a_parabola(space: sturz.Simulation) -> None:
    start, velocity, spin = np.array([0.1, -0.2, 0.3]), np.array([1.0, 2.0, 3.0]), np.array([5.0, 0.0, -7.0])
    number = drop(space, positions_m=[start], velocity_m_per_s=velocity, angular_velocity_rad_per_s=spin)
    window = space.advance(window_s=0.05, columns=["all"])
    state = window.state
    assert state is not None
    assert (window.steps_done, window.window_steps, window.step, window.stop_reason) == (5000, 5000, 5000, "complete")
    assert window.time_reached_s == 0.05
    assert state.ids.tolist() == [number]
    t = 0.05
    # The scheme is exact for constant forces; 5000 roundings of numbers below 4 leave 1e-12.
    np.testing.assert_allclose(state.positions_m[0], start + velocity * t + G * t**2 / 2, atol=1e-12)
    np.testing.assert_allclose(state.velocities_m_per_s[0], velocity + G * t, atol=1e-12)
    np.testing.assert_allclose(state.angular_velocities_rad_per_s[0], spin, atol=1e-12)


def test_a_cube_turns_at_constant_rate(space: sturz.Simulation) -> None:
    rate = np.array([30.0, -40.0, 0.0])
    drop(space, shape="cube", angular_velocity_rad_per_s=rate)
    state = space.advance(window_s=0.02, columns=["orientations"]).state
    assert state is not None
    half = np.linalg.norm(rate) * 0.02 / 2
    expected = np.array([math.cos(half), *(math.sin(half) * rate / np.linalg.norm(rate))])
    got = state.orientations_wxyz[0] * np.sign(state.orientations_wxyz[0, 0] * expected[0])
    # Second order: an angle of 5e-4 a step is off by its cube over twelve, 1e-11, 2000 times.
    np.testing.assert_allclose(got, expected, atol=1e-7)


def test_tilted_gravity_acts_from_the_next_step_on(space: sturz.Simulation) -> None:
    drop(space)
    space.advance(window_s=0.01)
    angle = math.radians(5.0)
    tilted = np.array([9.81 * math.sin(angle), 0.0, -9.81 * math.cos(angle)])
    space.set_gravity(gravity_m_per_s2=tilted)
    np.testing.assert_array_equal(space.info().gravity_m_per_s2, tilted)
    state = space.advance(window_s=0.02, columns=["velocities"]).state
    assert state is not None
    np.testing.assert_allclose(state.velocities_m_per_s[0], 0.01 * G + 0.02 * tilted, atol=1e-13)
    np.testing.assert_array_equal(state.gravity_m_per_s2, tilted)


def test_the_drum_turns_by_a_ramp_and_drags_its_particles_along(drum: sturz.Simulation) -> None:
    fill(drum)
    drum.advance(window_s=0.03)
    before = drum.report().energy
    # A step of a 23rd of a collision: second order, 2e-4 when this was written.
    assert before.residual_ratio() < 1e-3
    drum.set_rotation(boundary="drum", angular_velocity_rad_per_s=10.0, ramp_s=0.02)
    drum.advance(window_s=0.05)
    wall = drum.state().boundaries[0]
    # The ramp covers half its length, then 0.03 s at full speed.
    assert wall.angle_rad == pytest.approx(10.0 * (0.02 / 2 + 0.03), abs=1e-9)
    assert wall.angular_velocity_rad_per_s == pytest.approx(10.0, abs=1e-12)
    energy = drum.report().energy
    assert energy.work_boundaries_j > before.work_boundaries_j
    # Sliding costs an order: 5e-3, and 1.4e-3 at half the step.
    assert energy.residual_ratio() < 2e-2
    drum.set_fixed(boundary="drum")
    drum.advance(window_s=0.001)
    assert drum.state().boundaries[0].angular_velocity_rad_per_s == 0.0


def test_insertion_and_removal_keep_ids(drum: sturz.Simulation) -> None:
    lattice = drum.insert_lattice(
        shape="bead",
        material="glass",
        origin_m=(-0.006, 0.002, 0.0),
        spacing_m=(0.003, 0.003, 0.003),
        counts=(5, 3, 2),
        scale=(0.5, 0.9),
    )
    assert lattice.tolist() == list(range(int(lattice[0]), int(lattice[0]) + 30))
    region = sturz.Box((-0.01, 0.0, -0.012), (0.01, 0.012, -0.002))
    crosses = drum.insert_random(shape="cross", material="glass", region=region, count=5)
    state = drum.state()
    assert len(state) == 35
    assert state.positions_m.shape == (35, 3)
    of_lattice = np.isin(state.ids, lattice)
    assert ((state.scales[of_lattice] >= 0.5) & (state.scales[of_lattice] <= 0.9)).all()
    assert np.ptp(state.scales[of_lattice]) > 0.1
    shapes = drum.info().shapes
    assert {shapes[index] for index in state.shapes[np.isin(state.ids, crosses)]} == {"cross"}
    np.testing.assert_allclose(np.linalg.norm(state.orientations_wxyz, axis=1), 1.0, atol=1e-12)
    assert drum.remove(ids=lattice[:10]) == 10
    left = drum.state()
    assert left.header.topology_epoch > state.header.topology_epoch
    assert left.ids.tolist() == [*lattice[10:].tolist(), *crosses.tolist()]
    new = drum.insert_random(shape="bead", material="glass", region=region, count=1)
    assert new[0] > crosses[-1], "ids are never used again"


def test_random_insertion_until_a_solid_fraction(drum: sturz.Simulation) -> None:
    ids = drum.insert_random(shape="bead", material="glass", region=DRUM_REGION, solid_fraction=0.05)
    region_m3 = math.pi * 0.019**2 * 0.012
    bead_m3 = 4 / 3 * math.pi * 1e-9
    assert len(ids) * bead_m3 == pytest.approx(0.05 * region_m3, abs=bead_m3)
    positions = drum.state().positions_m
    # Wholly inside: not nearer to the wall than by a radius.
    assert np.hypot(positions[:, 0], positions[:, 2]).max() <= 0.018 + 1e-12
    gaps = np.linalg.norm(positions[:, None] - positions[None], axis=2)[np.triu_indices(len(ids), 1)]
    assert gaps.min() >= 2e-3


def test_fields_conserve_mass_and_momentum(space: sturz.Simulation) -> None:
    # Within 0.9 mm of the nodes of a lattice of 4 mm: beads of 2 mm do not meet.
    nodes = 4e-3 * np.stack(np.meshgrid(*[[-2, -1, 0, 1, 2]] * 3), axis=-1).reshape(-1, 3)[::6]
    positions = nodes + np.random.default_rng(3).uniform(-0.9e-3, 0.9e-3, nodes.shape)
    velocity = (0.3, -0.2, 0.1)
    space.insert_poses(shape="bead", material="glass", positions_m=positions, velocity_m_per_s=velocity)
    quantities = ("solid_fraction", "density", "momentum", "velocity", "granular_temperature")
    definition = space.define_field(
        name="all", min_m=[-0.03] * 3, max_m=[0.03] * 3, cells=[30] * 3, quantities=quantities, width_m=4e-3
    )
    assert space.info().fields[0].grid == definition.grid
    field = space.field("all")
    mass = len(positions) * 2500 * 4 / 3 * math.pi * 1e-9
    assert field.total_mass_kg == pytest.approx(mass, rel=1e-12)
    # Cells of half a width: the sum over cells is the integral to the jump at the cut-off, exp(-8) = 3e-4.
    assert field.integral("density") == pytest.approx(mass, rel=1e-3)
    assert field.integral("solid_fraction") == pytest.approx(mass / 2500, rel=1e-3)
    np.testing.assert_allclose(field.integral("momentum"), mass * np.array(velocity), rtol=1e-3)
    filled = field.density_kg_per_m3 > 0
    np.testing.assert_allclose(field.velocity_m_per_s[filled], np.broadcast_to(velocity, (filled.sum(), 3)), rtol=1e-9)
    assert np.abs(field.granular_temperature_m2_per_s2).max() < 1e-9, "all fly alike"
    in_window = space.advance(window_s=1e-4, fields=["all"]).fields["all"]
    assert (in_window.step, in_window.grid.cells) == (10, (30, 30, 30))
    space.drop_field(name="all")
    with pytest.raises(sturz.CommandError, match='no field "all" is defined') as caught:
        space.field("all")
    assert caught.value.code is sturz.ErrorCode.NOT_FOUND


def test_windows_are_cut_into_equal_steps_and_reach_their_end_exactly(space: sturz.Simulation) -> None:
    drop(space)
    first = space.advance(window_s=1.05e-4)
    assert (first.window_steps, first.steps_done, first.time_reached_s) == (11, 11, 1.05e-4)
    stepped = space.step(steps=3)
    assert (stepped.steps_done, stepped.step, stepped.stop_reason) == (3, 14, "complete")
    assert stepped.time_reached_s == pytest.approx(1.05e-4 + 3 * TIME_STEP_S, rel=1e-12)
    assert space.run_to(1e-3).time_reached_s == 1e-3


def test_a_window_that_starts_elsewhere_is_refused_and_both_times_are_named(space: sturz.Simulation) -> None:
    space.advance(window_s=1e-3)
    with pytest.raises(sturz.CommandError, match=r"0\.0 s.*0\.001 s") as caught:
        space.advance(window_s=1e-3, from_time_s=0.0)
    assert (caught.value.code, caught.value.path) == (sturz.ErrorCode.WRONG_TIME, "from_time_s")
    space.advance(window_s=1e-3)


def test_single_precision_and_chosen_columns(space: sturz.Simulation) -> None:
    drop(space, positions_m=[[1 / 3, 0, 0]])
    state = space.state(columns=["positions"], float_type="f32")
    assert set(state.columns) == {"ids", "positions"}
    assert state.positions_m.dtype == np.dtype("<f4")
    assert state.positions_m[0, 0] == np.float32(1 / 3)
    assert set(space.state(columns=[]).columns) == {"ids"}
    assert set(space.state(columns=["all"]).columns) == set(space.features().columns)
    assert set(space.state().columns) == set(space.features().columns) - {"forces", "torques", "frozen"}
    with pytest.raises(sturz.CommandError, match="colour") as caught:
        space.state(columns=["positions", "colour"])
    assert (caught.value.code, caught.value.path) == (sturz.ErrorCode.NOT_FOUND, "columns")


def test_it_runs_freely_until_paused(space: sturz.Simulation) -> None:
    drop(space)
    space.resume()
    with pytest.raises(sturz.CommandError) as caught:
        space.step()
    assert caught.value.code is sturz.ErrorCode.NOT_PAUSED
    time_s = space.pause()
    assert time_s > 0
    assert space.info().time_s == time_s
    # No time passes while it is paused.
    assert space.info().time_s == time_s
    space.advance(window_s=1e-4)


def test_later_takes_effect_at_its_simulated_time(space: sturz.Simulation) -> None:
    drop(space)
    down = space.later(0.01, space.set_gravity, gravity_m_per_s2=(0.0, 0.0, -1.0))
    up = space.later(0.02, space.set_gravity, gravity_m_per_s2=(0.0, 0.0, 2.0))
    more = space.later(0.02, space.insert_poses, shape="bead", material="glass", positions_m=[[0.5, 0, 0]])
    assert not down.done()
    state = space.advance(window_s=0.03, columns=["velocities"]).state
    assert state is not None
    assert down.result(5.0) is None and up.result(5.0) is None
    assert len(more.result(5.0)) == 1
    # Before the first step that starts at or after the time: at most a step late.
    slack = TIME_STEP_S * (9.81 + 2 + 3)
    assert state.velocities_m_per_s[0, 2] == pytest.approx(0.01 * (-9.81 - 1.0 + 2.0), abs=slack)
    assert state.velocities_m_per_s[1, 2] == pytest.approx(0.01 * 2.0, abs=slack)
    # What came late from another thread must not set the clock back.
    space.advance(window_s=1e-4)


def test_later_raises_what_the_daemon_refuses(space: sturz.Simulation) -> None:
    space.advance(window_s=1e-3)
    past = space.later(5e-4, space.set_gravity, gravity_m_per_s2=(0, 0, 0))
    with pytest.raises(sturz.CommandError, match=r"is at 0\.001 s already") as caught:
        past.result(5.0)
    assert (caught.value.code, caught.value.path) == (sturz.ErrorCode.WRONG_TIME, "header.at_time_s")
    unknown = space.later(2e-3, space.set_rotation, boundary="drum", angular_velocity_rad_per_s=1.0)
    space.advance(window_s=2e-3)
    with pytest.raises(sturz.CommandError, match="drum"):
        unknown.result(5.0)
    never = space.later(2e-3, space.pause)
    with pytest.raises(sturz.CommandError) as caught:
        never.result(5.0)
    assert caught.value.path == "header.at_time_s"


def test_what_the_daemon_says_of_itself(drum: sturz.Simulation) -> None:
    fill(drum, beads=3, crosses=2)
    info = drum.info()
    assert (info.scene, info.state, info.particles, info.threads) == ("small-drum", sturz.RunState.PAUSED, 5, 1)
    assert info.boundary("drum").radius_m == 0.02
    assert info.domain.periodic == (False, True, False)
    assert info.time_step_s == TIME_STEP_S
    assert drum.daemon is not None
    assert info.pid == drum.daemon.process.pid
    features = drum.features()
    assert {"insert", "set_motion", "advance", "stop"} <= set(features.commands)
    assert "cross_3d" in features.scene_schema_json
    assert features.limits.message_bytes > 1_000_000
    assert drum.plan()
    by_name = {shape.name: shape for shape in drum.shapes()}
    assert tuple(by_name) == info.shapes
    # Three beams of 4 x 1 x 1 mm that share a cube of 1 mm.
    assert by_name["cross"].volume_m3 == pytest.approx((3 * 4 - 2) * 1e-9, rel=1e-12)
    assert by_name["cross"].triangles.max() < len(by_name["cross"].vertices_m)
    report = drum.report()
    assert (report.particles, report.state) == (5, sturz.RunState.PAUSED)
    assert report.state_hash == info.state_hash
    assert set(report.streams) >= {"state", "report"}
    with pytest.raises(KeyError, match="no boundary 'lid'"):
        info.boundary("lid")


def test_a_failed_run_can_be_read_but_not_advanced(space: sturz.Simulation) -> None:
    # Two beads nearly in one place: more overlap than the scene allows.
    space.insert_poses(shape="bead", material="glass", positions_m=[(0.0, 0.0, 0.0), (1e-4, 0.0, 0.0)])
    with pytest.raises(sturz.CommandError, match="overlap") as caught:
        space.advance(window_s=0.01)
    assert caught.value.code is sturz.ErrorCode.RUN_FAILED
    info = space.info()
    assert info.state is sturz.RunState.FAILED
    assert "overlap" in info.failure
    assert len(space.state()) == 2
    for again in (space.step, space.resume, lambda: space.run_to(0.02)):
        with pytest.raises(sturz.CommandError) as caught:
            again()
        assert caught.value.code is sturz.ErrorCode.RUN_FAILED


def test_a_long_window_shows_its_progress(space: sturz.Simulation, capfd: pytest.CaptureFixture[str]) -> None:
    drop(space)
    space.advance(window_s=0.05, progress=True, label="flight")
    shown = capfd.readouterr().err
    assert "flight 100%" in shown
    assert "t = 0.0500 s" in shown
    space.advance(window_s=0.001, progress=None)
    assert "advance" not in capfd.readouterr().err, "no bar where there is no terminal"


def test_a_scene_from_the_bundle_and_one_from_a_file(tmp_path: object) -> None:
    from pathlib import Path

    path = Path(str(tmp_path)) / "my scene.toml"
    path.write_text(SPACE)
    with sturz.launch(path, paused=False) as simulation:
        assert simulation.instance.startswith("my-scene-")
        wait_for_state(simulation, sturz.RunState.RUNNING)
    with sturz.launch("drum-crosses", threads=2) as simulation:
        assert simulation.info().threads == 2
        assert any(shape.kind == "cross_3d" for shape in simulation.shapes())


FLOOR = """
[[material]]
name = "steel"
[[material_pair]]
materials = ["glass", "steel"]
stiffness_n_per_m = 1e3
restitution = 0.5
friction = 0.5
[[boundary]]
name = "floor"
material = "steel"
geometry = { kind = "plane", point_m = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0] }
"""


def test_a_floor_oscillates_swings_and_follows_a_table() -> None:
    with sturz.launch(scene_text=SPACE + FLOOR) as simulation:

        def floor() -> sturz.BoundaryState:
            return simulation.state(["positions"]).boundaries[0]

        simulation.set_oscillation(boundary="floor", amplitude_m=(0, 1e-3, 2e-3), frequency_hz=50.0, phase_rad=0.3)
        time_s = simulation.advance(window_s=7e-3).time_reached_s
        wave = np.sin(2 * np.pi * 50.0 * time_s + 0.3) - np.sin(0.3)
        np.testing.assert_allclose(floor().point_m, [0, 1e-3 * wave, 2e-3 * wave], rtol=1e-12)

        before = floor().point_m
        simulation.set_table(
            boundary="floor", times_s=[0, 0.01, 0.02], displacements_m=[[0, 0, 0], [1, 0, 0], [1, 2, 0]]
        )
        simulation.advance(window_s=0.015)
        np.testing.assert_allclose(floor().point_m - before, [1, 1, 0], rtol=1e-9)
        simulation.advance(window_s=0.05)
        np.testing.assert_allclose(floor().point_m - before, [1, 2, 0], rtol=1e-12)

        simulation.set_rotation_oscillation(
            boundary="floor", point_m=(0, 0, 0), axis=(0, 1, 0), amplitude_rad_per_s=3.0, frequency_hz=20.0
        )
        simulation.advance(window_s=0.0125)
        angle = 3.0 / (2 * np.pi * 20.0) * (1 - np.cos(2 * np.pi * 20.0 * 0.0125))
        np.testing.assert_allclose(floor().direction, [np.sin(angle), 0, np.cos(angle)], atol=1e-9)


def test_motions_that_cannot_be_are_refused_with_their_path() -> None:
    with sturz.launch(scene_text=SPACE + FLOOR) as simulation:
        before = simulation.info().state_hash
        bad = [
            (
                "motion.oscillation.frequency_hz",
                simulation.set_oscillation,
                {"amplitude_m": (0, 0, 1), "frequency_hz": 0},
            ),
            ("motion.table.times_s[1]", simulation.set_table, {"times_s": [0, 0], "displacements_m": np.zeros((2, 3))}),
            (
                "motion.table.displacements_m",
                simulation.set_table,
                {"times_s": [0], "displacements_m": np.zeros((1, 3))},
            ),
        ]
        for path, function, arguments in bad:
            with pytest.raises(sturz.CommandError) as refused:
                function(boundary="floor", **arguments)  # type: ignore[operator]
            assert refused.value.path == path
        assert simulation.info().state_hash == before
