//! Shapes in the files of other programs.

use thiserror::Error;

use super::description::{MassDescription, ShapeDescription};

/// A shape of a file, under its name there.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportedShape {
    /// As in the file.
    pub name: String,
    /// To be checked by [`super::Shape::build`].
    pub description: ShapeDescription,
}

/// Why a shape file was refused; lines count from 1.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ImportError {
    /// The file ends inside a shape.
    #[error("the file ends where {expected} should follow")]
    End {
        /// What is missing.
        expected: String,
    },
    /// A word where a number should be.
    #[error("line {line}: '{found}' where {expected} should be")]
    Unexpected {
        /// Where.
        line: usize,
        /// The word.
        found: String,
        /// What should be there.
        expected: String,
    },
    /// A shape without an entry that it needs.
    #[error("shape '{name}' that ends at line {line} has no {what}")]
    Missing {
        /// Its end.
        line: usize,
        /// Its name.
        name: String,
        /// The entry.
        what: &'static str,
    },
    /// A lone vertex is a sphere, which must be centred.
    #[error("shape '{name}' that ends at line {line} is a sphere off its centre of mass")]
    OffCentre {
        /// Its end.
        line: usize,
        /// Its name.
        name: String,
    },
}

/// Shapes of a Rockable `.shp` file.
///
/// Each lies between `<` and `>`: `name`, `radius` (Minkowski), `volume` and `I/m` (used if `preCompDone y`), `nv`, `ne`
/// and `nf` with as many vertices, edges (two indices) and faces (count, then indices). Other keys are skipped.
/// Vertices are about the centre of mass, in principal axes. Format: V. Richefeu et al., Rockable, `Shape::read`.
pub fn rockable_shapes(text: &str) -> Result<Vec<ImportedShape>, ImportError> {
    let mut words = Words::of(text);
    let mut shapes = Vec::new();
    while let Some((line, word)) = words.next() {
        if word == "<" {
            shapes.push(rockable_shape(&mut words)?);
        } else {
            return Err(ImportError::Unexpected { line, found: word.into(), expected: "'<'".into() });
        }
    }
    Ok(shapes)
}

/// Words of a text with their lines.
struct Words<'t> {
    words: Vec<(usize, &'t str)>,
    next: usize,
}

impl<'t> Words<'t> {
    fn of(text: &'t str) -> Self {
        let in_line = |(k, line): (usize, &'t str)| line.split_whitespace().map(move |word| (k + 1, word));
        Self { words: text.lines().enumerate().flat_map(in_line).collect(), next: 0 }
    }

    fn next(&mut self) -> Option<(usize, &'t str)> {
        let word = self.words.get(self.next).copied();
        self.next += 1;
        word
    }

    fn word(&mut self, expected: &str) -> Result<&'t str, ImportError> {
        self.next().map(|(_, word)| word).ok_or_else(|| ImportError::End { expected: expected.into() })
    }

    fn number<T: std::str::FromStr>(&mut self, expected: &str) -> Result<T, ImportError> {
        let (line, word) = self.next().ok_or_else(|| ImportError::End { expected: expected.into() })?;
        word.parse().map_err(|_| ImportError::Unexpected { line, found: word.into(), expected: expected.into() })
    }

    fn vector(&mut self, expected: &str) -> Result<[f64; 3], ImportError> {
        Ok([self.number(expected)?, self.number(expected)?, self.number(expected)?])
    }

    /// A count, and as many entries: never more memory than the file has words.
    fn list<T>(
        &mut self,
        what: &str,
        entry: impl Fn(&mut Self) -> Result<T, ImportError>,
    ) -> Result<Vec<T>, ImportError> {
        let count: usize = self.number(what)?;
        (0..count).map(|_| entry(self)).collect()
    }

    fn skip_numbers(&mut self) {
        while self.words.get(self.next).is_some_and(|(_, word)| word.parse::<f64>().is_ok()) {
            self.next += 1;
        }
    }

    fn line(&self) -> usize {
        self.words.get(self.next.saturating_sub(1)).map_or(0, |(line, _)| *line)
    }
}

/// What has been read of one shape.
#[derive(Default)]
struct Entries {
    name: String,
    radius: Option<f64>,
    computed: bool,
    volume: Option<f64>,
    inertia: Option<[f64; 3]>,
    vertices: Vec<[f64; 3]>,
    edges: Vec<[u32; 2]>,
    faces: Vec<Vec<u32>>,
}

fn rockable_shape(words: &mut Words<'_>) -> Result<ImportedShape, ImportError> {
    let mut entries = Entries::default();
    loop {
        match words.word("'>'")? {
            ">" => return entries.shape(words.line()),
            "name" => entries.name = words.word("a name")?.into(),
            "radius" => entries.radius = Some(words.number("a radius")?),
            "preCompDone" => entries.computed = words.word("y or n")? == "y",
            "volume" => entries.volume = Some(words.number("a volume")?),
            "I/m" => entries.inertia = Some(words.vector("a moment of inertia")?),
            "nv" => entries.vertices = words.list("a number of vertices", |w| w.vector("a coordinate"))?,
            "ne" => {
                let edge = |w: &mut Words<'_>| Ok([w.number("a vertex")?, w.number("a vertex")?]);
                entries.edges = words.list("a number of edges", edge)?;
            }
            "nf" => {
                let face = |w: &mut Words<'_>| w.list("a number of vertices", |w| w.number("a vertex"));
                entries.faces = words.list("a number of faces", face)?;
            }
            _ => words.skip_numbers(),
        }
    }
}

impl Entries {
    fn shape(self, line: usize) -> Result<ImportedShape, ImportError> {
        let name = self.name.clone();
        let missing = |what| ImportError::Missing { line, name: name.clone(), what };
        let radius_m = self.radius.ok_or_else(|| missing("radius"))?;
        if self.vertices.is_empty() {
            return Err(missing("vertices (nv)"));
        }
        let mass_properties = match (self.computed, self.volume, self.inertia) {
            (true, Some(volume_m3), Some(inertia_over_mass_m2)) => {
                Some(MassDescription { volume_m3, inertia_over_mass_m2 })
            }
            _ => None,
        };
        let description = match self.vertices[..] {
            [x] if x == [0.0; 3] => ShapeDescription::Sphere { radius_m },
            [_] => return Err(ImportError::OffCentre { line, name }),
            _ if self.edges.is_empty() && self.faces.is_empty() => return Err(missing("edges or faces (ne, nf)")),
            _ => ShapeDescription::RoundedPolyhedron {
                radius_m,
                vertices_m: self.vertices,
                edges: self.edges,
                faces: self.faces,
                mass_properties,
            },
        };
        Ok(ImportedShape { name, description })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Shape;

    const TETRAHEDRON: &str = "<\nname T\nradius 0.1\nobb.extent 1 1 1\npreCompDone n\nnv 4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n\
                               ne 6\n0 1\n0 2\n0 3\n1 2\n2 3\n3 1\nnf 4\n3 0 1 2\n3 0 1 3\n3 0 2 3\n3 1 2 3\n>\n";

    /// The skeleton keeps the file's numbering, and its mass is that of the hull of its points.
    #[test]
    fn a_tetrahedron_is_read_and_built() {
        let shapes = rockable_shapes(&TETRAHEDRON.repeat(2)).unwrap();
        assert_eq!(shapes.len(), 2);
        assert_eq!(shapes[1].name, "T");
        let shape = Shape::build(&shapes[0].description).unwrap();
        let skeleton = shape.parts()[0].skeleton.as_ref().unwrap();
        assert_eq!((skeleton.edges()[5].vertices, skeleton.faces().len()), ([3, 1], 4));
        assert!(skeleton.is_convex());
        let ShapeDescription::RoundedPolyhedron { vertices_m, .. } = &shapes[0].description else { panic!() };
        let hull = Shape::build(&ShapeDescription::rounded_hull(vertices_m.clone(), 0.1)).unwrap();
        let off = shape.mass_properties().volume / hull.mass_properties().volume - 1.0;
        assert!(off.abs() < 1e-14, "{off}");
    }

    #[test]
    fn errors_name_line_and_remedy() {
        let error = |text: &str| rockable_shapes(text).unwrap_err().to_string();
        assert_eq!(error("name"), "line 1: 'name' where '<' should be");
        assert_eq!(error(&TETRAHEDRON.replace("1 0 0", "1 x 0")), "line 8: 'x' where a coordinate should be");
        assert_eq!(error(&TETRAHEDRON.replace("radius 0.1\n", "")), "shape 'T' that ends at line 22 has no radius");
        assert_eq!(error("<\nnv 99999999999\n0 0"), "the file ends where a coordinate should follow");
        assert!(error(&TETRAHEDRON.replace('>', "")).contains("the file ends"));
        let open = TETRAHEDRON.replace("nf 4\n3 0 1 2\n", "nf 3\n");
        let open = Shape::build(&rockable_shapes(&open).unwrap()[0].description).unwrap_err().to_string();
        assert!(open.starts_with("mass_properties: are needed"), "{open}");
        let bad = TETRAHEDRON.replace("3 1 2 3", "3 1 2 9");
        let bad = Shape::build(&rockable_shapes(&bad).unwrap()[0].description).unwrap_err().to_string();
        assert!(bad.starts_with("faces[3]"), "{bad}");
    }
}
