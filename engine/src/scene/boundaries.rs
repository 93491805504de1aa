//! Boundaries of a scene: what is wrong with them, and what the engine starts with.

use super::validate::{Problems, material_index};
use super::{AngularVelocity, BoundaryDescription, BoundaryGeometry, BoxSide, MotionDescription, SceneDescription};
use crate::boundary::{Boundary, WallShape};
use crate::cell::Cell;
use crate::error::InvalidInput;
use crate::mesh::Mesh;

/// Axis and direction of the normal of each side, and what is put behind the name of its box.
const SIDES: [(BoxSide, usize, f64, &str); 6] = [
    (BoxSide::LowerX, 0, 1.0, "x-"),
    (BoxSide::UpperX, 0, -1.0, "x+"),
    (BoxSide::LowerY, 1, 1.0, "y-"),
    (BoxSide::UpperY, 1, -1.0, "y+"),
    (BoxSide::LowerZ, 2, 1.0, "z-"),
    (BoxSide::UpperZ, 2, -1.0, "z+"),
];

/// Puts the planes of each box in its place; returns where in the scene file each boundary comes from.
pub(super) fn expand_boxes(description: &mut SceneDescription, problems: &mut Problems) -> Vec<usize> {
    let (mut expanded, mut origins) = (Vec::new(), Vec::new());
    for (k, boundary) in std::mem::take(&mut description.boundaries).into_iter().enumerate() {
        let before = expanded.len();
        match &boundary.geometry {
            BoundaryGeometry::Box { min_m, max_m, open } => {
                let path = format!("boundary[{k}].geometry");
                problems.finite(&format!("{path}.min_m"), min_m);
                problems.finite(&format!("{path}.max_m"), max_m);
                if let Some(axis) = (0..3).find(|&axis| max_m[axis] <= min_m[axis]) {
                    problems.add(format!("{path}.max_m[{axis}]"), "must be above min_m");
                }
                if matches!(boundary.motion, MotionDescription::Servo { .. }) {
                    problems.add(
                        format!("boundary[{k}].motion"),
                        "is a servo: give it to one side of the box by a command",
                    );
                }
                expanded.extend(planes_of(&boundary, (min_m, max_m), open));
                if expanded.len() == before {
                    problems.add(format!("{path}.open"), "leaves no side");
                }
            }
            _ => expanded.push(boundary),
        }
        origins.resize(expanded.len(), k);
    }
    for (k, side) in expanded.iter().enumerate() {
        if expanded[..k].iter().any(|other| other.name == side.name) {
            problems.add(format!("boundary[{}].name", origins[k]), format!("'{}' is used twice", side.name));
        }
    }
    description.boundaries = expanded;
    origins
}

fn planes_of(
    boundary: &BoundaryDescription,
    (min_m, max_m): (&[f64; 3], &[f64; 3]),
    open: &[BoxSide],
) -> Vec<BoundaryDescription> {
    let closed = SIDES.iter().filter(|(side, ..)| !open.contains(side));
    closed
        .map(|&(_, axis, sign, suffix)| {
            let mut normal = [0.0; 3];
            normal[axis] = sign;
            // in the middle of the side: torques are about this point
            let mut point_m = [0, 1, 2].map(|axis| 0.5 * (min_m[axis] + max_m[axis]));
            point_m[axis] = if sign > 0.0 { min_m[axis] } else { max_m[axis] };
            BoundaryDescription {
                name: format!("{}/{suffix}", boundary.name),
                geometry: BoundaryGeometry::Plane { point_m, normal },
                ..boundary.clone()
            }
        })
        .collect()
}

/// The boundaries at time 0, or what is wrong with them; `origins` are those of [`expand_boxes`]. With `skeletons` meshes
/// can meet rounded polyhedra.
pub(super) fn build_boundaries(
    description: &SceneDescription,
    origins: &[usize],
    (cell, skeletons): (&Cell, bool),
    problems: &mut Problems,
) -> Vec<Boundary> {
    let mut boundaries = Vec::new();
    // elements of meshes are numbered over all meshes, after the boundaries
    let mut first_element = description.boundaries.len() as u32;
    for (boundary, k) in description.boundaries.iter().zip(origins) {
        let path = format!("boundary[{k}]");
        let before = problems.0.len();
        let material = material_index(description, &boundary.material, format!("{path}.material"), problems);
        check_geometry(&boundary.geometry, &format!("{path}.geometry"), problems);
        problems.keep(check_motion(&boundary.motion, &format!("{path}.motion")));
        if let (Some(material), true) = (material, problems.0.len() == before) {
            let mut boundary = Boundary::new(boundary, material as u32);
            if let BoundaryGeometry::Mesh { vertices_m, triangles } = &description.boundaries[boundaries.len()].geometry
            {
                match Mesh::build(vertices_m, triangles, skeletons) {
                    Ok(mesh) => first_element = boundary.set_mesh(mesh, first_element),
                    Err(error) => problems.add(format!("{path}.geometry.{}", error.key()), error.to_string()),
                }
            }
            problems.keep(check_in_cell(&boundary, cell, &path));
            boundaries.push(boundary);
        }
    }
    boundaries
}

fn check_geometry(geometry: &BoundaryGeometry, path: &str, problems: &mut Problems) {
    match geometry {
        BoundaryGeometry::Plane { point_m, normal } => {
            problems.finite(&format!("{path}.point_m"), point_m);
            problems.direction(&format!("{path}.normal"), normal);
        }
        BoundaryGeometry::MeshFile { path: file, .. } => {
            problems
                .add(format!("{path}.path"), format!("is '{file}': files are read together with a scene file only"));
        }
        // boxes are expanded already, and building a mesh checks it
        BoundaryGeometry::Box { .. } | BoundaryGeometry::Mesh { .. } => {}
        BoundaryGeometry::CylinderInside { point_m, axis, radius_m }
        | BoundaryGeometry::CylinderOutside { point_m, axis, radius_m } => {
            problems.finite(&format!("{path}.point_m"), point_m);
            problems.direction(&format!("{path}.axis"), axis);
            problems.in_range(&format!("{path}.radius_m"), *radius_m, "finite and above 0", *radius_m > 0.0);
        }
    }
}

/// A boundary must look the same in every image of the cell.
fn check_in_cell(boundary: &Boundary, cell: &Cell, path: &str) -> Result<(), InvalidInput> {
    for axis in (0..3).filter(|&axis| cell.periodic[axis]) {
        let along = boundary.direction()[axis].abs();
        let invariant = match boundary.shape {
            WallShape::Plane => along < 1e-12,
            WallShape::Mesh => boundary.mesh().is_none_or(|mesh| mesh.is_invariant_along(axis, cell)),
            WallShape::CylinderInside(_) | WallShape::CylinderOutside(_) => (along - 1.0).abs() < 1e-12,
        };
        if !invariant {
            let problem = format!(
                "is not the same in every periodic image along axis {axis}: a plane's normal must be perpendicular to it, a cylinder's axis parallel, and a mesh a profile along it that ends a quarter of the cell or more outside"
            );
            return Err(InvalidInput::new(path, problem));
        }
    }
    Ok(())
}

/// Checks the numbers of a motion.
pub(crate) fn check_motion(motion: &MotionDescription, path: &str) -> Result<(), InvalidInput> {
    let mut problems = Problems::default();
    match motion {
        MotionDescription::Fixed => {}
        MotionDescription::Translation { velocity_m_per_s } => {
            problems.finite(&format!("{path}.velocity_m_per_s"), velocity_m_per_s);
        }
        MotionDescription::Servo { .. } => check_servo(motion, path, &mut problems),
        MotionDescription::Rotation { point_m, axis, angular_velocity } => {
            problems.finite(&format!("{path}.point_m"), point_m);
            problems.direction(&format!("{path}.axis"), axis);
            check_angular_velocity(angular_velocity, &format!("{path}.angular_velocity"), &mut problems);
        }
        MotionDescription::Oscillation { amplitude_m, frequency_hz, phase_rad } => {
            problems.finite(&format!("{path}.amplitude_m"), amplitude_m);
            check_wave(*frequency_hz, *phase_rad, path, &mut problems);
        }
        MotionDescription::Table { times_s, displacements_m } => {
            check_table(times_s, displacements_m, path, &mut problems);
        }
    }
    problems.0.into_iter().next().map_or(Ok(()), Err)
}

fn check_angular_velocity(angular_velocity: &AngularVelocity, path: &str, problems: &mut Problems) {
    match *angular_velocity {
        AngularVelocity::Constant { rad_per_s } => problems.finite(&format!("{path}.rad_per_s"), &[rad_per_s]),
        AngularVelocity::Ramp { rad_per_s, duration_s } => {
            problems.finite(&format!("{path}.rad_per_s"), &[rad_per_s]);
            problems.in_range(&format!("{path}.duration_s"), duration_s, "finite and above 0", duration_s > 0.0);
        }
        AngularVelocity::Oscillation { amplitude_rad_per_s, frequency_hz, phase_rad } => {
            problems.finite(&format!("{path}.amplitude_rad_per_s"), &[amplitude_rad_per_s]);
            check_wave(frequency_hz, phase_rad, path, problems);
        }
    }
}

fn check_servo(motion: &MotionDescription, path: &str, problems: &mut Problems) {
    let MotionDescription::Servo { direction, force_n, pressure_pa, area_m2, gain_m_per_s_per_n, max_velocity_m_per_s } =
        motion
    else {
        return;
    };
    problems.direction(&format!("{path}.direction"), direction);
    match (force_n, pressure_pa, area_m2) {
        (Some(force), None, None) => problems.finite(&format!("{path}.force_n"), &[*force]),
        (None, Some(pressure), Some(area)) => {
            problems.finite(&format!("{path}.pressure_pa"), &[*pressure]);
            problems.in_range(&format!("{path}.area_m2"), *area, "finite and above 0", *area > 0.0);
        }
        _ => problems.add(format!("{path}.force_n"), "give force_n, or pressure_pa and area_m2"),
    }
    let above_0 = [("gain_m_per_s_per_n", *gain_m_per_s_per_n), ("max_velocity_m_per_s", *max_velocity_m_per_s)];
    for (key, value) in above_0 {
        problems.in_range(&format!("{path}.{key}"), value, "finite and above 0", value > 0.0);
    }
}

fn check_wave(frequency_hz: f64, phase_rad: f64, path: &str, problems: &mut Problems) {
    problems.in_range(&format!("{path}.frequency_hz"), frequency_hz, "finite and above 0", frequency_hz > 0.0);
    problems.finite(&format!("{path}.phase_rad"), &[phase_rad]);
}

fn check_table(times_s: &[f64], displacements_m: &[[f64; 3]], path: &str, problems: &mut Problems) {
    problems.finite(&format!("{path}.times_s"), times_s);
    for (k, displacement) in displacements_m.iter().enumerate() {
        problems.finite(&format!("{path}.displacements_m[{k}]"), displacement);
    }
    if times_s.len() < 2 || times_s.len() != displacements_m.len() {
        let (times, rows) = (times_s.len(), displacements_m.len());
        let problem = format!("has {rows} rows for {times} times; needs two or more, as many as times_s");
        problems.add(format!("{path}.displacements_m"), problem);
    } else if times_s[0] != 0.0 || displacements_m[0] != [0.0; 3] {
        problems.add(format!("{path}.times_s[0]"), "must be 0, with a displacement of (0, 0, 0)");
    }
    if let Some(k) = times_s.windows(2).position(|pair| pair[1] <= pair[0]) {
        problems.add(format!("{path}.times_s[{}]", k + 1), "must be later than the time before");
    }
}
