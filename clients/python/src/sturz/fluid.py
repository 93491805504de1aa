"""A fluid around the particles: what it is, its fields on a mesh, and what it gets from the particles.

`docs/coupling.md` has the equations; `sturz.coupling` marches particles and a solver in step.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import columns as wire
from ._proto.sturz.v1 import command_pb2, data_pb2

Side = Literal["closed", "open", "periodic"]
Sides = Side | tuple[Side, Side]
Drag = Literal["none", "stokes", "schiller_naumann", "haider_levenspiel", "ganser", "holzer_sommerfeld"]
Voidage = Literal["none", "di_felice", "gidaspow", "tenneti", "beetstra"]
Lift = Literal["none", "saffman_mei", "cross_flow"]
Pitching = Literal["none", "rosendahl"]
RotationalDrag = Literal["none", "stokes", "dennis"]


def _enum(prefix: str, name: str, choices: Any, what: str) -> Any:
    allowed = get_args(choices)
    if name not in allowed:
        raise ValueError(f"{what} is {name!r}; there are {', '.join(allowed)}")
    known = {f"{prefix}_NONE": f"{prefix}_UNSPECIFIED"}
    value = f"{prefix}_{name.upper()}"
    return getattr(command_pb2, value if hasattr(command_pb2, value) else known.get(value, value))


@dataclass(frozen=True)
class StructuredMesh:
    """Equal boxes. Values are means over a cell; x runs fastest: ``i + counts[0] * (j + counts[1] * k)``.

    Attributes:
        origin_m: lowest corner, (3,).
        spacing_m: sides of a cell, (3,).
        counts: cells along each axis, (3,).
        sides: by axis what the mesh ends in, or a pair for its low and its high end: ``closed`` (a wall: what the
            kernel spreads beyond it counts inside, mirrored), ``open`` (fluid ends there: particles are in it as far as
            they are inside) or ``periodic``.
    """

    origin_m: tuple[float, float, float]
    spacing_m: tuple[float, float, float]
    counts: tuple[int, int, int]
    sides: tuple[Sides, Sides, Sides] = ("closed", "closed", "closed")

    def __post_init__(self) -> None:
        for name in ("origin_m", "spacing_m", "counts", "sides"):
            if len(getattr(self, name)) != 3:
                raise ValueError(f"{name} is {getattr(self, name)}; three are needed, one per axis")
        if not all(np.isfinite(x) for x in self.origin_m):
            raise ValueError(f"origin_m is {self.origin_m}; must be finite")
        if not all(x > 0 and np.isfinite(x) for x in self.spacing_m):
            raise ValueError(f"spacing_m is {self.spacing_m}; must be finite and above 0")
        if not all(int(n) == n and n >= 1 for n in self.counts):
            raise ValueError(f"counts is {self.counts}; whole numbers of at least 1 are needed")
        for axis, pair in zip("xyz", self._pairs(), strict=True):
            if not all(side in get_args(Side) for side in pair):
                raise ValueError(f"sides of {axis} are {pair}; there are {', '.join(get_args(Side))}")
            if (pair[0] == "periodic") != (pair[1] == "periodic"):
                raise ValueError(f"sides of {axis} are {pair}; an axis is periodic at both ends or at none")

    def _pairs(self) -> list[tuple[Side, Side]]:
        return [(side, side) if isinstance(side, str) else side for side in self.sides]

    @property
    def n(self) -> int:
        """Cells."""
        return int(np.prod(self.counts))

    @property
    def cell_volume_m3(self) -> float:
        """Of each."""
        return float(np.prod(self.spacing_m))

    @property
    def volumes_m3(self) -> NDArray[np.float64]:
        """Of all, (n,)."""
        return np.full(self.n, self.cell_volume_m3)

    def centres(self) -> NDArray[np.float64]:
        """Of the cells, m, (n, 3)."""
        axes = [self.origin_m[a] + self.spacing_m[a] * (np.arange(self.counts[a]) + 0.5) for a in range(3)]
        z, y, x = np.meshgrid(axes[2], axes[1], axes[0], indexing="ij")
        return np.column_stack([x.ravel(), y.ravel(), z.ravel()])

    def reshape(self, values: ArrayLike) -> NDArray[Any]:
        """A column of the mesh as (counts[2], counts[1], counts[0]), with its components last."""
        array = np.asarray(values)
        return array.reshape(*self.counts[::-1], *array.shape[1:])

    def put_into(self, message: command_pb2.FluidDefinition) -> None:
        """For the wire."""
        sides = {
            f"{axis}_{end}": _enum("MESH_SIDE", side, Side, f"side of {axis}")
            for axis, pair in zip("xyz", self._pairs(), strict=True)
            for end, side in zip(("low", "high"), pair, strict=True)
        }
        message.structured.CopyFrom(
            command_pb2.StructuredMesh(
                origin_m=wire.vec3("origin_m", self.origin_m),
                spacing_m=wire.vec3("spacing_m", self.spacing_m),
                count_x=int(self.counts[0]),
                count_y=int(self.counts[1]),
                count_z=int(self.counts[2]),
                **sides,
            )
        )


@dataclass(frozen=True, eq=False)
class PointMesh:
    """Centres of the cells of any mesh, or its nodes.

    A point of a particle that is further than the smoothing length from all of them is outside of the fluid.

    Attributes:
        points_m: (n, 3), m.
        volumes_m3: that belong to each, (n,), above 0.
    """

    points_m: NDArray[np.float64]
    volumes_m3: NDArray[np.float64]

    def __post_init__(self) -> None:
        points, volumes = np.asarray(self.points_m, float), np.asarray(self.volumes_m3, float)
        if points.ndim != 2 or points.shape[1] != 3 or volumes.shape != points.shape[:1]:
            raise ValueError(f"points_m and volumes_m3 have the shapes {points.shape}, {volumes.shape}; (n, 3), (n,)")
        object.__setattr__(self, "points_m", points)
        object.__setattr__(self, "volumes_m3", volumes)

    @property
    def n(self) -> int:
        """Points."""
        return len(self.volumes_m3)

    def put_into(self, message: command_pb2.FluidDefinition) -> None:
        """For the wire."""
        message.points.points_m.CopyFrom(wire.encode("points_m", self.points_m, components=3, unit="m"))
        message.points.volumes_m3.CopyFrom(wire.encode("volumes_m3", self.volumes_m3, components=1, unit="m3"))


Mesh = StructuredMesh | PointMesh


@dataclass(frozen=True)
class Fluid:
    """A fluid for the particles to be in (`Simulation.set_fluid`).

    Each particle feels, in every step, drag K (u - v), lift and torques by the laws named here, the pressure gradient
    (-V grad p), added mass as inertia, and buoyancy where asked for. No drag limits the time step.

    Attributes:
        density_kg_per_m3: of the fluid.
        viscosity_pa_s: dynamic.
        mesh: where the fluid's values are; without one it is the same everywhere, and nobody answers for it.
        smoothing_length_m: half-width of the kernel that spreads each particle's volume over the mesh, whatever the
            size of the cells; needed with a mesh. Two to three particle diameters are usual.
        velocity_m_per_s: everywhere until fields come; without a mesh for good, (3,).
        drag: of one particle: ``haider_levenspiel`` (by sphericity), ``holzer_sommerfeld`` (by orientation),
            ``ganser``, ``schiller_naumann``, ``stokes``, ``none``.
        voidage: how neighbours change it: ``di_felice``, ``gidaspow`` (Ergun, Wen and Yu), ``tenneti``, ``beetstra``,
            ``none``.
        lift: ``none``, ``saffman_mei`` (spheres in shear), ``cross_flow`` (bodies with an axis).
        pitching: torque of drag beside the centre: ``none``, ``rosendahl``.
        rotational_drag: ``none``, ``stokes``, ``dennis``.
        added_mass_coefficient: over the displaced mass; 1/2 for a sphere.
        buoyancy: adds -density V gravity: for a fluid whose pressure leaves the hydrostatic part out, or that has none.
        void_fraction: that the laws see without a mesh.
        least_void_fraction: the laws see none below.
        refresh_steps: steps between two looks at where the particles are in the mesh; 0: at the start of each window,
            and whenever one may have come further than a tenth of the smoothing length.
    """

    density_kg_per_m3: float
    viscosity_pa_s: float
    mesh: Mesh | None = None
    smoothing_length_m: float | None = None
    velocity_m_per_s: ArrayLike = (0.0, 0.0, 0.0)
    drag: Drag = "haider_levenspiel"
    voidage: Voidage = "di_felice"
    lift: Lift = "none"
    pitching: Pitching = "none"
    rotational_drag: RotationalDrag = "none"
    added_mass_coefficient: float = 0.0
    buoyancy: bool = False
    void_fraction: float = 1.0
    least_void_fraction: float = 0.2
    refresh_steps: int = 0

    def to_message(self) -> command_pb2.FluidDefinition:
        """For the wire."""
        message = command_pb2.FluidDefinition(
            density_kg_per_m3=self.density_kg_per_m3,
            viscosity_pa_s=self.viscosity_pa_s,
            velocity_m_per_s=wire.vec3("velocity_m_per_s", self.velocity_m_per_s),
            smoothing_length_m=self.smoothing_length_m,
            void_fraction=self.void_fraction,
            least_void_fraction=self.least_void_fraction,
            drag=_enum("DRAG_LAW", self.drag, Drag, "drag"),
            voidage=_enum("VOIDAGE_LAW", self.voidage, Voidage, "voidage"),
            lift=_enum("LIFT_LAW", self.lift, Lift, "lift"),
            pitching=_enum("PITCHING_LAW", self.pitching, Pitching, "pitching"),
            rotational_drag=_enum("ROTATIONAL_DRAG_LAW", self.rotational_drag, RotationalDrag, "rotational_drag"),
            added_mass_coefficient=self.added_mass_coefficient,
            buoyancy=self.buoyancy,
            refresh_steps=self.refresh_steps,
        )
        if self.mesh is not None:
            self.mesh.put_into(message)
        return message


@dataclass(frozen=True, eq=False)
class FluidFields:
    """The fluid on its mesh, a row per cell or point; what is absent is 0.

    Attributes:
        velocity_m_per_s: interstitial, (n, 3).
        pressure_gradient_pa_per_m: (n, 3).
        acceleration_m_per_s2: material derivative of the velocity, for the added mass, (n, 3).
        vorticity_rad_per_s: curl of the velocity, for lift and rotation, (n, 3).
    """

    velocity_m_per_s: NDArray[np.float64]
    pressure_gradient_pa_per_m: NDArray[np.float64] | None = None
    acceleration_m_per_s2: NDArray[np.float64] | None = None
    vorticity_rad_per_s: NDArray[np.float64] | None = None

    def to_message(self, ramp_s: float = 0.0) -> command_pb2.FluidFields:
        """For the wire; `ramp_s`: velocity and vorticity come linearly out of those before over this time."""
        message = command_pb2.FluidFields(ramp_s=ramp_s)
        for name, unit in (
            ("velocity_m_per_s", "m/s"),
            ("pressure_gradient_pa_per_m", "Pa/m"),
            ("acceleration_m_per_s2", "m/s2"),
            ("vorticity_rad_per_s", "rad/s"),
        ):
            values = getattr(self, name)
            if values is not None:
                getattr(message, name).CopyFrom(wire.encode(name, values, components=3, unit=unit))
        return message


@dataclass(frozen=True, eq=False)
class Exchange:
    """What a fluid gets from the particles, a row per cell or point of its mesh.

    Attributes:
        from_time_s: start of the window over which the sources are means.
        time_s: now, its end.
        void_fraction: 1 less the part of the cell that particles fill, now, (n,). Not cut at 0: cells smaller than a
            particle can be overfilled where the smoothing length is small.
        solid_velocity_m_per_s: mean over the solid in the cell, now, (n, 3); 0 where there is none.
        interaction_n_per_m3: force on the fluid by drag, lift and added mass over the volume of the cell, (n, 3).
        pressure_force_n_per_m3: force on the particles by the given pressure gradient, likewise, (n, 3).
        drag_kg_per_m3_s: by how much the interaction opposes a change of the fluid's velocity, (n,).
        seen_velocity_m_per_s: of the fluid at the end of the window, as the particles saw it, (n, 3); set by who gave
            it to them. A solver that finds u instead may count on interaction + drag (seen - u).
        totals: sums over the particles: ``solid_volume_m3``, ``immersed_volume_m3``, ``outside`` (particles wholly
            outside of the mesh), ``impulse_on_fluid_n_s``, ``pressure_impulse_n_s``, ``buoyancy_impulse_n_s`` (on the
            particles), ``momentum_kg_m_per_s``, ``refreshes``.
    """

    from_time_s: float
    time_s: float
    void_fraction: NDArray[np.float64]
    solid_velocity_m_per_s: NDArray[np.float64]
    interaction_n_per_m3: NDArray[np.float64]
    pressure_force_n_per_m3: NDArray[np.float64]
    drag_kg_per_m3_s: NDArray[np.float64]
    totals: dict[str, Any] = field(default_factory=dict)
    seen_velocity_m_per_s: NDArray[np.float64] | None = None

    @classmethod
    def from_message(cls, message: data_pb2.ExchangeFrame) -> Exchange:
        """From the wire."""
        column = {column.name: wire.decode(column) for column in message.columns}
        vectors = ("impulse_on_fluid_n_s", "pressure_impulse_n_s", "buoyancy_impulse_n_s", "momentum_kg_m_per_s")
        numbers = ("solid_volume_m3", "immersed_volume_m3", "outside", "refreshes")
        totals: dict[str, Any] = {name: getattr(message, name) for name in numbers}
        totals.update({name: wire.from_vec3(getattr(message, name)) for name in vectors})
        return cls(
            from_time_s=message.from_time_s,
            time_s=message.header.sim_time_s,
            void_fraction=column["void_fraction"],
            solid_velocity_m_per_s=column["solid_velocity"],
            interaction_n_per_m3=column["interaction"],
            pressure_force_n_per_m3=column["pressure_force"],
            drag_kg_per_m3_s=column["drag"],
            totals=totals,
        )
