//! Beams: nonlinear modes and resonances, stability, and what hangs at the contact.

mod hung;
mod modes;
mod stability;
