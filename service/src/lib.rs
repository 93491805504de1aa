//! The daemon that serves a simulation on the bus, and the command line `sturz`.
//!
//! Physics runs on one plain thread ([`runner`]) that is reached through a bounded [`mailbox`] and hands out through
//! an [`outbox`] of latest-wins slots. Everything asynchronous, and everything that speaks zenoh, is in [`daemon`],
//! [`intake`], [`reply`] and [`publish`]; [`metrics`] answers Prometheus.

pub mod advance;
mod answer;
pub mod archive;
pub mod autosave;
pub mod checkpoints;
pub mod cli;
pub mod commands;
pub mod config;
pub mod course;
pub mod daemon;
pub mod events;
mod execute;
pub mod export;
pub mod guards;
pub mod intake;
pub mod journal;
pub mod lease;
pub mod mailbox;
pub mod memory;
pub mod meter;
pub mod metrics;
pub mod order;
pub mod outbox;
pub mod output;
pub mod play;
pub mod publish;
pub mod record;
pub mod reply;
mod rewind;
pub mod runner;
pub mod scenes;
pub mod schedule;
pub mod security;
mod settle;
pub mod stages;
pub mod study;
pub mod ticket;
