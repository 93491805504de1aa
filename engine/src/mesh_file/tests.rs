//! Meshes in both formats against the shapes that they are of, and every error.

use proptest::prelude::*;

use super::*;
use crate::math::{Quat, Vec3};
use crate::scene::{Scene, SceneDescription};
use crate::shape::{PartGeometry, Shape, ShapeDescription};

const CUBE_OBJ: &str = "# a cube of quadrangles\no cube\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                        f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// Two triangles for each side of a cube of unit edge, turned and moved.
fn cube(turn: &Quat, shift: Vec3) -> Vec<[Vec3; 3]> {
    let meshes = read_mesh(CUBE_OBJ.as_bytes(), MeshFormat::Obj, 1.0).unwrap();
    let at = |v: u32| turn * Vec3::from(meshes[0].vertices[v as usize]) + shift;
    meshes[0].triangles.iter().map(|t| t.map(at)).collect()
}

fn text_stl(triangles: &[[Vec3; 3]]) -> String {
    let mut text = String::from("solid cube\n");
    for corners in triangles {
        text += " facet normal 0 0 0\n  outer loop\n";
        for x in corners {
            text += &format!("   vertex {:e} {:e} {:e}\n", x.x as f32, x.y as f32, x.z as f32);
        }
        text += "  endloop\n endfacet\n";
    }
    text + "endsolid cube\n"
}

fn binary_stl(triangles: &[[Vec3; 3]]) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for corners in triangles {
        bytes.extend([0; 12]);
        bytes.extend(corners.iter().flat_map(|x| [x.x, x.y, x.z]).flat_map(|c| (c as f32).to_le_bytes()));
        bytes.extend([0, 0]);
    }
    bytes
}

fn shape(bytes: &[u8], format: MeshFormat) -> Shape {
    Shape::build(&convex_parts(&read_mesh(bytes, format, 1.0).unwrap()).unwrap()).unwrap()
}

fn error(bytes: &[u8], format: MeshFormat) -> String {
    let meshes = read_mesh(bytes, format, 1.0);
    meshes.and_then(|meshes| convex_parts(&meshes)).unwrap_err().to_string()
}

/// The same cube from OBJ and from both kinds of STL; polygons and pairs of triangles become six faces.
#[test]
fn a_cube_is_a_cube_in_every_format() {
    let still = cube(&Quat::identity(), Vec3::zeros());
    for shape in [
        shape(CUBE_OBJ.as_bytes(), MeshFormat::Obj),
        shape(text_stl(&still).as_bytes(), MeshFormat::Stl),
        shape(&binary_stl(&still), MeshFormat::Stl),
    ] {
        assert!((shape.mass_properties().volume - 1.0).abs() < 1e-14);
        let PartGeometry::Polyhedron(solid) = &shape.parts()[0].geometry else { panic!() };
        assert_eq!((solid.vertices().len(), solid.faces().len(), solid.edges().len()), (8, 6, 12));
    }
}

/// Single precision leaves the corners of a turned body off their planes by 1e-7: straightened, a cube has six faces
/// again, and a pinacoid, at whose corners four faces meet, its eight; both can be rounded.
#[test]
fn turned_bodies_in_single_precision_keep_their_faces() {
    let turn = Quat::from_scaled_axis(Vec3::new(0.3, -1.1, 0.7));
    let pinacoid =
        Shape::build(&ShapeDescription::Pinacoid { length_m: 1.0, width_m: 1.0, height_m: 1.0, alpha_deg: 60.0 });
    let PartGeometry::Polyhedron(solid) = &pinacoid.unwrap().parts()[0].geometry.clone() else { panic!() };
    let mut of_pinacoid = Vec::new();
    for face in 0..solid.faces().len() {
        let corners: Vec<Vec3> = solid
            .face_vertices(face)
            .iter()
            .map(|&v| turn * solid.vertices()[v as usize] + Vec3::repeat(0.4))
            .collect();
        of_pinacoid.extend((1..corners.len() - 1).map(|k| [corners[0], corners[k], corners[k + 1]]));
    }
    for (triangles, faces, volume) in [
        (cube(&turn, Vec3::new(0.1, 0.2, 0.3)), 6, 1.0),
        (
            of_pinacoid,
            solid.faces().len(),
            Shape::build(&ShapeDescription::Pinacoid { length_m: 1.0, width_m: 1.0, height_m: 1.0, alpha_deg: 60.0 })
                .unwrap()
                .mass_properties()
                .volume,
        ),
    ] {
        let description = convex_parts(&read_mesh(&binary_stl(&triangles), MeshFormat::Stl, 1.0).unwrap()).unwrap();
        let shape = Shape::build(&description).unwrap();
        let PartGeometry::Polyhedron(solid) = &shape.parts()[0].geometry else { panic!() };
        assert_eq!(solid.faces().len(), faces);
        assert!((shape.mass_properties().volume / volume - 1.0).abs() < 1e-6);
        assert!(crate::narrow::generalized_overlap::Core::new(solid, 0.02).is_ok());
    }
}

/// Two surfaces apart are two parts, in one file as in two objects; equal positions are one vertex.
#[test]
fn surfaces_apart_are_parts() {
    let mut both = cube(&Quat::identity(), Vec3::zeros());
    both.extend(cube(&Quat::identity(), Vec3::new(3.0, 0.0, 0.0)));
    let two = shape(&binary_stl(&both), MeshFormat::Stl);
    assert_eq!(two.parts().len(), 2);
    assert!((two.mass_properties().volume - 2.0).abs() < 1e-14);
    let objects = CUBE_OBJ.to_owned()
        + "o other\nv 2 0 0\nv 3 0 0\nv 2 1 0\nv 2 0 1\nf 9 11 10\nf 9 10 12\nf 9 12 11\nf 10 11 12\n";
    assert_eq!(shape(objects.as_bytes(), MeshFormat::Obj).parts().len(), 2);
}

#[test]
fn errors_name_the_place_and_the_remedy() {
    let obj = |text: &str| error(text.as_bytes(), MeshFormat::Obj);
    let open = obj(&CUBE_OBJ.replace("f 4 1 5 8\n", ""));
    assert!(open.contains("object 'cube' is open") && open.contains("edge from"), "{open}");
    let turned = obj(&CUBE_OBJ.replace("f 1 2 6 5", "f 5 6 2 1"));
    assert!(turned.contains("turned over"), "{turned}");
    let mut inverted: Vec<[Vec3; 3]> = cube(&Quat::identity(), Vec3::zeros());
    inverted.iter_mut().for_each(|t| t.swap(0, 1));
    assert!(error(&binary_stl(&inverted), MeshFormat::Stl).contains("inside out"));
    let dented = obj(&CUBE_OBJ.replace("v 1 1 1", "v 0.4 0.4 0.4").replace("f 5 6 7 8", "f 5 6 7\nf 5 7 8"));
    assert!(dented.contains("not convex") && dented.contains("convex parts"), "{dented}");
    let flat = obj("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\nf 3 2 1\n");
    assert!(flat.contains("triangle 0") && flat.contains("no area"), "{flat}");
    assert!(
        obj(&CUBE_OBJ.replace("v 1 0 0", "v 1 x 0")).starts_with("line 4"),
        "{}",
        obj(&CUBE_OBJ.replace("v 1 0 0", "v 1 x 0"))
    );
    assert!(obj("v 0 0 0\n").contains("no triangles"));
    assert!(obj(&CUBE_OBJ.replace("f 1 4 3 2", "f 1 4 3 99")).starts_with("line"));
    let short = &binary_stl(&cube(&Quat::identity(), Vec3::zeros()))[..300];
    assert!(error(short, MeshFormat::Stl).starts_with("after triangle 4"), "{}", error(short, MeshFormat::Stl));
    assert!(MeshFormat::of("rock.ply").unwrap_err().to_string().contains(".obj or .stl"));
}

/// A boundary out of a file is the mesh itself.
#[test]
fn boundaries_read_what_they_name() {
    let text = "[scene]\nname = \"s\"\nseed = 1\ngravity_m_per_s2 = [0.0, 0.0, -9.81]\ntime_step_s = 1e-6\n[[material]]\nname = \"w\"\n\
                [[boundary]]\nname = \"block\"\nmaterial = \"w\"\ngeometry = { kind = \"mesh_file\", path = \"cube.stl\", scale = 2.0 }\n";
    let mut scene = SceneDescription::from_toml(text).unwrap();
    let unread = Scene::validate(scene.clone()).err().unwrap().to_string();
    assert!(unread.contains("boundary[0].geometry.path") && unread.contains("cube.stl"), "{unread}");
    let bytes = binary_stl(&cube(&Quat::identity(), Vec3::zeros()));
    scene.read_files(|_| Ok(bytes.clone())).unwrap();
    let crate::scene::BoundaryGeometry::Mesh { vertices_m, triangles } = &scene.boundaries[0].geometry else {
        panic!()
    };
    assert_eq!((vertices_m.len(), triangles.len()), (8, 12));
    assert!(vertices_m.iter().flatten().all(|x| *x == 0.0 || *x == 2.0));
    assert!(Scene::validate(scene).is_ok());
}

/// In a scene: read where it is named, refused with the path.
#[test]
fn scenes_read_what_they_name() {
    let text = "[scene]\nname = \"s\"\nseed = 1\ngravity_m_per_s2 = [0.0, 0.0, -9.81]\ntime_step = \"auto\"\n[[material]]\nname = \"m\"\n\
                density_kg_per_m3 = 1000.0\n[[material_pair]]\nmaterials = [\"m\", \"m\"]\nstiffness_n_per_m = 1e5\nrestitution = 0.5\n\
                [[shape]]\nname = \"rock\"\ngeometry = { kind = \"file\", path = \"cube.obj\", scale = 0.01 }\n";
    let mut scene = SceneDescription::from_toml(text).unwrap();
    let unread = Scene::validate(scene.clone()).err().unwrap().to_string();
    assert!(unread.contains("shape[0].geometry") && unread.contains("cube.obj"), "{unread}");
    let missing = scene.clone().read_files(|_| Err(std::io::ErrorKind::NotFound.into())).unwrap_err().to_string();
    assert!(missing.contains("shape[0].geometry.path"), "{missing}");
    scene.read_files(|path| Ok(if path == "cube.obj" { CUBE_OBJ.into() } else { Vec::new() })).unwrap();
    let scene = Scene::validate(scene).unwrap();
    assert!((scene.shapes()[0].mass_properties().volume - 1e-6).abs() < 1e-18);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Any bytes, and any damage to a sound file, give meshes or an error.
    #[test]
    fn no_bytes_upset_the_readers(bytes in proptest::collection::vec(any::<u8>(), 0..400), at in 0..2000_usize, with in any::<u8>()) {
        let mut damaged = CUBE_OBJ.as_bytes().to_vec();
        let place = at % damaged.len();
        damaged[place] = with;
        let mut stl = binary_stl(&cube(&Quat::identity(), Vec3::zeros()));
        let place = at % stl.len();
        stl[place] = with;
        for (bytes, format) in [(&bytes, MeshFormat::Obj), (&bytes, MeshFormat::Stl), (&damaged, MeshFormat::Obj), (&stl, MeshFormat::Stl)] {
            if let Ok(meshes) = read_mesh(bytes, format, 1.0)
                && let Ok(description) = convex_parts(&meshes)
            {
                let _ = Shape::build(&description);
            }
        }
        let _ = crate::shape::rockable_shapes(&String::from_utf8_lossy(&bytes));
    }
}
