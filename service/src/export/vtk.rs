//! VTK's XML files: polygonal data (.vtp) and images (.vti), little-endian.
//!
//! Not crate vtkio: its stable version writes no compressed and no appended data, and holds a model of every kind of VTK file.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;

use crate::cli::Encoding;

/// Uncompressed bytes that are compressed at a time.
const BLOCK: usize = 1 << 18;

/// Numbers of an array.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// `Float32`
    F32(Vec<f32>),
    /// `Float64`
    F64(Vec<f64>),
    /// `Int32`
    I32(Vec<i32>),
    /// `Int64`
    I64(Vec<i64>),
}

impl Values {
    fn type_name(&self) -> &'static str {
        match self {
            Values::F32(_) => "Float32",
            Values::F64(_) => "Float64",
            Values::I32(_) => "Int32",
            Values::I64(_) => "Int64",
        }
    }

    fn bytes(&self) -> Vec<u8> {
        match self {
            Values::F32(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
            Values::F64(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
            Values::I32(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
            Values::I64(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
        }
    }

    fn text(&self) -> String {
        match self {
            Values::F32(values) => joined(values),
            Values::F64(values) => joined(values),
            Values::I32(values) => joined(values),
            Values::I64(values) => joined(values),
        }
    }
}

fn joined<T: ToString>(values: &[T]) -> String {
    values.iter().map(T::to_string).collect::<Vec<_>>().join(" ")
}

/// Whether floats are written with 32 or 64 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// 32 bits
    Single,
    /// 64 bits
    Double,
}

impl Precision {
    /// Floats of this precision.
    pub fn values(self, numbers: impl Iterator<Item = f64>) -> Values {
        match self {
            Precision::Single => Values::F32(numbers.map(|number| number as f32).collect()),
            Precision::Double => Values::F64(numbers.collect()),
        }
    }

    /// Rows of three floats.
    pub fn vectors(self, rows: impl Iterator<Item = [f64; 3]>) -> Values {
        self.values(rows.flatten())
    }
}

/// A named array of rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Such as `velocity`.
    pub name: Cow<'static, str>,
    /// Numbers per row.
    pub components: usize,
    /// Row-major.
    pub values: Values,
}

impl Array {
    /// One number per row.
    pub fn scalar(name: &'static str, values: Values) -> Self {
        Self { name: name.into(), components: 1, values }
    }

    /// Three numbers per row.
    pub fn vector(name: &'static str, values: Values) -> Self {
        Self { name: name.into(), components: 3, values }
    }
}

/// Cells as lists of points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cells {
    /// Points of all cells.
    pub connectivity: Vec<i32>,
    /// By cell: the end of its points.
    pub offsets: Vec<i32>,
}

impl Cells {
    /// Adds a cell.
    pub fn push(&mut self, points: impl IntoIterator<Item = i32>) {
        self.connectivity.extend(points);
        self.offsets.push(self.connectivity.len() as i32);
    }
}

/// Points, and cells of one kind on them.
#[derive(Clone, Debug)]
pub struct PolyData {
    /// Rows of three.
    pub points: Values,
    /// Kind of the cells.
    pub kind: CellKind,
    /// The cells.
    pub cells: Cells,
    /// One row per point.
    pub point_data: Vec<Array>,
    /// One row per cell.
    pub cell_data: Vec<Array>,
}

/// What the cells are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellKind {
    /// Single points.
    Verts,
    /// Lines.
    Lines,
    /// Plane polygons.
    Polys,
}

/// A regular grid with values at its cells.
#[derive(Clone, Debug)]
pub struct ImageData {
    /// Lower corner, m.
    pub origin: [f64; 3],
    /// Of a cell, m.
    pub spacing: [f64; 3],
    /// Cells along x, y, z.
    pub cells: [u32; 3],
    /// One row per cell, x fastest.
    pub cell_data: Vec<Array>,
}

/// Writes polygonal data of simulated time `time_s`.
pub fn write_poly(path: &Path, encoding: Encoding, time_s: f64, data: &PolyData) -> io::Result<()> {
    let PolyData { points, kind, cells, point_data, cell_data } = data;
    let count = |of| if *kind == of { cells.offsets.len() } else { 0 };
    let rows = match points {
        Values::F32(values) => values.len(),
        Values::F64(values) => values.len(),
        Values::I32(values) => values.len(),
        Values::I64(values) => values.len(),
    } / 3;
    let mut file = Document::new("PolyData", encoding);
    file.open("PolyData", "");
    file.time(time_s);
    let [verts, lines, polys] = [count(CellKind::Verts), count(CellKind::Lines), count(CellKind::Polys)];
    file.open(
        "Piece",
        &format!(
            r#" NumberOfPoints="{rows}" NumberOfVerts="{verts}" NumberOfLines="{lines}" NumberOfStrips="0" NumberOfPolys="{polys}""#
        ),
    );
    file.arrays("PointData", point_data);
    file.arrays("CellData", cell_data);
    file.open("Points", "");
    file.array("Points", 3, points);
    file.close("Points");
    for (of, name) in [(CellKind::Verts, "Verts"), (CellKind::Lines, "Lines"), (CellKind::Polys, "Polys")] {
        if *kind == of {
            file.open(name, "");
            file.array("connectivity", 1, &Values::I32(cells.connectivity.clone()));
            file.array("offsets", 1, &Values::I32(cells.offsets.clone()));
            file.close(name);
        }
    }
    file.close("Piece");
    file.close("PolyData");
    file.write(path)
}

/// Writes an image of simulated time `time_s`.
pub fn write_image(path: &Path, encoding: Encoding, time_s: f64, image: &ImageData) -> io::Result<()> {
    let [x, y, z] = image.cells;
    let mut file = Document::new("ImageData", encoding);
    let (origin, spacing) = (joined(&image.origin), joined(&image.spacing));
    let extent = format!("0 {x} 0 {y} 0 {z}");
    file.open("ImageData", &format!(r#" WholeExtent="{extent}" Origin="{origin}" Spacing="{spacing}""#));
    file.time(time_s);
    file.open("Piece", &format!(r#" Extent="{extent}""#));
    file.arrays("CellData", &image.cell_data);
    file.close("Piece");
    file.close("ImageData");
    file.write(path)
}

/// A file in the making.
struct Document {
    encoding: Encoding,
    xml: String,
    appended: String,
}

impl Document {
    fn new(kind: &str, encoding: Encoding) -> Self {
        let compressor = match encoding {
            Encoding::Compressed => r#" compressor="vtkZLibDataCompressor""#,
            Encoding::Base64 | Encoding::Ascii => "",
        };
        let xml = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"{kind}\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\"{compressor}>\n"
        );
        Self { encoding, xml, appended: String::new() }
    }

    fn open(&mut self, tag: &str, attributes: &str) {
        self.xml += &format!("<{tag}{attributes}>\n");
    }

    fn close(&mut self, tag: &str) {
        self.xml += &format!("</{tag}>\n");
    }

    fn time(&mut self, time_s: f64) {
        self.open("FieldData", "");
        let array = r#"<DataArray type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii">"#;
        self.xml += &format!("{array}{time_s}</DataArray>\n");
        self.close("FieldData");
    }

    fn arrays(&mut self, tag: &str, arrays: &[Array]) {
        self.open(tag, "");
        for Array { name, components, values } in arrays {
            self.array(name, *components, values);
        }
        self.close(tag);
    }

    fn array(&mut self, name: &str, components: usize, values: &Values) {
        let kind = values.type_name();
        let name = name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
        let head = format!(r#"<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}""#);
        let element = match self.encoding {
            Encoding::Ascii => format!("{head} format=\"ascii\">\n{}\n</DataArray>\n", values.text()),
            Encoding::Base64 | Encoding::Compressed => {
                let offset = self.appended.len();
                self.append(&values.bytes());
                format!("{head} format=\"appended\" offset=\"{offset}\"/>\n")
            }
        };
        self.xml += &element;
    }

    fn append(&mut self, bytes: &[u8]) {
        if self.encoding == Encoding::Base64 {
            let mut block = (bytes.len() as u64).to_le_bytes().to_vec();
            block.extend_from_slice(bytes);
            STANDARD.encode_string(block, &mut self.appended);
            return;
        }
        let blocks: Vec<Vec<u8>> = bytes.chunks(BLOCK).map(compressed).collect();
        let rest = bytes.len() % BLOCK;
        let mut header = vec![blocks.len() as u64, BLOCK as u64, rest as u64];
        header.extend(blocks.iter().map(|block| block.len() as u64));
        let header: Vec<u8> = header.iter().flat_map(|word| word.to_le_bytes()).collect();
        STANDARD.encode_string(header, &mut self.appended);
        STANDARD.encode_string(blocks.concat(), &mut self.appended);
    }

    fn write(self, path: &Path) -> io::Result<()> {
        let mut file = File::create(path)?;
        file.write_all(self.xml.as_bytes())?;
        if self.encoding != Encoding::Ascii {
            file.write_all(b"<AppendedData encoding=\"base64\">\n_")?;
            file.write_all(self.appended.as_bytes())?;
            file.write_all(b"\n</AppendedData>\n")?;
        }
        file.write_all(b"</VTKFile>\n")
    }
}

fn compressed(block: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(block).and_then(|()| encoder.finish()).expect("writing to memory cannot fail")
}
