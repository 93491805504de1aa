//! Stokes' law: C_D = 24 / Re, so f = 1 and K = 3 pi mu d, with d of the sphere of the same volume.

pub(crate) const SOURCE: &str = "Stokes 1851, Trans. Camb. Phil. Soc. 9, 8";
pub(crate) const RANGE: &str = "spheres, Re < 0.1 (2 % low there, by Oseen's 3/16 Re); other bodies count as spheres";
