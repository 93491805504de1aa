//! A series of files of one kind, and the .pvd file that gives each its simulated time.

use std::fs::File;
use std::io::{self, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use crate::export::Choice;

const HEAD: &str = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n";
const TAIL: &str = "</Collection>\n</VTKFile>\n";

/// The first multiple of an interval after `time_s`, s. A time that misses a multiple by rounding is at it.
pub fn next_multiple(time_s: f64, every_s: f64) -> f64 {
    ((time_s / every_s + 1e-9).floor() + 1.0) * every_s
}

/// Whether a time is there, but for rounding.
pub fn reached(time_s: f64, wanted_s: f64) -> bool {
    time_s >= wanted_s - 1e-12 * wanted_s.abs()
}

/// Which frames of a stream to write.
#[derive(Clone, Debug)]
pub struct Picker {
    choice: Choice,
    seen: u64,
    next_s: f64,
    last_s: f64,
}

impl Picker {
    /// From the first frame on.
    pub fn new(choice: Choice) -> Self {
        Self { choice, seen: 0, next_s: f64::NEG_INFINITY, last_s: f64::NEG_INFINITY }
    }

    /// Whether to write the next frame, of this simulated time.
    pub fn take(&mut self, time_s: f64) -> bool {
        self.seen += 1;
        let back = time_s < self.last_s;
        self.last_s = time_s;
        match &mut self.choice {
            Choice::All => true,
            Choice::Stride(stride) => (self.seen - 1).is_multiple_of(*stride),
            Choice::Every(every_s) => {
                let wanted = back || reached(time_s, self.next_s);
                if wanted {
                    self.next_s = next_multiple(time_s, *every_s);
                }
                wanted
            }
            Choice::Times(times) => {
                let passed = times.iter().filter(|&&wanted_s| reached(time_s, wanted_s)).count();
                drop(times.drain(..passed));
                passed > 0
            }
        }
    }

    /// Simulated times asked for that no frame has reached.
    pub fn missed(&self) -> &[f64] {
        match &self.choice {
            Choice::Times(times) => times,
            _ => &[],
        }
    }
}

/// Files `<name>_000000.<extension>`, ... and `<name>.pvd`, which is whole after every file.
pub struct Series {
    folder: PathBuf,
    name: String,
    extension: &'static str,
    collection: File,
    files: u64,
}

impl Series {
    /// Begins one; what an earlier export left under these names is written over.
    pub fn begin(folder: &Path, name: &str, extension: &'static str) -> io::Result<Self> {
        let mut collection = File::create(folder.join(format!("{name}.pvd")))?;
        collection.write_all(format!("{HEAD}{TAIL}").as_bytes())?;
        Ok(Self { folder: folder.into(), name: name.into(), extension, collection, files: 0 })
    }

    /// Writes the next file by `write`, and its entry.
    pub fn add(&mut self, time_s: f64, write: impl FnOnce(&Path) -> io::Result<()>) -> io::Result<()> {
        let file = format!("{}_{:06}.{}", self.name, self.files, self.extension);
        write(&self.folder.join(&file))?;
        self.collection.seek(SeekFrom::End(-(TAIL.len() as i64)))?;
        let entry = format!("<DataSet timestep=\"{time_s}\" part=\"0\" file=\"{file}\"/>\n{TAIL}");
        self.collection.write_all(entry.as_bytes())?;
        self.files += 1;
        Ok(())
    }

    /// Files so far.
    pub fn files(&self) -> u64 {
        self.files
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn taken(choice: Choice, times: &[f64]) -> Vec<f64> {
        let mut picker = Picker::new(choice);
        times.iter().copied().filter(|&time_s| picker.take(time_s)).collect()
    }

    #[test]
    fn frames_are_picked_by_interval_stride_or_time() {
        let times = [0.0, 0.1, 0.25, 0.3, 0.5, 0.75, 1.0];
        assert_eq!(taken(Choice::All, &times), times);
        assert_eq!(taken(Choice::Stride(3), &times), [0.0, 0.3, 1.0]);
        assert_eq!(taken(Choice::Every(0.25), &times), [0.0, 0.25, 0.5, 0.75, 1.0]);
        assert_eq!(taken(Choice::Every(0.25), &[0.5, 0.6, 0.2, 0.25]), [0.5, 0.2, 0.25], "a restore");
        assert_eq!(taken(Choice::Times(vec![0.2, 0.24, 0.75]), &times), [0.25, 0.75]);
        let steps: Vec<f64> = (0..=100).map(|step| f64::from(step) * 0.01).collect();
        assert_eq!(taken(Choice::Every(0.1), &steps).len(), 11, "sums of 0.1 are not multiples to the last bit");
        let mut picker = Picker::new(Choice::Times(vec![0.5, 2.0]));
        assert!(picker.take(1.0));
        assert_eq!(picker.missed(), [2.0]);
    }

    #[test]
    fn the_collection_is_whole_after_every_file() {
        let folder = tempfile::tempdir().unwrap();
        let mut series = Series::begin(folder.path(), "particles", "vtp").unwrap();
        let read = || std::fs::read_to_string(folder.path().join("particles.pvd")).unwrap();
        assert_eq!(read(), format!("{HEAD}{TAIL}"));
        for time_s in [0.0, 0.5] {
            series.add(time_s, |path| std::fs::write(path, "x")).unwrap();
        }
        let text = read();
        assert!(text.starts_with(HEAD) && text.ends_with(TAIL), "{text}");
        assert_eq!(text.matches(TAIL).count(), 1, "{text}");
        assert!(text.contains("timestep=\"0.5\" part=\"0\" file=\"particles_000001.vtp\""), "{text}");
        assert!(folder.path().join("particles_000001.vtp").exists());
    }
}
