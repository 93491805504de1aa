//! Bytes as OBJ and as STL: meshes, convex parts and shapes, or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sturz_engine::mesh_file::{MeshFormat, convex_parts, read_mesh};
use sturz_engine::shape::Shape;

fuzz_target!(|bytes: &[u8]| {
    for format in [MeshFormat::Obj, MeshFormat::Stl] {
        if let Ok(meshes) = read_mesh(bytes, format, 1.0)
            && let Ok(description) = convex_parts(&meshes)
        {
            let _ = Shape::build(&description);
        }
    }
});
