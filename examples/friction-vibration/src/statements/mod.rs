//! What the paper says, held against its own model.

mod transients;

use stickslip::harmonic::CurveSettings;
use stickslip_report::document::{Block, Cell, Section};

use crate::Failure;
use crate::draw::{equivalent_stiffness, table};
use crate::sweeps::{FIXED, FRICTIONS, Resonance, STIFFNESSES, fraction};
use crate::system::{ABOVE_SUPERHARMONICS, FORCE, RANGE, System, X, Y, fine, linear, minimum};

/// A statement and what became of it.
struct Statement {
    figure: &'static str,
    said: &'static str,
    found: String,
    verdict: Verdict,
}

/// What became of a statement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Verdict {
    Holds,
    Roughly,
    Fails,
}

impl Verdict {
    fn of(holds: bool) -> Self {
        if holds { Verdict::Holds } else { Verdict::Fails }
    }
}

/// All statements, those that fail marked.
pub fn section(
    system: &System,
    forces: &[Resonance],
    frictions: &[Resonance],
) -> Result<(Section, usize), Failure> {
    let mut all = vec![slip_onset(system)?, minimal_receptance(system, forces)?];
    all.push(dissipated_fraction(system, forces)?);
    all.push(softening(forces));
    all.extend(friction(system, frictions)?);
    all.extend(transients::statements(system)?);
    all.push(printed_law(system)?);
    all.extend(stiffness(system)?);
    let (fail, hold): (Vec<_>, Vec<_>) = all.into_iter().partition(|one| one.verdict == Verdict::Fails);
    let failing = fail.len();
    let rows = |all: Vec<Statement>| {
        let row = |one: Statement| {
            let mark = match one.verdict {
                Verdict::Holds => Cell::text("holds"),
                Verdict::Roughly => Cell::text("holds roughly"),
                Verdict::Fails => Cell::Marked("not supported".into()),
            };
            [Cell::text(one.figure), Cell::text(one.said), Cell::text(one.found), mark]
        };
        all.into_iter().map(row).collect()
    };
    let heading = ["Figure", "The paper", "The model", ""];
    let section = Section {
        id: "statements".into(),
        title: "Statements of the paper that its own model does not support".into(),
        blocks: vec![
            Block::Text(
                "Each statement is computed with the equations and the parameters that the paper prints. With A/(μN₀) given \
                 the response divided by A is given too, so that figures 7 and 9 show one and the same dependence: \
                 μ at A = 0.4 N stands for A = 0.008 N/μ at μ = 0.02."
                    .into(),
            ),
            table("Statements that fail", heading, rows(fail)),
            Block::Text("Statements that hold:".into()),
            table("Statements that hold", heading, rows(hold)),
        ],
    };
    Ok((section, failing))
}

fn slip_onset(system: &System) -> Result<Statement, Failure> {
    let (frequency, receptance) = largest_stuck_receptance(system)?;
    let onset = system.limit() / (system.stiffness * receptance);
    let [below, above] = [0.99, 1.01].map(|factor| system.point(factor * onset, frequency, &fine()));
    let slips = below?.dissipated_energy() == 0.0 && above?.dissipated_energy() > 0.0;
    Ok(Statement {
        figure: "7",
        said: "The receptance stays constant, without dissipation, before the friction force surpasses its limit of 0.2 N.",
        found: format!(
            "The limit is μN₀ = {} N, and the contact begins to slip at A = {onset:.5} N, at ω = {frequency:.3} rad/s{}.",
            system.limit(),
            if slips { "; 1 % below that nothing is dissipated, 1 % above something is" } else { "" }
        ),
        verdict: Verdict::of((onset - 0.2).abs() < 0.02),
    })
}

fn minimal_receptance(system: &System, tracked: &[Resonance]) -> Result<Statement, Failure> {
    let of_x = best(tracked, |one| -one.x.peak.amplitude / one.value);
    let of_y = best(tracked, |one| -one.y.peak.amplitude / one.value);
    let around = |value: f64| (0.8 * value, 1.25 * value);
    let x = minimum(around(of_x), 1e-4, |force| Ok(system.first_peak(force, X)?.peak.amplitude / force))?;
    let y = minimum(around(of_y), 1e-4, |force| Ok(system.first_peak(force, Y)?.peak.amplitude / force))?;
    let at =
        |force: f64, node: usize| Ok::<_, Failure>(system.first_peak(force, node)?.peak.amplitude / force);
    Ok(Statement {
        figure: "7",
        said: "The receptance at the first resonance is smallest at A = 0.2 N.",
        found: format!(
            "It is smallest at A = {x:.3} N for x ({:.3} m/N; {:.3} at 0.2 N) and at {y:.3} N for y ({:.3} m/N; {:.3} at \
             0.2 N).",
            at(x, X)?,
            at(0.2, X)?,
            at(y, Y)?,
            at(0.2, Y)?
        ),
        verdict: Verdict::of((x - 0.2).abs() < 0.02 && (y - 0.2).abs() < 0.02),
    })
}

fn dissipated_fraction(system: &System, tracked: &[Resonance]) -> Result<Statement, Failure> {
    let start = best(tracked, |one| fraction(&one.y.point));
    let at = minimum((0.8 * start, 1.25 * start), 1e-4, |force| {
        Ok(-fraction(&system.first_peak(force, Y)?.point))
    })?;
    let largest = fraction(&system.first_peak(at, Y)?.point);
    let printed = fraction(&system.first_peak(0.2, Y)?.point);
    Ok(Statement {
        figure: "7",
        said: "The ratio of dissipated to input energy reaches its maximum at A = 0.2 N.",
        found: format!(
            "At the peak of y it is largest, {largest:.3}, at A = {at:.3} N; at 0.2 N it is {printed:.3}."
        ),
        verdict: Verdict::of((at - 0.2).abs() < 0.02),
    })
}

fn softening(tracked: &[Resonance]) -> Statement {
    let frequency: Vec<f64> = tracked.iter().map(|one| one.y.peak.angular_frequency).collect();
    let falls = frequency.windows(2).all(|pair| pair[1] <= pair[0] + 1e-6);
    let (first, last) = (frequency[0], frequency[frequency.len() - 1]);
    Statement {
        figure: "7, 8",
        said: "The first resonance frequency decreases as the force grows.",
        found: format!(
            "The peak of y goes from {first:.4} to {last:.4} rad/s between A = {} and {} N{}.",
            tracked[0].value,
            tracked[tracked.len() - 1].value,
            if falls { ", falling all the way" } else { "" }
        ),
        verdict: Verdict::of(falls && last < first),
    }
}

fn friction(system: &System, tracked: &[Resonance]) -> Result<[Statement; 4], Failure> {
    let fixed = |friction: f64| {
        Ok::<_, Failure>(system.with_friction(friction).point(FORCE, FIXED, &fine())?.dissipated_energy())
    };
    let at_peak = |friction: f64| {
        Ok::<_, Failure>(system.with_friction(friction).first_peak(FORCE, Y)?.point.dissipated_energy())
    };
    let at_fixed = minimum((0.04, 0.09), 1e-5, |friction| Ok(-fixed(friction)?))?;
    let start = best(tracked, |one| one.y.point.dissipated_energy());
    let at_tracked = minimum((0.8 * start, 1.25 * start), 1e-4, |friction| Ok(-at_peak(friction)?))?;
    let ends = system.stiffness * stuck_receptance(system, FIXED)? * FORCE / system.normal_load;
    let (_, receptance) = largest_stuck_receptance(system)?;
    let sticks = system.stiffness * receptance * FORCE / system.normal_load;
    let around = |value: f64| (0.8 * value, 1.25 * value);
    let x = best(tracked, |one| -one.x.peak.amplitude);
    let x = minimum(around(x), 1e-4, |friction| {
        Ok(system.with_friction(friction).first_peak(FORCE, X)?.peak.amplitude)
    })?;
    let y = best(tracked, |one| -one.y.peak.amplitude);
    let y = minimum(around(y), 1e-4, |friction| {
        Ok(system.with_friction(friction).first_peak(FORCE, Y)?.peak.amplitude)
    })?;
    Ok([
        Statement {
            figure: "10",
            said: "At the first resonance the dissipated energy increases from μ = 0.01 to 0.06 and then decreases.",
            found: format!(
                "At the first resonance it increases up to μ = {at_tracked:.3} ({:.4} J; {:.4} J at 0.06). Only at a fixed \
                 frequency it peaks earlier: at ω = {FIXED} rad/s at μ = {at_fixed:.4} ({:.4} J; {:.4}, {:.4} and {:.4} J at \
                 0.05, 0.06, 0.07).",
                at_peak(at_tracked)?,
                at_peak(0.06)?,
                fixed(at_fixed)?,
                fixed(0.05)?,
                fixed(0.06)?,
                fixed(0.07)?
            ),
            verdict: Verdict::of((at_tracked - 0.06).abs() < 0.01),
        },
        Statement {
            figure: "9, 10",
            said: "At μ = 0.3 the contact is fully stuck and the dissipation zero.",
            found: format!(
                "At the first resonance {:.4} J are dissipated at μ = 0.3; it is stuck above μ = {sticks:.3}. At ω = {FIXED} \
                 rad/s the dissipation ends at μ = {ends:.3}.",
                at_peak(0.3)?
            ),
            verdict: Verdict::of(sticks < 0.3),
        },
        Statement {
            figure: "9",
            said: "The receptance decreases with μ up to a critical μ = 0.1 and increases beyond.",
            found: format!("The peak is smallest at μ = {x:.3} for x and at μ = {y:.3} for y."),
            verdict: match ((x - 0.1).abs(), (y - 0.1).abs()) {
                (x, y) if x.max(y) < 0.01 => Verdict::Holds,
                (x, y) if x.max(y) < 0.05 => Verdict::Roughly,
                _ => Verdict::Fails,
            },
        },
        Statement {
            figure: "9",
            said: "The first resonance frequency increases with μ.",
            found: {
                let of = |friction: f64| {
                    Ok::<_, Failure>(system.with_friction(friction).first_peak(FORCE, Y)?.peak)
                };
                let all = FRICTIONS.iter().map(|&friction| Ok(of(friction)?.angular_frequency));
                let all = all.collect::<Result<Vec<f64>, Failure>>()?;
                let list: Vec<String> = all.iter().map(|frequency| format!("{frequency:.4}")).collect();
                format!("Peaks of y for the values of figure 9: {} rad/s.", list.join(", "))
            },
            verdict: Verdict::of(
                tracked
                    .windows(2)
                    .all(|pair| pair[1].y.peak.angular_frequency >= pair[0].y.peak.angular_frequency - 1e-6),
            ),
        },
    ])
}

fn printed_law(system: &System) -> Result<Statement, Failure> {
    let literal = system.with_contact_on(X)?;
    let settings = fine();
    let peaks = |one: &System| {
        let curve = one.curve(FORCE, RANGE, &settings)?;
        let of = |node: usize| {
            let shown: Vec<String> = curve
                .peaks
                .iter()
                .filter(|peak| peak.node == node && peak.angular_frequency > ABOVE_SUPERHARMONICS)
                .map(|peak| format!("{:.4} m at {:.4} rad/s", peak.amplitude, peak.angular_frequency))
                .collect();
            shown.join(" and ")
        };
        Ok::<_, Failure>((of(X), of(Y)))
    };
    let (on_first, on_second) = (peaks(&literal)?.1, peaks(system)?.1);
    Ok(Statement {
        figure: "eq. 2",
        said: "The friction force depends on x, the displacement of the first mass, and in slip on the velocity of the slider.",
        found: format!(
            "Equation 1 puts the force on the second mass, and a force that follows another mass’s displacement is no contact. \
             With the element on the second mass y peaks with {on_second}, as figure 4 has it; with the element on the first \
             mass, with {on_first}. In slip the slider moves with the mass, so that the sign is that of k_t (y − z)."
        ),
        verdict: Verdict::of(false),
    })
}

fn stiffness(system: &System) -> Result<Vec<Statement>, Failure> {
    let lowest = |low: f64, high: f64| {
        let of = |frequency: f64| Ok(equivalent_stiffness(&system.point(FORCE, frequency, &fine())?));
        minimum((low, high), 1e-6, of)
    };
    let (first, second) = (lowest(0.50, 0.58)?, lowest(1.25, 1.35)?);
    let stuck = stuck_above(system)?;
    let stays = system.point(FORCE, stuck * 1.001, &fine())?.dissipated_energy() == 0.0
        && system.point(FORCE, stuck * 0.999, &fine())?.dissipated_energy() > 0.0;
    let (spread, at, inner) = spread_over_stiffness(system)?;
    Ok(vec![
        Statement {
            figure: "13",
            said: "The equivalent stiffness is lowest at a resonance of 0.6 rad/s.",
            found: format!("It is lowest at ω = {first:.5} rad/s, where y peaks."),
            verdict: Verdict::of((first - 0.6).abs() < 0.02),
        },
        Statement {
            figure: "12, 13",
            said: "It declines again at the second resonance, 1.3 rad/s.",
            found: format!("The second minimum lies at ω = {second:.4} rad/s."),
            verdict: Verdict::of((second - 1.3).abs() < 0.01),
        },
        Statement {
            figure: "12",
            said: "At high frequency the contact is fully stuck and the equivalent stiffness is that of the contact.",
            found: format!("Stuck throughout above ω = {stuck:.5} rad/s."),
            verdict: Verdict::of(stays),
        },
        Statement {
            figure: "14",
            said: "Up to 1.3 rad/s the contact stiffness has no effect on the equivalent stiffness.",
            found: format!(
                "For k_t from {} to {} N/m the equivalent stiffness varies by up to {:.0} % of its smallest value below 1.3 \
                 rad/s (at ω = {at:.3} rad/s), and by {:.1} % at the first resonance.",
                STIFFNESSES[0],
                STIFFNESSES[STIFFNESSES.len() - 1],
                100.0 * spread,
                100.0 * inner
            ),
            verdict: match spread {
                spread if spread < 0.01 => Verdict::Holds,
                spread if spread < 0.25 => Verdict::Roughly,
                _ => Verdict::Fails,
            },
        },
    ])
}

/// How much k_eq varies with k_t below 1.3 rad/s, relative to its smallest value: the largest variation, where,
/// and the variation at the first minimum of k_eq.
fn spread_over_stiffness(system: &System) -> Result<(f64, f64, f64), Failure> {
    let spread = |frequency: f64| {
        let mut range = (f64::INFINITY, 0.0_f64);
        for stiffness in STIFFNESSES {
            let point = system.with_stiffness(stiffness).point(FORCE, frequency, &fine())?;
            let value = equivalent_stiffness(&point);
            range = (range.0.min(value), range.1.max(value));
        }
        Ok::<_, Failure>(range.1 / range.0 - 1.0)
    };
    let mut largest = (0.0, 0.0);
    for frequency in linear(RANGE.0, 1.3, 56) {
        let value = spread(frequency)?;
        if value > largest.0 {
            largest = (value, frequency);
        }
    }
    Ok((largest.0, largest.1, spread(0.541)?))
}

/// The frequency (rad/s) above which the contact sticks throughout at the force printed.
pub fn stuck_above(system: &System) -> Result<f64, Failure> {
    let (mut low, mut high) = (1.32, RANGE.1);
    let slips = |frequency: f64| {
        Ok::<_, Failure>(system.stiffness * stuck_receptance(system, frequency)? * FORCE > system.limit())
    };
    if !slips(low)? || slips(high)? {
        return Err(Failure::from("the contact does not go from slip to stick above the second resonance"));
    }
    while high - low > 1e-10 {
        let middle = 0.5 * (low + high);
        if slips(middle)? { low = middle } else { high = middle }
    }
    Ok(0.5 * (low + high))
}

/// The frequency (rad/s) at which the stuck contact moves most, and how much (m/N).
fn largest_stuck_receptance(system: &System) -> Result<(f64, f64), Failure> {
    let at = minimum((0.6, 0.75), 1e-9, |frequency| Ok(-stuck_receptance(system, frequency)?))?;
    Ok((at, stuck_receptance(system, at)?))
}

/// Displacement of the stuck contact per unit of force (m/N): under a force too small to make it slip all is linear.
fn stuck_receptance(system: &System, angular_frequency: f64) -> Result<f64, Failure> {
    const SMALL: f64 = 1e-6;
    let settings = CurveSettings { harmonics: 1, ..fine() };
    Ok(system.point(SMALL, angular_frequency, &settings)?.amplitude[Y] / SMALL)
}

/// The value at which `of` is largest.
fn best(tracked: &[Resonance], of: impl Fn(&Resonance) -> f64) -> f64 {
    tracked.iter().max_by(|a, b| of(a).total_cmp(&of(b))).map_or(f64::NAN, |one| one.value)
}
