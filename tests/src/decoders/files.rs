//! Recordings and meshes.

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::Path;

use prost::Message as _;
use sturz_client::v1;
use sturz_engine::mesh_file::{MeshFormat, convex_parts, read_mesh as mesh_of};
use sturz_engine::shape::Shape;
use sturz_engine::{ContactColumn, ContactNetwork, FloatType, ParticleColumn, Snapshot};
use sturz_protocol::convert::{contacts_to_wire, field_to_wire, frame_to_wire};
use sturz_service::cli::Encoding;
use sturz_service::config::Limits;
use sturz_service::export::{Choice, Exporter, Options, Precision};
use sturz_service::play::Shown;
use sturz_service::record::{MessageTimes, Recording, RecordingWriter};
use sturz_service::reply::Identity;
use zenoh::bytes::ZBytes;

use crate::decoders::world::engine_under_way;
use crate::faults::daemon::Folder;

/// Plays it and exports it, as it is, and without its checksums.
pub fn read_recording(bytes: &[u8]) {
    thread_local! {
        static OUT: Folder = Folder::new("decoders-export").unwrap_or_else(|problem| panic!("{problem}"));
    }
    OUT.with(|out| {
        for bytes in [bytes.to_vec(), without_checksums(bytes)] {
            play_and_export(bytes, out.path());
        }
    });
}

fn play_and_export(bytes: Vec<u8>, out: &Path) {
    let Ok(mut recording) = Recording::of(Path::new("fuzz.mcap"), Cursor::new(bytes)) else { return };
    let options = Options {
        out: out.into(),
        particles: true,
        contacts: true,
        fields: true,
        boundaries: true,
        glyphs: false,
        choice: Choice::All,
        encoding: Encoding::Base64,
        precision: Precision::Single,
    };
    let Ok(mut exporter) = Exporter::new(options) else { return };
    let mut shown = Shown::new("fuzz");
    while let Ok(Some(message)) = recording.read() {
        drop(shown.take(&message, &ZBytes::from(message.payload.clone())));
        drop(exporter.message(&message.topic.message, &message.payload));
    }
    for tail in ["info", "features", "shapes/latest", "state/latest", "report/latest", "field/density/latest"] {
        drop(shown.answer(tail, v1::RunState::Paused, [Some("positions|ids"), Some("f32")]));
    }
}

/// Zeros for the checksums of chunks, data and summary: an MCAP file need not have any.
fn without_checksums(bytes: &[u8]) -> Vec<u8> {
    const MAGIC_BYTES: usize = 8;
    const HEAD_BYTES: usize = 9;
    let mut bare = bytes.to_vec();
    let mut at = MAGIC_BYTES;
    while let Some(head) = bare.get(at..at + HEAD_BYTES) {
        let (kind, length) = (head[0], u64::from_le_bytes(std::array::from_fn(|k| head[1 + k])));
        // Chunk: behind two times and a length. End of data: first. Footer: behind two places.
        let checksum = match kind {
            0x06 => Some(24),
            0x0f => Some(0),
            0x02 => Some(16),
            _ => None,
        };
        let content = at + HEAD_BYTES;
        if let Some(place) = checksum.and_then(|offset| bare.get_mut(content + offset..content + offset + 4)) {
            place.fill(0);
        }
        let Some(next) = usize::try_from(length).ok().and_then(|length| content.checked_add(length)) else { break };
        at = next.min(bare.len());
    }
    bare
}

/// With every kind of message; compressed, and not.
pub fn recordings() -> anyhow::Result<Vec<Vec<u8>>> {
    let messages = messages()?;
    let folder = Folder::new("decoders-recordings")?;
    [true, false]
        .into_iter()
        .map(|compressed| {
            let path = folder.path().join(format!("{compressed}.mcap"));
            let mut writer = RecordingWriter::create(&path, compressed, BTreeMap::new())?;
            for (key, name, payload) in &messages {
                writer.write(&format!("sturz/v1/small/{key}"), name, MessageTimes::default(), payload)?;
            }
            writer.finish()?;
            Ok(fs::read(path)?)
        })
        .collect()
}

/// Keys below the instance, names and payloads.
fn messages() -> anyhow::Result<Vec<(&'static str, &'static str, Vec<u8>)>> {
    let mut engine = engine_under_way()?;
    let identity = Identity::new("small", "run".into(), engine.scene(), 1, &Limits::default());
    let (mut snapshot, mut network) = (Snapshot::default(), ContactNetwork::default());
    engine.snapshot(&mut snapshot);
    engine.snapshot_forces(&mut snapshot);
    engine.contact_network(&mut network);
    let definition = engine.scene().description().fields[0].clone();
    let field = engine.compute_field(&definition);
    let header = || identity.blank_header(0, 1);
    let event = v1::Event { header: Some(header()), message: "hello".into(), ..Default::default() };
    // Without the schema of scenes, which is long and only copied.
    let features = v1::Features { scene_schema_json: String::new(), ..identity.features.clone() };
    let float = FloatType::F32;
    Ok(vec![
        ("info", "Info", identity.scene_info().encode_to_vec()),
        ("features", "Features", features.encode_to_vec()),
        ("plan", "Plan", identity.plan.encode_to_vec()),
        ("shapes/0", "Shapes", identity.shapes.encode_to_vec()),
        ("state/frame", "Frame", frame_to_wire(&snapshot, ParticleColumn::ALL, float, header()).encode_to_vec()),
        (
            "contacts/frame",
            "ContactFrame",
            contacts_to_wire(&network, ContactColumn::ALL, float, header()).encode_to_vec(),
        ),
        ("field/density", "FieldFrame", field_to_wire(&field, &[], float, header()).encode_to_vec()),
        ("event/run", "Event", event.encode_to_vec()),
    ])
}

/// As OBJ and as STL: meshes, convex parts, shapes.
pub fn read_mesh(bytes: &[u8]) {
    for format in [MeshFormat::Obj, MeshFormat::Stl] {
        if let Ok(meshes) = mesh_of(bytes, format, 1.0)
            && let Ok(description) = convex_parts(&meshes)
        {
            drop(Shape::build(&description));
        }
    }
}

/// A tetrahedron in each format.
pub fn meshes() -> anyhow::Result<Vec<Vec<u8>>> {
    let corners = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let mut obj = String::from("o tetrahedron\n");
    corners.iter().for_each(|[x, y, z]| obj += &format!("v {x} {y} {z}\n"));
    faces.iter().for_each(|face| obj += &format!("f {} {} {}\n", face[0] + 1, face[1] + 1, face[2] + 1));
    let mut text = String::from("solid t\n");
    let mut binary = vec![0; 80];
    binary.extend_from_slice(&(faces.len() as u32).to_le_bytes());
    for face in faces {
        text += "facet normal 0 0 0\nouter loop\n";
        binary.extend_from_slice(&[0; 12]);
        for corner in face.map(|k: usize| corners[k]) {
            text += &format!("vertex {} {} {}\n", corner[0], corner[1], corner[2]);
            corner.iter().for_each(|number| binary.extend_from_slice(&number.to_le_bytes()));
        }
        text += "endloop\nendfacet\n";
        binary.extend_from_slice(&[0; 2]);
    }
    text += "endsolid t\n";
    Ok(vec![obj.into_bytes(), text.into_bytes(), binary])
}
