//! The fluid around the particles.

use sturz_client::{FluidFields, v1};
use sturz_protocol::columns;

use crate::border::{column, rows, shared};
use crate::code::sturz_code;
use crate::failure::{Failure, guard};
use crate::simulation::{connection, sturz_simulation};

/// Drag of one particle in a fluid without others, as docs/hydrodynamics.md has it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum sturz_drag {
    /// Haider and Levenspiel.
    Default = 0,
    /// No drag.
    None = 1,
    /// 3 pi mu d, for Reynolds numbers below 0.1.
    Stokes = 2,
    /// Schiller and Naumann 1935: spheres.
    SchillerNaumann = 3,
    /// Haider and Levenspiel 1989: by sphericity.
    HaiderLevenspiel = 4,
    /// Ganser 1993: by sphericity.
    Ganser = 5,
    /// Hoelzer and Sommerfeld 2008: by orientation.
    HolzerSommerfeld = 6,
}

/// How the drag changes among other particles.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum sturz_voidage {
    /// Di Felice.
    Default = 0,
    /// Not at all.
    None = 1,
    /// Di Felice 1994: a factor of the law of one particle.
    DiFelice = 2,
    /// Gidaspow 1994: Ergun's law in beds, Wen and Yu's above; instead of the law of one particle.
    Gidaspow = 3,
    /// Tenneti, Garg and Subramaniam 2011.
    Tenneti = 4,
    /// Beetstra, van der Hoef and Kuipers 2007; instead of the law of one particle.
    Beetstra = 5,
}

/// Force across the flow.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum sturz_lift {
    /// None.
    None = 0,
    /// Saffman 1965 with Mei 1992: spheres in shear; needs the vorticity.
    SaffmanMei = 1,
    /// Hoerner 1965: bodies with an axis, by their angle to the flow.
    CrossFlow = 2,
}

/// Torque by drag that acts beside the centre of mass.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum sturz_pitching {
    /// None.
    None = 0,
    /// Rosendahl 2000: bodies with an axis.
    Rosendahl = 1,
}

/// Torque against spin.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum sturz_rotational_drag {
    /// None.
    None = 0,
    /// pi mu d^3.
    Stokes = 1,
    /// Dennis, Singh and Ingham 1980.
    Dennis = 2,
}

/// What a structured mesh ends in.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum sturz_mesh_side {
    /// Closed.
    Default = 0,
    /// A wall: what is spread beyond it counts inside, mirrored.
    Closed = 1,
    /// Fluid ends there: particles are in it as far as they are inside.
    Open = 2,
    /// What leaves comes in at the other end; at both ends of an axis or at none.
    Periodic = 3,
}

/// Equal boxes. Values are means over a cell; x runs fastest: i + counts[0] * (j + counts[1] * k).
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct sturz_structured_mesh {
    /// Lowest corner, m.
    pub origin_m: [f64; 3],
    /// Sides of a cell, above 0, m.
    pub spacing_m: [f64; 3],
    /// Cells along each axis, at least 1.
    pub counts: [u32; 3],
    /// What each axis ends in at its low end: `enum sturz_mesh_side`.
    pub low_sides: [i32; 3],
    /// What each axis ends in at its high end.
    pub high_sides: [i32; 3],
}

/// Centres of the cells of any mesh, or its nodes. A particle further than the smoothing length from all is outside.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct sturz_point_mesh {
    /// n.
    pub count: u64,
    /// (n, 3), m.
    pub points_m: *const f64,
    /// (n): volume that belongs to each, above 0, m3.
    pub volumes_m3: *const f64,
}

/// A fluid for the particles to be in; docs/coupling.md has the equations. Start from zeros or from `sturz_fluid_default`,
/// and set density, viscosity and, for a solver, a mesh and the smoothing length.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct sturz_fluid {
    /// Above 0, kg/m3.
    pub density_kg_per_m3: f64,
    /// Dynamic, above 0, Pa s.
    pub viscosity_pa_s: f64,
    /// Everywhere, until fields come; without a mesh for good, m/s.
    pub velocity_m_per_s: [f64; 3],
    /// Where its values are: one of the two meshes. Both null: the same everywhere, and nobody answers for it.
    pub structured_mesh: *const sturz_structured_mesh,
    /// Instead of the structured one.
    pub point_mesh: *const sturz_point_mesh,
    /// Half-width of the kernel that spreads particles over the mesh, above 0 with a mesh and 0 without one, m. Two to three
    /// particle diameters are usual.
    pub smoothing_length_m: f64,
    /// Without a mesh: void fraction that the laws see, in (0, 1]. 0 means 1.
    pub void_fraction: f64,
    /// The laws see no void fraction below this, in (0, 1]. 0 means 0.2.
    pub least_void_fraction: f64,
    /// `enum sturz_drag`.
    pub drag: i32,
    /// `enum sturz_voidage`.
    pub voidage: i32,
    /// `enum sturz_lift`.
    pub lift: i32,
    /// `enum sturz_pitching`.
    pub pitching: i32,
    /// `enum sturz_rotational_drag`.
    pub rotational_drag: i32,
    /// Not 0 adds -density volume gravity: for a fluid whose pressure leaves the hydrostatic part out.
    pub buoyancy: i32,
    /// Added mass over the mass of the fluid displaced, at least 0: 1/2 for a sphere.
    pub added_mass_coefficient: f64,
    /// Steps between two looks at where the particles are in the mesh. 0: at the start of each window, and whenever one may
    /// have come further than a tenth of the smoothing length.
    pub refresh_steps: u64,
}

/// The fluid on its mesh: arrays with a row per cell or point, or null: 0 for all.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct sturz_fluid_fields {
    /// n, cells or points of the mesh.
    pub count: u64,
    /// (n, 3): between the particles, not averaged over the cell with them, m/s.
    pub velocity_m_per_s: *const f64,
    /// (n, 3), Pa/m.
    pub pressure_gradient_pa_per_m: *const f64,
    /// (n, 3): material derivative of the velocity, for the added mass, m/s2.
    pub acceleration_m_per_s2: *const f64,
    /// (n, 3): curl of the velocity, for lift and rotation, rad/s.
    pub vorticity_rad_per_s: *const f64,
    /// The fields before change linearly into these over this time, s: the window, for fields of its end. 0: at once.
    pub ramp_s: f64,
}

impl sturz_fluid_fields {
    /// As the client has them.
    ///
    /// # Safety
    /// Each array is null or has `count` rows.
    pub(crate) unsafe fn read(&self) -> Result<FluidFields, Failure> {
        let count = self.count;
        let gradient = self.pressure_gradient_pa_per_m;
        // SAFETY: the caller's word.
        unsafe {
            Ok(FluidFields {
                velocity_m_per_s: rows("fields.velocity_m_per_s", self.velocity_m_per_s, count)?,
                pressure_gradient_pa_per_m: rows("fields.pressure_gradient_pa_per_m", gradient, count)?,
                acceleration_m_per_s2: rows("fields.acceleration_m_per_s2", self.acceleration_m_per_s2, count)?,
                vorticity_rad_per_s: rows("fields.vorticity_rad_per_s", self.vorticity_rad_per_s, count)?,
                ramp_s: self.ramp_s,
            })
        }
    }
}

impl sturz_fluid {
    /// As the wire has it.
    ///
    /// # Safety
    /// Meshes are null or sound.
    unsafe fn read(&self) -> Result<v1::FluidDefinition, Failure> {
        let some = |value: f64| (value != 0.0).then_some(value);
        Ok(v1::FluidDefinition {
            density_kg_per_m3: self.density_kg_per_m3,
            viscosity_pa_s: self.viscosity_pa_s,
            velocity_m_per_s: Some(vec3(self.velocity_m_per_s)),
            // SAFETY: the caller's word.
            mesh: unsafe { self.mesh() }?,
            smoothing_length_m: some(self.smoothing_length_m),
            void_fraction: some(self.void_fraction),
            least_void_fraction: some(self.least_void_fraction),
            drag: kind::<v1::DragLaw>("fluid.drag", "sturz_drag", self.drag)?,
            voidage: kind::<v1::VoidageLaw>("fluid.voidage", "sturz_voidage", self.voidage)?,
            lift: kind::<v1::LiftLaw>("fluid.lift", "sturz_lift", self.lift)?,
            pitching: kind::<v1::PitchingLaw>("fluid.pitching", "sturz_pitching", self.pitching)?,
            rotational_drag: kind::<v1::RotationalDragLaw>(
                "fluid.rotational_drag",
                "sturz_rotational_drag",
                self.rotational_drag,
            )?,
            added_mass_coefficient: self.added_mass_coefficient,
            buoyancy: self.buoyancy != 0,
            refresh_steps: self.refresh_steps,
        })
    }

    /// # Safety
    /// Meshes are null or sound.
    unsafe fn mesh(&self) -> Result<Option<v1::fluid_definition::Mesh>, Failure> {
        use v1::fluid_definition::Mesh;
        // SAFETY: the caller's word.
        match (self.structured_mesh.is_null(), self.point_mesh.is_null()) {
            (true, true) => Ok(None),
            (false, true) => {
                unsafe { shared("fluid.structured_mesh", self.structured_mesh) }?.read().map(Mesh::Structured).map(Some)
            }
            (true, false) => unsafe { shared("fluid.point_mesh", self.point_mesh)?.read() }.map(Mesh::Points).map(Some),
            (false, false) => {
                Err(Failure::argument("fluid.point_mesh", "is given beside a structured mesh: one is allowed"))
            }
        }
    }
}

impl sturz_structured_mesh {
    fn read(&self) -> Result<v1::StructuredMesh, Failure> {
        let side = |end: &str, axis: usize, value: i32| {
            kind::<v1::MeshSide>(&format!("fluid.structured_mesh.{end}_sides[{axis}]"), "sturz_mesh_side", value)
        };
        let [count_x, count_y, count_z] = self.counts;
        let [x_low, y_low, z_low] = self.low_sides;
        let [x_high, y_high, z_high] = self.high_sides;
        Ok(v1::StructuredMesh {
            origin_m: Some(vec3(self.origin_m)),
            spacing_m: Some(vec3(self.spacing_m)),
            count_x,
            count_y,
            count_z,
            x_low: side("low", 0, x_low)?,
            x_high: side("high", 0, x_high)?,
            y_low: side("low", 1, y_low)?,
            y_high: side("high", 1, y_high)?,
            z_low: side("low", 2, z_low)?,
            z_high: side("high", 2, z_high)?,
        })
    }
}

impl sturz_point_mesh {
    /// # Safety
    /// Each array is null or has `count` rows.
    unsafe fn read(&self) -> Result<v1::PointMesh, Failure> {
        for (path, array) in [("points_m", self.points_m), ("volumes_m3", self.volumes_m3)] {
            if array.is_null() {
                return Err(Failure::argument(&format!("fluid.point_mesh.{path}"), "is null"));
            }
        }
        // SAFETY: the caller's word.
        let (points, volumes) = unsafe {
            let points = rows::<3>("fluid.point_mesh.points_m", self.points_m, self.count)?;
            (points, column("fluid.point_mesh.volumes_m3", self.volumes_m3, self.count)?)
        };
        Ok(v1::PointMesh {
            points_m: Some(columns::rows("points_m", "m", &points)),
            volumes_m3: Some(columns::flat("volumes_m3", "m3", 1, &volumes)),
        })
    }
}

/// A number that stands for one of `E`: C has no other check of it.
fn kind<E: TryFrom<i32>>(path: &str, of: &str, value: i32) -> Result<i32, Failure> {
    let known = E::try_from(value).is_ok();
    known.then_some(value).ok_or_else(|| Failure::argument(path, &format!("is {value}; must be one of enum {of}")))
}

fn vec3([x, y, z]: [f64; 3]) -> v1::Vec3 {
    v1::Vec3 { x, y, z }
}

/// A fluid with the usual laws written out (Haider and Levenspiel's drag, Di Felice's factor; no lift, no torques, no added
/// mass, no buoyancy), without density, viscosity and mesh, which have no default. Zeros mean the same.
#[unsafe(no_mangle)]
pub extern "C" fn sturz_fluid_default() -> sturz_fluid {
    sturz_fluid {
        density_kg_per_m3: 0.0,
        viscosity_pa_s: 0.0,
        velocity_m_per_s: [0.0; 3],
        structured_mesh: std::ptr::null(),
        point_mesh: std::ptr::null(),
        smoothing_length_m: 0.0,
        void_fraction: 1.0,
        least_void_fraction: 0.2,
        drag: sturz_drag::HaiderLevenspiel as i32,
        voidage: sturz_voidage::DiFelice as i32,
        lift: sturz_lift::None as i32,
        pitching: sturz_pitching::None as i32,
        rotational_drag: sturz_rotational_drag::None as i32,
        buoyancy: 0,
        added_mass_coefficient: 0.0,
        refresh_steps: 0,
    }
}

/// Puts a fluid around the particles, instead of the one before, with fields on its mesh; null for `fields`: the fluid's
/// velocity everywhere. Fields need a mesh.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_set_fluid(
    simulation: *const sturz_simulation,
    fluid: *const sturz_fluid,
    fields: *const sturz_fluid_fields,
) -> sturz_code {
    guard(|| {
        // SAFETY: the caller's word.
        let (connection, fluid, fields) = unsafe {
            let fluid = shared("fluid", fluid)?.read()?;
            let fields = if fields.is_null() { None } else { Some(shared("fields", fields)?.read()?) };
            (connection(simulation)?, fluid, fields)
        };
        connection.set_fluid(Some(fluid), fields).map(drop).map_err(Failure::from)
    })
}

/// Takes the fluid away.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_remove_fluid(simulation: *const sturz_simulation) -> sturz_code {
    // SAFETY: the caller's word.
    guard(|| unsafe { connection(simulation) }?.set_fluid(None, None).map(drop).map_err(Failure::from))
}
