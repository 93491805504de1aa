//! Two cores in a pose, and the terms of their overlap.

use super::edges::EdgePair;
use super::{Core, OverlapGeometry};
use crate::math::{Similarity, Vec3};

/// Two rounded polyhedra; lengths in the unit of `a`, everything in its frame.
#[derive(Clone, Copy)]
pub struct RoundedPair<'p> {
    /// Of the particle with the lower id.
    pub a: &'p Core,
    /// Of the other one.
    pub b: &'p Core,
    /// Pose of `b`.
    pub b_to_a: &'p Similarity,
    /// Parameters.
    pub geometry: &'p OverlapGeometry,
}

/// Names a term; terms are added in ascending order of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct TermCode(u32);

/// What a code names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TermKind {
    /// A vertex of `b` against the core of `a`.
    VertexOfB(usize),
    /// A vertex of `a` against the core of `b`.
    VertexOfA(usize),
    /// An edge of `a` against one of `b`.
    Edges(usize, usize),
}

impl TermCode {
    const SHIFT: u32 = 30;

    pub(super) fn vertex_of_b(vertex: usize) -> Self {
        Self(vertex as u32)
    }

    pub(super) fn vertex_of_a(vertex: usize) -> Self {
        Self((1 << Self::SHIFT) | vertex as u32)
    }

    pub(super) fn edges(edge_a: usize, edge_b: usize) -> Self {
        Self((2 << Self::SHIFT) | ((edge_a as u32) << 15) | edge_b as u32)
    }

    #[inline]
    pub(super) fn kind(self) -> TermKind {
        let index = (self.0 & ((1 << Self::SHIFT) - 1)) as usize;
        match self.0 >> Self::SHIFT {
            0 => TermKind::VertexOfB(index),
            1 => TermKind::VertexOfA(index),
            _ => TermKind::Edges(index >> 15, index & 0x7fff),
        }
    }
}

/// One pair of features that overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// d, positive.
    pub overlap: f64,
    /// w in (0, 1].
    pub weight: f64,
    /// Unit, from `a` to `b`.
    pub normal: Vec3,
    /// Halfway between the closest points of the cores.
    pub position: Vec3,
    /// Gradient of the weight by the motion of `b`: force, and moment about the origin of `a`.
    pub weight_gradient: Option<(Vec3, Vec3)>,
    /// Whether it is a pair of edges.
    pub is_edges: bool,
}

impl RoundedPair<'_> {
    /// R = r_a + r_b.
    #[inline]
    pub fn radius(&self) -> f64 {
        self.a.radius + self.b.radius * self.b_to_a.scale
    }

    /// A term, if it overlaps with a weight above 0.
    #[inline]
    pub fn term(&self, code: TermCode) -> Option<Term> {
        match code.kind() {
            TermKind::VertexOfB(v) => self.vertex_of_b(v),
            TermKind::VertexOfA(v) => self.vertex_of_a(v),
            TermKind::Edges(e, f) => self.edges(e, f),
        }
    }

    fn vertex_of_b(&self, vertex: usize) -> Option<Term> {
        let y = self.b_to_a.point(&self.b.solid().vertices()[vertex]);
        let (normal, distance) = self.a.project(&y);
        self.vertex_term(normal, distance, y - normal * (0.5 * distance))
    }

    fn vertex_of_a(&self, vertex: usize) -> Option<Term> {
        let x = self.a.solid().vertices()[vertex];
        let (outwards, distance) = self.b.project(&self.b_to_a.inverse_point(&x));
        let (normal, distance) = (-self.b_to_a.direction(&outwards), distance * self.b_to_a.scale);
        self.vertex_term(normal, distance, x + normal * (0.5 * distance))
    }

    fn vertex_term(&self, normal: Vec3, distance: f64, position: Vec3) -> Option<Term> {
        let overlap = self.radius() - distance;
        (overlap > 0.0).then_some(Term {
            overlap,
            weight: 1.0,
            normal,
            position,
            weight_gradient: None,
            is_edges: false,
        })
    }

    /// The two edges in the frame of `a`.
    #[inline]
    pub(super) fn edge_pair(&self, edge_a: usize, edge_b: usize) -> EdgePair {
        let ends_b = self.b.edge(edge_b).map(|x| self.b_to_a.point(&x));
        let lengths = [self.a.edge_length(edge_a), self.b.edge_length(edge_b) * self.b_to_a.scale];
        EdgePair::new(&self.a.edge(edge_a), &ends_b, lengths)
    }

    fn edges(&self, edge_a: usize, edge_b: usize) -> Option<Term> {
        let pair = self.edge_pair(edge_a, edge_b);
        let radius = self.radius();
        let weight = pair.weight(&self.geometry.fade, radius)?;
        let (x, y) = pair.closest();
        let gap = y - x;
        let distance2 = gap.norm_squared();
        if distance2 >= radius * radius {
            return None;
        }
        let distance = distance2.sqrt();
        // edges that cross exactly are at the end of the law's range: any fixed direction will do
        let normal = if distance > 0.0 { gap / distance } else { pair.perpendicular() };
        Some(Term {
            overlap: radius - distance,
            weight: weight.value,
            normal,
            position: x + gap * 0.5,
            weight_gradient: weight.varies().then(|| pair.gradient(&weight)),
            is_edges: true,
        })
    }
}
