//! Inputs for a decoder without a fuzzer: sound ones, changed at random, the same on every machine.

use std::time::{Duration, Instant};

use crate::decoders::Target;
use crate::faults::chance::Chance;

/// Longest input, bytes.
const MOST_BYTES: usize = 1 << 16;
/// Numbers that are often at the edge of something.
const EDGES: [u64; 12] = [
    0,
    1,
    0x7f,
    0x80,
    0xff,
    0xffff,
    0x7fff_ffff,
    0xffff_ffff,
    1 << 62,
    0x7ff0_0000_0000_0000,
    0x7ff8_0000_0000_0000,
    u64::MAX,
];

/// What was tried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tried {
    /// Sound inputs.
    pub seeds: u64,
    /// Changed ones.
    pub changed: u64,
}

/// Reads the sound inputs, and then changed ones: so many, and not beyond `most` of time.
///
/// # Errors
/// There is no sound input.
pub fn mutate(target: &Target, seed: u64, count: u64, most: Duration) -> anyhow::Result<Tried> {
    let seeds = target.seeds()?;
    anyhow::ensure!(!seeds.is_empty(), "{} has nothing to begin with", target.name);
    seeds.iter().for_each(|bytes| target.read(bytes));
    let mut chance = Chance::new(seed);
    let begin = Instant::now();
    let mut tried = Tried { seeds: seeds.len() as u64, changed: 0 };
    while tried.changed < count && begin.elapsed() < most {
        let mut bytes = pick(&seeds, &mut chance).to_vec();
        for _ in 0..1 + chance.below(4) {
            change(&mut bytes, &seeds, &mut chance);
        }
        bytes.truncate(MOST_BYTES);
        target.read(&bytes);
        tried.changed += 1;
    }
    Ok(tried)
}

fn pick<'s>(seeds: &'s [Vec<u8>], chance: &mut Chance) -> &'s [u8] {
    &seeds[chance.below(seeds.len() as u64) as usize]
}

/// A place from 0 to the length, the end included.
fn place(bytes: &[u8], chance: &mut Chance) -> usize {
    chance.below(bytes.len() as u64 + 1) as usize
}

fn change(bytes: &mut Vec<u8>, seeds: &[Vec<u8>], chance: &mut Chance) {
    let at = place(bytes, chance);
    match chance.below(8) {
        0 | 1 => {
            if let Some(byte) = bytes.get_mut(at) {
                *byte ^= 1 << chance.below(8);
            }
        }
        2 => {
            if let Some(byte) = bytes.get_mut(at) {
                *byte = chance.bits() as u8;
            }
        }
        3 | 4 => {
            // A number of 1 to 8 bytes.
            let edge = EDGES[chance.below(EDGES.len() as u64) as usize].to_le_bytes();
            let end = bytes.len().min(at + (1 << chance.below(4)));
            bytes[at..end].copy_from_slice(&edge[..end - at]);
        }
        5 => bytes.truncate(at),
        6 => {
            // A piece is left out, or is there twice.
            let end = bytes.len().min(at + chance.below(64) as usize);
            let piece: Vec<u8> = bytes.drain(at..end).collect();
            if chance.below(2) == 0 {
                let at = place(bytes, chance);
                bytes.splice(at..at, piece.iter().chain(&piece).copied());
            }
        }
        _ => {
            // The head of one, the tail of another.
            let other = pick(seeds, chance);
            let from = place(other, chance);
            bytes.splice(at.., other[from..].iter().copied());
        }
    }
}
