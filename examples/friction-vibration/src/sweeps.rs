//! Figures 7 to 14: what force, friction and contact stiffness do.

use stickslip::harmonic::{Curve, Point};
use stickslip_report::document::{Axis, Block, Cell, Line, Panel, Plot, Scaling, Section, Stroke};

use crate::Failure;
use crate::draw::{equivalent_stiffness, frequency, hysteresis, ordered, over_frequency, plot, table};
use crate::system::{FORCE, RANGE, System, Tracked, X, Y, fine, linear, logarithmic};

/// Amplitudes of the force (N) of figures 7, 8 and 13; from stuck throughout to nearly free.
pub const FORCES: [f64; 8] = [0.002, 0.02, 0.04, 0.0632, 0.1, 0.2, 0.4, 0.8];
/// Coefficients of friction of figures 9, 10 and 12.
pub const FRICTIONS: [f64; 8] = [0.01, 0.02, 0.04, 0.06, 0.1, 0.126, 0.2, 0.3];
/// Contact stiffnesses (N/m) of figure 14.
pub const STIFFNESSES: [f64; 6] = [0.1, 0.2, 0.4, 0.6, 0.8, 1.0];
/// Near the first resonance of the model as printed (rad/s), where dissipation over μ is looked at too.
pub const FIXED: f64 = 0.54;

/// The first resonance of both masses at one value of a parameter.
pub struct Resonance {
    pub value: f64,
    pub x: Tracked,
    pub y: Tracked,
}

/// The first resonance over the force, from stuck to nearly free.
pub fn over_force(system: &System) -> Result<Vec<Resonance>, Failure> {
    let forces = logarithmic(0.01, 1.0, 41);
    forces.into_iter().map(|force| resonance(system, force, force)).collect()
}

/// The first resonance over the coefficient of friction.
pub fn over_friction(system: &System) -> Result<Vec<Resonance>, Failure> {
    let frictions = linear(0.01, 0.5, 50);
    frictions
        .into_iter()
        .map(|friction| resonance(&system.with_friction(friction), FORCE, friction))
        .collect()
}

fn resonance(system: &System, force: f64, value: f64) -> Result<Resonance, Failure> {
    Ok(Resonance { value, x: system.first_peak(force, X)?, y: system.first_peak(force, Y)? })
}

/// Figures 7 and 8.
pub fn force_section(system: &System, tracked: &[Resonance]) -> Result<Section, Failure> {
    let curves = curves(system, &FORCES, |force| (system.clone(), force))?;
    let over_force = |node: usize, name: &str| {
        let y = Axis::new(format!("{name} over force"), "m/N").scaled(Scaling::Either);
        let lines = named(&curves, "A", "N", |_, force, point| point.amplitude[node] / force);
        plot(
            format!("Figure 7. Receptance {name}/A over frequency for amplitudes A of the force."),
            true,
            frequency(),
            y,
            lines,
        )
    };
    let peaks = |name: &str, of: fn(&Resonance) -> f64, index: usize| Line {
        name: name.to_owned(),
        x: tracked.iter().map(|one| one.value).collect(),
        y: tracked.iter().map(of).collect(),
        stroke: ordered(index, 3),
    };
    let tracked_plot = Plot {
        caption: "Receptance at the first resonance over the force, each mass at its own peak; below, the fraction of the \
                  work of the force that friction takes there."
            .into(),
        half: false,
        x: Axis::new("amplitude A of the force", "N").scaled(Scaling::Logarithmic),
        panels: vec![
            Panel {
                y: Axis::new("peak receptance", "m/N"),
                lines: vec![
                    peaks("x/A", |one| one.x.peak.amplitude / one.value, 0),
                    peaks("y/A", |one| one.y.peak.amplitude / one.value, 2),
                ],
            },
            Panel {
                y: Axis::new("dissipated / work", "1"),
                lines: vec![peaks("at the peak of y", |one| fraction(&one.y.point), 1)],
            },
        ],
    };
    let loops = FORCES.iter().enumerate().map(|(index, &force)| {
        let at = system.first_peak(force, Y)?;
        hysteresis(format!("A = {force} N"), system, &at.point, ordered(index, FORCES.len()))
    });
    let loops = loops.collect::<Result<Vec<_>, _>>()?;
    let (u, force) = (Axis::new("displacement y", "m"), Axis::new("friction force", "N"));
    let loops = plot("Figure 8. Loops at the first resonance (peak of y).", false, u, force, loops);
    let rows = FORCES.iter().map(|&force| {
        let (x, y) = (system.first_peak(force, X)?, system.first_peak(force, Y)?);
        Ok([
            Cell::Number(force, 4),
            Cell::Number(x.peak.angular_frequency, 6),
            Cell::Number(x.peak.amplitude / force, 6),
            Cell::Number(y.peak.angular_frequency, 6),
            Cell::Number(y.peak.amplitude / force, 6),
            Cell::Number(y.point.dissipated_energy(), 6),
            Cell::Number(fraction(&y.point), 4),
            Cell::Number(equivalent_stiffness(&y.point), 6),
        ])
    });
    let rows = rows.collect::<Result<Vec<_>, Failure>>()?;
    Ok(Section {
        id: "force".into(),
        title: "Figures 7 and 8: amplitude of the force".into(),
        blocks: vec![
            Block::Plots(vec![over_force(X, "x"), over_force(Y, "y"), tracked_plot, loops]),
            table(
                "First resonance over the force",
                [
                    "A (N)",
                    "ω of x (rad/s)",
                    "x/A (m/N)",
                    "ω of y (rad/s)",
                    "y/A (m/N)",
                    "Dissipated at y (J)",
                    "Fraction of the work",
                    "k_eq (N/m)",
                ],
                rows,
            ),
        ],
    })
}

/// Figures 9 and 10.
pub fn friction_section(system: &System, tracked: &[Resonance]) -> Result<Section, Failure> {
    let curves = curves(system, &FRICTIONS, |friction| (system.with_friction(friction), FORCE))?;
    let response = |node: usize, name: &str| {
        let y = Axis::new(format!("{name} over force"), "m/N").scaled(Scaling::Either);
        let lines = named(&curves, "μ", "", |_, _, point| point.amplitude[node] / FORCE);
        let caption = format!("Figure 9. Receptance {name}/A over frequency for coefficients of friction μ.");
        plot(caption, true, frequency(), y, lines)
    };
    let fixed = fixed_dissipation(system, &linear(0.005, 0.5, 100))?;
    let at_peak = Line {
        name: "at the peak of y".into(),
        x: tracked.iter().map(|one| one.value).collect(),
        y: tracked.iter().map(|one| one.y.point.dissipated_energy()).collect(),
        stroke: ordered(0, 2),
    };
    let at_fixed = Line {
        name: format!("at ω = {FIXED} rad/s"),
        x: fixed.iter().map(|(friction, _)| *friction).collect(),
        y: fixed.iter().map(|(_, energy)| *energy).collect(),
        stroke: ordered(1, 2),
    };
    let energy = plot(
        "Energy that friction takes per cycle over μ: along the resonance, and at a frequency that stays.",
        false,
        Axis::new("coefficient of friction μ", "1"),
        Axis::new("energy per cycle", "J"),
        vec![at_peak, at_fixed],
    );
    let loops = |caption: &str, at: &dyn Fn(&System) -> Result<Point, Failure>| {
        let lines = FRICTIONS.iter().enumerate().map(|(index, &friction)| {
            let one = system.with_friction(friction);
            hysteresis(format!("μ = {friction}"), &one, &at(&one)?, ordered(index, FRICTIONS.len()))
        });
        let lines = lines.collect::<Result<Vec<_>, _>>()?;
        let (u, force) = (Axis::new("displacement y", "m"), Axis::new("friction force", "N"));
        Ok::<_, Failure>(plot(caption, true, u, force, lines))
    };
    let tracked_loops = loops("Figure 10. Loops at the first resonance (peak of y).", &|one| {
        Ok(one.first_peak(FORCE, Y)?.point)
    })?;
    let caption = format!("The same at ω = {FIXED} rad/s throughout.");
    let fixed_loops = loops(&caption, &|one| one.point(FORCE, FIXED, &fine()))?;
    let rows = FRICTIONS.iter().map(|&friction| {
        let one = system.with_friction(friction);
        let (x, y, there) =
            (one.first_peak(FORCE, X)?, one.first_peak(FORCE, Y)?, one.point(FORCE, FIXED, &fine())?);
        Ok([
            Cell::Number(friction, 3),
            Cell::Number(x.peak.amplitude / FORCE, 6),
            Cell::Number(y.peak.angular_frequency, 6),
            Cell::Number(y.peak.amplitude / FORCE, 6),
            Cell::Number(y.point.dissipated_energy(), 6),
            Cell::Number(equivalent_stiffness(&y.point), 6),
            Cell::Number(there.dissipated_energy(), 6),
        ])
    });
    let rows = rows.collect::<Result<Vec<_>, Failure>>()?;
    let heading = format!("Dissipated at ω = {FIXED} (J)");
    Ok(Section {
        id: "friction".into(),
        title: "Figures 9 and 10: coefficient of friction".into(),
        blocks: vec![
            Block::Plots(vec![response(X, "x"), response(Y, "y"), energy, tracked_loops, fixed_loops]),
            table(
                "First resonance over the coefficient of friction",
                [
                    "μ",
                    "x/A (m/N)",
                    "ω of y (rad/s)",
                    "y/A (m/N)",
                    "Dissipated at y (J)",
                    "k_eq at y (N/m)",
                    &heading,
                ],
                rows,
            ),
        ],
    })
}

/// Energy per cycle (J) over μ at the fixed frequency.
pub fn fixed_dissipation(system: &System, frictions: &[f64]) -> Result<Vec<(f64, f64)>, Failure> {
    let energy = |&friction: &f64| {
        let point = system.with_friction(friction).point(FORCE, FIXED, &fine())?;
        Ok((friction, point.dissipated_energy()))
    };
    frictions.iter().map(energy).collect()
}

/// Figures 12 to 14.
pub fn stiffness_section(system: &System) -> Result<Section, Failure> {
    let forces: Vec<f64> = FORCES[3..].to_vec();
    let by_friction = curves(system, &FRICTIONS, |friction| (system.with_friction(friction), FORCE))?;
    let by_force = curves(system, &forces, |force| (system.clone(), force))?;
    let by_stiffness = curves(system, &STIFFNESSES, |stiffness| (system.with_stiffness(stiffness), FORCE))?;
    let figure = |caption: &str, curves: &[(f64, Curve)], what: &str, unit: &str| {
        let lines = named(curves, what, unit, |_, _, point| equivalent_stiffness(point));
        let y = Axis::new("equivalent stiffness", "N/m").scaled(Scaling::Either);
        plot(caption, false, frequency(), y, lines)
    };
    let plots = vec![
        figure(
            "Figure 12. Equivalent stiffness over frequency for coefficients of friction μ at A = 0.4 N.",
            &by_friction,
            "μ",
            "",
        ),
        figure("Figure 13. The same for amplitudes A of the force.", &by_force, "A", "N"),
        figure(
            "Figure 14. The same for stiffnesses k_t of the contact at A = 0.4 N.",
            &by_stiffness,
            "k_t",
            "N/m",
        ),
    ];
    Ok(Section {
        id: "stiffness".into(),
        title: "Figures 12 to 14: equivalent stiffness".into(),
        blocks: vec![
            Block::Text(
                "The equivalent stiffness is the slope of the contact’s loop from tip to tip (figure 11): μN over the \
                 amplitude of y in slip, k_t in stick."
                    .into(),
            ),
            Block::Plots(plots),
            extremes(system)?,
        ],
    })
}

/// Minima and maximum of the equivalent stiffness of the model as printed, and where it sticks.
fn extremes(system: &System) -> Result<Block, Failure> {
    let row = |name: &str, near: (f64, f64), sign: f64| {
        let of = |frequency: f64| Ok(sign * equivalent_stiffness(&system.point(FORCE, frequency, &fine())?));
        let at = crate::system::minimum(near, 1e-6, of)?;
        let value = equivalent_stiffness(&system.point(FORCE, at, &fine())?);
        Ok::<_, Failure>([Cell::text(name), Cell::Number(at, 5), Cell::Number(value, 6)])
    };
    let stuck = crate::statements::stuck_above(system)?;
    Ok(table(
        "Equivalent stiffness at A = 0.4 N",
        ["At μ = 0.02, k_t = 0.2 N/m, A = 0.4 N", "ω (rad/s)", "k_eq (N/m)"],
        vec![
            row("minimum at the first resonance", (0.50, 0.58), 1.0)?,
            row("maximum between the resonances", (0.8, 1.2), -1.0)?,
            row("minimum at the second resonance", (1.25, 1.35), 1.0)?,
            [Cell::text("stuck throughout above"), Cell::Number(stuck, 5), Cell::Number(system.stiffness, 6)],
        ],
    ))
}

/// The response at each of `values`.
pub fn curves(
    _system: &System,
    values: &[f64],
    variant: impl Fn(f64) -> (System, f64),
) -> Result<Vec<(f64, Curve)>, Failure> {
    let one = |&value: &f64| {
        let (system, force) = variant(value);
        Ok((value, system.curve(force, RANGE, &fine())?))
    };
    values.iter().map(one).collect()
}

fn named(
    curves: &[(f64, Curve)],
    what: &str,
    unit: &str,
    value: impl Fn(usize, f64, &Point) -> f64,
) -> Vec<Line> {
    let line = |(index, (parameter, curve)): (usize, &(f64, Curve))| {
        let name = format!("{what} = {parameter} {unit}").trim_end().to_owned();
        let stroke: Stroke = ordered(index, curves.len());
        over_frequency(name, curve, stroke, |point| value(index, *parameter, point))
    };
    curves.iter().enumerate().map(line).collect()
}

/// Fraction of the work of the excitation that the contact takes.
pub fn fraction(point: &Point) -> f64 {
    if point.work > 0.0 { point.dissipated_energy() / point.work } else { 0.0 }
}
