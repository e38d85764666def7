//! Records whose first sample finds the model in a state that nobody knows: the state is made of unknowns of the
//! record, which a fit finds beside the parameters of the model.

mod contact;
mod hypothesis;
mod oscillator;

pub(super) use contact::ContactOfUnknownStart;
pub(super) use oscillator::OscillatorOfUnknownStart;
