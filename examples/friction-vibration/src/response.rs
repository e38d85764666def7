//! Figures 4 to 6: the response by harmonic balance and in the time domain.

use stickslip::harmonic::{CurveSettings, Point};
use stickslip_report::document::{Axis, Block, Cell, Line, Plot, Scaling, Section, Stroke};

use crate::Failure;
use crate::draw::{frequency, hysteresis, over_frequency, plot, table};
use crate::system::{ABOVE_SUPERHARMONICS, FORCE, RANGE, System, X, Y, fine, linear};
use crate::time_domain::{self, Motion};

/// Frequencies of the table (rad/s): the paper's loop, both resonances, between them, and in stick.
const FREQUENCIES: [f64; 5] = [0.5, 0.541, 1.0, 1.3, 2.0];
/// Numbers of harmonics whose error is shown.
const HARMONICS: [usize; 6] = [1, 3, 7, 21, 51, 101];
/// Blue and orange that all forms of colour blindness tell apart.
const COLOURS: [&str; 2] = ["#0072B2", "#D55E00"];

/// Free and stuck natural frequencies.
pub fn system_section(system: &System) -> Result<Section, Failure> {
    let natural = |structure: &stickslip::system::LinearStructure| {
        let modes = structure.natural_modes()?;
        Ok::<_, Failure>(modes.angular_frequency)
    };
    let (free, stuck) = (natural(system.structure())?, natural(&system.stuck())?);
    let row = |name: &str, values: &[f64]| {
        [Cell::text(name), Cell::Number(values[0], 7), Cell::Number(values[1], 7)]
    };
    Ok(Section {
        id: "system".into(),
        title: "The system".into(),
        blocks: vec![
            Block::Text(
                "Two masses of 1 kg; a spring of 1 N/m holds the first (x) to the ground, one of 0.5 N/m the second (y) to \
                 the first, and dampers of 0.1 N s/m each of them to the ground. A force A cos ωt of 0.4 N acts on the first \
                 mass. The second rubs on the ground: a Jenkins element of k_t = 0.2 N/m under a normal load of 1 N with a \
                 coefficient of friction of 0.02. The heading of table 1 of the paper is lost; this is the reading that \
                 its figures and its text fit."
                    .into(),
            ),
            table(
                "Undamped natural frequencies (rad/s)",
                ["Undamped natural frequencies (rad/s)", "First", "Second"],
                vec![row("contact sliding without friction", &free), row("contact stuck", &stuck)],
            ),
        ],
    })
}

/// Figures 4 and 5, and the largest relative deviation between the methods.
pub fn response_section(system: &System) -> Result<(Section, f64), Failure> {
    let settings = CurveSettings { max_step: 0.004, stability: true, ..fine() };
    let curve = system.curve(FORCE, RANGE, &settings)?;
    let mut times = Vec::new();
    for frequency in linear(RANGE.0, RANGE.1, 37) {
        times.push((frequency, time_domain::periodic(system, FORCE, frequency, false)?));
    }
    let names = ["x", "y"];
    let balance = names.iter().enumerate().map(|(node, name)| {
        let name = format!("{name}, harmonic balance");
        over_frequency(name, &curve, Stroke::solid(COLOURS[node]), |point| point.amplitude[node])
    });
    let time = names.iter().enumerate().map(|(node, name)| Line {
        name: format!("{name}, time integration"),
        x: times.iter().map(|(frequency, _)| *frequency).collect(),
        y: times.iter().map(|(_, motion)| motion.amplitude[node]).collect(),
        stroke: Stroke::points(COLOURS[node], "circle-open"),
    });
    let response = plot(
        "Figures 4 and 5. Largest displacement of the masses over a period by harmonic balance with 21 harmonics \
         (lines) and by time integration to the periodic state (circles).",
        false,
        frequency(),
        Axis::new("displacement", "m").scaled(Scaling::Either),
        balance.chain(time).collect(),
    );
    let (mut rows, mut deviation) = (Vec::new(), 0.0);
    for frequency in FREQUENCIES {
        deviation = f64::max(deviation, compared(system, &mut rows, format!("ω = {frequency}"), frequency)?);
    }
    for (node, name) in names.iter().enumerate() {
        let peaks = curve
            .peaks
            .iter()
            .filter(|peak| peak.node == node && peak.angular_frequency > ABOVE_SUPERHARMONICS);
        for (order, peak) in ["first", "second"].iter().zip(peaks) {
            let name = format!("{order} peak of {name}");
            deviation = f64::max(deviation, compared(system, &mut rows, name, peak.angular_frequency)?);
        }
    }
    let section = Section {
        id: "response".into(),
        title: "Figures 4 and 5: response".into(),
        blocks: vec![
            Block::Plots(vec![response]),
            table(
                "Response by both methods",
                [
                    "", "ω (rad/s)", "x (m)", "y (m)", "Dissipated (J)", "Work (J)", "Largest deviation",
                ],
                rows,
            ),
            Block::Note(
                "Harmonic balance with 21 harmonics; the deviation is the largest of x, y, dissipation and work from time \
                 integration, each relative to itself."
                    .into(),
            ),
            truncation(system)?,
        ],
    };
    Ok((section, deviation))
}

/// A row with the response at one frequency, harmonic balance against time integration. Returns how far they
/// are apart.
fn compared(
    system: &System,
    rows: &mut Vec<[Cell; 7]>,
    name: String,
    frequency: f64,
) -> Result<f64, Failure> {
    let point = system.point(FORCE, frequency, &fine())?;
    let motion = time_domain::periodic(system, FORCE, frequency, false)?;
    let deviation = deviations(&point, &motion).into_iter().fold(0.0, f64::max);
    rows.push([
        Cell::text(name),
        Cell::Number(frequency, 6),
        Cell::Number(point.amplitude[X], 9),
        Cell::Number(point.amplitude[Y], 9),
        Cell::Number(point.dissipated_energy(), 9),
        Cell::Number(point.work, 8),
        Cell::Scientific(deviation),
    ]);
    Ok(deviation)
}

/// Relative deviations of x, y, dissipation (where there is any) and work.
fn deviations(point: &Point, motion: &Motion) -> [f64; 4] {
    let relative = |ours: f64, theirs: f64| {
        if theirs.abs() > 1e-12 { (ours / theirs - 1.0).abs() } else { (ours - theirs).abs() }
    };
    [
        relative(point.amplitude[X], motion.amplitude[X]),
        relative(point.amplitude[Y], motion.amplitude[Y]),
        relative(point.dissipated_energy(), motion.dissipated),
        relative(point.work, motion.work),
    ]
}

/// What the number of harmonics costs at the paper's loop.
fn truncation(system: &System) -> Result<Block, Failure> {
    let motion = time_domain::periodic(system, FORCE, 0.5, false)?;
    let rows = HARMONICS.iter().map(|&harmonics| {
        let point = system.point(FORCE, 0.5, &CurveSettings { harmonics, ..fine() })?;
        let [x, y, dissipated, work] = deviations(&point, &motion);
        let cells = [x, y, dissipated, work].map(Cell::Scientific);
        let [x, y, dissipated, work] = cells;
        Ok([Cell::Count(harmonics), x, y, dissipated, work, Cell::Scientific(point.error_estimate)])
    });
    Ok(table(
        "Error of harmonic balance at ω = 0.5 rad/s",
        [
            "Harmonics, at ω = 0.5 rad/s",
            "Error of x",
            "Of y",
            "Of the dissipation",
            "Of the work",
            "Estimate",
        ],
        rows.collect::<Result<_, Failure>>()?,
    ))
}

/// Figure 6.
pub fn loop_section(system: &System) -> Result<Section, Failure> {
    let (force, frequency) = (FORCE, 0.5);
    let point = system.point(force, frequency, &fine())?;
    let motion = time_domain::periodic(system, force, frequency, true)?;
    let balance = hysteresis("harmonic balance".into(), system, &point, Stroke::solid(COLOURS[0]))?;
    let (x, y) = motion.contact.clone().unwrap_or_default();
    let mut every = Stroke::points(COLOURS[1], "circle-open");
    every.note = "";
    let time = Line {
        name: "time integration".into(),
        x: x.iter().step_by(6).copied().collect(),
        y: y.iter().step_by(6).copied().collect(),
        stroke: every,
    };
    let (u, f) = (Axis::new("displacement y", "m"), Axis::new("friction force", "N"));
    let figure: Plot =
        plot("Figure 6. Loop of the contact at ω = 0.5 rad/s.", false, u, f, vec![balance, time]);
    let amplitude = point.amplitude[Y];
    let limit = system.limit();
    let closed = 4.0 * limit * (amplitude - limit / system.stiffness);
    let row = |name: &str, energy: f64| [Cell::text(name), Cell::Number(energy, 10)];
    Ok(Section {
        id: "loop".into(),
        title: "Figure 6: loop at ω = 0.5 rad/s".into(),
        blocks: vec![
            Block::Plots(vec![figure]),
            table(
                "Dissipated energy",
                ["Energy per cycle at ω = 0.5 rad/s", "(J)"],
                vec![
                    row("harmonic balance, 21 harmonics", point.dissipated_energy()),
                    row("time integration", motion.dissipated),
                    row("closed form 4 μN (Y − μN/k_t) with the Y of harmonic balance", closed),
                ],
            ),
        ],
    })
}
