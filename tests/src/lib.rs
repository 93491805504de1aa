//! What judges Sturz from outside: benchmarks ([`bench`]), cases with references ([`cases`]), faults ([`faults`]) and decoders
//! ([`decoders`]).
//!
//! | program | question |
//! |---|---|
//! | `bench` | how fast is a step, and how good is it at that speed? |
//! | `decoders` | what do readers of bytes from outside do with any bytes? (also `make fuzz`) |
//! | `faults` | what does the service do when it is killed, damaged, or asked for nonsense? |
//! | `validate` | does the engine compute what closed forms, other programs and papers say? |

#![warn(missing_docs)]

pub mod bench;
pub mod cases;
pub mod decoders;
pub mod faults;
pub mod report;
pub mod scene;
