//! Report, boundaries and domain for the wire.

use sturz_engine::scene::{BoundaryDescription, BoundaryGeometry, DomainSection};
use sturz_engine::{EnergyBalance, Report, WarningCounts};

use super::vec3;
use crate::{columns, v1};

/// The engine's part of a report: what only the daemon knows (speed, stages, streams, hash) is left empty.
pub fn report_to_wire(report: &Report, mut header: v1::Header) -> v1::Report {
    header.step = report.step;
    header.sim_time_s = report.time_s;
    let [smooth, vertex_face, edge_edge] = report.contact_points_by_kind;
    v1::Report {
        header: Some(header),
        particles: report.particles,
        touching_pairs: report.touching_pairs,
        touching_boundary_pairs: report.touching_boundary_pairs,
        contact_points: report.contact_points,
        contact_points_smooth: smooth,
        contact_points_vertex_face: vertex_face,
        contact_points_edge_edge: edge_edge,
        neighbour_rebuilds: report.neighbour_rebuilds,
        energy: Some(energy_to_wire(&report.energy)),
        momentum_kg_m_per_s: Some(vec3(report.momentum_kg_m_per_s)),
        internal_force_residual_n: report.internal_force_residual_n,
        largest_overlap_m: report.largest_overlap_m,
        largest_overlap_ratio: report.largest_overlap_ratio,
        largest_overlap_over_rounding: report.largest_overlap_over_rounding,
        largest_overlap_ratio_so_far: report.largest_overlap_ratio_so_far,
        time_step_s: report.time_step_s,
        critical_time_step_s: report.critical_time_step_s,
        present_critical_time_step_s: report.present_critical_time_step_s,
        contact_duration_s: report.contact_duration_s,
        warnings: Some(warnings_to_wire(report.warnings)),
        ..Default::default()
    }
}

fn energy_to_wire(energy: &EnergyBalance) -> v1::EnergyBalance {
    v1::EnergyBalance {
        kinetic_translation_j: energy.kinetic_translation_j,
        kinetic_rotation_j: energy.kinetic_rotation_j,
        potential_j: energy.potential_j,
        elastic_j: energy.elastic_j,
        dissipated_normal_j: energy.dissipated_normal_j,
        dissipated_friction_j: energy.dissipated_friction_j,
        dissipated_local_j: energy.dissipated_local_j,
        work_boundaries_j: energy.work_boundaries_j,
        work_commands_j: energy.work_commands_j,
        residual_j: energy.residual_j,
        work_loads_j: energy.work_loads_j,
    }
}

fn warnings_to_wire(warnings: WarningCounts) -> v1::WarningCounts {
    v1::WarningCounts {
        rotation_not_converged: warnings.rotation_not_converged,
        large_overlap: warnings.large_overlap,
        fast_particle: warnings.fast_particle,
        deep_rounding: warnings.deep_rounding,
    }
}

/// A boundary as the scene has it.
pub fn boundary_to_wire(boundary: &BoundaryDescription) -> v1::BoundaryInfo {
    use v1::boundary_info::Geometry;
    let geometry = match &boundary.geometry {
        BoundaryGeometry::Plane { point_m, normal } => {
            Geometry::Plane(v1::PlaneGeometry { point_m: Some(vec3(*point_m)), normal: Some(vec3(*normal)) })
        }
        BoundaryGeometry::Mesh { vertices_m, triangles } => Geometry::Mesh(v1::MeshGeometry {
            vertices: Some(columns::rows("vertices", "m", vertices_m)),
            triangles: Some(columns::rows("triangles", "", triangles)),
        }),
        // a scene that has been proved usable has planes instead
        BoundaryGeometry::Box { .. } | BoundaryGeometry::MeshFile { .. } => return without_geometry(boundary),
        BoundaryGeometry::CylinderOutside { point_m, axis, radius_m } => {
            Geometry::CylinderOutside(v1::CylinderOutsideGeometry {
                point_m: Some(vec3(*point_m)),
                axis: Some(vec3(*axis)),
                radius_m: *radius_m,
            })
        }
        BoundaryGeometry::CylinderInside { point_m, axis, radius_m } => {
            Geometry::CylinderInside(v1::CylinderInsideGeometry {
                point_m: Some(vec3(*point_m)),
                axis: Some(vec3(*axis)),
                radius_m: *radius_m,
            })
        }
    };
    v1::BoundaryInfo { name: boundary.name.clone(), material: boundary.material.clone(), geometry: Some(geometry) }
}

fn without_geometry(boundary: &BoundaryDescription) -> v1::BoundaryInfo {
    v1::BoundaryInfo { name: boundary.name.clone(), material: boundary.material.clone(), geometry: None }
}

/// Extent and periodic axes.
pub fn domain_to_wire(domain: &DomainSection) -> v1::Domain {
    let [periodic_x, periodic_y, periodic_z] = domain.periodic;
    v1::Domain { min_m: Some(vec3(domain.min_m)), max_m: Some(vec3(domain.max_m)), periodic_x, periodic_y, periodic_z }
}
