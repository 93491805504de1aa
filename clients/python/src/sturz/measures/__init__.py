"""What a packing or a flow is like, in numbers, from the arrays of `State` and `Contacts`.

One file per question: `bodies` (masses), `statistics` (means with honest errors), `solid_fraction`, `stress`, `order`
(pair correlation, nematic order), `coarse` (fields along one axis), `network` (coordination, kinds of contacts),
`motion` (velocities, temperature, energy), `surface` (free surface and its angles), `avalanches`, `mixing`, `drum`
(regimes). Numpy is all they need. docs/measures.md says which is which.
"""

from .avalanches import Avalanches, bursts, drops
from .bodies import Bodies, bodies, densities_kg_per_m3, minimum_image
from .coarse import CoarseProfile, coarse_profile
from .drum import DrumRegime, DrumState, drum_regime, drum_state
from .mixing import MixingIndex, lacey_index
from .motion import (
    Distribution,
    EnergyPartition,
    Profile,
    distribution,
    energy_partition,
    granular_temperature,
    inertial_number,
    velocity_profile,
)
from .network import (
    ContactType,
    Coordination,
    TypeShares,
    contact_types,
    coordination,
    neighbour_pairs,
    type_shares,
    wall_neighbours,
)
from .order import NematicOrder, PairCorrelation, isotropic_order, nematic_order, pair_correlation
from .solid_fraction import (
    SolidFraction,
    enclosed_volume_m3,
    is_inside,
    monte_carlo_solid_fraction,
    solid_fraction_profile,
)
from .statistics import Mean, autocorrelation_function, block_mean, integrated_autocorrelation
from .stress import LayerStress, layer_stress, particle_contact_moments_j, rotation_moments_j
from .surface import Angle, FreeSurface, centre_of_mass_m, drum_angle, free_surface, surface_angle

__all__ = [
    "Angle",
    "Avalanches",
    "Bodies",
    "CoarseProfile",
    "ContactType",
    "Coordination",
    "Distribution",
    "DrumRegime",
    "DrumState",
    "EnergyPartition",
    "FreeSurface",
    "LayerStress",
    "Mean",
    "MixingIndex",
    "NematicOrder",
    "PairCorrelation",
    "Profile",
    "SolidFraction",
    "TypeShares",
    "autocorrelation_function",
    "block_mean",
    "bodies",
    "bursts",
    "centre_of_mass_m",
    "coarse_profile",
    "contact_types",
    "coordination",
    "densities_kg_per_m3",
    "distribution",
    "drops",
    "drum_angle",
    "drum_regime",
    "drum_state",
    "enclosed_volume_m3",
    "energy_partition",
    "free_surface",
    "granular_temperature",
    "inertial_number",
    "integrated_autocorrelation",
    "is_inside",
    "isotropic_order",
    "lacey_index",
    "layer_stress",
    "minimum_image",
    "monte_carlo_solid_fraction",
    "neighbour_pairs",
    "nematic_order",
    "pair_correlation",
    "particle_contact_moments_j",
    "rotation_moments_j",
    "solid_fraction_profile",
    "surface_angle",
    "type_shares",
    "velocity_profile",
    "wall_neighbours",
]
