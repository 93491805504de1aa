//! R518: every contact of 512 rounded dodecahedra and 6 plates, as Rockable lists them.
//!
//! Data: a state under isotropic compression of Rockable (V. Richefeu et al., CeCILL-B), not part of the repository.
//! A test of geometry, apart from any law. Faces are flat to 1e-8 only, so overlaps are compared to 1e-7. Rockable
//! keeps a vertex at an edge wherever its foot lies inside the edge; this engine only where the edge and the vertex are
//! nearest to each other in their bodies, 34 of its 125.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, ensure};
use sturz_engine::math::{Quat, Similarity, Vec3};
use sturz_engine::narrow::FeatureKey;
use sturz_engine::narrow::features::{FeatureContact, FeatureList, FeaturePair, FeatureScratch};
use sturz_engine::shape::{Shape, rockable_shapes};

use super::{Case, Checks};

/// Contacts by kind, in Rockable's numbers.
const KINDS: [&str; 4] = ["vertex-vertex", "vertex-edge", "vertex-face", "edge-edge"];
/// Bodies, kind, features of them.
type Key = (usize, usize, usize, usize, usize);

pub(super) fn cases() -> Vec<Case> {
    vec![Case::slow("R518", "All contacts of Rockable's 512 rounded dodecahedra (needs --data)", r518)]
}

struct Body {
    shape: usize,
    scale: f64,
    position: Vec3,
    orientation: Quat,
}

/// Normal from the second body to the first, and overlap.
#[derive(Clone, Copy)]
struct Listed {
    normal: Vec3,
    overlap: f64,
}

struct State {
    shapes: Vec<Shape>,
    /// How many bodies at the start are walls, which do not meet each other.
    driven: usize,
    bodies: Vec<Body>,
    contacts: BTreeMap<Key, Listed>,
}

fn r518(checks: &mut Checks) -> anyhow::Result<()> {
    let folder = checks.data().join("rockable_518_dodecahedra");
    if !folder.is_dir() {
        checks.holds(format!("not run: no data in {}", checks.data().display()), false);
        return Ok(());
    }
    let state = State::read(&folder)?;
    let found = state.search(checks)?;
    let of = |all: &BTreeMap<Key, Listed>, kind: usize| all.keys().filter(|key| key.2 == kind).count() as f64;
    let sum = |all: &BTreeMap<Key, Listed>, kind: usize| -> f64 {
        all.iter().filter(|(key, _)| key.2 == kind).map(|(_, contact)| contact.overlap).sum()
    };
    let missing = |from: &BTreeMap<Key, Listed>, there: &BTreeMap<Key, Listed>, kind: usize| {
        from.keys().filter(|key| key.2 == kind && !there.contains_key(key)).count() as f64
    };
    for (kind, count) in [(2, 2229.0), (3, 1510.0)] {
        let name = KINDS[kind];
        checks.near(format!("{name} contacts"), of(&found, kind), count, 0.0, "-");
        checks.vanishes(format!("{name} contacts not found"), missing(&state.contacts, &found, kind), 0.0, "-");
        checks.vanishes(
            format!("{name} contacts found and not listed"),
            missing(&found, &state.contacts, kind),
            0.0,
            "-",
        );
        checks.near(format!("{name} sum of overlaps"), sum(&found, kind), sum(&state.contacts, kind), 1e-6, "m");
    }
    for kind in [2, 3] {
        let (mut overlap, mut angle) = (0.0f64, 0.0f64);
        for (contact, there) in found.iter().filter_map(|(k, c)| (k.2 == kind).then_some((c, state.contacts.get(k)?))) {
            overlap = overlap.max((contact.overlap - there.overlap).abs());
            let (sine, cosine) = (contact.normal.cross(&there.normal).norm(), contact.normal.dot(&there.normal));
            angle = angle.max(sine.atan2(cosine));
        }
        let name = KINDS[kind];
        checks.vanishes(format!("{name} largest difference of overlaps"), overlap, 1e-7, "m");
        checks.vanishes(format!("{name} largest angle of normals"), angle, 1e-6, "rad");
    }
    for (key, contact) in state.contacts.iter().filter(|(key, _)| key.2 == 2 && !found.contains_key(key)) {
        checks.holds(format!("not found: {key:?}, overlap {:e}", contact.overlap), false);
    }
    for (key, contact) in found.iter().filter(|(key, _)| key.2 > 1 && !state.contacts.contains_key(key)) {
        checks.holds(format!("not listed: {key:?}, overlap {:e}", contact.overlap), false);
    }
    checks.near("vertex-edge contacts nearest in both bodies", of(&found, 1), 34.0, 0.0, "-");
    checks.vanishes("of these not listed by Rockable", missing(&found, &state.contacts, 1), 0.0, "-");
    let only_theirs = missing(&state.contacts, &found, 1);
    checks.near("vertex-edge contacts that Rockable alone keeps", only_theirs, 125.0 - 34.0, 0.0, "-");
    checks.holds(
        format!("vertex-vertex contacts: {} here, {} there (no aim)", of(&found, 0), of(&state.contacts, 0)),
        true,
    );
    Ok(())
}

impl State {
    fn read(folder: &Path) -> anyhow::Result<Self> {
        let text = |name: &str| {
            let path = folder.join(name);
            std::fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))
        };
        let imported = rockable_shapes(&text("shape.shp")?)?;
        let shapes = imported.iter().map(|s| Shape::build(&s.description)).collect::<Result<Vec<_>, _>>()?;
        let state = text("reference_state.conf")?;
        let block = |title: &str| -> anyhow::Result<Vec<&str>> {
            let start = state.lines().position(|line| line.starts_with(title)).context("a block is missing")?;
            let count: usize =
                state.lines().nth(start).and_then(|l| l.split(' ').nth(1)).context("no count")?.parse()?;
            Ok(state.lines().skip(start + 1).filter(|line| !line.starts_with('#')).take(count).collect())
        };
        let body = |line: &&str| -> anyhow::Result<Body> {
            let (name, numbers) = line.split_once(' ').context("an empty line")?;
            let n = numbers_of(numbers)?;
            let q = Quat::from_quaternion([n[13], n[14], n[15], n[12]].into());
            let shape = imported.iter().position(|shape| shape.name == name).context("an unknown shape")?;
            Ok(Body { shape, scale: n[2], position: Vec3::new(n[3], n[4], n[5]), orientation: q })
        };
        let bodies = block("Particles")?.iter().map(body).collect::<anyhow::Result<Vec<_>>>()?;
        let mut contacts = BTreeMap::new();
        for line in block("Interactions")? {
            let n = numbers_of(line)?;
            let [i, j, kind, p, q] = [0, 1, 2, 3, 4].map(|k| n[k] as usize);
            let contact = Listed { normal: Vec3::new(n[5], n[6], n[7]), overlap: -n[8] };
            if contact.overlap > 0.0 {
                contacts.insert((i, j, kind, p, q), contact);
            }
        }
        let driven = state.lines().find_map(|line| line.strip_prefix("nDriven ")).context("no nDriven")?;
        Ok(Self { shapes, driven: driven.trim().parse()?, bodies, contacts })
    }

    /// All contacts by the engine's lists, which must agree with the search over all features.
    fn search(&self, checks: &mut Checks) -> anyhow::Result<BTreeMap<Key, Listed>> {
        let mut found = BTreeMap::new();
        let mut scratch = FeatureScratch::default();
        let mut lists_agree = true;
        for (i, a) in self.bodies.iter().enumerate() {
            for (j, b) in self.bodies.iter().enumerate().skip(i + 1) {
                let reach = [a, b].map(|body| self.shapes[body.shape].bounding_radius() * body.scale);
                if j < self.driven {
                    continue;
                }
                if (b.position - a.position).norm() >= reach[0] + reach[1] {
                    continue;
                }
                let turn = a.orientation.inverse();
                let b_to_a = Similarity {
                    rotation: (turn * b.orientation).to_rotation_matrix().into_inner(),
                    translation: (turn * (b.position - a.position)) / a.scale,
                    scale: b.scale / a.scale,
                };
                let skeleton = |body: &Body| self.shapes[body.shape].parts()[0].skeleton.as_deref();
                let (Some(of_a), Some(of_b)) = (skeleton(a), skeleton(b)) else { anyhow::bail!("no skeleton") };
                let pair = FeaturePair { a: of_a, b: of_b, b_to_a: &b_to_a };
                let (mut list, mut all) = (FeatureList::default(), FeatureList::default());
                list.update(&pair, &mut scratch);
                pair.all_candidates(&mut all);
                lists_agree &= list.contacts(&pair).count() == all.contacts(&pair).count();
                for (feature, contact) in list.contacts(&pair) {
                    let (key, contact) = listed((i, j), feature, &contact, a);
                    ensure!(found.insert(key, contact).is_none(), "a contact was found twice");
                }
            }
        }
        checks.holds("lists of features agree with the search over all", lists_agree);
        Ok(found)
    }
}

/// In Rockable's order: the body of the vertex first.
fn listed((i, j): (usize, usize), feature: FeatureKey, contact: &FeatureContact, a: &Body) -> (Key, Listed) {
    let code = feature.0 as usize & 0x3fff_ffff;
    let (first, second) = (code >> 15, code & 0x7fff);
    let (vertex, other) = (code >> 14 & 0x3fff, code & 0x3fff);
    let (key, from_a) = match (feature.kind(), code >> 28) {
        (1, _) => ((i, j, 2, first, second), true),
        (2, _) => ((j, i, 2, first, second), false),
        (3, _) => ((i, j, 3, first, second), true),
        (_, 1) => ((i, j, 1, vertex, other), true),
        (_, 2) => ((j, i, 1, vertex, other), false),
        _ => ((i, j, 0, vertex, other), true),
    };
    let normal = a.orientation * contact.normal;
    (key, Listed { normal: if from_a { -normal } else { normal }, overlap: contact.overlap * a.scale })
}

fn numbers_of(line: &str) -> anyhow::Result<Vec<f64>> {
    Ok(line.split_whitespace().map(str::parse).collect::<Result<_, _>>()?)
}
