"""Beds in water for the scripts of flow through them: scenes, sphericities, and the laws that they are compared to."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sturz import Box, Simulation
from sturz.coupling import ColumnSolver, Exchange, Fluid, StructuredMesh

WATER, VISCOSITY, GLASS, GRAVITY = 1000.0, 1e-3, 2500.0, 9.81
# volume of the grains: that of a sphere of 1 mm
DIAMETER_M = 1e-3
VOLUME_M3 = math.pi / 6 * DIAMETER_M**3


@dataclass(frozen=True)
class Grain:
    """A shape of the volume of a sphere of 1 mm.

    Attributes:
        geometry: as in a scene file.
        sphericity: surface of the sphere of the same volume over its own.
    """

    geometry: str
    sphericity: float


def _box(x: float, y: float, z: float) -> str:
    return f'{{ kind = "box", size_m = [{x!r}, {y!r}, {z!r}] }}'


def grains() -> dict[str, Grain]:
    """Sphere, cube and a cross of three bars four times as long as wide."""
    side = VOLUME_M3 ** (1 / 3)
    # three bars l x w x w with l = 4 w share a cube: volume 3 l w^2 - 2 w^3 = 10 w^3, surface 6 w^2 + 12 w (l - w)
    width = (VOLUME_M3 / 10) ** (1 / 3)
    surface = 6 * width**2 + 12 * width * 3 * width
    bars = [_box(4 * width, width, width), _box(width, 4 * width, width), _box(width, width, 4 * width)]
    parts = ", ".join(f"{{ shape = {bar} }}" for bar in bars)
    sphere = math.pi * DIAMETER_M**2
    return {
        "sphere": Grain(f'{{ kind = "sphere", radius_m = {DIAMETER_M / 2!r} }}', 1.0),
        "cube": Grain(_box(side, side, side), sphere / (6 * side**2)),
        "cross": Grain(f'{{ kind = "composite", parts = [{parts}] }}', sphere / surface),
    }


def scene(name: str, grain: Grain, *, width_m: float, stiffness: float = 20.0) -> str:
    """A floor in a cell that is periodic across; grains come by command. A collision takes 35 steps."""
    step_s = math.pi * math.sqrt(0.5 * GLASS * VOLUME_M3 / stiffness) / 35
    return f"""
[scene]
name = "{name}"
gravity_m_per_s2 = [0.0, 0.0, -{GRAVITY}]
time_step_s = {step_s!r}
seed = 1
[domain]
min_m = [0.0, 0.0, 0.0]
max_m = [{width_m!r}, {width_m!r}, 0.0]
periodic = [true, true, false]
[[material]]
name = "glass"
density_kg_per_m3 = {GLASS}
[[material_pair]]
materials = ["glass", "glass"]
stiffness_n_per_m = {stiffness}
restitution = 0.3
friction = 0.3
[[shape]]
name = "grain"
geometry = {grain.geometry}
[[boundary]]
name = "floor"
material = "glass"
geometry = {{ kind = "plane", point_m = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0] }}
"""


def column(width_m: float, height_m: float, cells: int) -> StructuredMesh:
    """One cell across, `cells` along z."""
    spacing = (width_m, width_m, height_m / cells)
    return StructuredMesh((0.0, 0.0, 0.0), spacing, (1, 1, cells), sides=("periodic", "periodic", ("closed", "open")))


def ergun(void: float, superficial: float, sphericity: float = 1.0) -> float:
    """Pressure gradient, Pa/m (Ergun, Chem. Eng. Prog. 48 (1952) 89)."""
    d = sphericity * DIAMETER_M
    viscous = 150 * VISCOSITY * (1 - void) ** 2 * superficial / (void**3 * d**2)
    return viscous + 1.75 * WATER * (1 - void) * superficial**2 / (void**3 * d)


def minimum_fluidisation(void: float, sphericity: float = 1.0) -> float:
    """Superficial velocity at which Ergun's gradient is the buoyant weight, m/s."""
    weight = (1 - void) * (GLASS - WATER) * GRAVITY
    low, high = 0.0, 1.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if ergun(void, middle, sphericity) < weight else (low, middle)
    return low


def wen_yu() -> float:
    """The same by Wen and Yu, AIChE J. 12 (1966) 610, m/s."""
    archimedes = WATER * (GLASS - WATER) * GRAVITY * DIAMETER_M**3 / VISCOSITY**2
    return (math.sqrt(33.7**2 + 0.0408 * archimedes) - 33.7) * VISCOSITY / (WATER * DIAMETER_M)


def inside(
    solver: ColumnSolver, exchange: Exchange, low: float, high: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Void fractions and pressure gradients (Pa/m) of the cells of a bed between two parts of its height."""
    z = solver.mesh.centres()[:, 2]
    top = bed_height(solver, exchange)
    cells = (z > low * top) & (z < high * top)
    gradient = solver.fields().pressure_gradient_pa_per_m
    assert gradient is not None
    return exchange.void_fraction[cells], -gradient[cells, 2]


def bed_height(solver: ColumnSolver, exchange: Exchange) -> float:
    """Height at which a bed of the void fraction of its middle would hold all the solid, m."""
    z = solver.mesh.centres()[:, 2]
    solid = 1.0 - exchange.void_fraction
    centre = float((solid * z).sum() / solid.sum())
    # a uniform bed is twice as high as its centre of mass
    middle = solid[(z > 0.5 * centre) & (z < 1.4 * centre)].mean()
    return float(solid.sum() * solver.mesh.spacing_m[2] / middle)


def poured(simulation: Simulation, count: int, width_m: float, height_m: float) -> None:
    """Grains at random orientations, loosely on the floor."""
    region = Box((0.0, 0.0, 0.0), (width_m, width_m, height_m))
    simulation.insert_deposition(shape="grain", material="glass", region=region, count=count)


def settle_in_water(simulation: Simulation, seconds: float) -> None:
    """Still water, so that the grains sink and rest without bouncing."""
    simulation.set_fluid(Fluid(WATER, VISCOSITY, buoyancy=True, void_fraction=0.6, voidage="gidaspow"))
    simulation.advance(window_s=seconds)


def richardson_zaki(reynolds: float) -> float:
    """Exponent n of u = v_t e^n (Richardson and Zaki, Trans. Inst. Chem. Eng. 32 (1954) 35, without walls)."""
    if reynolds < 0.2:
        return 4.65
    if reynolds < 1:
        return 4.35 * reynolds**-0.03
    if reynolds < 500:
        return 4.45 * reynolds**-0.1
    return 2.39


def terminal_speed() -> float:
    """Of the sphere in water by Schiller and Naumann, m/s."""
    low, high = 0.0, 1.0
    weight = (GLASS - WATER) * GRAVITY * VOLUME_M3
    for _ in range(200):
        v = 0.5 * (low + high)
        reynolds = WATER * v * DIAMETER_M / VISCOSITY
        drag = 3 * math.pi * VISCOSITY * DIAMETER_M * v * (1 + 0.15 * reynolds**0.687)
        low, high = (v, high) if drag < weight else (low, v)
    return low
