//! Sharing over all points of two bodies instead of those of two of their parts.

use super::table::{ContactTable, Slot};
use crate::scene::Sharing;

/// Points and largest overlap of one pair of bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyPoints {
    count: u32,
    overlap: f64,
}

/// What tells one pair of bodies from the next: slots of the same two bodies follow each other.
fn bodies(slot: &Slot) -> (bool, u32, u32) {
    (slot.kind.is_wall(), slot.a, slot.b)
}

/// `model_b` and `max_overlap_shared` with N the number of points between two bodies, as their sources mean it: bodies
/// glued of N convex parts are then as stiff as one part. Serial, for composites only.
pub fn share_over_bodies(table: &mut ContactTable, sharing: Sharing) {
    let ContactTable { slots, chunks, body_points, .. } = table;
    body_points.clear();
    let mut last = None;
    for (slots, chunk) in slots.chunks(super::CHUNK).zip(&*chunks) {
        for contact in &chunk.contacts {
            let key = bodies(&slots[contact.slot as usize]);
            if last.replace(key) != Some(key) {
                body_points.push(BodyPoints::default());
            }
            if let Some(points) = body_points.last_mut() {
                points.count += 1;
                points.overlap = points.overlap.max(contact.overlap);
            }
        }
    }
    let mut of_bodies = body_points.iter();
    let (mut last, mut points) = (None, BodyPoints::default());
    for (slots, chunk) in slots.chunks(super::CHUNK).zip(chunks) {
        for contact in &mut chunk.contacts {
            let key = bodies(&slots[contact.slot as usize]);
            if last.replace(key) != Some(key) {
                points = of_bodies.next().copied().unwrap_or_default();
            }
            contact.weight = 1.0 / f64::from(points.count);
            if sharing == Sharing::MaxOverlapShared {
                contact.overlap = points.overlap;
            }
        }
    }
}
