//! Shapes of particles.
