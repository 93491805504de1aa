//! What a client says of the fluid, and what is wrong with it.

use crate::checkpoint::codec::{Malformed, Pack, Reader, pack_fields};
use crate::error::InvalidInput;
use crate::hydrodynamics::{DragLaw, HydrodynamicLaws, LiftLaw, PitchingLaw, RotationalDragLaw, VoidageLaw};

/// What a mesh ends in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Side {
    /// A wall: what the kernel spreads beyond it counts inside, mirrored.
    #[default]
    Closed,
    /// Fluid ends there: particles are in it as far as they are inside.
    Open,
    /// What leaves comes in at the other side.
    Periodic,
}

/// Both ends of an axis; periodic at both or at none.
pub type AxisSides = [Side; 2];

/// Where the fluid's values are.
#[derive(Clone, Debug, PartialEq)]
pub enum MeshDescription {
    /// Equal boxes; values are means over a cell, x runs fastest: i + n_x (j + n_y k).
    Structured {
        /// Lowest corner, m.
        origin_m: [f64; 3],
        /// Sides of a cell, m.
        spacing_m: [f64; 3],
        /// Cells along each axis.
        counts: [u32; 3],
        /// By axis.
        sides: [AxisSides; 3],
    },
    /// Centres of the cells of any mesh, or its nodes, with the volume that belongs to each. A point of a particle that is
    /// further than the smoothing length from all of them is outside of the fluid.
    Points {
        /// m
        points_m: Vec<[f64; 3]>,
        /// m3
        volumes_m3: Vec<f64>,
    },
}

/// A fluid for the particles to be in.
#[derive(Clone, Debug, PartialEq)]
pub struct FluidDescription {
    /// kg/m3
    pub density_kg_per_m3: f64,
    /// Dynamic, Pa s.
    pub viscosity_pa_s: f64,
    /// Everywhere, until fields come; without a mesh for good, m/s.
    pub velocity_m_per_s: [f64; 3],
    /// Where its values are; `None`: a fluid that is the same everywhere and that nobody answers for.
    pub mesh: Option<MeshDescription>,
    /// Half-width of the kernel that spreads particles, m; with a mesh only.
    pub smoothing_length_m: Option<f64>,
    /// Without a mesh: void fraction that the laws see.
    pub void_fraction: f64,
    /// The laws see no void fraction below this.
    pub least_void_fraction: f64,
    /// Drag, lift, torque, added mass.
    pub laws: HydrodynamicLaws,
    /// Adds -rho V g: for a fluid whose pressure leaves the hydrostatic part out.
    pub buoyancy: bool,
    /// Steps between two looks at where the particles are; 0: whenever one may have come further than a tenth of the
    /// smoothing length.
    pub refresh_steps: u64,
}

impl Default for FluidDescription {
    fn default() -> Self {
        Self {
            density_kg_per_m3: 1000.0,
            viscosity_pa_s: 1e-3,
            velocity_m_per_s: [0.0; 3],
            mesh: None,
            smoothing_length_m: None,
            void_fraction: 1.0,
            least_void_fraction: 0.2,
            laws: HydrodynamicLaws::default(),
            buoyancy: false,
            refresh_steps: 0,
        }
    }
}

/// The fluid on its mesh, a row per cell or point. Empty columns are 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FluidFields {
    /// Interstitial, m/s.
    pub velocity_m_per_s: Vec<[f64; 3]>,
    /// Pa/m
    pub pressure_gradient_pa_per_m: Vec<[f64; 3]>,
    /// Material derivative of the velocity, m/s2: for the added mass.
    pub acceleration_m_per_s2: Vec<[f64; 3]>,
    /// Curl of the velocity, rad/s: for lift and rotation.
    pub vorticity_rad_per_s: Vec<[f64; 3]>,
    /// Velocity and vorticity change linearly from those before into these over this time from now on, then these are
    /// held, s; 0: at once. Pressure gradient and acceleration, being means over a window, always act at once.
    pub ramp_s: f64,
}

pack_fields!(FluidFields {
    velocity_m_per_s: Vec<[f64; 3]>,
    pressure_gradient_pa_per_m: Vec<[f64; 3]>,
    acceleration_m_per_s2: Vec<[f64; 3]>,
    vorticity_rad_per_s: Vec<[f64; 3]>,
    ramp_s: f64,
});
pack_fields!(FluidDescription {
    density_kg_per_m3: f64,
    viscosity_pa_s: f64,
    velocity_m_per_s: [f64; 3],
    mesh: Option<MeshDescription>,
    smoothing_length_m: Option<f64>,
    void_fraction: f64,
    least_void_fraction: f64,
    laws: HydrodynamicLaws,
    buoyancy: bool,
    refresh_steps: u64,
});

pack_fields!(HydrodynamicLaws {
    drag: DragLaw,
    voidage: VoidageLaw,
    lift: LiftLaw,
    pitching: PitchingLaw,
    rotational_drag: RotationalDragLaw,
    added_mass_coefficient: f64,
});

/// Choices as their places in a list that only ever grows at its end.
macro_rules! pack_choice {
    ($type:ty, $what:literal, [$($choice:expr),* $(,)?]) => {
        impl Pack for $type {
            const LEAST_BYTES: usize = 1;
            fn put(&self, out: &mut Vec<u8>) {
                let all = [$($choice),*];
                let place = all.iter().position(|choice| choice == self).unwrap_or(all.len());
                (place as u8).put(out);
            }
            fn get(from: &mut Reader<'_>) -> Result<Self, Malformed> {
                let place = usize::from(from.get::<u8>()?);
                [$($choice),*].get(place).copied().ok_or(Malformed($what))
            }
        }
    };
}

pack_choice!(Side, "has a side of unknown kind", [Side::Closed, Side::Open, Side::Periodic]);
pack_choice!(
    DragLaw,
    "has a drag law of unknown kind",
    [
        DragLaw::None,
        DragLaw::Stokes,
        DragLaw::SchillerNaumann,
        DragLaw::HaiderLevenspiel,
        DragLaw::Ganser,
        DragLaw::HolzerSommerfeld,
    ]
);
pack_choice!(
    VoidageLaw,
    "has a voidage law of unknown kind",
    [VoidageLaw::None, VoidageLaw::DiFelice, VoidageLaw::Gidaspow, VoidageLaw::Tenneti, VoidageLaw::Beetstra]
);
pack_choice!(LiftLaw, "has a lift law of unknown kind", [LiftLaw::None, LiftLaw::SaffmanMei, LiftLaw::CrossFlow]);
pack_choice!(PitchingLaw, "has a pitching law of unknown kind", [PitchingLaw::None, PitchingLaw::Rosendahl]);
pack_choice!(
    RotationalDragLaw,
    "has a rotational drag law of unknown kind",
    [RotationalDragLaw::None, RotationalDragLaw::Stokes, RotationalDragLaw::Dennis]
);

impl Pack for MeshDescription {
    const LEAST_BYTES: usize = 1;
    fn put(&self, out: &mut Vec<u8>) {
        match self {
            Self::Structured { origin_m, spacing_m, counts, sides } => {
                0u8.put(out);
                [*origin_m, *spacing_m].put(out);
                counts.put(out);
                sides.put(out);
            }
            Self::Points { points_m, volumes_m3 } => {
                1u8.put(out);
                points_m.put(out);
                volumes_m3.put(out);
            }
        }
    }
    fn get(from: &mut Reader<'_>) -> Result<Self, Malformed> {
        match from.get::<u8>()? {
            0 => {
                let [origin_m, spacing_m] = from.get()?;
                Ok(Self::Structured { origin_m, spacing_m, counts: from.get()?, sides: from.get()? })
            }
            1 => Ok(Self::Points { points_m: from.get()?, volumes_m3: from.get()? }),
            _ => Err(Malformed("has a mesh of unknown kind")),
        }
    }
}

/// Cells or points of a mesh.
const MOST_CELLS: u64 = 1 << 24;

fn error(path: &str, problem: String) -> InvalidInput {
    InvalidInput::new(format!("fluid.{path}"), problem)
}

fn check_positive(path: &str, value: f64) -> Result<(), InvalidInput> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(error(path, format!("is {value}; must be finite and above 0")))
    }
}

fn check_finite(path: &str, numbers: &[f64]) -> Result<(), InvalidInput> {
    match numbers.iter().position(|number| !number.is_finite()) {
        Some(at) => Err(error(&format!("{path}[{at}]"), format!("is {}; must be finite", numbers[at]))),
        None => Ok(()),
    }
}

impl MeshDescription {
    /// Cells or points.
    pub fn len(&self) -> usize {
        match self {
            Self::Structured { counts, .. } => counts.iter().map(|&n| n as usize).product(),
            Self::Points { points_m, .. } => points_m.len(),
        }
    }

    /// Whether it has none, which no checked one has.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn check(&self) -> Result<(), InvalidInput> {
        match self {
            Self::Structured { origin_m, spacing_m, counts, sides } => {
                check_finite("mesh.origin_m", origin_m)?;
                for (axis, &spacing) in spacing_m.iter().enumerate() {
                    check_positive(&format!("mesh.spacing_m[{axis}]"), spacing)?;
                }
                let cells = counts.iter().try_fold(1u64, |product, &n| product.checked_mul(u64::from(n)));
                if !cells.is_some_and(|cells| (1..=MOST_CELLS).contains(&cells)) {
                    let problem = format!("are {counts:?}; must be 1 or more each, {MOST_CELLS} cells at most");
                    return Err(error("mesh.counts", problem));
                }
                for (axis, [low, high]) in sides.iter().enumerate() {
                    if (*low == Side::Periodic) != (*high == Side::Periodic) {
                        return Err(error(&format!("mesh.sides[{axis}]"), "is periodic at one end only".into()));
                    }
                }
                Ok(())
            }
            Self::Points { points_m, volumes_m3 } => {
                if points_m.is_empty() || points_m.len() as u64 > MOST_CELLS {
                    let problem = format!("are {}; must be 1 to {MOST_CELLS}", points_m.len());
                    return Err(error("mesh.points_m", problem));
                }
                if points_m.len() != volumes_m3.len() {
                    let problem = format!("has {} rows for {} points", volumes_m3.len(), points_m.len());
                    return Err(error("mesh.volumes_m3", problem));
                }
                check_finite("mesh.points_m", points_m.as_flattened())?;
                match volumes_m3.iter().position(|volume| !(volume.is_finite() && *volume > 0.0)) {
                    Some(at) => check_positive(&format!("mesh.volumes_m3[{at}]"), volumes_m3[at]),
                    None => Ok(()),
                }
            }
        }
    }
}

/// Cells that the kernel of one point covers.
const MOST_COVERED: f64 = 20_000.0;
/// Weights of all particles together: some 2.4 GB.
const MOST_WEIGHTS: f64 = 2e8;

impl MeshDescription {
    /// Cells or points that a body of a bounding radius has weights in, about.
    fn covered(&self, radius: f64, length: f64) -> f64 {
        match self {
            Self::Structured { spacing_m, counts, .. } => {
                let along = |axis: usize| match counts[axis] {
                    1 => 1.0,
                    _ => 2.0 * (radius + length) / spacing_m[axis] + 2.0,
                };
                along(0) * along(1) * along(2)
            }
            Self::Points { points_m, .. } => {
                let ends = |axis: usize| {
                    let x = points_m.iter().map(|x| x[axis]);
                    x.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)))
                };
                let part = |axis: usize| {
                    let (low, high) = ends(axis);
                    if high > low { (2.0 * (radius + length) / (high - low)).min(1.0) } else { 1.0 }
                };
                points_m.len() as f64 * part(0) * part(1) * part(2)
            }
        }
    }

    fn check_reach(&self, length: f64) -> Result<(), InvalidInput> {
        let covered = self.covered(0.0, length);
        if covered > MOST_COVERED {
            let problem = format!("covers {covered:.0} cells or points; must cover {MOST_COVERED} at most");
            return Err(error("smoothing_length_m", problem));
        }
        Ok(())
    }

    /// Refuses a mesh too fine for particles of these bounding radii.
    pub(super) fn check_weights(&self, length: f64, radii: &[f64]) -> Result<(), InvalidInput> {
        let whole = self.len() as f64;
        let mut radii = radii.to_vec();
        radii.sort_unstable_by(f64::total_cmp);
        // of many particles of few sizes each size is reckoned once
        let sizes = radii.chunk_by(|a, b| a == b);
        let weights: f64 = sizes.map(|same| same.len() as f64 * self.covered(same[0], length).min(whole)).sum();
        if weights > MOST_WEIGHTS {
            let problem = format!(
                "is so fine that the particles would have some {weights:.1e} weights in it; at most {MOST_WEIGHTS:.1e} are \
                 allowed: make its cells larger"
            );
            return Err(error("mesh", problem));
        }
        Ok(())
    }
}

impl FluidDescription {
    /// Whether an engine can use it; the error names what is wrong.
    pub fn check(&self) -> Result<(), InvalidInput> {
        check_positive("density_kg_per_m3", self.density_kg_per_m3)?;
        check_positive("viscosity_pa_s", self.viscosity_pa_s)?;
        check_finite("velocity_m_per_s", &self.velocity_m_per_s)?;
        let fraction = |path: &str, value: f64| {
            let inside = value > 0.0 && value <= 1.0;
            inside.then_some(()).ok_or_else(|| error(path, format!("is {value}; must be above 0 and at most 1")))
        };
        fraction("void_fraction", self.void_fraction)?;
        fraction("least_void_fraction", self.least_void_fraction)?;
        let added = self.laws.added_mass_coefficient;
        if !(added.is_finite() && added >= 0.0) {
            return Err(error("added_mass_coefficient", format!("is {added}; must be finite and 0 or more")));
        }
        match (&self.mesh, self.smoothing_length_m) {
            (None, None) => Ok(()),
            (None, Some(_)) => Err(error("smoothing_length_m", "does nothing without a mesh".into())),
            (Some(_), None) => Err(error("smoothing_length_m", "is missing; a mesh needs one, above 0".into())),
            (Some(mesh), Some(length)) => {
                check_positive("smoothing_length_m", length)?;
                mesh.check()?;
                mesh.check_reach(length)
            }
        }
    }
}

impl FluidFields {
    /// Whether a mesh of `n` cells can have them; `path` is where they are in the request.
    pub fn check(&self, n: usize) -> Result<(), InvalidInput> {
        for (name, column) in [
            ("velocity_m_per_s", &self.velocity_m_per_s),
            ("pressure_gradient_pa_per_m", &self.pressure_gradient_pa_per_m),
            ("acceleration_m_per_s2", &self.acceleration_m_per_s2),
            ("vorticity_rad_per_s", &self.vorticity_rad_per_s),
        ] {
            let path = || format!("fluid_fields.{name}");
            if !column.is_empty() && column.len() != n {
                let problem = format!("has {} rows, the mesh {n} cells or points", column.len());
                return Err(InvalidInput::new(path(), problem));
            }
            if let Some(row) = column.iter().position(|row| row.iter().any(|number| !number.is_finite())) {
                let problem = format!("is {:?}; must be finite", column[row]);
                return Err(InvalidInput::new(format!("{}[{row}]", path()), problem));
            }
        }
        if !(self.ramp_s.is_finite() && self.ramp_s >= 0.0) {
            let problem = format!("is {}; must be finite and 0 or more", self.ramp_s);
            return Err(InvalidInput::new("fluid_fields.ramp_s", problem));
        }
        Ok(())
    }
}
