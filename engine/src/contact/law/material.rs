//! Contact parameters of each pair of materials, resolved once when the scene is validated.

/// Linear law of a pair of materials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairLaw {
    /// Normal stiffness of a single point, N/m.
    pub stiffness: f64,
    /// Normal damping ratio; the coefficient is 2 zeta sqrt(k m), m the reduced mass. Unused with `raw_damping`.
    pub damping_ratio: f64,
    /// Normal dashpot coefficient where it was given directly, N s/m.
    pub raw_damping: Option<f64>,
    /// Coulomb coefficient.
    pub friction: f64,
    /// Tangential stiffness, N/m.
    pub tangential_stiffness: f64,
    /// Tangential over normal dashpot coefficient.
    pub tangential_damping_ratio: f64,
}

impl PairLaw {
    /// Normal dashpot coefficient for a reduced mass, N s/m.
    #[inline(always)]
    pub fn damping(&self, reduced_mass: f64) -> f64 {
        match self.raw_damping {
            Some(c) => c,
            None => 2.0 * self.damping_ratio * (self.stiffness * reduced_mass).sqrt(),
        }
    }
}

/// Symmetric table over pairs of material indices.
#[derive(Clone, Debug, PartialEq)]
pub struct PairTable {
    materials: usize,
    laws: Vec<Option<PairLaw>>,
}

impl PairTable {
    /// A table without entries.
    pub fn new(materials: usize) -> Self {
        Self { materials, laws: vec![None; materials * materials] }
    }

    /// Sets the law of `a` with `b`.
    pub fn set(&mut self, a: usize, b: usize, law: PairLaw) {
        self.laws[a * self.materials + b] = Some(law);
        self.laws[b * self.materials + a] = Some(law);
    }

    /// The law of `a` with `b`, if the scene has one.
    pub fn get(&self, a: usize, b: usize) -> Option<&PairLaw> {
        self.laws[a * self.materials + b].as_ref()
    }

    /// The law of a pair that the scene has proved to exist.
    #[inline(always)]
    pub(crate) fn law(&self, a: u32, b: u32) -> &PairLaw {
        self.laws[a as usize * self.materials + b as usize].as_ref().expect("pairs are checked on insertion")
    }

    /// Whether any pair has friction.
    pub fn any_friction(&self) -> bool {
        self.laws.iter().flatten().any(|law| law.friction > 0.0)
    }
}
