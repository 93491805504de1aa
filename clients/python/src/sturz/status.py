"""What a simulation is, and how well it does."""

from __future__ import annotations

import enum
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import columns
from ._proto.sturz.v1 import command_pb2
from ._proto.sturz.v1 import status_pb2 as pb
from .field import FieldDefinition
from .output import Output
from .state import Header


class RunState(enum.IntEnum):
    """What the daemon does."""

    UNSPECIFIED = 0
    RUNNING = 1
    PAUSED = 2
    ADVANCING = 3
    FAILED = 4
    ENDED = 5

    @classmethod
    def _missing_(cls, value: object) -> RunState:
        return cls.UNSPECIFIED


class EventKind(enum.IntEnum):
    """What happened."""

    UNSPECIFIED = 0
    COMMAND = 1
    STARTED = 2
    PAUSED = 3
    RESUMED = 4
    FAILED = 5
    ENDED = 6
    PARTICLES = 7
    FIELD = 8
    CHECKPOINT = 9
    RESTORED = 10
    LEASE = 11
    WARNING = 12
    OUTPUT = 13
    JOURNAL = 20
    STAGE = 30
    INFLOW = 31

    @classmethod
    def _missing_(cls, value: object) -> EventKind:
        return cls.UNSPECIFIED


class Severity(enum.IntEnum):
    """Of an event."""

    UNSPECIFIED = 0
    INFO = 1
    WARNING = 2
    ERROR = 3

    @classmethod
    def _missing_(cls, value: object) -> Severity:
        return cls.UNSPECIFIED


class LeaseChange(enum.IntEnum):
    """What became of the lease."""

    UNSPECIFIED = 0
    ACQUIRED = 1
    RELEASED = 2
    LOST = 3

    @classmethod
    def _missing_(cls, value: object) -> LeaseChange:
        return cls.UNSPECIFIED


class WarningKind(enum.IntEnum):
    """What a guard warns of."""

    UNSPECIFIED = 0
    LARGE_OVERLAP = 1
    FAST_PARTICLE = 2
    DEEP_ROUNDING = 3
    ROTATION_NOT_CONVERGED = 4
    TIME_STEP = 5

    @classmethod
    def _missing_(cls, value: object) -> WarningKind:
        return cls.UNSPECIFIED


def _plain(cls: type[Any], message: Any) -> Any:
    """Dataclass from the fields of the same names of a message."""
    return cls(**{field.name: getattr(message, field.name) for field in fields(cls)})


@dataclass(frozen=True, eq=False)
class Boundary:
    """A boundary as the scene has it.

    Attributes:
        name: what `set_rotation` and its like ask for.
        material: of its surface.
        kind: ``plane``, ``cylinder_inside``, ``cylinder_outside``, ``mesh``, or empty when this client is too old to
            know it.
        point_m: a point of the plane or of the axis at the start, (3,), m.
        direction: normal of the plane, or direction of the axis, (3,).
        radius_m: of a cylinder; NaN for others.
        vertices_m: of a mesh at the start, (k, 3), m; None for others.
        triangles: of a mesh, (m, 3), indices of vertices; None for others.
    """

    name: str
    material: str
    kind: str
    point_m: NDArray[np.float64]
    direction: NDArray[np.float64]
    radius_m: float
    vertices_m: NDArray[np.float64] | None = None
    triangles: NDArray[np.uint32] | None = None

    @classmethod
    def from_message(cls, message: pb.BoundaryInfo) -> Boundary:
        kind = message.WhichOneof("geometry") or ""
        point, direction, radius = np.zeros(3), np.zeros(3), float("nan")
        if kind == "plane":
            point, direction = columns.from_vec3(message.plane.point_m), columns.from_vec3(message.plane.normal)
        elif kind in ("cylinder_inside", "cylinder_outside"):
            geometry = getattr(message, kind)
            point, direction = columns.from_vec3(geometry.point_m), columns.from_vec3(geometry.axis)
            radius = geometry.radius_m
        elif kind == "mesh":
            mesh = columns.decode(message.mesh.vertices), columns.decode(message.mesh.triangles)
            return cls(message.name, message.material, kind, point, np.array((0.0, 0.0, 1.0)), radius, *mesh)
        return cls(message.name, message.material, kind, point, direction, radius)


@dataclass(frozen=True, eq=False)
class Domain:
    """Extent, meaningful along periodic axes.

    Attributes:
        min_m: lower corner, (3,), m.
        max_m: upper corner, (3,), m.
        periodic: along x, y, z.
    """

    min_m: NDArray[np.float64]
    max_m: NDArray[np.float64]
    periodic: tuple[bool, bool, bool]

    @classmethod
    def from_message(cls, message: pb.Domain) -> Domain:
        return cls(
            columns.from_vec3(message.min_m),
            columns.from_vec3(message.max_m),
            (message.periodic_x, message.periodic_y, message.periodic_z),
        )


@dataclass(frozen=True, eq=False)
class Info:
    """What a simulation is.

    Attributes:
        version: of the daemon.
        schema_version: of the protocol.
        instance: name on the bus.
        run_id: another one for every start of a daemon.
        scene: name in the scene.
        pid: process of the daemon.
        state: what it does.
        failure: why the run failed; empty otherwise.
        time_s: simulated time, s.
        step: steps done.
        time_step_s: nominal time step, s.
        particles: present.
        topology_epoch: counts insertions and removals.
        state_hash: of the whole state; independent of row order and thread count.
        gravity_m_per_s2: (3,).
        domain: extent and periodic axes.
        fields: defined ones.
        boundaries: in the order of the scene.
        materials: names that `State.materials` indexes.
        shapes: names that `State.shapes` indexes.
        scene_toml: the whole scene as it was started.
        threads: of the physics.
        lease_holder: id of the client that holds the lease; empty when none does.
        outputs: what each stream holds now, and when.
    """

    version: str
    schema_version: int
    instance: str
    run_id: str
    scene: str
    pid: int
    state: RunState
    failure: str
    time_s: float
    step: int
    time_step_s: float
    particles: int
    topology_epoch: int
    state_hash: int
    gravity_m_per_s2: NDArray[np.float64]
    domain: Domain
    fields: tuple[FieldDefinition, ...]
    boundaries: tuple[Boundary, ...]
    materials: tuple[str, ...]
    shapes: tuple[str, ...]
    scene_toml: str
    threads: int
    lease_holder: str
    outputs: tuple[Output, ...]

    @classmethod
    def from_message(cls, message: pb.Info) -> Info:
        return cls(
            version=message.version,
            schema_version=message.schema_version,
            instance=message.instance,
            run_id=message.run_id,
            scene=message.scene,
            pid=message.pid,
            state=RunState(message.state),
            failure=message.failure,
            time_s=message.sim_time_s,
            step=message.step,
            time_step_s=message.time_step_s,
            particles=message.particles,
            topology_epoch=message.topology_epoch,
            state_hash=message.state_hash,
            gravity_m_per_s2=columns.from_vec3(message.gravity_m_per_s2),
            domain=Domain.from_message(message.domain),
            fields=tuple(FieldDefinition.from_message(field) for field in message.fields),
            boundaries=tuple(Boundary.from_message(boundary) for boundary in message.boundaries),
            materials=tuple(message.materials),
            shapes=tuple(message.shapes),
            scene_toml=message.scene_toml,
            threads=message.threads,
            lease_holder=message.lease_holder,
            outputs=tuple(Output.from_message(output) for output in message.outputs),
        )

    def boundary(self, name: str) -> Boundary:
        """The boundary of that name.

        Raises:
            KeyError: there is none.
        """
        for boundary in self.boundaries:
            if boundary.name == name:
                return boundary
        raise KeyError(f"no boundary {name!r}; there are {[boundary.name for boundary in self.boundaries]}")


@dataclass(frozen=True)
class Limits:
    """What the daemon refuses to exceed: bytes of a request, particles, requests waiting and remembered, fields,
    checkpoints in memory (and their bytes together) and on disk, sessions of clients, candidate pairs, requests not yet
    answered."""

    message_bytes: int
    insertion_particles: int
    particles: int
    queue_length: int
    remembered_requests: int
    fields: int
    field_cells: int
    checkpoints: int
    checkpoint_bytes: int
    checkpoint_files: int
    clients: int
    pairs: int
    open_requests: int


@dataclass(frozen=True)
class Checkpoint:
    """A saved state.

    Attributes:
        token: what `Simulation.restore` takes.
        step: steps done by it.
        time_s: its simulated time, s.
        particles: in it.
        topology_epoch: counts insertions and removals.
        state_hash: of the whole state.
        bytes: that it takes.
        on_disk: as a file that outlives the daemon, else in its memory.
    """

    token: str
    step: int
    time_s: float
    particles: int
    topology_epoch: int
    state_hash: int
    bytes: int
    on_disk: bool

    @classmethod
    def from_message(cls, message: command_pb2.Checkpoint) -> Checkpoint:
        return cls(
            token=message.token,
            step=message.step,
            time_s=message.sim_time_s,
            particles=message.particles,
            topology_epoch=message.topology_epoch,
            state_hash=message.state_hash,
            bytes=message.bytes,
            on_disk=message.on_disk,
        )


@dataclass(frozen=True)
class Features:
    """What the daemon can do.

    Attributes:
        commands: such as ``set_gravity``.
        columns: names for `state(columns=...)`.
        contact_columns: names for `contacts(columns=...)`.
        field_quantities: names for `define_field(quantities=...)`.
        capabilities: kinds of shapes and boundaries of scene files, and other things by name.
        limits: what it refuses to exceed.
        scene_schema_json: JSON schema of scene files.
    """

    commands: tuple[str, ...]
    columns: tuple[str, ...]
    contact_columns: tuple[str, ...]
    field_quantities: tuple[str, ...]
    capabilities: tuple[str, ...]
    limits: Limits
    scene_schema_json: str

    @classmethod
    def from_message(cls, message: pb.Features) -> Features:
        return cls(
            commands=tuple(message.commands),
            columns=tuple(message.columns),
            contact_columns=tuple(message.contact_columns),
            field_quantities=tuple(message.field_quantities),
            capabilities=tuple(message.capabilities),
            limits=_plain(Limits, message.limits),
            scene_schema_json=message.scene_schema_json,
        )


@dataclass(frozen=True)
class EnergyBalance:
    """Energies and works since the start of the run, J.

    `residual_j` is kinetic + potential + elastic + dissipated - work, less its value at the start: 0 when it closes.
    """

    kinetic_translation_j: float
    kinetic_rotation_j: float
    potential_j: float
    elastic_j: float
    dissipated_normal_j: float
    dissipated_friction_j: float
    dissipated_local_j: float
    work_boundaries_j: float
    work_commands_j: float
    work_loads_j: float
    residual_j: float

    def residual_ratio(self) -> float:
        """Residual over the energy that went through the system: the largest of the other terms."""
        terms = [abs(getattr(self, field.name)) for field in fields(self) if field.name != "residual_j"]
        return float(abs(self.residual_j) / max(*terms, 1e-300))


@dataclass(frozen=True)
class Warnings:
    """Events that do not stop a run, counted since its start.

    Attributes:
        rotation_not_converged: rotation steps whose implicit equation kept an error: reduce the time step.
        large_overlap: steps with an overlap above a tenth of the smaller bounding radius: raise the stiffness.
        fast_particle: steps in which one moved by more than a tenth of its bounding radius: reduce the time step.
        deep_rounding: steps with a generalized overlap above 1.5 rounding radii (refused at 2): raise the stiffness.
    """

    rotation_not_converged: int
    large_overlap: int
    fast_particle: int
    deep_rounding: int


@dataclass(frozen=True)
class StreamCounts:
    """Frames of one stream since the start: by the physics, on the bus, overwritten before they were published."""

    name: str
    offered: int
    published: int
    dropped: int


@dataclass(frozen=True)
class WindowProgress:
    """How far a step command or a window is."""

    from_time_s: float
    to_time_s: float
    steps_done: int
    steps_total: int


@dataclass(frozen=True, eq=False)
class Report:
    """How good the run is, in numbers.

    Attributes:
        header: step, time, run.
        state: what the daemon does.
        particles: present.
        touching_pairs: pairs of particles that touch.
        touching_boundary_pairs: pairs of a particle and a boundary that touch.
        contact_points: of all of these.
        contact_points_smooth, contact_points_vertex_face, contact_points_edge_edge: by kind of feature.
        neighbour_rebuilds: since the start.
        energy: balance since the start.
        momentum_kg_m_per_s: total, (3,).
        internal_force_residual_n: sum of contact forces between particles: 0 to rounding.
        largest_overlap_m: now.
        largest_overlap_ratio: over the smaller bounding radius, now.
        largest_overlap_ratio_so_far: since the start.
        largest_overlap_over_rounding: generalized overlap over the rounding radius, now; 0 with other laws.
        time_step_s: in use.
        critical_time_step_s: largest stable one of a single contact.
        present_critical_time_step_s: of the contacts that are there now, all of a body's together: an estimate from
            below; infinite without contacts.
        contact_duration_s: shortest one of two particles present.
        warnings: counted since the start.
        stages_s_per_step: wall seconds per step by stage, since the report before.
        sim_s_per_wall_s: simulated seconds per wall second, since the report before.
        steps_per_wall_s: since the report before.
        streams: frames by stream, since the start.
        state_hash: of the whole state.
        progress: of the step command or window under way; None when there is none.
        wall_s: since the start of the daemon.
    """

    header: Header
    state: RunState
    particles: int
    touching_pairs: int
    touching_boundary_pairs: int
    contact_points: int
    contact_points_smooth: int
    contact_points_vertex_face: int
    contact_points_edge_edge: int
    neighbour_rebuilds: int
    energy: EnergyBalance
    momentum_kg_m_per_s: NDArray[np.float64]
    internal_force_residual_n: float
    largest_overlap_m: float
    largest_overlap_ratio: float
    largest_overlap_ratio_so_far: float
    largest_overlap_over_rounding: float
    time_step_s: float
    critical_time_step_s: float
    present_critical_time_step_s: float
    contact_duration_s: float
    warnings: Warnings
    stages_s_per_step: dict[str, float]
    sim_s_per_wall_s: float
    steps_per_wall_s: float
    streams: dict[str, StreamCounts]
    state_hash: int
    progress: WindowProgress | None
    wall_s: float

    @classmethod
    def from_message(cls, message: pb.Report) -> Report:
        converted: dict[str, Any] = {
            "header": Header.from_message(message.header),
            "state": RunState(message.state),
            "energy": _plain(EnergyBalance, message.energy),
            "momentum_kg_m_per_s": columns.from_vec3(message.momentum_kg_m_per_s),
            "warnings": _plain(Warnings, message.warnings),
            "stages_s_per_step": {stage.name: stage.s_per_step for stage in message.stages},
            "streams": {stream.name: _plain(StreamCounts, stream) for stream in message.streams},
            "progress": _plain(WindowProgress, message.progress) if message.HasField("progress") else None,
        }
        plain = {field.name: getattr(message, field.name) for field in fields(cls) if field.name not in converted}
        return cls(**converted, **plain)

    @property
    def step(self) -> int:
        """Steps done."""
        return self.header.step

    @property
    def time_s(self) -> float:
        """Simulated time, s."""
        return self.header.time_s


@dataclass(frozen=True)
class GuardWarning:
    """A guard's warning; of one kind at most one in a second.

    Attributes:
        kind: of what.
        count: steps (of ``ROTATION_NOT_CONVERGED`` rotations) since the last event of this kind; 0 for ``TIME_STEP``.
        total: the same, since the start of the run.
        particle_id: the worst particle now; None where there is no one of them.
        value: now: a ratio, or a time step, s.
        limit: above which it warns.
    """

    kind: WarningKind
    count: int
    total: int
    particle_id: int | None
    value: float
    limit: float

    @classmethod
    def from_message(cls, message: pb.GuardWarning) -> GuardWarning:
        return cls(
            kind=WarningKind(message.kind),
            count=message.count,
            total=message.total,
            particle_id=message.particle_id if message.HasField("particle_id") else None,
            value=message.value,
            limit=message.limit,
        )


@dataclass(frozen=True)
class CommandOutcome:
    """What became of a command, in an event.

    Attributes:
        client_id: who asked.
        request_id: which request of that client.
        command: such as ``set_gravity``.
        step: steps done when it took effect.
        time_s: simulated time then, s.
        error: why it was refused; empty otherwise.
        path: into the request, of what was refused.
    """

    client_id: str
    request_id: str
    command: str
    step: int
    time_s: float
    error: str
    path: str

    @classmethod
    def from_message(cls, message: command_pb2.Outcome) -> CommandOutcome:
        return cls(
            client_id=message.client_id,
            request_id=message.request_id,
            command=message.command,
            step=message.step,
            time_s=message.sim_time_s,
            error=message.error.message,
            path=message.error.path,
        )


@dataclass(frozen=True)
class Event:
    """Something that happened.

    Attributes:
        header: step, time, run.
        kind: what.
        severity: how bad.
        message: for people.
        name: of the field, output, checkpoint, stage or inflow, for such events; of the client, for lease events.
        request_id: of the command, for command events; empty otherwise.
        outcome: of the command, for command events.
        inserted: ids that were added, for particles events.
        removed: ids that were removed, as ascending ranges, for particles events.
        warning: of a guard, for warnings.
        lease: what became of it, for lease events.
        checkpoint: that was saved or restored, for such events; None when one was dropped.
        output: as it is now, for output events.
    """

    header: Header
    kind: EventKind
    severity: Severity
    message: str
    name: str
    request_id: str
    outcome: CommandOutcome | None
    inserted: range | None
    removed: tuple[range, ...]
    warning: GuardWarning | None
    lease: LeaseChange | None
    checkpoint: Checkpoint | None
    output: Output | None

    @classmethod
    def from_message(cls, message: pb.Event) -> Event:
        def part(name: str, convert: Any) -> Any:
            return convert(getattr(message, name)) if message.HasField(name) else None

        return cls(
            header=Header.from_message(message.header),
            kind=EventKind(message.kind),
            severity=Severity(message.severity),
            message=message.message,
            name=message.name,
            request_id=message.outcome.request_id,
            outcome=part("outcome", CommandOutcome.from_message),
            inserted=part("inserted", _ids),
            removed=tuple(_ids(ids) for ids in message.removed),
            warning=part("warning", GuardWarning.from_message),
            lease=LeaseChange(message.lease) if message.lease else None,
            checkpoint=part("checkpoint", Checkpoint.from_message),
            output=part("output", Output.from_message),
        )


def _ids(message: command_pb2.IdRange) -> range:
    return range(message.first_id, message.first_id + message.count)
