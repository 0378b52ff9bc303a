//! The tests of the Rust core. They are one program, so that the dependencies are linked once.
//!
//! Each module tests one part. `cargo test --test rust MODULE::` runs the tests of one module.
#![allow(clippy::unwrap_used, reason = "a test that cannot continue has failed")]

mod block_tridiagonal;
mod chain_matrix;
mod common;
mod connections;
mod conservation;
mod eigen;
mod elements;
mod events;
mod exponential;
mod fuzz;
mod guaranteed_interval;
mod integrators;
mod mesh_geometry;
mod mesh_power;
mod motion;
mod no_allocation;
mod scene;
mod scene_round_trip;
mod speed;
mod stability;
mod structured;
mod teeth;
