//! An FMU in a process of its own: what it does to its memory stays there, and its crash is an error like others.

mod client;
mod process;
mod protocol;
mod server;

pub use client::IsolatedSlave;
pub use server::serve;
