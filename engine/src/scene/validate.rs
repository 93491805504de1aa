//! The only way to a [`Scene`]: afterwards the engine cannot fail to start.

use std::sync::Arc;

use super::boundaries::{build_boundaries, expand_boxes};
use super::{
    MaterialPairDescription, NormalLaw, Plan, PointLaws, RoundedShapes, SceneDescription, TimeStepChoice, point_laws,
    stages,
};
use crate::boundary::Boundary;
use crate::cell::Cell;
use crate::checkpoint::Bed;
use crate::contact::law::{PairLaw, PairTable, damping_ratio, least_restitution};
use crate::error::{InvalidInput, InvalidScene};
use crate::insertion::{self, Surroundings};
use crate::integrate::critical_step::{Body, ContactBounds, contact_bounds, rounded_critical_step};
use crate::integrate::point_bounds;
use crate::particles::NewParticle;
use crate::scene::auto_step::{chosen_time_step, contacts_per_body};
use crate::shape::{MAX_FEATURES, Part, PartGeometry, Shape};

/// A scene that has been proved usable.
#[derive(Clone, Debug)]
pub struct Scene {
    description: SceneDescription,
    shapes: Vec<Shape>,
    pairs: PairTable,
    boundaries: Vec<Boundary>,
    cell: Cell,
    plan: Plan,
    rounded: Option<RoundedShapes>,
    point_laws: Option<PointLaws>,
    time_step_s: f64,
    particles: Vec<NewParticle>,
    pub(super) stages: Vec<Arc<Scene>>,
    /// What it starts with, out of a checkpoint.
    pub(super) bed: Option<Arc<Bed>>,
}

/// Collects everything that is wrong.
#[derive(Default)]
pub(super) struct Problems(pub(super) Vec<InvalidInput>);

impl Problems {
    pub(super) fn add(&mut self, path: impl Into<String>, problem: impl Into<String>) {
        self.0.push(InvalidInput::new(path, problem));
    }

    pub(super) fn keep<T>(&mut self, result: Result<T, InvalidInput>) -> Option<T> {
        result.map_err(|error| self.0.push(error)).ok()
    }

    pub(super) fn finite(&mut self, path: &str, values: &[f64]) {
        if values.iter().any(|v| !v.is_finite()) {
            self.add(path, format!("is {values:?}; every number must be finite"));
        }
    }

    pub(super) fn direction(&mut self, path: &str, v: &[f64; 3]) {
        let norm = v.iter().map(|c| c * c).sum::<f64>().sqrt();
        if !(norm.is_finite() && norm > 0.0) {
            self.add(path, format!("is {v:?}; must be finite and not zero"));
        }
    }

    pub(super) fn in_range(&mut self, path: &str, value: f64, allowed: &str, ok: bool) {
        if !(value.is_finite() && ok) {
            self.add(path, format!("is {value}; must be {allowed}"));
        }
    }
}

impl SceneDescription {
    /// Reads a scene file.
    pub fn from_toml(text: &str) -> Result<Self, InvalidInput> {
        toml::from_str(text).map_err(|error| InvalidInput::new("scene file", error.to_string()))
    }

    /// Writes a scene file.
    pub fn to_toml(&self) -> Result<String, InvalidInput> {
        toml::to_string_pretty(self).map_err(|error| InvalidInput::new("scene", error.to_string()))
    }
}

impl Scene {
    /// Proves the description usable, or lists everything that is wrong with it.
    pub fn validate(description: SceneDescription) -> Result<Self, InvalidScene> {
        let staged = description.stages.iter().map(|stage| stage.applied_to(&description)).collect();
        let mut scene = Self::without_particles(description)?;
        let mut problems = Problems::default();
        scene.build_stages(staged, &mut problems);
        scene.read_start(&mut problems);
        let inflows = scene.check_inflows(&mut problems);
        if !problems.0.is_empty() {
            return Err(InvalidScene(problems.0));
        }
        scene.place_particles(&inflows, &mut problems);
        let time_step_s = scene.choose_time_step(&inflows, &mut problems);
        scene.time_step_s = time_step_s;
        scene.stages.iter_mut().for_each(|stage| Arc::make_mut(stage).time_step_s = time_step_s);
        problems.0.extend(scene.resolution().and_then(|resolution| resolution.refusal()));
        if problems.0.is_empty() { Ok(scene) } else { Err(InvalidScene(problems.0)) }
    }

    /// All but its particles, time step and stages.
    pub(super) fn without_particles(mut description: SceneDescription) -> Result<Self, InvalidScene> {
        let mut problems = Problems::default();
        check_numbers(&description, &mut problems);
        check_names(&description, &mut problems);
        let origins = expand_boxes(&mut description, &mut problems);
        let shapes: Vec<Shape> = description
            .shapes
            .iter()
            .enumerate()
            .filter_map(|(k, shape)| {
                Shape::build(&shape.geometry)
                    .map_err(|e| problems.add(format!("shape[{k}].geometry"), e.to_string()))
                    .ok()
            })
            .collect();
        let shapes = description.contact.feature_pairs.round(&description, shapes, &mut problems.0);
        check_skeletons(&shapes, &mut problems);
        let pairs = build_pairs(&description, &mut problems);
        if !problems.0.is_empty() {
            return Err(InvalidScene(problems.0));
        }
        problems.0.extend(point_laws::check_shapes(&description, &shapes));
        let rounded = RoundedShapes::build(&description, &shapes, &mut problems.0);
        if !problems.0.is_empty() {
            return Err(InvalidScene(problems.0));
        }
        let cell = Cell::new(&description.domain);
        let skeletons = shapes.iter().flat_map(Shape::parts).any(Part::is_rounded_polyhedron);
        let boundaries = build_boundaries(&description, &origins, (&cell, skeletons), &mut problems);
        let point_laws = PointLaws::build(&description, &shapes);
        let plan = Plan::new(&description, &shapes, &pairs, point_laws.as_ref());
        let scene = Self {
            description,
            shapes,
            pairs,
            boundaries,
            cell,
            plan,
            point_laws,
            rounded,
            time_step_s: 0.0,
            particles: Vec::new(),
            stages: Vec::new(),
            bed: None,
        };
        if problems.0.is_empty() { Ok(scene) } else { Err(InvalidScene(problems.0)) }
    }

    fn place_particles(&mut self, inflows: &[NewParticle], problems: &mut Problems) {
        self.particles.extend(self.bed.iter().flat_map(|bed| bed.particles()));
        for k in 0..self.description.insertions.len() {
            let surroundings = Surroundings {
                scene: self,
                boundaries: &self.boundaries,
                present: &self.particles,
                first_id: self.particles.len() as u64,
            };
            let path = format!("insertion[{k}]");
            let placed = insertion::place(&self.description.insertions[k], &surroundings, &path);
            if let Some(new) = problems.keep(placed.and_then(|new| self.check_sizes(&new, &path).map(|()| new))) {
                self.particles.extend(new);
            }
        }
        let frozen = self.particles.iter().filter(|particle| particle.frozen).count();
        if frozen > 0 {
            let line = format!(
                "frozen: {frozen} particles, which keep their velocity and meet neither their like nor boundaries"
            );
            self.add_plan_line(line);
        }
        let mut materials: Vec<usize> = self.particles.iter().chain(inflows).map(|p| p.material as usize).collect();
        materials.sort_unstable();
        materials.dedup();
        problems.keep(self.check_pairs_among(&materials, "material_pair"));
    }

    /// Along a periodic axis no pair may meet through two images at once.
    pub(crate) fn check_sizes(&self, new: &[NewParticle], path: &str) -> Result<(), InvalidInput> {
        let largest = new.iter().map(|particle| particle.radius).fold(0.0, f64::max);
        let bonds = self.point_laws.as_ref().map_or(0.0, |laws| laws.least_skin(largest));
        let needed = (4.0 * largest * (1.0 + 2.0 * self.plan.skin_fraction)).max(4.0 * (largest + bonds));
        let extent = self.cell.shortest_periodic_extent();
        if needed <= extent {
            return Ok(());
        }
        let problem = format!(
            "the largest particle has bounding radius {largest:e} m; a periodic cell needs an extent of at least {needed:e} m and has {extent:e} m"
        );
        Err(InvalidInput::new(path, problem))
    }

    fn choose_time_step(&self, inflows: &[NewParticle], problems: &mut Problems) -> f64 {
        let all = [&self.particles, inflows].concat();
        let bounds = self.with_stages().filter_map(|(_, scene)| scene.contact_bounds(&all)).reduce(ContactBounds::min);
        let section = &self.description.scene;
        let time_step = match (section.time_step_s, section.time_step_fraction, section.time_step, bounds) {
            (Some(dt), None, None, _) => dt,
            (None, Some(fraction), None, Some(bounds)) => fraction * bounds.critical_time_step_s,
            (None, None, Some(TimeStepChoice::Auto), Some(bounds)) => {
                chosen_time_step(&bounds, self.description.normal_law())
            }
            (None, fraction, choice, None) if fraction.is_some() != choice.is_some() => {
                let key = if choice.is_some() { "scene.time_step" } else { "scene.time_step_fraction" };
                let needs =
                    "needs at least one shape, one material with density and their material_pair; give time_step_s";
                problems.add(key, needs);
                return 0.0;
            }
            _ => {
                problems.add("scene", "give exactly one of time_step_s, time_step_fraction and time_step = \"auto\"");
                return 0.0;
            }
        };
        problems.keep(self.check_time_step(time_step, &all, "scene.time_step_s"));
        time_step
    }

    /// Refuses a step above the critical one of these particles, in the scene or in one of its stages.
    pub(crate) fn check_time_step(&self, dt: f64, particles: &[NewParticle], path: &str) -> Result<(), InvalidInput> {
        for (stage, scene) in self.with_stages() {
            let Some(bounds) = scene.contact_bounds(particles).filter(|bounds| dt > bounds.critical_time_step_s) else {
                continue;
            };
            let of = stage.map_or_else(String::new, |title| format!(" in {title}"));
            let problem = format!(
                "the time step {dt:e} s is above the critical one of a single contact{of}, {:e} s (stiffness, damping, mass and inertia of the lightest pair): reduce time_step_s, {:e} s is a fiftieth of the collision",
                bounds.critical_time_step_s,
                bounds.duration_s / 50.0
            );
            return Err(InvalidInput::new(path, problem));
        }
        Ok(())
    }

    /// Smallest bounds over all pairs that may meet; over all shapes and materials while there are no particles.
    pub(crate) fn contact_bounds(&self, particles: &[NewParticle]) -> Option<ContactBounds> {
        let classes = if particles.is_empty() { self.possible_bodies() } else { self.lightest_bodies(particles) };
        let mut smallest: Option<ContactBounds> = None;
        let tangential = self.description.contact.tangential;
        let mut consider = |materials: [usize; 2], a: &Body, b: Option<&Body>| {
            let Some(law) = self.pairs.get(materials[0], materials[1]) else { return };
            let mut bounds = self.point_laws.as_ref().map_or_else(
                || contact_bounds(law, a, b),
                |laws| {
                    let extras = laws.extras(materials[0] as u32, materials[1] as u32);
                    point_bounds(laws, tangential, (law, extras), a, b)
                },
            );
            if let Some(rounded) = &self.rounded
                && a.is_rounded
                && b.is_none_or(|b| b.is_rounded)
            {
                let critical = rounded_critical_step(law, &rounded.law, a, b);
                bounds.critical_time_step_s = bounds.critical_time_step_s.min(critical);
            }
            smallest = Some(smallest.map_or(bounds, |s| s.min(bounds)));
        };
        for (k, (material_a, a)) in classes.iter().enumerate() {
            for (material_b, b) in &classes[k..] {
                consider([*material_a, *material_b], a, Some(b));
            }
            for boundary in &self.boundaries {
                consider([*material_a, boundary.material as usize], a, None);
            }
        }
        smallest
    }

    /// By particle of `particles`: t^2 of the way F t^2/m that takes a contact with its like apart without overshooting, where as many
    /// contacts act on a body as the law may have, s2.
    pub(crate) fn relaxation_times_squared(&self, particles: &[NewParticle]) -> Vec<f64> {
        // a step of t_critical/sqrt(2) along the force closes a single contact at once
        let share = 0.5 / contacts_per_body(self.description.normal_law());
        let mut last: Option<(f64, (u32, u32, f64))> = None;
        let of_particle = |particle: &NewParticle| {
            let class = (particle.shape, particle.material, particle.scale);
            match last {
                Some((time2, seen)) if seen == class => time2,
                _ => {
                    let bounds = self.contact_bounds(std::slice::from_ref(particle));
                    let time2 = bounds.map_or(0.0, |bounds| share * bounds.critical_time_step_s.powi(2));
                    last = Some((time2, class));
                    time2
                }
            }
        };
        particles.iter().map(of_particle).collect()
    }

    fn body(&self, shape: usize, mass: f64, scale: f64) -> Body {
        let is_rounded = self.rounded.as_ref().is_some_and(|rounded| rounded.has_core(shape));
        let shape = &self.shapes[shape];
        let properties = shape.mass_properties();
        Body {
            mass,
            leverage: shape.leverage(),
            points: shape.parts().iter().map(Part::most_points).sum(),
            radius: scale * shape.parts().iter().map(Part::contact_radius).fold(0.0, f64::max),
            smallest_inertia: properties.principal_inertia.min() / properties.volume * mass * scale * scale,
            is_rounded,
        }
    }

    /// Each shape of each particle material, at unit scale.
    fn possible_bodies(&self) -> Vec<(usize, Body)> {
        let mut bodies = Vec::new();
        for (m, material) in self.description.materials.iter().enumerate() {
            let Some(density) = material.density_kg_per_m3 else { continue };
            for (s, shape) in self.shapes.iter().enumerate() {
                let properties = shape.mass_properties();
                bodies.push((m, self.body(s, properties.volume * density, 1.0)));
            }
        }
        bodies
    }

    /// The smallest particle of each (shape, material) present.
    fn lightest_bodies(&self, particles: &[NewParticle]) -> Vec<(usize, Body)> {
        let materials = self.description.materials.len();
        let mut lightest: Vec<Option<&NewParticle>> = vec![None; materials * self.shapes.len()];
        for particle in particles {
            let class = &mut lightest[particle.shape as usize * materials + particle.material as usize];
            if class.is_none_or(|known| particle.scale < known.scale) {
                *class = Some(particle);
            }
        }
        let body = |p: &NewParticle| (p.material as usize, self.body(p.shape as usize, p.mass, p.scale));
        lightest.into_iter().flatten().map(body).collect()
    }

    /// Every material that particles of `material` may meet needs a pair.
    pub(crate) fn check_pairs_of(&self, material: usize, path: &str) -> Result<(), InvalidInput> {
        let name = |m: usize| self.description.materials[m].name.as_str();
        let particles = (0..self.description.materials.len())
            .filter(|&m| self.description.materials[m].density_kg_per_m3.is_some() && m == material);
        let walls = self.boundaries.iter().map(|boundary| boundary.material as usize);
        for other in particles.chain(walls) {
            if self.pairs.get(material, other).is_none() {
                let problem = format!(
                    "materials '{}' and '{}' may meet but have no [[material_pair]]",
                    name(material),
                    name(other)
                );
                return Err(InvalidInput::new(path, problem));
            }
        }
        Ok(())
    }

    /// Every two materials of particles present need a pair.
    pub(crate) fn check_pairs_among(&self, materials: &[usize], path: &str) -> Result<(), InvalidInput> {
        for &a in materials {
            for &b in materials {
                if self.pairs.get(a, b).is_none() {
                    let name = |m: usize| self.description.materials[m].name.as_str();
                    let problem =
                        format!("materials '{}' and '{}' may meet but have no [[material_pair]]", name(a), name(b));
                    return Err(InvalidInput::new(path, problem));
                }
            }
        }
        Ok(())
    }

    /// What the user wrote, with the planes of each box in its place.
    pub fn description(&self) -> &SceneDescription {
        &self.description
    }

    /// Shapes, in the order of the scene.
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// Contact parameters.
    pub fn pairs(&self) -> &PairTable {
        &self.pairs
    }

    /// Boundaries at time 0.
    pub fn boundaries(&self) -> &[Boundary] {
        &self.boundaries
    }

    /// Periodic cell.
    pub fn cell(&self) -> &Cell {
        &self.cell
    }

    /// What the scene needs.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Cores and law, where polyhedra meet by generalized overlap.
    pub fn rounded(&self) -> Option<&RoundedShapes> {
        self.rounded.as_ref()
    }

    /// Laws of point contacts, where the scene names more than the plain one.
    pub fn point_laws(&self) -> Option<&PointLaws> {
        self.point_laws.as_ref()
    }

    /// What it starts with, out of a checkpoint.
    pub(crate) fn bed(&self) -> Option<&Bed> {
        self.bed.as_deref()
    }

    pub(super) fn add_plan_line(&mut self, line: String) {
        self.plan.lines.push(line);
    }

    /// Time step, s.
    pub fn time_step_s(&self) -> f64 {
        self.time_step_s
    }

    /// Particles at time 0.
    pub fn particles(&self) -> &[NewParticle] {
        &self.particles
    }
}

fn check_numbers(description: &SceneDescription, problems: &mut Problems) {
    let scene = &description.scene;
    problems.finite("scene.gravity_m_per_s2", &scene.gravity_m_per_s2);
    if let Some(dt) = scene.time_step_s {
        problems.in_range("scene.time_step_s", dt, "finite and above 0", dt > 0.0);
    }
    if let Some(fraction) = scene.time_step_fraction {
        problems.in_range("scene.time_step_fraction", fraction, "in (0, 1)", fraction > 0.0 && fraction < 1.0);
    }
    let domain = &description.domain;
    problems.finite("domain.min_m", &domain.min_m);
    problems.finite("domain.max_m", &domain.max_m);
    problems.finite("domain.origin_m", &domain.origin_m);
    for axis in (0..3).filter(|&axis| domain.periodic[axis]) {
        if domain.max_m[axis] <= domain.min_m[axis] {
            problems.add(format!("domain.max_m[{axis}]"), "must be above domain.min_m along a periodic axis");
        }
    }
    let contact = &description.contact;
    let limit = contact.overlap_limit;
    problems.in_range("contact.overlap_limit", limit, "in (0, 2]", limit > 0.0 && limit <= 2.0);
    problems.0.extend(contact.generalized_overlap.check());
    problems.0.extend(point_laws::check(description));
    if let Some(skin) = contact.skin_fraction {
        problems.in_range("contact.skin_fraction", skin, "in (0, 2]", skin > 0.0 && skin <= 2.0);
    }
    check_relax(description, problems);
    stages::check(description, problems);
    for (k, inflow) in description.inflows.iter().enumerate() {
        inflow.check(&format!("inflow[{k}]"), problems);
    }
    for (k, material) in description.materials.iter().enumerate() {
        if let Some(density) = material.density_kg_per_m3 {
            let path = format!("material[{k}].density_kg_per_m3");
            problems.in_range(&path, density, "finite and above 0", density > 0.0);
        }
    }
    description.output.check(problems);
    if let Some(time) = description.stop.time_s {
        problems.in_range("stop.time_s", time, "finite and at least 0", time >= 0.0);
    }
    for (k, field) in description.fields.iter().enumerate() {
        let path = format!("field[{k}]");
        problems.keep(field.validate(&path));
        let names: Vec<&str> = description.boundaries.iter().map(|boundary| boundary.name.as_str()).collect();
        problems.keep(field.check_names(&names, &path));
    }
}

fn check_relax(description: &SceneDescription, problems: &mut Problems) {
    let Some(relax) = &description.relax else { return };
    let (overlap, way) = (relax.overlap_ratio, relax.displacement_fraction);
    problems.in_range("relax.overlap_ratio", overlap, "in (0, 1]", overlap > 0.0 && overlap <= 1.0);
    problems.in_range("relax.displacement_fraction", way, "in (0, 0.5]", way > 0.0 && way <= 0.5);
    if relax.max_iterations == 0 {
        problems.add("relax.max_iterations", "is 0; must be at least 1");
    }
}

fn check_names(description: &SceneDescription, problems: &mut Problems) {
    let mut unique = |section: &str, names: Vec<&str>| {
        for (k, name) in names.iter().enumerate() {
            if name.is_empty() || names[..k].contains(name) {
                problems.add(format!("{section}[{k}].name"), format!("'{name}' is empty or used twice"));
            }
        }
    };
    unique("material", description.materials.iter().map(|m| m.name.as_str()).collect());
    unique("shape", description.shapes.iter().map(|s| s.name.as_str()).collect());
    unique("boundary", description.boundaries.iter().map(|b| b.name.as_str()).collect());
    unique("field", description.fields.iter().map(|f| f.name.as_str()).collect());
}

pub(super) fn material_index(
    description: &SceneDescription,
    name: &str,
    path: String,
    problems: &mut Problems,
) -> Option<usize> {
    let index = description.materials.iter().position(|material| material.name == name);
    if index.is_none() {
        let known: Vec<&str> = description.materials.iter().map(|m| m.name.as_str()).collect();
        problems.add(path, format!("'{name}' is not a [[material]]; the scene has {known:?}"));
    }
    index
}

/// Whatever may meet a rounded polyhedron must have features that can be named; cylinders are asked by a function of their own.
fn check_skeletons(shapes: &[Shape], problems: &mut Problems) {
    let any_rounded = shapes.iter().flat_map(Shape::parts).any(|part| part.is_rounded_polyhedron());
    let is_nameless = |part: &Part| part.skeleton.is_none() && !matches!(part.geometry, PartGeometry::Cylinder { .. });
    for (k, shape) in shapes.iter().enumerate().filter(|_| any_rounded) {
        if shape.parts().iter().any(is_nameless) {
            let problem = format!("has more than {MAX_FEATURES} features, too many to meet a rounded polyhedron");
            problems.add(format!("shape[{k}].geometry"), problem);
        }
    }
}

fn build_pairs(description: &SceneDescription, problems: &mut Problems) -> PairTable {
    let mut table = PairTable::new(description.materials.len());
    for (k, pair) in description.material_pairs.iter().enumerate() {
        let path = format!("material_pair[{k}]");
        let indices = [0, 1].map(|side| {
            material_index(description, &pair.materials[side], format!("{path}.materials[{side}]"), problems)
        });
        let law = pair_law(pair, description, &path, problems);
        if let ([Some(a), Some(b)], Some(law)) = (indices, law) {
            if table.get(a, b).is_some() {
                problems.add(format!("{path}.materials"), "this pair is already defined");
            }
            table.set(a, b, law);
        }
    }
    table
}

fn pair_law(
    pair: &MaterialPairDescription,
    description: &SceneDescription,
    path: &str,
    problems: &mut Problems,
) -> Option<PairLaw> {
    let before = problems.0.len();
    let hertz = description.normal_law() == NormalLaw::Hertz;
    // Hertz knows the stiffness of a load only; elsewhere its absence is refused already.
    let k = pair.stiffness_n_per_m.unwrap_or(if hertz { 0.0 } else { 1.0 });
    problems.in_range(&format!("{path}.stiffness_n_per_m"), k, "finite and above 0", k > 0.0 || hertz);
    let mu = pair.friction;
    problems.in_range(&format!("{path}.friction"), mu, "finite and at least 0", mu >= 0.0);
    let ratio = pair.tangential_stiffness_ratio;
    problems.in_range(
        &format!("{path}.tangential_stiffness_ratio"),
        ratio,
        "in [0, 10]",
        (0.0..=10.0).contains(&ratio),
    );
    let damping_ratio_t = pair.tangential_damping_ratio.unwrap_or(ratio.max(0.0).sqrt());
    problems.in_range(
        &format!("{path}.tangential_damping_ratio"),
        damping_ratio_t,
        "in [0, 10]",
        (0.0..=10.0).contains(&damping_ratio_t),
    );
    let end = description.contact.contact_end;
    let least = least_restitution(end);
    let (zeta, raw) = match (pair.restitution, pair.damping_n_s_per_m) {
        (Some(e), None) => {
            let allowed = format!("in [{least:.3}, 1] with contact_end = {end:?}");
            problems.in_range(&format!("{path}.restitution"), e, &allowed, e >= least && e <= 1.0);
            (damping_ratio(e, end), None)
        }
        (None, Some(c)) => {
            problems.in_range(&format!("{path}.damping_n_s_per_m"), c, "finite and at least 0", c >= 0.0);
            (0.0, Some(c))
        }
        _ => {
            problems.add(path, "give restitution or damping_n_s_per_m, not both");
            (0.0, None)
        }
    };
    (problems.0.len() == before).then_some(PairLaw {
        stiffness: k,
        damping_ratio: zeta,
        raw_damping: raw,
        friction: mu,
        tangential_stiffness: k * ratio,
        tangential_damping_ratio: damping_ratio_t,
    })
}
