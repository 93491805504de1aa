//! Particles as surfaces or as points.

use sturz_protocol::columns;
use sturz_protocol::v1;

use super::exporter::ExportError;
use super::geometry::{Bounds, Rotation, Vector, add, norm};
use super::table::Table;
use super::vtk::{Array, CellKind, Cells, PolyData, Precision, Values};

/// A shape at scale 1, in the body frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// m
    pub vertices: Vec<Vector>,
    /// Counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// About the centre of mass, m.
    pub bounding_radius: f64,
}

impl Surface {
    /// Of the wire.
    pub fn read(shape: &v1::Shape) -> Result<Self, ExportError> {
        let bad = |what: String| ExportError::Message(format!("shape {:?}: {what}", shape.name));
        let (Some(vertices), Some(triangles)) = (&shape.vertices, &shape.triangles) else {
            return Err(bad("has no surface".into()));
        };
        let vertices = columns::read_floats::<3>(vertices).map_err(|error| bad(format!("vertices: {error}")))?;
        let triangles = columns::read::<u32, 3>(triangles).map_err(|error| bad(format!("triangles: {error}")))?;
        if let Some(index) = triangles.iter().flatten().find(|&&index| index as usize >= vertices.len()) {
            return Err(bad(format!("a triangle has vertex {index} of {}", vertices.len())));
        }
        Ok(Self { vertices, triangles, bounding_radius: shape.bounding_radius_m })
    }
}

/// The columns of a frame.
pub struct Particles {
    ids: Vec<[u64; 1]>,
    shapes: Vec<[u32; 1]>,
    materials: Option<Vec<[u32; 1]>>,
    scales: Option<Vec<[f64; 1]>>,
    /// Centres of mass, m.
    pub positions: Vec<Vector>,
    orientations: Option<Vec<[f64; 4]>>,
    velocities: Option<Vec<Vector>>,
    angular_velocities: Option<Vec<Vector>>,
    forces: Option<Vec<Vector>>,
}

impl Particles {
    /// Proves the shapes to be those of `surfaces`.
    pub fn read(frame: &v1::Frame, surfaces: &[Surface]) -> Result<Self, ExportError> {
        let table = Table { what: "frame", rows: frame.n as usize, columns: &frame.columns };
        let particles = Self {
            ids: table.needed("ids", table.numbers("ids")?)?,
            shapes: table.needed("shapes", table.numbers("shapes")?)?,
            materials: table.numbers("materials")?,
            scales: table.floats("scales")?,
            positions: table.needed("positions", table.floats("positions")?)?,
            orientations: table.floats("orientations")?,
            velocities: table.floats("velocities")?,
            angular_velocities: table.floats("angular_velocities")?,
            forces: table.floats("forces")?,
        };
        match particles.shapes.iter().find(|[shape]| *shape as usize >= surfaces.len()) {
            Some([shape]) => {
                Err(ExportError::Message(format!("a particle has shape {shape}; {} are known", surfaces.len())))
            }
            None => Ok(particles),
        }
    }

    fn len(&self) -> usize {
        self.ids.len()
    }

    fn scale(&self, row: usize) -> f64 {
        self.scales.as_ref().map_or(1.0, |scales| scales[row][0])
    }

    /// Radius of the ball about the centre of mass that holds the particle, m.
    fn radius(&self, row: usize, surfaces: &[Surface]) -> f64 {
        self.scale(row) * surfaces[self.shapes[row][0] as usize].bounding_radius
    }

    /// Takes all particles into `bounds`.
    pub fn bound(&self, surfaces: &[Surface], bounds: &mut Bounds) {
        (0..self.len()).for_each(|row| bounds.take(self.positions[row], self.radius(row, surfaces)));
    }

    /// Row of an id; ids ascend.
    pub fn row_of(&self, id: u64) -> Option<usize> {
        self.ids.binary_search(&[id]).ok()
    }

    /// The surface of each, with its data at each of its points.
    pub fn surfaces(&self, surfaces: &[Surface], precision: Precision) -> PolyData {
        let (mut points, mut rows, mut cells) = (Vec::new(), Vec::new(), Cells::default());
        for row in 0..self.len() {
            let surface = &surfaces[self.shapes[row][0] as usize];
            let rotation = Rotation::new(self.orientations.as_ref().map_or([1.0, 0.0, 0.0, 0.0], |all| all[row]));
            let (centre, scale, first) = (self.positions[row], self.scale(row), points.len() as i32);
            points.extend(surface.vertices.iter().map(|&vertex| add(centre, scale, rotation.of(vertex))));
            rows.resize(points.len(), row);
            surface.triangles.iter().for_each(|corners| cells.push(corners.map(|corner| first + corner as i32)));
        }
        PolyData {
            points: precision.vectors(points.into_iter()),
            kind: CellKind::Polys,
            cells,
            point_data: self.data(&rows, precision),
            cell_data: Vec::new(),
        }
    }

    /// A point for each, with what a glyph needs: orientation (w, x, y, z), scale and radius.
    pub fn points(&self, surfaces: &[Surface], precision: Precision) -> PolyData {
        let rows: Vec<usize> = (0..self.len()).collect();
        let mut cells = Cells::default();
        rows.iter().for_each(|&row| cells.push([row as i32]));
        let mut point_data = self.data(&rows, precision);
        if let Some(orientations) = &self.orientations {
            let values = precision.values(orientations.iter().flatten().copied());
            point_data.push(Array { name: "orientation".into(), components: 4, values });
        }
        let per_row = |of: &dyn Fn(usize) -> f64| precision.values(rows.iter().map(|&row| of(row)));
        point_data.push(Array::scalar("scale", per_row(&|row| self.scale(row))));
        point_data.push(Array::scalar("bounding_radius", per_row(&|row| self.radius(row, surfaces))));
        let points = precision.vectors(self.positions.iter().copied());
        PolyData { points, kind: CellKind::Verts, cells, point_data, cell_data: Vec::new() }
    }

    /// What is known of the particle of each of `rows`.
    fn data(&self, rows: &[usize], precision: Precision) -> Vec<Array> {
        let mut data = vec![
            Array::scalar("id", Values::I64(rows.iter().map(|&row| self.ids[row][0] as i64).collect())),
            Array::scalar("shape", Values::I32(rows.iter().map(|&row| self.shapes[row][0] as i32).collect())),
        ];
        if let Some(materials) = &self.materials {
            let values = rows.iter().map(|&row| materials[row][0] as i32).collect();
            data.push(Array::scalar("material", Values::I32(values)));
        }
        for (name, column) in
            [("velocity", &self.velocities), ("angular_velocity", &self.angular_velocities), ("force", &self.forces)]
        {
            if let Some(column) = column {
                data.push(Array::vector(name, precision.vectors(rows.iter().map(|&row| column[row]))));
            }
        }
        if let Some(velocities) = &self.velocities {
            let speeds: Vec<f64> = velocities.iter().map(|&velocity| norm(velocity)).collect();
            data.push(Array::scalar("speed", precision.values(rows.iter().map(|&row| speeds[row]))));
        }
        data
    }
}
