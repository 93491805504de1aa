"""Loads on particles from outside."""

from __future__ import annotations

from dataclasses import dataclass

from numpy.typing import ArrayLike

from . import columns as wire
from ._proto.sturz.v1 import command_pb2, data_pb2


@dataclass(frozen=True)
class Loads:
    """Loads from outside: a force and a torque per particle, and the linearised pair of a drag.

    On a particle of velocity v and angular velocity w act the force f + K (u - v) and the torque t + L (q - w); K and L
    may be as large as you like. What is absent is 0 for all.

    Attributes:
        topology_epoch: of the state that the ids are from (`state.header.topology_epoch`); with another one than the
            present the loads are refused.
        ids: each particle once, (n,).
        force_n: f, (n, 3), N.
        torque_n_m: t, (n, 3), N m, world axes.
        drag_n_s_per_m: K, (n,), N s/m.
        fluid_velocity_m_per_s: u, (n, 3), m/s.
        rotational_drag_n_m_s: L, (n,), N m s.
        fluid_angular_velocity_rad_per_s: q, (n, 3), rad/s, world axes.
        ramp_s: the loads before change linearly into these over this time; 0: at once.
        valid_until_s: simulated time until which they act; without end when absent.
    """

    topology_epoch: int
    ids: ArrayLike = ()
    force_n: ArrayLike | None = None
    torque_n_m: ArrayLike | None = None
    drag_n_s_per_m: ArrayLike | None = None
    fluid_velocity_m_per_s: ArrayLike | None = None
    rotational_drag_n_m_s: ArrayLike | None = None
    fluid_angular_velocity_rad_per_s: ArrayLike | None = None
    ramp_s: float = 0.0
    valid_until_s: float | None = None

    def to_message(self) -> command_pb2.Loads:
        """For the wire."""
        message = command_pb2.Loads(topology_epoch=self.topology_epoch, ramp_s=self.ramp_s)
        message.ids.CopyFrom(wire.encode("ids", self.ids, components=1, dtype=data_pb2.DATA_TYPE_U64))
        for name, values, components, unit in (
            ("force_n", self.force_n, 3, "N"),
            ("torque_n_m", self.torque_n_m, 3, "N m"),
            ("drag_n_s_per_m", self.drag_n_s_per_m, 1, "N s/m"),
            ("fluid_velocity_m_per_s", self.fluid_velocity_m_per_s, 3, "m/s"),
            ("rotational_drag_n_m_s", self.rotational_drag_n_m_s, 1, "N m s"),
            ("fluid_angular_velocity_rad_per_s", self.fluid_angular_velocity_rad_per_s, 3, "rad/s"),
        ):
            if values is not None:
                column = wire.encode(name, values, components=components, unit=unit)
                getattr(message, name).CopyFrom(column)
        if self.valid_until_s is not None:
            message.valid_until_s = self.valid_until_s
        return message
