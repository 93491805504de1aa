//! What a checkpoint takes for granted: the scene it belongs to, as one hash per section of the scene file.

use std::fmt::Write;

use xxhash_rust::xxh3::Xxh3;

use crate::scene::{BoundaryDescription, MotionDescription, SceneDescription};

/// Sections that must agree, in the order of the hashes. Names, the first particles, what is published, and all that is
/// part of the state itself (gravity, motions, fields) may differ.
pub(super) const SECTIONS: [&str; 8] =
    ["scene", "domain", "contact", "integrator", "material", "material_pair", "shape", "boundary"];

/// A hash for each of [`SECTIONS`].
pub(super) type Layout = [u64; SECTIONS.len()];

struct Hash(Xxh3);

impl Write for Hash {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        self.0.update(text.as_bytes());
        Ok(())
    }
}

/// Of the text that the types themselves print: numbers by the shortest decimals that give the same bits.
fn hash(section: &dyn std::fmt::Debug) -> u64 {
    let mut hash = Hash(Xxh3::new());
    write!(hash, "{section:?}").expect("hashing cannot fail");
    hash.0.digest()
}

/// Of a scene with this time step, s.
pub(super) fn layout(scene: &SceneDescription, time_step_s: f64) -> Layout {
    let at_rest =
        |boundary: &BoundaryDescription| BoundaryDescription { motion: MotionDescription::Fixed, ..boundary.clone() };
    let boundaries: Vec<BoundaryDescription> = scene.boundaries.iter().map(at_rest).collect();
    [
        hash(&(scene.scene.seed, time_step_s)),
        hash(&scene.domain),
        hash(&scene.contact),
        hash(&scene.integrator),
        hash(&scene.materials),
        hash(&scene.material_pairs),
        hash(&scene.shapes),
        hash(&boundaries),
    ]
}

/// Of the stages and of the inflows of a scene.
pub(super) fn course_layout(scene: &SceneDescription) -> [u64; 2] {
    [hash(&scene.stages), hash(&scene.inflows)]
}

/// Of a scene without any.
pub(super) fn course_layout_of_none() -> [u64; 2] {
    [hash(&[(); 0]); 2]
}

/// Names of the sections that differ.
pub(super) fn differing(a: &Layout, b: &Layout) -> Vec<&'static str> {
    (0..SECTIONS.len()).filter(|&k| a[k] != b[k]).map(|k| SECTIONS[k]).collect()
}
