//! What a residual shows: scored predictions come in, numbers go out.
//!
//! [`blocks`] compares two models by blocks of samples that count as independent; [`remainder`] asks whether a residual looks
//! like the noise, [`maps`] whether it repeats at the same places of the motion.

pub(super) mod blocks;
pub(super) mod maps;
pub(super) mod remainder;
