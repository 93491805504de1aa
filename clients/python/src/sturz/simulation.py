"""A simulation to steer and to look at: `launch` or `connect`, then `Simulation`."""

from __future__ import annotations

import contextlib
import itertools
import os
import secrets
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import columns as wire
from ._proto.sturz.v1 import command_pb2 as pb
from ._proto.sturz.v1 import data_pb2, status_pb2
from .bus import Bus
from .contacts import Contacts
from .daemon import Daemon
from .errors import CommandError, DaemonGone, ErrorCode, NotConnected, SturzError, Timeout
from .field import Field, FieldAverage, FieldDefinition, GridCylinder, grid_from
from .fluid import Exchange, Fluid, FluidFields
from .loads import Loads
from .output import FloatType, output_message
from .progress import ProgressBar, wanted
from .sizes import Scale, write_scale
from .state import Shape, State
from .status import Checkpoint, Event, Features, Info, Report
from .stream import Stream
from .target import Target, Tls

DEFAULT_ENDPOINT = "tcp/127.0.0.1:7447"
StopReason = Literal["unspecified", "complete", "paused", "stopped", "lease_lost"]
_STOP_REASONS: tuple[StopReason, ...] = ("unspecified", "complete", "paused", "stopped", "lease_lost")
T = TypeVar("T")


def _stop_reason(number: int) -> StopReason:
    """By name; a newer daemon may know more."""
    return _STOP_REASONS[number] if number < len(_STOP_REASONS) else "unspecified"


@dataclass(frozen=True)
class Box:
    """Axis-aligned box for random insertion; particles lie wholly inside.

    Attributes:
        min_m: lower corner, (3,), m.
        max_m: upper corner, (3,), m.
    """

    min_m: ArrayLike
    max_m: ArrayLike


@dataclass(frozen=True)
class Cylinder:
    """Solid circular cylinder for random insertion; particles lie wholly inside.

    Attributes:
        point_m: centre of one end, (3,), m.
        axis: direction from that end to the other, (3,).
        radius_m: m.
        length_m: distance of the ends, m.
    """

    point_m: ArrayLike
    axis: ArrayLike
    radius_m: float
    length_m: float


@dataclass(frozen=True)
class Stepped:
    """What became of a step command.

    Attributes:
        time_reached_s: simulated time now, s.
        step: steps done by the state now.
        steps_done: by this command.
        stop_reason: ``complete``, ``paused`` (by a `pause`), ``stopped`` (by the end of the daemon) or
            ``lease_lost`` (the holder of the lease was lost).
    """

    time_reached_s: float
    step: int
    steps_done: int
    stop_reason: StopReason


@dataclass(frozen=True)
class Advanced(Stepped):
    """What became of a window.

    Attributes:
        window_steps: equal steps that the window was cut into.
        state: at the end of the window; None when no columns were asked for.
        fields: at the end of the window, by name.
        contacts: at the end of the window; None when they were not asked for.
        exchange: for the fluid, over the window; None when it was not asked for.
    """

    window_steps: int
    state: State | None
    fields: dict[str, Field]
    contacts: Contacts | None
    exchange: Exchange | None = None


def launch(
    scene: str | os.PathLike[str] | None = None,
    *,
    scene_text: str | None = None,
    name: str | None = None,
    threads: int | None = None,
    paused: bool = True,
    checkpoints: str | os.PathLike[str] | None = None,
    journal: str | os.PathLike[str] | None = None,
    resume: str | os.PathLike[str] | None = None,
    timeout_s: float = 30.0,
    binary: str | os.PathLike[str] | None = None,
) -> Simulation:
    """Starts a daemon of its own and connects to it. Closing the simulation ends the daemon.

    Args:
        scene: name of a bundled scene (`sturz scenes` lists them) or path of a scene file.
        scene_text: the scene itself, TOML, instead of `scene`.
        name: instance on the bus: letters, digits, `_` and `-`; made from the scene when absent.
        threads: of the physics; the daemon's default when absent.
        paused: start paused, so that nothing happens before the first command.
        checkpoints: folder for checkpoints on disk, made if need be; none when absent. A journal has its own.
        journal: folder for a new journal: what was acknowledged survives the daemon.
        resume: folder of a journal: goes on with its run, instead of starting a scene.
        timeout_s: for start and connection together.
        binary: the daemon; else the environment's STURZ_BINARY, the repository's release build, the one beside this
            interpreter, or the PATH.

    Raises:
        LaunchFailed: the daemon is nowhere, or refused the scene; the text says why.
    """
    stem = Path(scene).stem if scene is not None else "scene"
    plain = "".join(letter if letter.isascii() and (letter.isalnum() or letter in "_-") else "-" for letter in stem)
    daemon = Daemon(
        scene=scene,
        scene_text=scene_text,
        name=name or f"{plain[:50]}-{secrets.token_hex(3)}",
        threads=threads,
        paused=paused,
        checkpoints=checkpoints,
        journal=journal,
        resume=resume,
        timeout_s=timeout_s,
        binary=binary,
    )
    try:
        target = Target(daemon.endpoint)
        return Simulation(Bus(target=target, instance=daemon.instance, timeout_s=timeout_s), daemon=daemon)
    except BaseException:
        daemon.close()
        raise


def connect(
    name: str,
    *,
    endpoint: str = DEFAULT_ENDPOINT,
    tls: str | os.PathLike[str] | Tls | None = None,
    config: str | os.PathLike[str] | None = None,
    timeout_s: float = 5.0,
) -> Simulation:
    """Connects to a daemon that is there already. Closing the simulation leaves it running.

    Args:
        name: instance on the bus.
        endpoint: where the daemon listens.
        tls: for an endpoint such as ``tls/host:7447``: the folder with the certificate of this client, such as
            ``lab/clients/alice``, or the three files of it.
        config: a zenoh configuration file to start from.
        timeout_s: until one is there.

    Raises:
        NotConnected: nobody listens there, or no instance of that name is alive.
        AccessDenied: the daemon does not accept the certificate, or its name has no role there.
    """
    certificates = Tls.from_folder(tls) if isinstance(tls, str | os.PathLike) else tls
    target = Target(endpoint, certificates, None if config is None else Path(config))
    return Simulation(Bus(target=target, instance=name, timeout_s=timeout_s))


class Simulation:
    """A connected simulation. Use `launch` or `connect` to get one, and it in a `with` to close it.

    Every method blocks until the daemon has answered; every method may be called from any thread. Units are SI and in
    the names. Commands that the daemon refuses raise `CommandError` and leave its state as it was.

    Attributes:
        timeout_s: for the answer to anything that is quick. Steps and windows may take as long as they need.
    """

    def __init__(self, bus: Bus, *, daemon: Daemon | None = None) -> None:
        self.timeout_s = 10.0
        self.client_id = f"python-{os.getpid()}-{secrets.token_hex(4)}"
        self._bus = bus
        self._daemon = daemon
        self._numbers = itertools.count(1)
        self._time_s: float | None = None
        self._later = threading.local()
        self._lock = threading.Lock()
        self._streams: list[Stream[Any]] = []
        self._token: Any = None

    def __repr__(self) -> str:
        return f"Simulation({self.instance!r} at {self._bus.endpoint})"

    @property
    def instance(self) -> str:
        """Name on the bus."""
        return self._bus.instance

    @property
    def endpoint(self) -> str:
        """Where the daemon listens."""
        return self._bus.endpoint

    @property
    def daemon(self) -> Daemon | None:
        """The daemon that `launch` started; None after `connect`."""
        return self._daemon

    def _reached(self, time_s: float) -> None:
        """Notes where the simulation is. Answers come here out of order from several threads; time never goes back."""
        with self._lock:
            if self._time_s is None or time_s > self._time_s:
                self._time_s = time_s

    def _went_to(self, time_s: float) -> None:
        """Notes where a restored simulation is, be it earlier."""
        with self._lock:
            self._time_s = time_s

    # Questions.

    def _ask(self, key: str) -> bytes:
        return self._bus.ask(key, timeout_s=self.timeout_s)

    def info(self) -> Info:
        """What this simulation is, and where it stands."""
        info = Info.from_message(status_pb2.Info.FromString(self._ask("info")))
        self._reached(info.time_s)
        return info

    def features(self) -> Features:
        """What the daemon can do."""
        return Features.from_message(status_pb2.Features.FromString(self._ask("features")))

    def plan(self) -> tuple[str, ...]:
        """What this scene needs, in words."""
        return tuple(status_pb2.Plan.FromString(self._ask("plan")).lines)

    def shapes(self) -> tuple[Shape, ...]:
        """Shapes in the order that `State.shapes` indexes."""
        message = status_pb2.Shapes.FromString(self._ask("shapes/latest"))
        return tuple(Shape.from_message(shape) for shape in message.shapes)

    def report(self) -> Report:
        """How good the run is now."""
        return Report.from_message(status_pb2.Report.FromString(self._ask("report/latest")))

    def state(self, columns: Iterable[str] | None = None, *, float_type: FloatType = "f64") -> State:
        """The particles now.

        Args:
            columns: names such as ``positions`` (see `Features.columns`; ``all`` for every one); all but ``forces`` and
                ``torques`` when absent. Ids are always there.
            float_type: of floating-point columns.
        """
        names = "" if columns is None else f"columns={'|'.join(['ids', *columns])};"
        answer = self._ask(f"state/latest?{names}float={float_type}")
        return State.from_message(data_pb2.Frame.FromString(answer))

    def contacts(self, columns: Iterable[str] | None = None, *, float_type: FloatType = "f64") -> Contacts:
        """The contact network now: who touches whom, where, and with what force.

        Args:
            columns: names such as ``points`` (see `Features.contact_columns`); all when absent. Ids and boundaries are
                always there.
            float_type: of floating-point columns.
        """
        names = "" if columns is None else f"columns={'|'.join(['ids', *columns])};"
        answer = self._ask(f"contacts/latest?{names}float={float_type}")
        return Contacts.from_message(data_pb2.ContactFrame.FromString(answer))

    def field(self, name: str) -> Field:
        """A defined field, sampled now."""
        return Field.from_message(data_pb2.FieldFrame.FromString(self._ask(f"field/{name}/latest")))

    # Commands.

    def new_request_id(self) -> str:
        """An id that no request of this client has had."""
        return str(next(self._numbers))

    def command(self, verb: str, request: Any, *, timeout_s: float | None = None, retries: int = 1) -> pb.Outcome:
        """Sends any request of the protocol, and returns the outcome; what all methods below are made of.

        A request without a header gets one. After a timeout it is sent again with the same id, which the daemon
        answers from memory: it is applied once.

        Args:
            verb: such as ``set_gravity``.
            request: the protobuf message that belongs to it.
            timeout_s: for the answer; as long as the daemon lives when absent.
            retries: how often to send it again after a timeout.

        Raises:
            CommandError: refused.
        """
        if not request.header.client_id:
            request.header.client_id = self.client_id
        if not request.header.request_id:
            request.header.request_id = self.new_request_id()
        sent = None
        if getattr(self._later, "time_s", None) is not None:
            request.header.at_time_s = self._later.time_s
            sent = self._later.sent
        payload = request.SerializeToString()
        for attempt in itertools.count():
            try:
                answer = self._bus.ask(f"cmd/{verb}", payload=payload, timeout_s=timeout_s, sent=sent)
                break
            except Timeout as timeout:
                if attempt >= retries:
                    raise Timeout(f"{timeout} (request id {request.header.request_id!r})") from None
        outcome: pb.Outcome = pb.Outcome.FromString(answer)
        if outcome.WhichOneof("result") == "error":
            error = outcome.error
            raise CommandError(
                code=ErrorCode(error.code), path=error.path, message=error.message, command=verb, step=outcome.step
            )
        self._reached(outcome.sim_time_s)
        return outcome

    def _quick(self, verb: str, request: Any) -> pb.Outcome:
        later = getattr(self._later, "time_s", None) is not None
        return self.command(verb, request, timeout_s=None if later else self.timeout_s)

    def later(self, at_time_s: float, function: Callable[..., T], **arguments: Any) -> Future[T]:
        """Has a command take effect before the first step that starts at or after a simulated time.

        ``future = simulation.later(1.5, simulation.set_gravity, gravity_m_per_s2=(0, 0, -1.6))`` returns as soon as
        the command is on its way; commands that follow come after it. `future.result()` waits until it has taken
        effect, and raises when it was refused.

        Args:
            at_time_s: not before now, s.
            function: method of this simulation: insert, remove, set something, define or drop a field.
            arguments: of the method.
        """
        future: Future[T] = Future()
        sent = threading.Event()

        def work() -> None:
            self._later.time_s, self._later.sent = at_time_s, sent.set
            try:
                future.set_result(function(**arguments))
            except BaseException as error:
                future.set_exception(error)
            finally:
                sent.set()

        threading.Thread(target=work, name=f"sturz later {at_time_s:g}", daemon=True).start()
        sent.wait(self.timeout_s)
        return future

    def insert_poses(
        self,
        *,
        shape: str,
        material: str,
        positions_m: ArrayLike,
        orientations_wxyz: ArrayLike | None = None,
        velocity_m_per_s: ArrayLike = (0, 0, 0),
        angular_velocity_rad_per_s: ArrayLike = (0, 0, 0),
        scale: Scale = 1.0,
        frozen: bool = False,
    ) -> NDArray[np.uint64]:
        """Adds particles at given poses of the shape's given frame. Overlap is not checked.

        Args:
            shape: name in the scene.
            material: name in the scene.
            positions_m: (n, 3), m.
            orientations_wxyz: unit quaternions, (n, 4); unrotated when absent.
            velocity_m_per_s: of each, (3,).
            angular_velocity_rad_per_s: of each, in world axes, (3,).
            scale: size relative to the shape, (smallest, largest) for uniformly random ones, or one of `NormalScale`,
                `LognormalScale` and `ScaleTable`.
            frozen: they keep their velocity whatever pushes them, and meet neither their like nor boundaries: a rough
                base.

        Returns:
            Ids, (n,).
        """
        poses = pb.PosesPlacement(positions_m=wire.encode("positions_m", positions_m, components=3, unit="m"))
        if orientations_wxyz is not None:
            orientations = wire.encode("orientations_wxyz", orientations_wxyz, components=4)
            poses.orientations_wxyz.CopyFrom(orientations)
        request = pb.InsertRequest(shape=shape, material=material, poses=poses)
        return self._insert(request, velocity_m_per_s, angular_velocity_rad_per_s, scale, frozen)

    def insert_lattice(
        self,
        *,
        shape: str,
        material: str,
        origin_m: ArrayLike,
        spacing_m: ArrayLike,
        counts: Sequence[int],
        random_orientation: bool = False,
        velocity_m_per_s: ArrayLike = (0, 0, 0),
        angular_velocity_rad_per_s: ArrayLike = (0, 0, 0),
        scale: Scale = 1.0,
        frozen: bool = False,
    ) -> NDArray[np.uint64]:
        """Adds particles on the nodes of a lattice.

        Args:
            origin_m: first node, (3,), m.
            spacing_m: distance of nodes along each axis, (3,), m.
            counts: nodes along each axis.
            random_orientation: instead of unrotated.

        The other arguments, and what is returned, are those of `insert_poses`.
        """
        lattice = pb.LatticePlacement(
            origin_m=wire.vec3("origin_m", origin_m),
            spacing_m=wire.vec3("spacing_m", spacing_m),
            count_x=counts[0],
            count_y=counts[1],
            count_z=counts[2],
            random_orientation=random_orientation,
        )
        request = pb.InsertRequest(shape=shape, material=material, lattice=lattice)
        return self._insert(request, velocity_m_per_s, angular_velocity_rad_per_s, scale, frozen)

    def insert_random(
        self,
        *,
        shape: str,
        material: str,
        region: Box | Cylinder,
        count: int | None = None,
        solid_fraction: float | None = None,
        fixed_orientation: bool = False,
        attempts: int | None = None,
        velocity_m_per_s: ArrayLike = (0, 0, 0),
        angular_velocity_rad_per_s: ArrayLike = (0, 0, 0),
        scale: Scale = 1.0,
        frozen: bool = False,
    ) -> NDArray[np.uint64]:
        """Adds particles at random places without overlap with particles or boundaries.

        Args:
            region: where; particles lie wholly inside.
            count: how many. Give this or `solid_fraction`.
            solid_fraction: until the new particles fill this part of the region.
            fixed_orientation: unrotated instead of random.
            attempts: per particle before the insertion is refused; the daemon's default when absent.

        The other arguments, and what is returned, are those of `insert_poses`.
        """
        if (count is None) == (solid_fraction is None):
            raise ValueError("give either count or solid_fraction")
        random = pb.RandomPlacement(fixed_orientation=fixed_orientation)
        if count is not None:
            random.count = count
        if solid_fraction is not None:
            random.solid_fraction = solid_fraction
        if attempts is not None:
            random.attempts = attempts
        if isinstance(region, Box):
            random.box.min_m.CopyFrom(wire.vec3("min_m", region.min_m))
            random.box.max_m.CopyFrom(wire.vec3("max_m", region.max_m))
        else:
            random.cylinder.point_m.CopyFrom(wire.vec3("point_m", region.point_m))
            random.cylinder.axis.CopyFrom(wire.vec3("axis", region.axis))
            random.cylinder.radius_m = region.radius_m
            random.cylinder.length_m = region.length_m
        request = pb.InsertRequest(shape=shape, material=material, random=random)
        return self._insert(request, velocity_m_per_s, angular_velocity_rad_per_s, scale, frozen)

    def insert_deposition(
        self,
        *,
        shape: str,
        material: str,
        region: Box,
        count: int,
        fixed_orientation: bool = False,
        velocity_m_per_s: ArrayLike = (0, 0, 0),
        angular_velocity_rad_per_s: ArrayLike = (0, 0, 0),
        scale: Scale = 1.0,
        frozen: bool = False,
    ) -> NDArray[np.uint64]:
        """Adds particles as a loose bed: circumscribed spheres drop one by one and roll to local minima of height.

        Args:
            region: its floor bears them, as does what is there already; its sides along x and y are walls unless it
                spans a periodic cell. Refused where the heap grows above it.
            count: how many.
            fixed_orientation: unrotated instead of random.

        The other arguments, and what is returned, are those of `insert_poses`.
        """
        deposition = pb.DepositionPlacement(count=count, fixed_orientation=fixed_orientation)
        deposition.box.min_m.CopyFrom(wire.vec3("min_m", region.min_m))
        deposition.box.max_m.CopyFrom(wire.vec3("max_m", region.max_m))
        request = pb.InsertRequest(shape=shape, material=material, deposition=deposition)
        return self._insert(request, velocity_m_per_s, angular_velocity_rad_per_s, scale, frozen)

    def _insert(
        self,
        request: pb.InsertRequest,
        velocity_m_per_s: ArrayLike,
        angular_velocity_rad_per_s: ArrayLike,
        scale: Scale,
        frozen: bool,
    ) -> NDArray[np.uint64]:
        request.velocity_m_per_s.CopyFrom(wire.vec3("velocity_m_per_s", velocity_m_per_s))
        request.angular_velocity_rad_per_s.CopyFrom(wire.vec3("angular_velocity_rad_per_s", angular_velocity_rad_per_s))
        write_scale(request, scale)
        request.frozen = frozen
        # Dense random insertion takes its time.
        inserted = self.command("insert", request).inserted
        return np.arange(inserted.first_id, inserted.first_id + inserted.count, dtype=np.uint64)

    def remove(self, *, ids: ArrayLike) -> int:
        """Removes particles, all or none: every one of `ids` must exist. Returns how many."""
        numbers = np.atleast_1d(np.asarray(ids))
        if numbers.size and (numbers.dtype.kind not in "iu" or numbers.min() < 0):
            raise ValueError(f"ids are {numbers.dtype}: whole numbers from 0 are needed")
        request = pb.RemoveRequest(ids=numbers.ravel().tolist())
        return int(self._quick("remove", request).removed.count)

    def set_gravity(self, *, gravity_m_per_s2: ArrayLike) -> None:
        """Sets the acceleration of gravity, (3,), m/s2."""
        request = pb.SetGravityRequest(gravity_m_per_s2=wire.vec3("gravity_m_per_s2", gravity_m_per_s2))
        self._quick("set_gravity", request)

    def set_rotation(
        self,
        *,
        boundary: str,
        angular_velocity_rad_per_s: float,
        ramp_s: float = 0.0,
        point_m: ArrayLike | None = None,
        axis: ArrayLike | None = None,
    ) -> None:
        """Rotates a boundary.

        Args:
            boundary: name in the scene.
            angular_velocity_rad_per_s: about `axis` by the right-hand rule.
            ramp_s: duration of the linear change from the present angular velocity, s.
            point_m: a point of the axis of rotation, (3,); the boundary's own when absent.
            axis: direction, (3,); the cylinder's own when absent.
        """
        if point_m is None or axis is None:
            geometry = next((each for each in self.info().boundaries if each.name == boundary), None)
            # An unknown name goes to the daemon as it is: its answer says which names there are.
            point_m = point_m if point_m is not None else (geometry.point_m if geometry else (0, 0, 0))
            axis = axis if axis is not None else (geometry.direction if geometry else (0, 0, 1))
        rotation = pb.RotationMotion(point_m=wire.vec3("point_m", point_m), axis=wire.vec3("axis", axis))
        if ramp_s > 0.0:
            rotation.ramp.rad_per_s, rotation.ramp.duration_s = angular_velocity_rad_per_s, ramp_s
        else:
            rotation.constant.rad_per_s = angular_velocity_rad_per_s
        self._set_motion(boundary, pb.Motion(rotation=rotation))

    def set_translation(self, *, boundary: str, velocity_m_per_s: ArrayLike) -> None:
        """Moves a boundary at constant velocity, (3,), m/s."""
        translation = pb.TranslationMotion(velocity_m_per_s=wire.vec3("velocity_m_per_s", velocity_m_per_s))
        self._set_motion(boundary, pb.Motion(translation=translation))

    def set_oscillation(
        self, *, boundary: str, amplitude_m: ArrayLike, frequency_hz: float, phase_rad: float = 0.0
    ) -> None:
        """Moves a boundary to and fro from where it is: amplitude (sin(2 pi frequency t + phase) - sin(phase)).

        Args:
            boundary: name in the scene.
            amplitude_m: along each axis, (3,), m.
            frequency_hz: above 0.
            phase_rad: at the start.
        """
        amplitude = wire.vec3("amplitude_m", amplitude_m)
        wave = pb.OscillationMotion(amplitude_m=amplitude, frequency_hz=frequency_hz, phase_rad=phase_rad)
        self._set_motion(boundary, pb.Motion(oscillation=wave))

    def set_rotation_oscillation(
        self,
        *,
        boundary: str,
        point_m: ArrayLike,
        axis: ArrayLike,
        amplitude_rad_per_s: float,
        frequency_hz: float,
        phase_rad: float = 0.0,
    ) -> None:
        """Swings a boundary about an axis at the angular velocity amplitude sin(2 pi frequency t + phase)."""
        rotation = pb.RotationMotion(point_m=wire.vec3("point_m", point_m), axis=wire.vec3("axis", axis))
        rotation.oscillation.amplitude_rad_per_s = amplitude_rad_per_s
        rotation.oscillation.frequency_hz = frequency_hz
        rotation.oscillation.phase_rad = phase_rad
        self._set_motion(boundary, pb.Motion(rotation=rotation))

    def set_table(self, *, boundary: str, times_s: ArrayLike, displacements_m: ArrayLike) -> None:
        """Moves a boundary by a table, linear between its rows; at rest after the last one.

        Args:
            boundary: name in the scene.
            times_s: since now, (n,), s: 0 first, then ascending.
            displacements_m: from where it is, (n, 3), m: (0, 0, 0) first.
        """
        table = pb.TableMotion(
            times_s=np.asarray(times_s, dtype=np.float64).ravel().tolist(),
            displacements_m=wire.encode("displacements_m", displacements_m, components=3, unit="m"),
        )
        self._set_motion(boundary, pb.Motion(table=table))

    def set_servo(
        self,
        *,
        boundary: str,
        direction: ArrayLike,
        force_n: float,
        gain_m_per_s_per_n: float,
        max_velocity_m_per_s: float,
    ) -> None:
        """Moves a boundary until it presses on the particles with a force: velocity = gain (target - measured).

        Args:
            boundary: name in the scene; of a box, one of its sides (``room/z+``).
            direction: in which it presses, (3,).
            force_n: target; a pressure times its area.
            gain_m_per_s_per_n: above 0; gain times stiffness times time step must be well below 1.
            max_velocity_m_per_s: above 0.
        """
        servo = pb.ServoMotion(
            direction=wire.vec3("direction", direction),
            force_n=force_n,
            gain_m_per_s_per_n=gain_m_per_s_per_n,
            max_velocity_m_per_s=max_velocity_m_per_s,
        )
        self._set_motion(boundary, pb.Motion(servo=servo))

    def set_fixed(self, *, boundary: str) -> None:
        """Lets a boundary rest."""
        self._set_motion(boundary, pb.Motion(fixed=pb.FixedMotion()))

    def _set_motion(self, boundary: str, motion: pb.Motion) -> None:
        self._quick("set_motion", pb.SetMotionRequest(boundary=boundary, motion=motion))

    def set_loads(self, loads: Loads) -> None:
        """Replaces the loads from outside, from now on."""
        self._quick("set_loads", pb.SetLoadsRequest(loads=loads.to_message()))

    def set_fluid(self, fluid: Fluid | None, fields: FluidFields | None = None) -> None:
        """Puts a fluid around the particles, instead of the one before; None takes it away.

        Args:
            fluid: its density, viscosity and laws, and where its values are.
            fields: on its mesh, at once; its own velocity everywhere when absent.
        """
        request = pb.SetFluidRequest()
        if fluid is not None:
            request.fluid.CopyFrom(fluid.to_message())
        if fields is not None:
            request.fields.CopyFrom(fields.to_message())
        self._quick("set_fluid", request)

    def exchange(self) -> Exchange:
        """What the fluid gets from the particles, now; refused where there is no fluid with a mesh."""
        return Exchange.from_message(data_pb2.ExchangeFrame.FromString(self._ask("exchange/latest")))

    def pause(self) -> float:
        """Stops stepping, and ends a window in flight early. Returns the simulated time, s."""
        return float(self._quick("pause", pb.PauseRequest()).sim_time_s)

    def resume(self) -> None:
        """Lets the simulation step freely, until `pause`."""
        self._quick("resume", pb.ResumeRequest())

    def step(self, *, steps: int = 1) -> Stepped:
        """Does some steps of the nominal time step. The simulation must be paused."""
        with self._paused_by_interrupt():
            message = self.command("step", pb.StepRequest(steps=steps)).stepped
        self._reached(message.time_reached_s)
        return Stepped(message.time_reached_s, message.step, message.steps_done, _stop_reason(message.stop_reason))

    def advance(
        self,
        *,
        window_s: float,
        from_time_s: float | None = None,
        columns: Iterable[str] = (),
        fields: Iterable[str] = (),
        contacts: bool = False,
        float_type: FloatType = "f64",
        loads: Loads | None = None,
        fluid: FluidFields | None = None,
        fluid_ramp: bool = False,
        exchange: bool = False,
        progress: bool | None = False,
        label: str = "advance",
    ) -> Advanced:
        """Advances by exactly one window, cut into equal steps. The simulation must be paused.

        Args:
            window_s: its length, s.
            from_time_s: where you believe the simulation to be, bit for bit; from the last reply when absent. Another
                time than the daemon's is refused, which catches lost and doubled windows.
            columns: of the state to return (see `Features.columns`; ``all`` for every one).
            fields: names of defined fields to return.
            contacts: return the contact network.
            float_type: of the floating-point columns of state and contacts.
            loads: replace those before from the start of the window on; those before go on when absent.
            fluid: fields of the fluid (`set_fluid`) from the start of the window on; those before go on when absent.
            fluid_ramp: velocity and vorticity change linearly from those before into those of `fluid` over the window,
                instead of at once; pressure gradient and acceleration, being means over the window, always act at once.
            exchange: return what the fluid gets from the particles.
            progress: show a bar with simulated time, speed and time left; None: on a terminal only.
            label: of the bar.

        Returns:
            Time reached, steps, and what was asked for. Ctrl-C pauses the simulation and is passed on.
        """
        start = from_time_s if from_time_s is not None else self._time_s
        if start is None:
            start = self.info().time_s
        outputs = pb.Outputs(
            columns=list(columns),
            fields=list(fields),
            float_type=data_pb2.DATA_TYPE_F32 if float_type == "f32" else data_pb2.DATA_TYPE_F64,
            contacts=contacts,
            exchange=exchange,
        )
        request = pb.AdvanceRequest(from_time_s=start, window_s=window_s, outputs=outputs)
        if loads is not None:
            request.loads.CopyFrom(loads.to_message())
        if fluid is not None:
            request.fluid.CopyFrom(fluid.to_message(window_s if fluid_ramp else 0.0))
        with self._paused_by_interrupt(), self._bar(start, window_s, label if wanted(progress) else None):
            message = self.command("advance", request).advanced
            self._reached(message.time_reached_s)
        return Advanced(
            time_reached_s=message.time_reached_s,
            step=message.step,
            steps_done=message.steps_done,
            stop_reason=_stop_reason(message.stop_reason),
            window_steps=message.window_steps,
            state=State.from_message(message.frame) if message.HasField("frame") else None,
            fields={frame.name: Field.from_message(frame) for frame in message.fields},
            contacts=Contacts.from_message(message.contacts) if message.HasField("contacts") else None,
            exchange=Exchange.from_message(message.exchange) if message.HasField("exchange") else None,
        )

    def run_to(self, time_s: float, *, progress: bool | None = None, label: str = "run") -> Advanced:
        """Advances to the simulated time `time_s` in one window. The simulation must be paused.

        Args:
            time_s: later than now.
            progress: show a bar with simulated time, speed and time left; None: on a terminal only.
            label: of the bar.
        """
        now = self.info().time_s
        return self.advance(window_s=time_s - now, from_time_s=now, progress=progress, label=label)

    @contextlib.contextmanager
    def _paused_by_interrupt(self) -> Iterator[None]:
        try:
            yield
        except KeyboardInterrupt:
            # Else the daemon would go on with a window that nobody waits for.
            with contextlib.suppress(SturzError):
                self.pause()
            raise

    @contextlib.contextmanager
    def _bar(self, from_time_s: float, window_s: float, label: str | None) -> Iterator[None]:
        if label is None:
            yield
            return
        bar = ProgressBar(from_time_s=from_time_s, to_time_s=from_time_s + window_s, label=label)
        try:
            with self.reports(keep=1).for_each(bar.update):
                yield
        finally:
            bar.close(self._time_s if self._time_s is not None else from_time_s)

    def define_field(
        self,
        *,
        name: str,
        min_m: ArrayLike,
        max_m: ArrayLike,
        cells: Iterable[int],
        quantities: Iterable[str],
        width_m: float | Iterable[float],
        cutoff_widths: float | None = None,
        kernel: str = "gaussian",
        cylinder: GridCylinder | None = None,
        wall_correction: bool = False,
        body_axis: str = "longest",
        average: FieldAverage | None = None,
        moves_at_m_per_s: tuple[float, float, float] | None = None,
        moves_with: str | None = None,
    ) -> FieldDefinition:
        """Defines a field, or replaces the one of that name. It is computed only while somebody asks or subscribes.

        A mean over time is taken as long as the field is defined, and goes on where an equal field is defined again.

        Args:
            name: letters, digits, `_` and `-`.
            min_m: lower corner of the grid, (3,), m; with `cylinder` radius (m), angle (rad) and height (m).
            max_m: upper corner, (3,), m.
            cells: along each axis; 1 averages over the whole extent.
            quantities: names as in `Features.field_quantities`.
            width_m: coarse-graining width w of the kernel, m; several are sampled in one pass.
            cutoff_widths: support of the kernel over its width; the daemon's default (4) when absent.
            kernel: ``gaussian``: exp(-R^2 / (2 w^2)) up to the cutoff, ``lucy`` or ``heaviside``.
            cylinder: axis of a cylindrical grid.
            wall_correction: gives what plane walls cut off a kernel back to its part in front of them.
            body_axis: whose orientation is sampled: ``longest``, ``shortest``, ``x``, ``y`` or ``z`` of the body frame.
            average: a mean over time with standard errors, instead of the state of now.
            moves_at_m_per_s: velocity of the grid, which is where it is given at time 0.
            moves_with: name of a boundary that the grid moves with.
        """
        widths = [float(width) for width in width_m] if isinstance(width_m, Iterable) else [width_m]
        if not widths:
            raise ValueError("width_m is empty; one width at least is needed")
        definition = FieldDefinition(
            name=name,
            grid=grid_from(min_m, max_m, cells, cylinder),
            quantities=tuple(quantities),
            width_m=widths[0],
            cutoff_widths=cutoff_widths,
            kernel=kernel,
            more_widths_m=tuple(widths[1:]),
            wall_correction=wall_correction,
            body_axis=body_axis,
            average=average,
            moves_at_m_per_s=moves_at_m_per_s,
            moves_with=moves_with,
        )
        self._quick("define_field", pb.DefineFieldRequest(field=definition.to_message()))
        return definition

    def drop_field(self, *, name: str) -> None:
        """Forgets a field."""
        self._quick("drop_field", pb.DropFieldRequest(name=name))

    def define_output(
        self,
        stream: str,
        *,
        columns: Iterable[str] = (),
        float_type: FloatType | None = None,
        every_steps: int | None = None,
        every_wall_s: float | None = None,
        every_sim_s: float | None = None,
    ) -> None:
        """Sets columns, float type and pace of a stream, for all who subscribe to it.

        What is absent is as in the scene.

        Args:
            stream: ``state``, ``contacts``, ``report`` or ``field/<name>``.
            columns: names (see `Features.columns`, `contact_columns`, `field_quantities`); ``all`` for every one.
            float_type: of floating-point columns.
            every_steps: at every step whose number is a multiple. Give one pace, or none.
            every_wall_s: at most one in so much wall time, at least 0.001 s.
            every_sim_s: at the first step at or after every multiple of this simulated time.
        """
        output = output_message(
            stream=stream,
            columns=columns,
            float_type=float_type,
            every_steps=every_steps,
            every_wall_s=every_wall_s,
            every_sim_s=every_sim_s,
        )
        self._quick("define_output", pb.DefineOutputRequest(output=output))

    def checkpoint(self, *, token: str = "", on_disk: bool = False) -> Checkpoint:
        """Saves the whole state, to go back to by `restore`: bit for bit, springs of contacts and motions included.

        Args:
            token: letters, digits, `_` and `-`; one of that name is replaced. The daemon makes one when it is empty.
            on_disk: as a file that outlives the daemon, in its folder for checkpoints, instead of in its memory.
                Returns when the file is safe.
        """
        outcome = self.command("checkpoint", pb.CheckpointRequest(token=token, on_disk=on_disk))
        return Checkpoint.from_message(outcome.checkpointed.checkpoint)

    def restore(self, *, token: str) -> Checkpoint:
        """Goes back, or ahead, to a saved state, bit for bit. A run that has failed is paused by it.

        Windows that follow start there; ids and topology epochs given since are given again.
        """
        outcome = self.command("restore", pb.RestoreRequest(token=token))
        self._went_to(outcome.sim_time_s)
        return Checkpoint.from_message(outcome.restored.checkpoint)

    def checkpoints(self) -> tuple[Checkpoint, ...]:
        """The saved states, by token."""
        saved = self._quick("list_checkpoints", pb.ListCheckpointsRequest()).checkpoints.checkpoints
        return tuple(Checkpoint.from_message(each) for each in saved)

    def drop_checkpoint(self, *, token: str) -> None:
        """Forgets a saved state, its file included."""
        self._quick("drop_checkpoint", pb.DropCheckpointRequest(token=token))

    def acquire_lease(self) -> None:
        """Makes this client the only one that may step, advance, resume, restore and set loads.

        Others observe, and may steer, pause and stop. When this client is lost or closed, the run is paused.
        """
        had_one = self._token is not None
        if not had_one:
            self._token = self._bus.declare_token(f"client/{self.client_id}")
        deadline = time.monotonic() + 2.0
        while True:
            try:
                self._quick("acquire_lease", pb.AcquireLeaseRequest())
                return
            except CommandError as error:
                unseen = error.code is ErrorCode.LEASE and error.path == "header.client_id"
                if not unseen or time.monotonic() > deadline:
                    if not had_one:
                        self._drop_token()
                    raise
                time.sleep(0.02)  # the token is on its way

    def release_lease(self) -> None:
        """Lets others advance again; the run goes on."""
        self._quick("release_lease", pb.ReleaseLeaseRequest())
        self._drop_token()

    def _drop_token(self) -> None:
        token, self._token = self._token, None
        if token is not None:
            token.undeclare()

    # Streams.

    def _stream(self, stream: Stream[Any], key: str, *, history: bool = False) -> None:
        stream.at_close(self._bus.when_ended(stream.end))
        stream.at_close(self._bus.subscribe(key, stream.receive, missed=stream.miss if history else None))
        with self._lock:
            self._streams.append(stream)

        def forget() -> None:
            with self._lock:
                if stream in self._streams:
                    self._streams.remove(stream)

        stream.at_close(forget)

    def states(self, *, keep: int = 4) -> Stream[State]:
        """States as the daemon publishes them. A reader that is slow loses all but the newest `keep`."""
        stream: Stream[State] = Stream(
            name="state/frame", decode=data_pb2.Frame.FromString, convert=State.from_message, keep=keep
        )
        self._stream(stream, "state/frame")
        return stream

    def contact_networks(self, *, keep: int = 4) -> Stream[Contacts]:
        """The contact network as the daemon publishes it. A reader that is slow loses all but the newest `keep`."""
        stream: Stream[Contacts] = Stream(
            name="contacts/frame", decode=data_pb2.ContactFrame.FromString, convert=Contacts.from_message, keep=keep
        )
        self._stream(stream, "contacts/frame")
        return stream

    def fields(self, name: str, *, keep: int = 4) -> Stream[Field]:
        """Samples of a field as the daemon publishes them. A reader that is slow loses all but the newest `keep`."""
        stream: Stream[Field] = Stream(
            name=f"field/{name}", decode=data_pb2.FieldFrame.FromString, convert=Field.from_message, keep=keep
        )
        self._stream(stream, f"field/{name}")
        return stream

    def reports(self, *, keep: int = 16) -> Stream[Report]:
        """Reports as the daemon publishes them. A reader that is slow loses all but the newest `keep`."""
        stream: Stream[Report] = Stream(
            name="report", decode=status_pb2.Report.FromString, convert=Report.from_message, keep=keep
        )
        self._stream(stream, "report")
        return stream

    def events(self, *, keep: int = 1000) -> Stream[Event]:
        """What happened and happens: starts, pauses, outcomes of commands, particles, fields, outputs, warnings,
        checkpoints, the lease. Late readers get the recent past as well; `Stream.missed` counts what did not come. A
        reader that is slow loses all but the newest `keep`."""
        stream: Stream[Event] = Stream(
            name="event", decode=status_pb2.Event.FromString, convert=Event.from_message, keep=keep, counted=False
        )
        self._stream(stream, "event/**", history=True)
        return stream

    # The end.

    def reconnect(self, *, timeout_s: float = 5.0) -> Info:
        """Connects anew after `DaemonGone`, as the same client.

        A request of before the loss, sent again under its id, is not applied twice if the daemon has lived on. Streams
        have ended and must be opened again; the lease was lost and must be acquired again. The `run_id` of what is
        returned tells whether it is still the same run.

        Raises:
            NotConnected: the daemon is not there again within `timeout_s`; this object stays as it is.
            AccessDenied: it is, and does not let this client in.
        """
        bus = Bus(target=self._bus.target, instance=self.instance, timeout_s=timeout_s)
        with self._lock:
            streams, self._streams = self._streams, []
            old, self._bus = self._bus, bus
            self._time_s = None
            self._token = None
        for stream in streams:
            with contextlib.suppress(DaemonGone):
                stream.close()
        old.close()
        return self.info()

    def stop(self) -> None:
        """Ends the daemon, whoever started it, and closes this simulation."""
        with contextlib.suppress(DaemonGone, Timeout):
            # It may be gone before its answer is here.
            self._quick("stop", pb.StopRequest())
        self.close()

    def close(self) -> None:
        """Ends streams and connection; also the daemon when `launch` started it. Twice is harmless."""
        with self._lock:
            streams, self._streams = self._streams, []
        failure: BaseException | None = None
        for stream in streams:
            try:
                stream.close()
            except BaseException as error:
                failure = failure or error
        if self._daemon is not None and not self._bus.gone and not self._bus.closed:
            with contextlib.suppress(SturzError):
                self._bus.ask("cmd/stop", payload=self._stop_request(), timeout_s=2.0)
        self._bus.close()
        if self._daemon is not None:
            self._daemon.close()
        if failure is not None:
            raise failure

    def _stop_request(self) -> bytes:
        header = pb.CommandHeader(client_id=self.client_id, request_id=self.new_request_id())
        return bytes(pb.StopRequest(header=header).SerializeToString())

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            self.close()
        except BaseException:
            if error is None:
                raise


__all__ = [
    "DEFAULT_ENDPOINT",
    "Advanced",
    "Box",
    "Cylinder",
    "NotConnected",
    "Simulation",
    "Stepped",
    "connect",
    "launch",
]
