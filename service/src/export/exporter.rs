//! Takes messages of the wire, and writes the files that were asked for.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::io;
use std::path::{Path, PathBuf};

use serde::Serialize;
use sturz_protocol::keys::check_name;
use sturz_protocol::v1;
use thiserror::Error;

use super::boundaries::{self, Extent, Wall};
use super::contacts;
use super::fields;
use super::geometry::Bounds;
use super::particles::{Particles, Surface};
use super::series::{Picker, Series};
use super::vtk::{PolyData, Precision, write_image, write_poly};
use crate::cli::Encoding;

/// Which frames to write.
#[derive(Clone, Debug, PartialEq)]
pub enum Choice {
    /// Every one.
    All,
    /// The first at or after each multiple of this simulated time, s.
    Every(f64),
    /// Each N-th.
    Stride(u64),
    /// The first at or after each of these, s, ascending.
    Times(Vec<f64>),
}

/// What to write, and how.
#[derive(Clone, Debug)]
pub struct Options {
    /// Where to.
    pub out: PathBuf,
    /// Surfaces or glyphs.
    pub particles: bool,
    /// Lines.
    pub contacts: bool,
    /// Images.
    pub fields: bool,
    /// Walls.
    pub boundaries: bool,
    /// Points instead of surfaces.
    pub glyphs: bool,
    /// Which frames.
    pub choice: Choice,
    /// Of the arrays.
    pub encoding: Encoding,
    /// Of the floats.
    pub precision: Precision,
}

/// Why there is no file.
#[derive(Debug, Error)]
pub enum ExportError {
    /// The file system refuses.
    #[error("cannot write {}: {error}", .path.display())]
    Io {
        /// Where.
        path: PathBuf,
        /// As the operating system says.
        error: io::Error,
    },
    /// A message is not what it should be.
    #[error("{0}")]
    Message(String),
}

/// What was written.
#[derive(Debug, Default, Serialize)]
pub struct Written {
    /// The folder.
    pub out: PathBuf,
    /// Files of each series, by its name.
    pub files: BTreeMap<String, u64>,
    /// Simulated times asked for that the source does not reach, s.
    pub times_missed: Vec<f64>,
}

/// What `info` and `shapes` say.
struct Model {
    surfaces: Vec<Surface>,
    walls: Vec<Wall>,
    domain: v1::Domain,
    extent: Extent,
}

/// A folder of series in the making.
pub struct Exporter {
    options: Options,
    info: Option<v1::Info>,
    shapes: Option<v1::Shapes>,
    model: Option<Model>,
    /// Of the last frame, whether it was written or not: what contacts refer to.
    particles: Option<Particles>,
    pickers: BTreeMap<String, Picker>,
    series: BTreeMap<String, Series>,
}

impl Exporter {
    /// Makes the folder.
    pub fn new(options: Options) -> Result<Self, ExportError> {
        std::fs::create_dir_all(&options.out).map_err(|error| ExportError::Io { path: options.out.clone(), error })?;
        Ok(Self {
            options,
            info: None,
            shapes: None,
            model: None,
            particles: None,
            pickers: BTreeMap::new(),
            series: BTreeMap::new(),
        })
    }

    /// What to write.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// What the frames refer to. The first time, and again when it has changed.
    pub fn info(&mut self, info: v1::Info) -> Result<(), ExportError> {
        let names = serde_json::json!({
            "scene": info.scene,
            "materials": info.materials,
            "shapes": info.shapes,
            "boundaries": info.boundaries.iter().map(|boundary| boundary.name.clone()).collect::<Vec<_>>(),
        });
        let path = self.options.out.join("names.json");
        std::fs::write(&path, format!("{names:#}\n")).map_err(|error| ExportError::Io { path, error })?;
        self.info = Some(info);
        self.build()
    }

    /// The surfaces of the particles.
    pub fn shapes(&mut self, shapes: v1::Shapes) -> Result<(), ExportError> {
        self.shapes = Some(shapes);
        self.build()
    }

    fn build(&mut self) -> Result<(), ExportError> {
        let (Some(info), Some(shapes)) = (&self.info, &self.shapes) else { return Ok(()) };
        let surfaces = shapes.shapes.iter().map(Surface::read).collect::<Result<_, _>>()?;
        let walls: Vec<Wall> = info.boundaries.iter().map(Wall::read).collect::<Result<_, _>>()?;
        let domain = info.domain.unwrap_or_default();
        let before = self.model.take().filter(|model| model.walls == walls);
        let extent = before.map_or_else(|| Extent::new(domain), |model| model.extent);
        self.model = Some(Model { surfaces, walls, domain, extent });
        Ok(())
    }

    /// A state: particles and boundaries.
    pub fn frame(&mut self, frame: &v1::Frame) -> Result<(), ExportError> {
        let time_s = time_of(&frame.header);
        let Options { particles: wants_particles, boundaries: wants_boundaries, .. } = self.options;
        let wanted = self.pick("state", time_s) && (wants_particles || wants_boundaries);
        if !wanted && !self.options.contacts {
            return Ok(());
        }
        let Model { surfaces, walls, extent, .. } = self.model.as_mut().ok_or_else(no_model)?;
        let particles = Particles::read(frame, surfaces)?;
        if wanted {
            let Options { glyphs, precision, .. } = self.options;
            let mut bounds = Bounds::EMPTY;
            particles.bound(surfaces, &mut bounds);
            extent.take(&bounds, walls, &frame.boundaries);
            let boundaries = (wants_boundaries && !walls.is_empty())
                .then(|| boundaries::polygons(walls, &frame.boundaries, extent, precision));
            let poly = wants_particles.then(|| match glyphs {
                true => ("glyphs", particles.points(surfaces, precision)),
                false => ("particles", particles.surfaces(surfaces, precision)),
            });
            if let Some((name, poly)) = poly {
                self.write(name, time_s, &poly)?;
            }
            if let Some(poly) = boundaries {
                self.write("boundaries", time_s, &poly)?;
            }
        }
        self.particles = Some(particles);
        Ok(())
    }

    /// A field.
    pub fn field(&mut self, field: &v1::FieldFrame) -> Result<(), ExportError> {
        // It becomes the name of files.
        check_name(&field.name).map_err(|problem| ExportError::Message(format!("a field: {problem}")))?;
        let (name, time_s) = (format!("field_{}", field.name), time_of(&field.header));
        if !self.options.fields || !self.pick(&name, time_s) {
            return Ok(());
        }
        if let Some(obstacle) = fields::obstacle(field) {
            tracing::warn!("the field {:?} is left out: {obstacle}", field.name);
            return Ok(());
        }
        let Options { encoding, precision, .. } = self.options;
        let image = fields::image(field, precision)?;
        self.add(&name, "vti", time_s, |path| write_image(path, encoding, time_s, &image))
    }

    /// Contacts of the frame given last: a `ContactFrame`, which begins with the fields of a `Frame`.
    pub fn contacts(&mut self, contacts: &v1::Frame) -> Result<(), ExportError> {
        let time_s = time_of(&contacts.header);
        if !self.options.contacts || !self.pick("contacts", time_s) {
            return Ok(());
        }
        let (Some(model), Some(particles)) = (&self.model, &self.particles) else { return Ok(()) };
        let lines = contacts::lines(contacts, particles, &model.domain, self.options.precision)?;
        self.write("contacts", time_s, &lines)
    }

    /// What has come of it.
    pub fn finish(self) -> Written {
        let missed = self.pickers.values().flat_map(|picker| picker.missed().iter().copied());
        let mut times_missed: Vec<f64> = missed.collect();
        times_missed.sort_by(f64::total_cmp);
        times_missed.dedup();
        let files = self.series.iter().map(|(name, series)| (name.clone(), series.files())).collect();
        Written { out: self.options.out, files, times_missed }
    }

    fn pick(&mut self, stream: &str, time_s: f64) -> bool {
        let choice = &self.options.choice;
        self.pickers.entry(stream.into()).or_insert_with(|| Picker::new(choice.clone())).take(time_s)
    }

    fn write(&mut self, name: &str, time_s: f64, poly: &PolyData) -> Result<(), ExportError> {
        let encoding = self.options.encoding;
        self.add(name, "vtp", time_s, |path| write_poly(path, encoding, time_s, poly))
    }

    fn add(
        &mut self,
        name: &str,
        extension: &'static str,
        time_s: f64,
        write: impl FnOnce(&Path) -> io::Result<()>,
    ) -> Result<(), ExportError> {
        let out = &self.options.out;
        let failed = |error| ExportError::Io { path: out.join(name), error };
        let series = match self.series.entry(name.into()) {
            Entry::Occupied(there) => there.into_mut(),
            Entry::Vacant(place) => place.insert(Series::begin(out, name, extension).map_err(failed)?),
        };
        series.add(time_s, write).map_err(failed)
    }
}

fn time_of(header: &Option<v1::Header>) -> f64 {
    header.as_ref().map_or(0.0, |header| header.sim_time_s)
}

fn no_model() -> ExportError {
    ExportError::Message("a state came before `info` and `shapes`: it cannot be drawn".into())
}
