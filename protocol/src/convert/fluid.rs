//! A fluid around the particles, from the wire; what it gets from them, to the wire.

use sturz_engine::coupling::{AxisSides, Side};
use sturz_engine::hydrodynamics::{DragLaw, HydrodynamicLaws, LiftLaw, PitchingLaw, RotationalDragLaw, VoidageLaw};
use sturz_engine::{Exchange, FluidDescription, FluidFields, InvalidInput, MeshDescription};

use super::loads::{flat, rows};
use super::{optional_vector, vec3};
use crate::columns;
use crate::v1;

/// Of `set_fluid`, under `path` in the request. Values are the engine's to check.
pub fn fluid_from_wire(fluid: &v1::FluidDefinition, path: &str) -> Result<FluidDescription, InvalidInput> {
    let usual = FluidDescription::default();
    let mesh = match &fluid.mesh {
        None => None,
        Some(v1::fluid_definition::Mesh::Structured(mesh)) => Some(structured(mesh, &format!("{path}.structured"))?),
        Some(v1::fluid_definition::Mesh::Points(points)) => {
            let path = format!("{path}.points");
            Some(MeshDescription::Points {
                points_m: rows(&points.points_m, &path, "points_m")?,
                volumes_m3: flat(&points.volumes_m3, &path, "volumes_m3")?,
            })
        }
    };
    Ok(FluidDescription {
        density_kg_per_m3: fluid.density_kg_per_m3,
        viscosity_pa_s: fluid.viscosity_pa_s,
        velocity_m_per_s: optional_vector(&fluid.velocity_m_per_s, &format!("{path}.velocity_m_per_s"))?,
        mesh,
        smoothing_length_m: fluid.smoothing_length_m,
        void_fraction: fluid.void_fraction.unwrap_or(usual.void_fraction),
        least_void_fraction: fluid.least_void_fraction.unwrap_or(usual.least_void_fraction),
        laws: laws(fluid, path)?,
        buoyancy: fluid.buoyancy,
        refresh_steps: fluid.refresh_steps,
    })
}

fn structured(mesh: &v1::StructuredMesh, path: &str) -> Result<MeshDescription, InvalidInput> {
    let spacing = mesh.spacing_m.as_ref();
    let spacing = spacing.ok_or_else(|| InvalidInput::new(format!("{path}.spacing_m"), "is missing"))?;
    let side = |value: i32, name: &str| match v1::MeshSide::try_from(value) {
        Ok(v1::MeshSide::Unspecified | v1::MeshSide::Closed) => Ok(Side::Closed),
        Ok(v1::MeshSide::Open) => Ok(Side::Open),
        Ok(v1::MeshSide::Periodic) => Ok(Side::Periodic),
        Err(_) => Err(unknown(value, &format!("{path}.{name}"))),
    };
    let axis = |low: i32, high: i32, name: &str| -> Result<AxisSides, InvalidInput> {
        Ok([side(low, &format!("{name}_low"))?, side(high, &format!("{name}_high"))?])
    };
    Ok(MeshDescription::Structured {
        origin_m: optional_vector(&mesh.origin_m, &format!("{path}.origin_m"))?,
        spacing_m: [spacing.x, spacing.y, spacing.z],
        counts: [mesh.count_x, mesh.count_y, mesh.count_z],
        sides: [
            axis(mesh.x_low, mesh.x_high, "x")?,
            axis(mesh.y_low, mesh.y_high, "y")?,
            axis(mesh.z_low, mesh.z_high, "z")?,
        ],
    })
}

fn unknown(value: i32, path: &str) -> InvalidInput {
    InvalidInput::new(path, format!("is {value}: no such value"))
}

fn laws(fluid: &v1::FluidDefinition, path: &str) -> Result<HydrodynamicLaws, InvalidInput> {
    let at = |name: &str| format!("{path}.{name}");
    let drag = match v1::DragLaw::try_from(fluid.drag) {
        Ok(v1::DragLaw::None) => DragLaw::None,
        Ok(v1::DragLaw::Stokes) => DragLaw::Stokes,
        Ok(v1::DragLaw::SchillerNaumann) => DragLaw::SchillerNaumann,
        Ok(v1::DragLaw::Unspecified | v1::DragLaw::HaiderLevenspiel) => DragLaw::HaiderLevenspiel,
        Ok(v1::DragLaw::Ganser) => DragLaw::Ganser,
        Ok(v1::DragLaw::HolzerSommerfeld) => DragLaw::HolzerSommerfeld,
        Err(_) => return Err(unknown(fluid.drag, &at("drag"))),
    };
    let voidage = match v1::VoidageLaw::try_from(fluid.voidage) {
        Ok(v1::VoidageLaw::None) => VoidageLaw::None,
        Ok(v1::VoidageLaw::Unspecified | v1::VoidageLaw::DiFelice) => VoidageLaw::DiFelice,
        Ok(v1::VoidageLaw::Gidaspow) => VoidageLaw::Gidaspow,
        Ok(v1::VoidageLaw::Tenneti) => VoidageLaw::Tenneti,
        Ok(v1::VoidageLaw::Beetstra) => VoidageLaw::Beetstra,
        Err(_) => return Err(unknown(fluid.voidage, &at("voidage"))),
    };
    let lift = match v1::LiftLaw::try_from(fluid.lift) {
        Ok(v1::LiftLaw::Unspecified) => LiftLaw::None,
        Ok(v1::LiftLaw::SaffmanMei) => LiftLaw::SaffmanMei,
        Ok(v1::LiftLaw::CrossFlow) => LiftLaw::CrossFlow,
        Err(_) => return Err(unknown(fluid.lift, &at("lift"))),
    };
    let pitching = match v1::PitchingLaw::try_from(fluid.pitching) {
        Ok(v1::PitchingLaw::Unspecified) => PitchingLaw::None,
        Ok(v1::PitchingLaw::Rosendahl) => PitchingLaw::Rosendahl,
        Err(_) => return Err(unknown(fluid.pitching, &at("pitching"))),
    };
    let rotational_drag = match v1::RotationalDragLaw::try_from(fluid.rotational_drag) {
        Ok(v1::RotationalDragLaw::Unspecified) => RotationalDragLaw::None,
        Ok(v1::RotationalDragLaw::Stokes) => RotationalDragLaw::Stokes,
        Ok(v1::RotationalDragLaw::Dennis) => RotationalDragLaw::Dennis,
        Err(_) => return Err(unknown(fluid.rotational_drag, &at("rotational_drag"))),
    };
    let added_mass_coefficient = fluid.added_mass_coefficient;
    Ok(HydrodynamicLaws { drag, voidage, lift, pitching, rotational_drag, added_mass_coefficient })
}

/// Of `advance`, under `path` in the request.
pub fn fluid_fields_from_wire(fields: &v1::FluidFields, path: &str) -> Result<FluidFields, InvalidInput> {
    Ok(FluidFields {
        velocity_m_per_s: rows(&fields.velocity_m_per_s, path, "velocity_m_per_s")?,
        pressure_gradient_pa_per_m: rows(&fields.pressure_gradient_pa_per_m, path, "pressure_gradient_pa_per_m")?,
        acceleration_m_per_s2: rows(&fields.acceleration_m_per_s2, path, "acceleration_m_per_s2")?,
        vorticity_rad_per_s: rows(&fields.vorticity_rad_per_s, path, "vorticity_rad_per_s")?,
        ramp_s: fields.ramp_s,
    })
}

/// The header's `sim_time_s` is overwritten.
pub fn exchange_to_wire(exchange: &Exchange, mut header: v1::Header) -> v1::ExchangeFrame {
    header.sim_time_s = exchange.time_s;
    header.step = exchange.step;
    header.topology_epoch = exchange.topology_epoch;
    let totals = &exchange.totals;
    v1::ExchangeFrame {
        header: Some(header),
        from_time_s: exchange.from_time_s,
        columns: vec![
            columns::flat("void_fraction", "", 1, &exchange.void_fraction),
            columns::rows("solid_velocity", "m/s", &exchange.solid_velocity_m_per_s),
            columns::rows("interaction", "N/m3", &exchange.interaction_n_per_m3),
            columns::rows("pressure_force", "N/m3", &exchange.pressure_force_n_per_m3),
            columns::flat("drag", "kg/(m3 s)", 1, &exchange.drag_kg_per_m3_s),
        ],
        solid_volume_m3: totals.solid_volume_m3,
        immersed_volume_m3: totals.immersed_volume_m3,
        outside: totals.outside,
        impulse_on_fluid_n_s: Some(vec3(totals.impulse_on_fluid_n_s)),
        pressure_impulse_n_s: Some(vec3(totals.pressure_impulse_n_s)),
        buoyancy_impulse_n_s: Some(vec3(totals.buoyancy_impulse_n_s)),
        momentum_kg_m_per_s: Some(vec3(totals.momentum_kg_m_per_s)),
        refreshes: totals.refreshes,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_out_is_as_usual_and_unknown_values_are_named() {
        let fluid = v1::FluidDefinition { density_kg_per_m3: 1.2, viscosity_pa_s: 1.8e-5, ..Default::default() };
        let read = fluid_from_wire(&fluid, "fluid").unwrap();
        let wanted = FluidDescription {
            density_kg_per_m3: 1.2,
            viscosity_pa_s: 1.8e-5,
            laws: HydrodynamicLaws {
                drag: DragLaw::HaiderLevenspiel,
                voidage: VoidageLaw::DiFelice,
                lift: LiftLaw::None,
                pitching: PitchingLaw::None,
                rotational_drag: RotationalDragLaw::None,
                added_mass_coefficient: 0.0,
            },
            ..FluidDescription::default()
        };
        assert_eq!(read, wanted);
        let unknown = fluid_from_wire(&v1::FluidDefinition { lift: 77, ..fluid.clone() }, "fluid").unwrap_err();
        assert_eq!(unknown.path, "fluid.lift");
        let mesh = v1::StructuredMesh { spacing_m: Some(vec3([1.0; 3])), z_high: 9, ..Default::default() };
        let mesh = Some(v1::fluid_definition::Mesh::Structured(mesh));
        let unknown = fluid_from_wire(&v1::FluidDefinition { mesh, ..fluid }, "fluid").unwrap_err();
        assert_eq!(unknown.path, "fluid.structured.z_high");
    }
}
