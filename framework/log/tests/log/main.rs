//! Logs: what a controller's messages say and that they obey their schemas, and files on a disk.
#![cfg(feature = "mcap")]

mod controller;
mod files;
