"""A rotating drum of 3D crosses, steered live over the bus: `python drum_demo.py [--quick] [--out FOLDER]`.

Starts the daemon with the bundled scene, inserts crosses by command, lets them settle, turns the drum once, tilts
gravity, and goes on for a while. State and fields come over the bus meanwhile. Writes pictures and a table.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

import sturz
from sturz.plot import field_plot, picture

FIELD = "drum"
QUANTITIES = ("solid_fraction", "density", "momentum", "velocity", "granular_temperature")


@dataclass(frozen=True)
class Plan:
    """How much to simulate."""

    crosses: int
    settle_s: float
    turn_s: float
    ramp_s: float
    tilted_s: float
    rpm: float = 20.0
    tilt_deg: float = 5.0


FULL = Plan(crosses=260, settle_s=0.3, turn_s=3.0, ramp_s=0.1, tilted_s=0.3)
QUICK = Plan(crosses=20, settle_s=0.02, turn_s=0.05, ramp_s=0.01, tilted_s=0.01)


@dataclass(frozen=True)
class Phase:
    """What one part of the run took."""

    name: str
    simulated_s: float
    steps: int
    wall_s: float
    particles: int

    def row(self) -> str:
        rate = self.steps / self.wall_s
        return (
            f"| {self.name:<14} | {self.simulated_s:9.3f} | {self.steps:8d} | {self.wall_s:7.1f} "
            f"| {rate:8.0f} | {rate * self.particles:16.3g} |"
        )


def drum_of(info: sturz.Info) -> sturz.Boundary:
    """The drum of the scene."""
    return next(boundary for boundary in info.boundaries if boundary.kind == "cylinder_inside")


def insert(simulation: sturz.Simulation, info: sturz.Info, count: int) -> np.ndarray:
    """Inserts crosses at random places inside of the drum; returns their ids."""
    drum = drum_of(info)
    length_m = float(np.dot(info.domain.max_m - info.domain.min_m, np.abs(drum.direction)))
    start = np.where(np.abs(drum.direction) > 0.5, info.domain.min_m, drum.point_m)
    return simulation.insert_random(
        shape=info.shapes[0],
        material=simulation_material(info),
        region=sturz.Cylinder(start, np.abs(drum.direction), radius_m=0.98 * drum.radius_m, length_m=length_m),
        count=count,
    )


def simulation_material(info: sturz.Info) -> str:
    """The material that is not the drum's alone, or the only one."""
    walls = {boundary.material for boundary in info.boundaries}
    return next((name for name in info.materials if name not in walls), info.materials[0])


def tilted(gravity_m_per_s2: np.ndarray, axis: np.ndarray, angle_deg: float) -> np.ndarray:
    """Gravity turned about an axis of unit length that is perpendicular to it."""
    angle = np.deg2rad(angle_deg)
    return np.asarray(np.cos(angle) * gravity_m_per_s2 + np.sin(angle) * np.cross(axis, gravity_m_per_s2))


def energy_table(energy: sturz.EnergyBalance) -> str:
    """The energy balance, a line per term."""
    names = {
        "kinetic_translation_j": "kinetic energy, translation",
        "kinetic_rotation_j": "kinetic energy, rotation",
        "potential_j": "potential energy",
        "elastic_j": "elastic energy",
        "dissipated_normal_j": "dissipated by normal damping",
        "dissipated_friction_j": "dissipated by friction",
        "work_boundaries_j": "work of the drum",
        "work_commands_j": "work of commands (insertion, tilt)",
        "residual_j": "residual of the balance",
    }
    lines = ["| energy | mJ |", "|---|---:|"]
    lines += [f"| {text} | {getattr(energy, name) * 1e3:.6f} |" for name, text in names.items()]
    return "\n".join(lines)


class Demo:
    """The run, its phases and its streams."""

    def __init__(self, simulation: sturz.Simulation, plan: Plan, out: Path) -> None:
        self.simulation = simulation
        self.plan = plan
        self.out = out
        self.phases: list[Phase] = []
        self.started = time.monotonic()
        self.mean = sturz.FieldMean()
        self.mean_from_s = plan.settle_s + plan.turn_s / 2
        self.mean_to_s = plan.settle_s + plan.turn_s

    def collect(self, field: sturz.Field) -> None:
        """Takes a sample of the field from the stream: the mean is over the second half of the turn."""
        if self.mean_from_s <= field.time_s <= self.mean_to_s:
            self.mean.add(field)

    def run_for(self, name: str, duration_s: float) -> None:
        """One phase of the run, with a progress bar."""
        before = self.simulation.info()
        start = time.monotonic()
        window = self.simulation.run_to(before.time_s + duration_s, progress=True, label=f"{name:<7}")
        wall_s = time.monotonic() - start
        self.phases.append(Phase(name, duration_s, window.steps_done, wall_s, before.particles))

    def run(self) -> None:
        """Everything."""
        simulation, plan = self.simulation, self.plan
        info = simulation.info()
        drum = drum_of(info)
        axis = drum.direction / np.linalg.norm(drum.direction)
        print(f"{info.scene}: drum of {2e3 * drum.radius_m:g} mm, time step {info.time_step_s:g} s, ", end="")
        print(f"{info.threads} threads, sturz {info.version}, instance {info.instance}")

        start = time.monotonic()
        ids = insert(simulation, info, plan.crosses)
        print(f"inserted {len(ids)} crosses in {time.monotonic() - start:.1f} s")
        reach = np.where(np.abs(axis) > 0.5, 0.0, drum.radius_m)
        inside = np.abs(axis) > 0.5
        simulation.define_field(
            name=FIELD,
            min_m=np.where(inside, info.domain.min_m, drum.point_m - reach),
            max_m=np.where(inside, info.domain.max_m, drum.point_m + reach),
            cells=np.where(inside, 1, 80),
            quantities=QUANTITIES,
            width_m=2.5e-3,
        )
        with simulation.states(keep=2) as states, simulation.fields(FIELD, keep=8) as fields:
            self.steer(info, axis, drum.name, states, fields)

    def steer(
        self,
        info: sturz.Info,
        axis: np.ndarray,
        drum: str,
        states: sturz.Stream[sturz.State],
        fields: sturz.Stream[sturz.Field],
    ) -> None:
        """Settles, turns, tilts; then writes what was seen."""
        simulation, plan = self.simulation, self.plan
        seen: list[tuple[float, float]] = []
        states.for_each(lambda state: seen.append((state.time_s, float(state.speeds_m_per_s.max(initial=0.0)))))
        fields.for_each(self.collect)
        self.run_for("settle", plan.settle_s)
        rate = plan.rpm * 2 * np.pi / 60
        simulation.set_rotation(boundary=drum, angular_velocity_rad_per_s=rate, ramp_s=plan.ramp_s)
        self.run_for("turn", plan.turn_s)
        simulation.set_gravity(gravity_m_per_s2=tilted(info.gravity_m_per_s2, axis, plan.tilt_deg))
        self.run_for("tilt", plan.tilted_s)
        wall_s = time.monotonic() - self.started
        # What is on its way still counts.
        time.sleep(0.3)
        self.write(info, states, fields, wall_s)

    def write(
        self,
        info: sturz.Info,
        states: sturz.Stream[sturz.State],
        fields: sturz.Stream[sturz.Field],
        wall_s: float,
    ) -> None:
        """Pictures, table, numbers."""
        simulation, out = self.simulation, self.out
        report = simulation.report()
        state = simulation.state()
        picture(
            state,
            simulation.shapes(),
            info.boundaries,
            out / "drum.png",
            domain=info.domain,
            title=f"Rotating drum, {len(state)} 3D crosses",
        )
        fields.close()
        field = self.mean.field() if self.mean.frames else simulation.field(FIELD)
        note = f"mean of {self.mean.frames} frames, t = {self.mean_from_s:.2f} to {self.mean_to_s:.2f} s"
        for quantity, name in (
            ("solid_fraction", "solid_fraction"),
            ("velocity", "velocity"),
            ("granular_temperature", "temperature"),
        ):
            field_plot(
                field,
                quantity,
                out / f"field_{name}.png",
                boundaries=info.boundaries,
                note=note if self.mean.frames else None,
            )
        text = self.table(report, states, fields, wall_s)
        (out / "report.md").write_text(text + "\n")
        (out / "report.json").write_text(json.dumps(self.numbers(report, states, fields, wall_s), indent=2) + "\n")
        print("\n" + text)
        print(f"\nwritten: {', '.join(sorted(path.name for path in out.iterdir()))} in {out}")

    def total(self) -> Phase:
        """All phases together."""
        return Phase(
            "all",
            sum(phase.simulated_s for phase in self.phases),
            sum(phase.steps for phase in self.phases),
            sum(phase.wall_s for phase in self.phases),
            max(phase.particles for phase in self.phases),
        )

    def table(
        self,
        report: sturz.Report,
        states: sturz.Stream[sturz.State],
        fields: sturz.Stream[sturz.Field],
        wall_s: float,
    ) -> str:
        """How wrong, how long, and what came over the bus."""
        lines = [
            "| phase | simulated s | steps | wall s | steps/s | particle-steps/s |",
            "|---|---:|---:|---:|---:|---:|",
        ]
        lines += [phase.row() for phase in [*self.phases, self.total()]]
        lines += ["", energy_table(report.energy), "", "| quality | |", "|---|---:|"]
        lines += [
            f"| residual over largest term of the energy balance | {report.energy.residual_ratio():.2e} |",
            f"| largest overlap now | {report.largest_overlap_m * 1e6:.2f} µm |",
            f"| largest overlap over bounding radius, whole run | {100 * report.largest_overlap_ratio_so_far:.2f} % |",
            f"| time step over critical time step | {report.time_step_s / report.critical_time_step_s:.3f} |",
            f"| touching pairs, with the drum | {report.touching_pairs}, {report.touching_boundary_pairs} |",
            f"| warnings: rotation, overlap, fast | {report.warnings.rotation_not_converged}, "
            f"{report.warnings.large_overlap}, {report.warnings.fast_particle} |",
            f"| wall time from insertion to the end | {wall_s:.1f} s |",
        ]
        lines += ["", "| stream | received | dropped on the way | dropped here |", "|---|---:|---:|---:|"]
        for stream in (states, fields):
            lines.append(f"| {stream.name} | {stream.received} | {stream.dropped_on_the_way} | {stream.dropped_here} |")
        return "\n".join(lines)

    def numbers(
        self,
        report: sturz.Report,
        states: sturz.Stream[sturz.State],
        fields: sturz.Stream[sturz.Field],
        wall_s: float,
    ) -> dict[str, object]:
        """The same for programs."""
        return {
            "phases": [asdict(phase) for phase in self.phases],
            "total": asdict(self.total()),
            "energy": asdict(report.energy),
            "largest_overlap_m": report.largest_overlap_m,
            "largest_overlap_ratio_so_far": report.largest_overlap_ratio_so_far,
            "wall_s": wall_s,
            "state_hash": f"{report.state_hash:016x}",
            "streams": {
                stream.name: {
                    "received": stream.received,
                    "dropped_on_the_way": stream.dropped_on_the_way,
                    "dropped_here": stream.dropped_here,
                }
                for stream in (states, fields)
            },
            "averaged_field_frames": self.mean.frames,
        }


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="a few crosses for a moment: does it work?")
    parser.add_argument("--out", type=Path, default=Path("out/demo"), help="folder for pictures and tables")
    parser.add_argument("--scene", default="drum-crosses", help="bundled scene or path")
    parser.add_argument("--threads", type=int, default=os.cpu_count(), help="of the physics")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    with sturz.launch(options.scene, threads=options.threads) as simulation:
        Demo(simulation, QUICK if options.quick else FULL, options.out).run()


if __name__ == "__main__":
    main()
