//! The evaluation of the 2023 study, repeated and extended.
//!
//! *Practice.* Experiments ([`experiments`]) are data: questions, and cases of a scene, a representation and a
//! task. Cases that are compared are measured in one sitting (`sitting`), in which their samples take turns. A hardware
//! GPU is kept at its full clock, and its clock is sampled. Each case becomes a [`Record`]. A case that fails becomes a
//! record with its error. The [`report`](fn@report) is a function of records only: tables, plots, images, and the verdicts
//! on the study's claims.

mod claims;
mod clock;
mod clock_range;
mod clock_sampler;
mod command;
mod compare;
pub mod configuration;
mod counters;
mod environment;
pub mod experiment;
pub mod experiments;
mod first_use;
mod formatting;
pub mod hardware;
mod image_error;
mod outcome;
mod peer;
pub mod plan;
mod prepared;
mod record;
mod report;
mod run;
mod scenes;
mod sitting;
mod surface_error;
pub mod task;
mod views;
mod warm_up;

pub use compare::compare;
pub use peer::{PEER_VARIABLE, Peer};
pub use record::{Check, Machine, Record, Sitting, Store};
pub use report::{findings, report};
pub use run::{StudyOptions, StudyProgress, Summary, study};
