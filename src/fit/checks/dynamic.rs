//! Units that are off by powers of ten, where a structure and its model part: frequencies, and the response to the force.

use std::f64::consts::TAU;

use super::scale::APART;
use super::{Fault, Finding, finding, is_sound, quantile};
use crate::data::{Record, Regime};
use crate::model::{Model, Structure};
use crate::numeric::spectrum::hann_lines;
use crate::system::{LinearStructure, NaturalModes};

/// Ratio of frequencies that no change of parameters makes: stiffness off by 10³ makes 31.6.
const FREQUENCIES: f64 = 20.0;
/// Damping of every mode where only the size of a response matters.
const DAMPED: f64 = 0.02;
/// Radians of a mode in a step of its integration.
const FINE: f64 = 0.05;
/// Periods in a record below which a line of it may be a jump or a drift; a steady state has neither.
const DRIFT: usize = 3;

/// What a model says of its structure with the contact free and with the contact stuck.
pub(super) struct Linear {
    structure: LinearStructure,
    modes: Vec<NaturalModes>,
    key: &'static str,
}

impl Linear {
    /// `None` for a contact alone, and for a model that makes no system or one too large to be solved at once.
    pub fn of(model: &Model) -> Option<Self> {
        let key = match model.structure {
            Structure::Prescribed => return None,
            Structure::Beam(_) | Structure::PinRig(_) => "beam.youngs_modulus",
            _ => "spring",
        };
        let system = model.system().ok()?;
        let stiffness = model.contact.map_or(0.0, |contact| contact.tangential_stiffness);
        let (structure, stuck) = (system.linear_part(), system.stuck_part(stiffness));
        let modes =
            [&structure, &stuck].into_iter().map(|one| one.natural_modes().ok()).collect::<Option<_>>()?;
        Some(Self { structure, modes, key })
    }

    /// Natural frequencies (Hz) with the contact free, and stuck, in rising order.
    pub fn natural_frequencies(&self) -> [Vec<f64>; 2] {
        [0, 1].map(|which| {
            let mut all: Vec<f64> = self.modes[which].angular_frequency.iter().map(|one| one / TAU).collect();
            all.sort_by(f64::total_cmp);
            all
        })
    }

    /// Lowest and highest natural frequency (Hz), whatever the contact does.
    fn frequencies(&self) -> Option<[f64; 2]> {
        let all = self.modes.iter().flat_map(|modes| modes.angular_frequency.iter().copied());
        let all: Vec<f64> = all.filter(|one| *one > 0.0).map(|one| one / TAU).collect();
        Some([all.iter().copied().reduce(f64::min)?, all.iter().copied().reduce(f64::max)?])
    }

    /// Amplitude of the displacement at `output` (m) for a force of 1 N at `frequency` (Hz), the contact free and stuck.
    fn responses(&self, output: &str, frequency: f64) -> Option<Vec<f64>> {
        let row = &self.structure.outputs.iter().find(|one| one.name == output)?.row;
        let speed = TAU * frequency;
        let response = |modes: &NaturalModes| {
            let (mut real, mut imaginary) = (0.0, 0.0);
            for (mode, omega) in modes.angular_frequency.iter().enumerate() {
                let along =
                    |row: &[(usize, f64)]| row.iter().map(|(i, b)| b * modes.shapes[(*i, mode)]).sum::<f64>();
                let (stiff, damped) = (omega * omega - speed * speed, 2.0 * DAMPED * omega * speed);
                let part = along(row) * along(&self.structure.excitation) / (stiff * stiff + damped * damped);
                (real, imaginary) = (real + part * stiff, imaginary - part * damped);
            }
            real.hypot(imaginary)
        };
        Some(self.modes.iter().map(response).collect())
    }

    /// What `output` does from rest under `force` (N) at samples `step` (s) apart, all frequencies of the model times `faster`: with the
    /// contact free, and stuck. `order` counts derivatives of the displacement (m).
    pub fn response_from_rest(
        &self,
        output: &str,
        order: usize,
        force: &[f64],
        step: f64,
        faster: f64,
    ) -> Option<Vec<Vec<f64>>> {
        let row = &self.structure.outputs.iter().find(|one| one.name == output)?.row;
        let response = |modes: &NaturalModes| {
            let mut all = vec![0.0; force.len()];
            for (mode, omega) in modes.angular_frequency.iter().enumerate() {
                let along =
                    |row: &[(usize, f64)]| row.iter().map(|(i, b)| b * modes.shapes[(*i, mode)]).sum::<f64>();
                let weight = along(row) * along(&self.structure.excitation);
                let moved = mode_from_rest(faster * omega, force, step);
                all.iter_mut().zip(moved).for_each(|(sum, state)| *sum += weight * state[order]);
            }
            all
        };
        Some(self.modes.iter().map(response).collect())
    }
}

/// Displacement, velocity and acceleration of a mode of mass 1 from rest, the force straight between its samples.
fn mode_from_rest(omega: f64, force: &[f64], step: f64) -> Vec<[f64; 3]> {
    let parts = (omega * step / FINE).ceil().clamp(1.0, 1e4);
    let fine = step / parts;
    let (mut u, mut v) = (0.0, 0.0);
    let acceleration = |force: f64, u: f64, v: f64| force - 2.0 * DAMPED * omega * v - omega * omega * u;
    let mut states = Vec::with_capacity(force.len());
    for (k, now) in force.iter().enumerate() {
        states.push([u, v, acceleration(*now, u, v)]);
        let next = force.get(k + 1).unwrap_or(now);
        for part in 0..parts as usize {
            v += fine * acceleration(now + (next - now) * (part as f64 + 0.5) / parts, u, v);
            u += fine * v;
        }
    }
    states
}

/// The frequencies at which a structure moves against the model's natural ones.
pub(super) fn of_frequencies(
    linear: &Linear,
    records: &[Record],
    told: &[Vec<Finding>],
    found: &mut Vec<Finding>,
) {
    let Some([lowest, highest]) = linear.frequencies() else { return };
    let measured = records.iter().zip(told).filter_map(|(record, told)| frequency(record, told));
    let measured: Vec<f64> = measured.collect();
    let (Some(least), Some(most)) =
        (measured.iter().copied().reduce(f64::min), measured.iter().copied().reduce(f64::max))
    else {
        return;
    };
    let mut add = |measured, modelled, cause| {
        let what = "frequency of the motion";
        let fault = Fault::Scale { what, measured, modelled, unit: "Hz", cause };
        found.push(Finding { record: None, channel: Some(linear.key.to_owned()), fault });
    };
    if least > FREQUENCIES * highest {
        add(
            least,
            highest,
            "the model is far too soft or too heavy, as with a stiffness or Young’s modulus in N/mm, N/mm² or GPa, or \
             a mass in g",
        );
    } else if most * FREQUENCIES < lowest {
        add(
            most,
            lowest,
            "the model is far too stiff or too light, as with a mass in t or a length in mm, or the time is in ms where s is \
             said",
        );
    }
}

/// The size of the response to the excitation, where it is largest, against what the model says.
pub(super) fn of_response(linear: &Linear, record: &Record, found: &mut Vec<Finding>) {
    let mut driven = record.channels_of("excitation");
    let (Some(excitation), None, Some(step)) = (driven.next(), driven.next(), record.sample_step()) else {
        return;
    };
    let Some(force) = hann_lines(&excitation.values).filter(|_| is_sound(found, excitation)) else { return };
    for (order, quantity) in ["displacement", "velocity", "acceleration"].into_iter().enumerate() {
        for channel in record.channels_of(quantity) {
            let Some(moved) = hann_lines(&channel.values).filter(|_| is_sound(found, channel)) else {
                continue;
            };
            let size = |k: &usize| force[*k].norm() * moved[*k].norm();
            let most = (1..force.len()).max_by(|a, b| size(a).total_cmp(&size(b)));
            let Some(most) = most.filter(|line| is_motion(record, *line)) else { continue };
            let frequency = most as f64 / (step * channel.values.len() as f64);
            let measured = moved[most].norm() / force[most].norm();
            let output = channel.name.split_once(':').map_or("", |(_, place)| place);
            let Some(modelled) = linear.responses(output, frequency) else { continue };
            let modelled = modelled.into_iter().map(|one| one * (TAU * frequency).powi(order as i32));
            let (low, high) =
                modelled.fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), x| (low.min(x), high.max(x)));
            let (nearest, cause) = if measured > APART * high {
                (high, "its unit is too large, as m for mm, or that of the excitation too small, as N for kN")
            } else if measured * APART < low {
                (low, "its unit is too small, as mm for m, or that of the excitation too large, as kN for N")
            } else {
                continue;
            };
            let unit = ["m/N", "m/s/N", "m/s^2/N"][order];
            let what = "response to the excitation";
            found.push(finding(
                record,
                &channel.name,
                Fault::Scale { what, measured, modelled: nearest, unit, cause },
            ));
        }
    }
}

/// The frequency (Hz) at which a record moves most: of a table the middle of its column.
fn frequency(record: &Record, told: &[Finding]) -> Option<f64> {
    if let Some(column) = record.channel("frequency") {
        return Some(quantile(&column.values, 0.5));
    }
    let step = record.sample_step()?;
    let moved = ["acceleration", "velocity", "displacement"];
    let mut channels = moved.iter().flat_map(|quantity| record.channels_of(quantity));
    let channel = channels.find(|channel| is_sound(told, channel))?;
    let lines = hann_lines(&channel.values)?;
    let most = (1..lines.len()).max_by(|a, b| lines[*a].norm().total_cmp(&lines[*b].norm()));
    let most = most.filter(|line| is_motion(record, *line))?;
    Some(most as f64 / (step * channel.values.len() as f64))
}

/// Whether the largest line of a record is that of a motion: a jump or a drift of the chain has its largest among the first.
fn is_motion(record: &Record, line: usize) -> bool {
    line >= DRIFT || record.regime == Regime::Steady
}
