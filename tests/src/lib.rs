//! What judges Sturz from outside: benchmarks ([`bench`]), cases with references ([`cases`]) and faults ([`faults`]).
//!
//! | program | question |
//! |---|---|
//! | `bench` | how fast is a step, and how good is it at that speed? |
//! | `faults` | what does the service do when it is killed, damaged, or asked for nonsense? |
//! | `validate` | does the engine compute what closed forms, other programs and papers say? |

#![warn(missing_docs)]

pub mod bench;
pub mod cases;
pub mod faults;
pub mod report;
pub mod scene;
