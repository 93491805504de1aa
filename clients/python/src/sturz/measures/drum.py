"""Which regime a rotating drum is in, from what its particles do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..contacts import Contacts
from ..state import State
from .bodies import Floats, rows_of

CENTRIFUGING_SLIP = 0.05
"""Mean difference to the drum's own motion, over the rim's speed, below which a bed goes round with it, as a ring or as
an entangled lump."""
FLYING_SHARE = 0.3
"""Share of particles without contact from which on a bed cataracts: a fast layer of hard balls has much of it, too."""
CASCADING_BEND = 0.05
"""Bend of the surface over the drum's radius from which on rolling is called cascading."""
INTERMITTENCE = 0.25
"""Deviation over mean of the mean speed in time from which on a bed avalanches."""


@dataclass(frozen=True, eq=False)
class DrumState:
    """Signatures of one state in a drum.

    Attributes:
        time_s: s.
        mean_speed: mean speed over that of the rim.
        slip: mean difference to the velocity of the drum at the same place, over the speed of the rim.
        flying: share of particles without any contact.
        centre_radius: distance of the centre of mass from the axis, over the radius.
        centre_angle_rad: of the centre of mass, from straight down, positive in the sense of rotation.
        bend: standard deviation of the free surface about its straight fit, over the radius; NaN where it is not found.
    """

    time_s: float
    mean_speed: float
    slip: float
    flying: float
    centre_radius: float
    centre_angle_rad: float
    bend: float


def drum_state(
    state: State,
    contacts: Contacts,
    masses_kg: ArrayLike,
    *,
    axis: ArrayLike,
    centre_m: ArrayLike,
    radius_m: float,
    angular_velocity_rad_per_s: float,
    columns: int = 20,
) -> DrumState:
    """Signatures of one state.

    Args:
        state, contacts: of the same step.
        masses_kg: (n,).
        axis: of the drum; it turns by the right-hand rule.
        centre_m: a point of the axis, (3,), m.
        radius_m: of the drum, m.
        angular_velocity_rad_per_s: above 0.
        columns: of the free surface.
    """
    if len(state) == 0:
        nothing = float("nan")
        return DrumState(state.time_s, nothing, nothing, nothing, nothing, nothing, nothing)
    along = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    down = state.gravity_m_per_s2 - along * (state.gravity_m_per_s2 @ along)
    down = down / np.linalg.norm(down)
    forward = np.cross(along, down)
    offset = np.asarray(state.positions_m, dtype=float) - np.asarray(centre_m, dtype=float)
    v = np.asarray(state.velocities_m_per_s, dtype=float)
    rim = angular_velocity_rad_per_s * radius_m
    rigid = angular_velocity_rad_per_s * np.cross(along, offset)
    across = v - rigid
    touched = np.zeros(len(state), dtype=bool)
    for side in (0, 1):
        ids = contacts.ids[:, side]
        present = ids <= state.ids[-1]
        touched[rows_of(state.ids, ids[present])] = True
    centre = np.average(offset, axis=0, weights=np.asarray(masses_kg, dtype=float))
    x, depth = float(centre @ forward), float(centre @ down)
    return DrumState(
        time_s=state.time_s,
        mean_speed=float(np.linalg.norm(v, axis=1).mean() / rim),
        slip=float(np.linalg.norm(across, axis=1).mean() / rim),
        flying=float(1.0 - touched.mean()),
        centre_radius=float(np.hypot(x, depth) / radius_m),
        centre_angle_rad=float(np.arctan2(x, depth)),
        bend=_bend(offset, forward, -down, radius_m, columns),
    )


def _bend(offset: Floats, along: Floats, up: Floats, radius: float, columns: int) -> float:
    """Deviation of the free surface about its straight fit, over the radius; of a column the third highest
    centre, so that single fliers do not count."""
    x, y = offset @ along, offset @ up
    edges = np.linspace(-0.7 * radius, 0.7 * radius, columns + 1)
    places, heights = [], []
    for k in range(columns):
        inside = np.flatnonzero((x >= edges[k]) & (x < edges[k + 1]))
        if len(inside) >= 3:
            places.append(0.5 * (edges[k] + edges[k + 1]))
            heights.append(float(np.sort(y[inside])[-3]))
    if len(places) < columns // 2:
        return float("nan")
    rest = np.array(heights) - np.polyval(np.polyfit(places, heights, 1), places)
    return float(rest.std() / radius)


@dataclass(frozen=True)
class DrumRegime:
    """Regime with the means of its signatures over the states.

    Attributes:
        regime: ``centrifuging``, ``cataracting``, ``cascading``, ``rolling`` or ``avalanching``.
        slip, flying, bend, centre_radius, mean_speed: means of `DrumState`.
        intermittence: deviation over mean of the mean speed in time.
        froude: rate^2 radius / g.
    """

    regime: str
    slip: float
    flying: float
    bend: float
    centre_radius: float
    mean_speed: float
    intermittence: float
    froude: float


def drum_regime(
    states: list[DrumState], *, angular_velocity_rad_per_s: float, radius_m: float, gravity_m_per_s2: float
) -> DrumRegime:
    """Regime of a steady drum, by thresholds that are constants of this module (a choice of this project).

    In this order: a bed that goes round with the drum is centrifuging; one of which `FLYING_SHARE` has no contact
    cataracts; one whose mean speed wavers by `INTERMITTENCE` avalanches; one with a bent surface cascades; else it
    rolls. Rakotonirina et al. 2019 name regimes from pictures: figures near a threshold prove nothing.

    Raises:
        ValueError: no states.
    """
    if not states:
        raise ValueError("no states of the drum are given")

    def mean(name: str) -> float:
        values = np.array([getattr(each, name) for each in states], dtype=float)
        return float(np.nanmean(values)) if np.isfinite(values).any() else float("nan")

    speeds = np.array([each.mean_speed for each in states])
    intermittence = float(speeds.std() / speeds.mean()) if speeds.mean() > 0.0 else float("nan")
    slip, flying, bend = mean("slip"), mean("flying"), mean("bend")
    if slip < CENTRIFUGING_SLIP:
        regime = "centrifuging"
    elif flying >= FLYING_SHARE:
        regime = "cataracting"
    elif intermittence >= INTERMITTENCE:
        regime = "avalanching"
    elif np.isfinite(bend) and bend >= CASCADING_BEND:
        regime = "cascading"
    else:
        regime = "rolling"
    froude = angular_velocity_rad_per_s**2 * radius_m / gravity_m_per_s2
    return DrumRegime(regime, slip, flying, bend, mean("centre_radius"), mean("mean_speed"), intermittence, froude)
