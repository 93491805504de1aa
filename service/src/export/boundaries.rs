//! Boundaries where they are: what is infinite is cut to the particles.

use std::f64::consts::TAU;

use sturz_protocol::columns;
use sturz_protocol::v1::{self, boundary_info::Geometry};

use super::exporter::ExportError;
use super::geometry::{Bounds, HalfSpace, Rotation, Vector, add, cut, difference, dot, frame, unit};
use super::vtk::{Array, CellKind, Cells, PolyData, Precision, Values};

/// Sides of a cylinder.
const SIDES: u32 = 96;
/// Part of the diagonal of the particles that infinite boundaries reach beyond them.
const MARGIN: f64 = 0.05;

/// What a boundary is.
#[derive(Clone, Debug, PartialEq)]
pub enum Wall {
    /// Infinite plane.
    Plane,
    /// Infinite cylinder.
    Cylinder {
        /// m
        radius: f64,
    },
    /// In the frame of its vertices.
    Mesh {
        /// m
        vertices: Vec<Vector>,
        /// Indices.
        triangles: Vec<[u32; 3]>,
    },
    /// Of a kind that this program does not know.
    Unknown,
}

impl Wall {
    /// Of the wire.
    pub fn read(info: &v1::BoundaryInfo) -> Result<Self, ExportError> {
        let bad = |what: String| ExportError::Message(format!("boundary {:?}: {what}", info.name));
        Ok(match &info.geometry {
            Some(Geometry::Plane(_)) => Wall::Plane,
            Some(Geometry::CylinderInside(cylinder)) => Wall::Cylinder { radius: cylinder.radius_m },
            Some(Geometry::CylinderOutside(cylinder)) => Wall::Cylinder { radius: cylinder.radius_m },
            Some(Geometry::Mesh(mesh)) => {
                let (Some(vertices), Some(triangles)) = (&mesh.vertices, &mesh.triangles) else {
                    return Err(bad("its mesh is empty".into()));
                };
                let vertices = columns::read_floats::<3>(vertices).map_err(|error| bad(error.to_string()))?;
                let triangles = columns::read::<u32, 3>(triangles).map_err(|error| bad(error.to_string()))?;
                if let Some(index) = triangles.iter().flatten().find(|&&index| index as usize >= vertices.len()) {
                    return Err(bad(format!("a triangle has vertex {index} of {}", vertices.len())));
                }
                Wall::Mesh { vertices, triangles }
            }
            None => Wall::Unknown,
        })
    }
}

/// Where a boundary is now.
#[derive(Clone, Copy, Debug)]
struct Place {
    point: Vector,
    direction: Vector,
    rotation: Rotation,
}

impl Place {
    fn of(state: &v1::BoundaryState) -> Self {
        let vector = |v: &Option<v1::Vec3>| v.as_ref().map_or([0.0; 3], |v| [v.x, v.y, v.z]);
        let turned = state.orientation.as_ref().map_or([1.0, 0.0, 0.0, 0.0], |q| [q.w, q.x, q.y, q.z]);
        Self {
            point: vector(&state.point_m),
            direction: unit(vector(&state.direction)),
            rotation: Rotation::new(turned),
        }
    }
}

/// The extent of what is infinite: the periodic axes of the cell, and along the others all that particles and meshes have
/// taken in since the start, so that walls do not shrink from frame to frame.
#[derive(Clone, Debug)]
pub struct Extent {
    domain: v1::Domain,
    seen: Bounds,
}

impl Extent {
    /// Of nothing yet.
    pub fn new(domain: v1::Domain) -> Self {
        Self { domain, seen: Bounds::EMPTY }
    }

    /// Takes in particles, and boundaries that are finite somewhere.
    pub fn take(&mut self, particles: &Bounds, walls: &[Wall], states: &[v1::BoundaryState]) {
        if !particles.is_empty() {
            self.seen.take(particles.min, 0.0);
            self.seen.take(particles.max, 0.0);
        }
        for (wall, place) in walls.iter().zip(states.iter().map(Place::of)) {
            match wall {
                Wall::Mesh { vertices, .. } => {
                    for &vertex in vertices {
                        self.seen.take(add(place.point, 1.0, place.rotation.of(vertex)), 0.0);
                    }
                }
                // Across its axis; along it, it is infinite.
                Wall::Cylinder { radius } => {
                    for across in frame(place.direction) {
                        self.seen.take(add(place.point, *radius, across), 0.0);
                        self.seen.take(add(place.point, -radius, across), 0.0);
                    }
                }
                Wall::Plane | Wall::Unknown => {}
            }
        }
        self.take_planes(walls, states);
    }

    /// Takes in a point of each plane, the nearest one, so that no wall is outside however far the particles are from it.
    fn take_planes(&mut self, walls: &[Wall], states: &[v1::BoundaryState]) {
        for (_, place) in walls.iter().zip(states.iter().map(Place::of)).filter(|(wall, _)| **wall == Wall::Plane) {
            let nearest = match self.seen.is_empty() {
                true => place.point,
                false => {
                    let centre = self.seen.centre();
                    add(centre, -dot(difference(centre, place.point), place.direction), place.direction)
                }
            };
            self.seen.take(nearest, 0.0);
        }
    }

    fn bounds(&self) -> Bounds {
        let mut bounds = self.seen;
        if bounds.is_empty() {
            return bounds;
        }
        let diagonal = bounds.diagonal();
        let margin = if diagonal > 0.0 { MARGIN * diagonal } else { 1.0 };
        let periodic = [self.domain.periodic_x, self.domain.periodic_y, self.domain.periodic_z];
        let corner = |v: &Option<v1::Vec3>| v.as_ref().map_or([0.0; 3], |v| [v.x, v.y, v.z]);
        let (min, max) = (corner(&self.domain.min_m), corner(&self.domain.max_m));
        for axis in 0..3 {
            if periodic[axis] {
                (bounds.min[axis], bounds.max[axis]) = (min[axis], max[axis]);
            } else {
                bounds.min[axis] -= margin;
                bounds.max[axis] += margin;
            }
        }
        bounds
    }
}

/// All boundaries in their present states, one cell data row per polygon.
pub fn polygons(walls: &[Wall], states: &[v1::BoundaryState], extent: &Extent, precision: Precision) -> PolyData {
    let bounds = extent.bounds();
    let places: Vec<Place> = states.iter().map(Place::of).collect();
    let mut sheet = Sheet::default();
    for (index, (wall, place)) in walls.iter().zip(&places).enumerate() {
        sheet.boundary = index as i32;
        match wall {
            Wall::Plane => sheet.add_plane(place, &limits(walls, &places, &bounds, index), &bounds),
            Wall::Cylinder { radius } => {
                sheet.add_cylinder(place, *radius, &limits(walls, &places, &bounds, index), &bounds);
            }
            Wall::Mesh { vertices, triangles } => sheet.add_mesh(place, vertices, triangles),
            Wall::Unknown => {}
        }
    }
    let vector = |v: &Option<v1::Vec3>| v.as_ref().map_or([0.0; 3], |v| [v.x, v.y, v.z]);
    let of_boundary = |f: &dyn Fn(&v1::BoundaryState) -> [f64; 3]| {
        precision.vectors(sheet.boundaries.iter().map(|&boundary| f(&states[boundary as usize])))
    };
    let cell_data = vec![
        Array::scalar("boundary", Values::I32(sheet.boundaries.clone())),
        Array::vector("force", of_boundary(&|state| vector(&state.force_n))),
        Array::vector("torque", of_boundary(&|state| vector(&state.torque_n_m))),
    ];
    PolyData {
        points: precision.vectors(sheet.points.into_iter()),
        kind: CellKind::Polys,
        cells: sheet.cells,
        point_data: Vec::new(),
        cell_data,
    }
}

/// Half-spaces that the infinite boundary `index` is cut by: the extent, and the other planes, behind which no particle is.
fn limits(walls: &[Wall], places: &[Place], bounds: &Bounds, index: usize) -> Vec<HalfSpace> {
    let others = walls.iter().zip(places).enumerate();
    let planes = others.filter(|(other, (wall, _))| *other != index && **wall == Wall::Plane);
    let planes = planes.map(|(_, (_, place))| HalfSpace { point: place.point, normal: place.direction });
    bounds.half_spaces().into_iter().chain(planes).collect()
}

/// Polygons in the making.
#[derive(Default)]
struct Sheet {
    points: Vec<Vector>,
    cells: Cells,
    /// By cell.
    boundaries: Vec<i32>,
    boundary: i32,
}

impl Sheet {
    fn add(&mut self, polygon: &[Vector]) {
        if polygon.len() < 3 {
            return;
        }
        let first = self.points.len() as i32;
        self.points.extend_from_slice(polygon);
        self.cells.push(first..first + polygon.len() as i32);
        self.boundaries.push(self.boundary);
    }

    fn add_plane(&mut self, place: &Place, limits: &[HalfSpace], bounds: &Bounds) {
        let normal = place.direction;
        let [x, y] = frame(normal);
        let above = dot(difference(bounds.centre(), place.point), normal);
        let (centre, reach) = (add(bounds.centre(), -above, normal), bounds.diagonal());
        let corner = |i: f64, j: f64| add(add(centre, i * reach, x), j * reach, y);
        let square = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        // A parallel plane on the other side of this one cuts all of it away, which is right: nothing can be there.
        let polygon = limits.iter().fold(square, |polygon, limit| cut(&polygon, limit));
        self.add(&polygon);
    }

    fn add_cylinder(&mut self, place: &Place, radius: f64, limits: &[HalfSpace], bounds: &Bounds) {
        let axis = place.direction;
        let [x, y] = frame(axis);
        let middle = dot(difference(bounds.centre(), place.point), axis);
        let (centre, reach) = (add(place.point, middle, axis), bounds.diagonal());
        let rim = |k: u32| {
            let (sin, cos) = (TAU * f64::from(k) / f64::from(SIDES)).sin_cos();
            add(add(centre, radius * cos, x), radius * sin, y)
        };
        for k in 0..SIDES {
            let (here, next) = (rim(k), rim(k + 1));
            let strip =
                vec![add(here, -reach, axis), add(next, -reach, axis), add(next, reach, axis), add(here, reach, axis)];
            let polygon = limits.iter().fold(strip, |polygon, limit| cut(&polygon, limit));
            self.add(&polygon);
        }
    }

    fn add_mesh(&mut self, place: &Place, vertices: &[Vector], triangles: &[[u32; 3]]) {
        let first = self.points.len() as i32;
        self.points.extend(vertices.iter().map(|&vertex| add(place.point, 1.0, place.rotation.of(vertex))));
        for corners in triangles {
            self.cells.push(corners.map(|corner| first + corner as i32));
            self.boundaries.push(self.boundary);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(name: &str, point: Vector, normal: Vector) -> v1::BoundaryState {
        let wire = |[x, y, z]: Vector| Some(v1::Vec3 { x, y, z });
        v1::BoundaryState { name: name.into(), point_m: wire(point), direction: wire(normal), ..Default::default() }
    }

    fn corners(data: &PolyData, boundary: i32) -> Bounds {
        let Array { values: Values::I32(boundaries), .. } = &data.cell_data[0] else { panic!("indices are integers") };
        let Values::F64(points) = &data.points else { panic!("doubles were asked for") };
        let mut bounds = Bounds::EMPTY;
        let mut start = 0;
        for (cell, &end) in data.cells.offsets.iter().enumerate() {
            if boundaries[cell] == boundary {
                for &at in &data.cells.connectivity[start..end as usize] {
                    let at = 3 * at as usize;
                    bounds.take([points[at], points[at + 1], points[at + 2]], 0.0);
                }
            }
            start = end as usize;
        }
        bounds
    }

    #[test]
    fn the_walls_of_a_box_end_at_each_other() {
        let states = [
            plane("floor", [0.0, 0.0, -3.0], [0.0, 0.0, 1.0]),
            plane("left", [0.0; 3], [1.0, 0.0, 0.0]),
            plane("right", [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]),
        ];
        let walls = [Wall::Plane, Wall::Plane, Wall::Plane];
        let domain = v1::Domain { periodic_y: true, ..Default::default() };
        let (min, max) = (v1::Vec3 { x: 0.0, y: -1.0, z: 0.0 }, v1::Vec3 { x: 0.0, y: 2.0, z: 0.0 });
        let mut extent = Extent::new(v1::Domain { min_m: Some(min), max_m: Some(max), ..domain });
        let particles = Bounds { min: [0.2, 0.0, 0.1], max: [0.8, 1.0, 0.9] };
        extent.take(&particles, &walls, &states);
        let data = polygons(&walls, &states, &extent, Precision::Double);
        let floor = corners(&data, 0);
        let close = |a: Vector, b: Vector| (0..3).all(|axis| (a[axis] - b[axis]).abs() < 1e-12);
        assert!(close(floor.min, [0.0, -1.0, -3.0]) && close(floor.max, [1.0, 2.0, -3.0]), "{floor:?}");
        let left = corners(&data, 1);
        assert!((left.min[2] + 3.0).abs() < 1e-12 && left.max[2] > 0.9 && left.max[0].abs() < 1e-12, "{left:?}");
    }

    #[test]
    fn a_drum_is_as_long_as_its_periodic_cell() {
        let states = [plane("drum", [0.0; 3], [0.0, 1.0, 0.0])];
        let walls = [Wall::Cylinder { radius: 0.5 }];
        let (min, max) = (v1::Vec3::default(), v1::Vec3 { x: 0.0, y: 0.2, z: 0.0 });
        let domain = v1::Domain { min_m: Some(min), max_m: Some(max), periodic_y: true, ..Default::default() };
        let mut extent = Extent::new(domain);
        extent.take(&Bounds::EMPTY, &walls, &states);
        let data = polygons(&walls, &states, &extent, Precision::Double);
        let drum = corners(&data, 0);
        assert_eq!(data.cells.offsets.len(), SIDES as usize);
        assert!((drum.min[1], drum.max[1]) == (0.0, 0.2) && (drum.max[2] - 0.5).abs() < 1e-3, "{drum:?}");
    }

    #[test]
    fn a_mesh_moves_with_its_pose() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let mut state = plane("lifter", [0.0, 0.0, 2.0], [0.0, 0.0, 1.0]);
        state.orientation = Some(v1::Quaternion { w: half, x: 0.0, y: 0.0, z: half });
        let walls = [Wall::Mesh {
            vertices: vec![[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 0.0, 1.0]],
            triangles: vec![[0, 1, 2]],
        }];
        let data = polygons(&walls, &[state], &Extent::new(v1::Domain::default()), Precision::Double);
        let lifter = corners(&data, 0);
        let error = (lifter.min[1] - 1.0).abs() + (lifter.max[1] - 2.0).abs() + (lifter.max[2] - 3.0).abs();
        assert!(error < 1e-12, "{lifter:?}");
    }
}
