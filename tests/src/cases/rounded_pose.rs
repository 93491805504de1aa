//! Pairs of rounded polyhedra just before they touch, by kind of contact: what the cases of the law start from.

use anyhow::{Context, ensure};
use sturz_engine::math::{Quat, Similarity, Vec3};
use sturz_engine::narrow::generalized_overlap::{Core, EdgeFade, OverlapGeometry, PNorm, RoundedPair};
use sturz_engine::narrow::{Manifold, PairCache, collide};
use sturz_engine::shape::{Part, PartGeometry, Shape, ShapeDescription};

use crate::scene::SceneText;

/// Rounding radius of all shapes, m; their size is 1 m.
pub const ROUNDING: f64 = 5e-3;

/// A shape of unit mass.
pub struct Solid {
    pub name: &'static str,
    /// As in a scene.
    pub geometry: String,
    /// m^3
    pub volume: f64,
    core: Core,
    part: Part,
    rounding_fraction: f64,
}

/// Which features face each other along z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Aligned,
    Offset,
    Yawed,
    Tilted,
    EdgeFace,
    ParallelEdges,
    CrossedEdges,
    VertexFace,
    VertexEdge,
    VertexVertex,
    Random,
    /// Offset and yawed.
    FaceFace,
    /// As `FaceFace`, tilted by 1e-3.
    TiltedThousandth,
    /// As `FaceFace`, tilted by 1e-2.
    TiltedHundredth,
}

impl Kind {
    /// Of [`Solid::pair`].
    pub const ALL: [Self; 11] = [
        Self::Aligned,
        Self::Offset,
        Self::Yawed,
        Self::Tilted,
        Self::EdgeFace,
        Self::ParallelEdges,
        Self::CrossedEdges,
        Self::VertexFace,
        Self::VertexEdge,
        Self::VertexVertex,
        Self::Random,
    ];
}

/// Poses of both particles, centre of mass and orientation; the second comes down along z.
#[derive(Clone, Copy, Debug)]
pub struct Poses {
    pub position: [Vec3; 2],
    pub orientation: [Quat; 2],
}

/// SplitMix64: the same poses on every machine.
pub struct Draw(pub u64);

impl Draw {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }

    fn direction(&mut self) -> Vec3 {
        loop {
            let v = Vec3::from_fn(|_, _| self.between(-1.0, 1.0));
            if v.norm() < 1.0 && v.norm() > 1e-3 {
                return v.normalize();
            }
        }
    }
}

/// Cube, pinacoid and tetrahedron.
pub fn solids() -> anyhow::Result<Vec<Solid>> {
    let pinacoid = ShapeDescription::Pinacoid { length_m: 1.0, width_m: 1.0, height_m: 1.0, alpha_deg: 60.0 };
    let edge = 2f64.sqrt();
    [
        ("cube", "kind = \"cube\", edge_m = 1.0".to_owned(), ShapeDescription::Cube { edge_m: 1.0 }),
        (
            "pinacoid",
            "kind = \"pinacoid\", length_m = 1.0, width_m = 1.0, height_m = 1.0, alpha_deg = 60.0".to_owned(),
            pinacoid,
        ),
        (
            "tetrahedron",
            format!("kind = \"tetrahedron\", edge_m = {edge:?}"),
            ShapeDescription::Tetrahedron { edge_m: edge },
        ),
    ]
    .into_iter()
    .map(|(name, geometry, description)| {
        let shape = Shape::build(&description)?;
        let (turn, centre) = shape.given_from_body();
        ensure!(turn.angle() < 1e-12 && centre.norm() < 1e-12, "{name}: poses are those of the body frame");
        let PartGeometry::Polyhedron(solid) = &shape.parts()[0].geometry else { anyhow::bail!("not a polyhedron") };
        let core = |fraction: f64| Core::new(solid, fraction).map_err(anyhow::Error::msg).context(name);
        let rounding_fraction = ROUNDING / core(1e-3)?.size;
        let volume = shape.mass_properties().volume;
        let part = shape.parts()[0].clone();
        Ok(Solid { name, geometry, core: core(rounding_fraction)?, part, volume, rounding_fraction })
    })
    .collect()
}

/// Direction of a feature seen from inside, and a point of it (the middle of a face or edge); a direction in it.
fn feature(core: &Core, kind: usize, draw: &mut Draw) -> (Vec3, Vec3, Vec3) {
    let solid = core.solid();
    let at = |v: u32| solid.vertices()[v as usize];
    match kind {
        0 => {
            let face = draw.below(solid.faces().len());
            let corners = solid.face_vertices(face);
            let middle = corners.iter().map(|&v| at(v)).sum::<Vec3>() / corners.len() as f64;
            (solid.faces()[face].normal, middle, (at(corners[1]) - at(corners[0])).normalize())
        }
        1 => {
            let edge = &solid.edges()[draw.below(solid.edges().len())];
            let outwards = edge.faces.iter().map(|&f| solid.faces()[f as usize].normal).sum::<Vec3>().normalize();
            (outwards, (at(edge.vertices[0]) + at(edge.vertices[1])) * 0.5, edge.direction)
        }
        _ => {
            let vertex = draw.below(solid.vertices().len());
            let x = solid.vertices()[vertex];
            let outwards =
                solid.vertex_faces(vertex).iter().map(|&f| solid.faces()[f as usize].normal).sum::<Vec3>().normalize();
            (outwards, x, outwards.cross(&Vec3::new(0.3, 0.5, 0.8)).normalize())
        }
    }
}

/// Orientation that carries `up` to `target` (plus or minus z) and the perpendicular `along` to x.
fn standing(up: &Vec3, along: &Vec3, target: &Vec3) -> Quat {
    let frame = |up: &Vec3, along: &Vec3| {
        let along = (along - up * along.dot(up)).normalize();
        sturz_engine::math::Mat3::from_columns(&[along, up.cross(&along), *up])
    };
    let turn = frame(target, &Vec3::x()) * frame(up, along).transpose();
    Quat::from_matrix(&turn)
}

impl Solid {
    /// A pair of this shape, some 1e-6 to 3e-4 m before it touches: at any phase of a step.
    pub fn pair(&self, kind: Kind, draw: &mut Draw) -> anyhow::Result<Poses> {
        let (orientation, lateral) = self.facing(kind, draw);
        let gap = Vec3::z() * (1e-6 + 3e-4 * draw.unit());
        Ok(Poses { position: [Vec3::zeros(), self.above(&orientation, lateral)? + gap], orientation })
    }

    /// The same where nothing is rounded, up to `gap` before it touches.
    pub fn sharp_pair(&self, kind: Kind, gap: f64, draw: &mut Draw) -> anyhow::Result<Poses> {
        let (orientation, lateral) = self.facing(kind, draw);
        let gap = Vec3::z() * (gap * draw.unit());
        Ok(Poses { position: [Vec3::zeros(), self.sharp_above(&orientation, lateral)? + gap], orientation })
    }

    /// An orientation with a face (tilted about a horizontal axis) down, or a random one, and the height of the
    /// centroid where the lowest vertex is at z = 0.
    pub fn on_floor(&self, tilt: Option<f64>, draw: &mut Draw) -> (Quat, f64) {
        let q = match tilt {
            Some(tilt) => {
                let (down, _, along) = feature(&self.core, 0, draw);
                let axis = Vec3::new(draw.between(-1.0, 1.0), draw.between(-1.0, 1.0), 0.0).normalize();
                Quat::from_scaled_axis(axis * tilt) * standing(&down, &along, &-Vec3::z())
            }
            None => Quat::from_scaled_axis(draw.direction() * draw.between(0.0, 3.1)),
        };
        let PartGeometry::Polyhedron(solid) = &self.part.geometry else { unreachable!("built as one") };
        let lowest = solid.vertices().iter().map(|v| (q * v).z).fold(f64::MAX, f64::min);
        (q, -lowest)
    }

    /// Orientations of a pair, and the second one's place in x and y.
    fn facing(&self, kind: Kind, draw: &mut Draw) -> ([Quat; 2], Vec3) {
        use Kind as K;
        let kinds = match kind {
            K::Aligned | K::Offset | K::Yawed | K::Tilted => [0, 0],
            K::FaceFace | K::TiltedThousandth | K::TiltedHundredth => [0, 0],
            K::EdgeFace => [0, 1],
            K::ParallelEdges | K::CrossedEdges => [1, 1],
            K::VertexFace => [0, 2],
            K::VertexEdge => [1, 2],
            K::VertexVertex | K::Random => [2, 2],
        };
        let (up, on_a, along_a) = feature(&self.core, kinds[0], draw);
        let (down, on_b, along_b) = feature(&self.core, kinds[1], draw);
        let mut a = standing(&up, &along_a, &Vec3::z());
        let mut b = standing(&down, &along_b, &-Vec3::z());
        let yaw = |angle: f64| Quat::from_scaled_axis(Vec3::z() * angle);
        let mut sideways = |reach: f64| {
            let angle = draw.between(0.0, std::f64::consts::TAU);
            Vec3::new(angle.cos(), angle.sin(), 0.0) * draw.between(0.1 * reach, reach)
        };
        let shift = match kind {
            K::Aligned | K::CrossedEdges => Vec3::zeros(),
            K::Offset | K::Random | K::FaceFace | K::TiltedThousandth | K::TiltedHundredth => sideways(0.25),
            K::ParallelEdges => Vec3::x() * sideways(0.3).x,
            K::Yawed | K::Tilted | K::EdgeFace | K::VertexFace => sideways(0.1),
            K::VertexEdge | K::VertexVertex => sideways(2e-3),
        };
        let tilt = |angle: f64, draw: &mut Draw| {
            let axis = Vec3::new(draw.between(-1.0, 1.0), draw.between(-1.0, 1.0), 0.0).normalize();
            Quat::from_scaled_axis(axis * angle)
        };
        match kind {
            K::Aligned | K::Offset | K::ParallelEdges => {}
            K::Tilted => b = tilt(10f64.powf(draw.between(-4.0, -1.0)), draw) * b,
            K::TiltedThousandth => b = tilt(1e-3, draw) * yaw(draw.between(0.1, 3.0)) * b,
            K::TiltedHundredth => b = tilt(1e-2, draw) * yaw(draw.between(0.1, 3.0)) * b,
            K::CrossedEdges => b = yaw(draw.between(0.4, 2.7)) * b,
            K::Random => {
                a = Quat::from_scaled_axis(draw.direction() * draw.between(0.0, 3.1));
                b = Quat::from_scaled_axis(draw.direction() * draw.between(0.0, 3.1));
            }
            _ => b = yaw(draw.between(0.1, 3.0)) * b,
        }
        let flat = if kind == K::Random { Vec3::zeros() } else { a * on_a - b * on_b };
        ([a, b], Vec3::new(flat.x, flat.y, 0.0) + shift)
    }

    /// Where the second one is just above its first touch.
    fn above(&self, orientation: &[Quat; 2], lateral: Vec3) -> anyhow::Result<Vec3> {
        let geometry =
            OverlapGeometry { norm: PNorm::new(8.0), fade: EdgeFade { angle_factor: 2.0, reach_factor: 0.5 } };
        let mut terms = Vec::new();
        // in steps below the thickness of the rounding: deeper, the law has no meaning
        self.lowered(orientation, lateral, 0.5 * ROUNDING, |pose| {
            RoundedPair { a: &self.core, b: &self.core, b_to_a: pose, geometry: &geometry }.all_terms(&mut terms);
            !terms.is_empty()
        })
    }

    fn sharp_above(&self, orientation: &[Quat; 2], lateral: Vec3) -> anyhow::Result<Vec3> {
        let mut manifold = Manifold::default();
        self.lowered(orientation, lateral, 0.02, |pose| {
            manifold.clear();
            collide(&self.part, &self.part, pose, &mut PairCache::default(), &mut manifold);
            !manifold.is_empty()
        })
    }

    /// Lowers the second one in steps until the two touch, and halves the last step down to rounding.
    fn lowered(
        &self,
        [a, b]: &[Quat; 2],
        lateral: Vec3,
        step: f64,
        mut touch: impl FnMut(&Similarity) -> bool,
    ) -> anyhow::Result<Vec3> {
        let mut touches = |height: f64| {
            let rotation = *(a.inverse() * b).to_rotation_matrix().matrix();
            touch(&Similarity::rigid(rotation, a.inverse() * (lateral + Vec3::z() * height)))
        };
        let mut low = 2.5;
        while !touches(low) {
            low -= step;
            ensure!(low > -2.5, "{}: the two pass each other", self.name);
        }
        let mut high = low + step;
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if touches(middle) { low = middle } else { high = middle }
        }
        Ok(lateral + Vec3::z() * high)
    }

    /// One particle of unit mass in a random orientation, k = 1e6 N/m, on its way down to a wall at z = 0.
    pub fn at_wall(&self, draw: &mut Draw, speed: f64, time_step_s: f64, wall: &str) -> SceneText {
        let q = Quat::from_scaled_axis(draw.direction() * draw.between(0.0, 3.1));
        self.elastic(time_step_s, "restitution = 1.0", "")
            .section(&format!("[[boundary]]\nname = \"wall\"\nmaterial = \"w\"\ngeometry = {{ {wall} }}"))
            .section(&format!(
                "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nvelocity_m_per_s = [0.0, 0.0, {:?}]\n\
                 placement = {{ method = \"poses\", positions_m = [[0.0, 0.0, 1.0]], orientations_wxyz = [{:?}] }}",
                -speed,
                [q.w, q.i, q.j, q.k]
            ))
    }

    /// Materials and shape.
    fn elastic(&self, time_step_s: f64, pair: &str, contact: &str) -> SceneText {
        let section = format!("generalized_overlap = {{ rounding_fraction = {:?}{contact} }}", self.rounding_fraction);
        SceneText::new([0.0; 3], &format!("time_step_s = {time_step_s:?}"))
            .contact(&format!("normal = \"generalized_overlap\"\ncontact_end = \"tension\"\n{section}"))
            .materials(1.0 / self.volume, &format!("stiffness_n_per_m = 1e6\n{pair}"))
            .shape(&self.geometry)
    }

    /// Two particles of unit mass, k = 1e6 N/m, that close along z at `speed`, without gravity and friction.
    pub fn scene(&self, poses: &Poses, speed: f64, time_step_s: f64, pair: &str, contact: &str) -> SceneText {
        let mut scene = self.elastic(time_step_s, pair, contact);
        for k in 0..2 {
            let q = poses.orientation[k];
            let x: [f64; 3] = poses.position[k].into();
            let velocity = [0.0, 0.0, if k == 0 { 0.5 * speed } else { -0.5 * speed }];
            scene = scene.section(&format!(
                "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nvelocity_m_per_s = {velocity:?}\n\
                 placement = {{ method = \"poses\", positions_m = [{x:?}], orientations_wxyz = [{:?}] }}",
                [q.w, q.i, q.j, q.k]
            ));
        }
        scene
    }
}
