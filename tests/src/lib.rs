//! What judges Sturz from outside: benchmarks ([`bench`]) and cases with references ([`cases`]).
//!
//! | program | question |
//! |---|---|
//! | `bench` | how fast is a step, and how good is it at that speed? |
//! | `validate` | does the engine compute what closed forms, other programs and papers say? |

#![warn(missing_docs)]

pub mod bench;
pub mod cases;
pub mod scene;
