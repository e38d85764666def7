//! The sealed cases: each is its name, and its name is its seed.

use std::fmt;

use crate::beam::Beam;
use crate::effect::{Hidden, UNKNOWN};
use crate::motion::Drive;
use crate::oscillator::Oscillator;
use crate::prescribed::Prescribed;
use crate::random::Random;
use crate::record::Record;
use crate::rig::Rig;

/// Kind of model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A bare contact.
    Contact,
    /// Two masses and a contact.
    Oscillator,
    /// The beam with a frictional support.
    Beam,
}

impl Kind {
    /// All of them.
    pub const ALL: [Kind; 3] = [Kind::Contact, Kind::Oscillator, Kind::Beam];

    /// The word in a model file.
    pub fn word(self) -> &'static str {
        match self {
            Kind::Contact => "contact",
            Kind::Oscillator => "oscillator",
            Kind::Beam => "beam",
        }
    }

    /// The catalogue's effects that can be hidden in it.
    pub fn effects(self) -> &'static [&'static str] {
        match self {
            Kind::Contact => &[
                "micro_slip",
                "residual_stiffness",
                "normal_load_variation",
                "contact_damping",
                "velocity_weakening",
                "wear",
                "backlash",
                "stiffening",
                "asymmetry",
                "normal_hardening",
                "impact_damping",
                "sensor_delay",
                "sensor_offset",
            ],
            Kind::Oscillator => &[
                "micro_slip",
                "residual_stiffness",
                "normal_load_variation",
                "contact_damping",
                "velocity_weakening",
                "wear",
                "backlash",
                "stiffening",
                "asymmetry",
                "geometric_stiffening",
                "quadratic_damping",
                "added_mass",
                "hanging_mass",
                "sensor_delay",
                "sensor_gain",
                "sensor_offset",
            ],
            Kind::Beam => &[
                "micro_slip",
                "residual_stiffness",
                "normal_load_variation",
                "contact_damping",
                "velocity_weakening",
                "backlash",
                "stiffening",
                "asymmetry",
                "geometric_stiffening",
                "quadratic_damping",
                "added_mass",
                "support_compliance",
                "hanging_mass",
                "sensor_delay",
                "sensor_gain",
                "sensor_offset",
            ],
        }
    }

    fn pairs(self) -> &'static [[&'static str; 2]] {
        match self {
            Kind::Contact => &[
                ["backlash", "micro_slip"],
                ["velocity_weakening", "asymmetry"],
                ["residual_stiffness", "wear"],
                ["micro_slip", "residual_stiffness"],
                ["stiffening", "asymmetry"],
                ["backlash", "stiffening"],
                ["normal_load_variation", "micro_slip"],
                ["contact_damping", "backlash"],
                ["velocity_weakening", "residual_stiffness"],
                ["wear", "backlash"],
                ["sensor_offset", "micro_slip"],
                ["sensor_delay", "stiffening"],
                ["normal_load_variation", "velocity_weakening"],
                ["asymmetry", "micro_slip"],
            ],
            Kind::Oscillator => &[
                ["geometric_stiffening", "micro_slip"],
                ["quadratic_damping", "backlash"],
                ["added_mass", "residual_stiffness"],
                ["velocity_weakening", "geometric_stiffening"],
                ["contact_damping", "asymmetry"],
                ["micro_slip", "added_mass"],
                ["normal_load_variation", "quadratic_damping"],
                ["backlash", "stiffening"],
                ["sensor_gain", "micro_slip"],
                ["wear", "geometric_stiffening"],
            ],
            Kind::Beam => &[
                ["micro_slip", "added_mass"],
                ["residual_stiffness", "quadratic_damping"],
                ["micro_slip", "residual_stiffness"],
                ["support_compliance", "asymmetry"],
                ["geometric_stiffening", "backlash"],
                ["sensor_gain", "velocity_weakening"],
            ],
        }
    }

    fn outside(self) -> &'static [&'static str] {
        let all = &[
            "unknown:position_dependent_friction",
            "unknown:dwell_strengthening",
            "unknown:second_limit",
            "unknown:memory_damping",
            "unknown:periodic_disturbance",
            "unknown:time_drift",
        ];
        // A drift has no steady state.
        if self == Kind::Beam { &all[..5] } else { all }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.word())
    }
}

/// How large what is hidden is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Strength {
    /// Clearly there.
    Full,
    /// Half of it.
    Half,
    /// A quarter.
    Quarter,
}

impl Strength {
    /// All of them.
    pub const ALL: [Strength; 3] = [Strength::Full, Strength::Half, Strength::Quarter];

    /// Its name.
    pub fn word(self) -> &'static str {
        match self {
            Strength::Full => "full",
            Strength::Half => "half",
            Strength::Quarter => "quarter",
        }
    }

    fn factor(self) -> f64 {
        match self {
            Strength::Full => 1.0,
            Strength::Half => 0.5,
            Strength::Quarter => 0.25,
        }
    }
}

/// Noise of a case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Share of a channel's root mean square.
    pub share: f64,
    /// AR(1) with a correlation between 0.9 and 0.95 from sample to sample, instead of white.
    pub coloured: bool,
}

/// A sealed case.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// Kind of model.
    pub kind: Kind,
    /// What is hidden; nothing in a null case.
    pub effects: Vec<&'static str>,
    /// How large it is.
    pub strength: Strength,
    /// The noise.
    pub noise: Noise,
    /// How its records move.
    pub drive: Drive,
    /// Distinguishes cases that are otherwise alike.
    pub replica: usize,
}

/// A case with its numbers drawn.
pub struct Drawn {
    /// The experiment.
    pub rig: Box<dyn Rig>,
    /// Factors by which the given model's parameters are off.
    pub off: Vec<f64>,
    noise: Noise,
    noise_seed: u64,
}

impl Case {
    /// The name, which is the folder's.
    pub fn name(&self) -> String {
        let effects = if self.effects.is_empty() { "none".to_owned() } else { self.effects.join("+") };
        let colour = if self.noise.coloured { "coloured" } else { "white" };
        format!(
            "{}-{}-{}-{}%-{colour}-{}{}",
            self.kind,
            effects.replace(':', "-"),
            self.strength.word(),
            self.noise.share * 100.0,
            self.replica,
            self.drive.suffix()
        )
    }

    /// Draws the numbers of the case, always the same.
    ///
    /// # Errors
    /// An effect that cannot be hidden in the kind, a kind that has no such records.
    pub fn draw(&self) -> Result<Drawn, String> {
        let mut random = Random::new(fingerprint(&self.name()));
        let mut system = random.fork();
        let strength = self.strength.factor();
        if self.kind != Kind::Contact && self.drive.is_moving() {
            return Err(format!("a case of kind {} has stationary records only", self.kind));
        }
        let rig: Box<dyn Rig> = match self.kind {
            Kind::Contact => Box::new(Prescribed::draw(self.drive, &self.effects, strength, &mut system)?),
            Kind::Oscillator => Box::new(Oscillator::draw(&self.effects, strength, &mut system)?),
            Kind::Beam => Box::new(Beam::draw(&self.effects, strength, &mut system)?),
        };
        let mut ignorance = random.fork();
        let off = rig.ignorance().iter().map(|half_width| ignorance.about_one(*half_width)).collect();
        Ok(Drawn { rig, off, noise: self.noise, noise_seed: random.bits() })
    }

    /// Whether what is hidden is in no catalogue.
    pub fn is_outside(&self) -> bool {
        self.effects.iter().any(|id| id.starts_with(UNKNOWN))
    }
}

impl Drawn {
    /// The records as they were measured.
    pub fn measure(&self) -> Vec<Record> {
        let mut records = self.rig.respond();
        let mut random = Random::new(self.noise_seed);
        let correlation = if self.noise.coloured { random.between(0.9, 0.95) } else { 0.0 };
        for record in &mut records {
            let tell = self.rig.tells_noise(record.regime);
            record.measure(self.noise.share, correlation, tell, &mut random.fork());
        }
        records
    }

    /// The true model with all that is hidden in it; `None` when the catalogue has no words for it.
    pub fn true_model(&self) -> Option<String> {
        let exact = vec![1.0; self.off.len()];
        let entries: Option<Vec<String>> = self.rig.hidden().iter().map(Hidden::entry).collect();
        Some(self.rig.model(&exact) + &entries?.concat())
    }

    /// The engineer's model.
    pub fn model(&self) -> String {
        self.rig.model(&self.off)
    }
}

/// FNV-1a.
fn fingerprint(name: &str) -> u64 {
    name.bytes()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
}

/// All sealed cases.
pub fn sealed() -> Vec<Case> {
    let mut cases = Vec::new();
    for kind in Kind::ALL {
        nulls(kind, &mut cases);
        singles(kind, &mut cases);
        pairs(kind, &mut cases);
        outside(kind, &mut cases);
        if kind == Kind::Contact {
            moving(kind, &mut cases);
        }
    }
    cases
}

fn case(
    kind: Kind,
    effects: &[&'static str],
    strength: Strength,
    (share, coloured): (f64, bool),
    replica: usize,
) -> Case {
    Case {
        kind,
        effects: effects.to_vec(),
        strength,
        noise: Noise { share, coloured },
        drive: Drive::Stationary,
        replica,
    }
}

const NOISES: [(f64, bool); 8] = [
    (0.003, false),
    (0.003, true),
    (0.01, false),
    (0.01, true),
    (0.03, false),
    (0.03, true),
    (0.1, false),
    (0.1, true),
];

fn nulls(kind: Kind, cases: &mut Vec<Case>) {
    let replicas = match kind {
        Kind::Contact => 6,
        Kind::Oscillator => 2,
        Kind::Beam => 1,
    };
    for replica in 1..=replicas {
        cases.extend(NOISES.map(|noise| case(kind, &[], Strength::Full, noise, replica)));
    }
}

fn singles(kind: Kind, cases: &mut Vec<Case>) {
    use Strength::{Full, Half, Quarter};
    for (index, id) in kind.effects().iter().enumerate() {
        let plan: &[(Strength, (f64, bool))] = match (kind, index % 3) {
            (Kind::Contact, _) => &[
                (Full, (0.01, false)),
                (Full, (0.03, false)),
                (Full, (0.003, true)),
                (Full, (0.1, true)),
                (Half, (0.01, true)),
                (Quarter, (0.01, false)),
            ],
            (Kind::Oscillator, 0) => &[(Full, (0.01, false)), (Full, (0.03, true)), (Half, (0.01, false))],
            (Kind::Oscillator, 1) => {
                &[(Full, (0.01, false)), (Full, (0.03, true)), (Quarter, (0.003, false))]
            }
            (Kind::Oscillator, _) => &[(Full, (0.01, false)), (Full, (0.03, true)), (Full, (0.1, false))],
            (Kind::Beam, 0) => &[(Full, (0.01, false)), (Full, (0.03, true))],
            (Kind::Beam, 1) => &[(Full, (0.01, false)), (Half, (0.01, true))],
            (Kind::Beam, _) => &[(Full, (0.01, false)), (Full, (0.003, false))],
        };
        cases.extend(plan.iter().map(|(strength, noise)| case(kind, &[id], *strength, *noise, 1)));
    }
}

fn pairs(kind: Kind, cases: &mut Vec<Case>) {
    const PLAN: [(f64, bool); 3] = [(0.01, false), (0.003, true), (0.03, false)];
    for (index, pair) in kind.pairs().iter().enumerate() {
        cases.push(case(kind, pair, Strength::Full, PLAN[index % 3], 1));
    }
}

fn outside(kind: Kind, cases: &mut Vec<Case>) {
    let plan: &[(Strength, (f64, bool))] = match kind {
        Kind::Contact => &[
            (Strength::Full, (0.003, false)),
            (Strength::Full, (0.01, true)),
            (Strength::Full, (0.03, false)),
            (Strength::Half, (0.01, false)),
        ],
        Kind::Oscillator => &[(Strength::Full, (0.003, false)), (Strength::Full, (0.01, true))],
        Kind::Beam => &[(Strength::Full, (0.01, false))],
    };
    for id in kind.outside() {
        cases.extend(plan.iter().map(|(strength, noise)| case(kind, &[id], *strength, *noise, 1)));
    }
}

/// One of each kind of question, asked of records that are not stationary; where the noise is not told, those that can
/// be answered without it.
fn moving(kind: Kind, cases: &mut Vec<Case>) {
    const NULLS: [(f64, bool); 4] = [(0.003, false), (0.01, false), (0.01, true), (0.03, true)];
    const PAIRS: [(f64, bool); 3] = [(0.01, false), (0.003, true), (0.03, false)];
    let mut push = |drive, effects: &[&'static str], noise| {
        let case = case(kind, effects, Strength::Full, noise, 1);
        cases.push(Case { drive, ..case });
    };
    NULLS.into_iter().for_each(|noise| push(Drive::Moving, &[], noise));
    for id in kind.effects() {
        push(Drive::Moving, &[id], (0.01, false));
        push(Drive::Moving, &[id], (0.03, true));
    }
    kind.pairs().iter().zip(PAIRS).for_each(|(pair, noise)| push(Drive::Moving, pair, noise));
    for drive in [Drive::Moving, Drive::MovingUntold] {
        kind.outside().iter().for_each(|id| push(drive, &[id], (0.01, false)));
    }
    kind.effects().iter().for_each(|id| push(Drive::MovingUntold, &[id], (0.01, false)));
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn the_sealed_cases_are_enough_and_none_is_repeated() {
        let cases = sealed();
        let names: BTreeSet<String> = cases.iter().map(Case::name).collect();
        assert_eq!(names.len(), cases.len());
        assert!(cases.len() >= 200);
        assert!(cases.iter().filter(|case| case.effects.is_empty()).count() >= 60);
    }

    #[test]
    fn cases_that_were_there_before_keep_their_names() {
        let old: Vec<String> =
            sealed().into_iter().filter(|case| !case.drive.is_moving()).map(|case| case.name()).collect();
        assert_eq!(old.len(), 301);
        assert_eq!(format!("{:016x}", fingerprint(&old.join("\n"))), "5d1cd47880136401");
        let moving: Vec<String> =
            sealed().iter().filter(|case| case.drive.is_moving()).map(Case::name).collect();
        assert!(moving.len() == 58 && moving.iter().all(|name| name.contains("-moving")));
        // Those of one kind stand together.
        assert!(sealed().is_sorted_by_key(|case| case.kind));
    }

    #[test]
    fn every_case_can_be_drawn_and_hides_what_it_says() {
        for case in sealed() {
            let drawn = case.draw().unwrap();
            let hidden: Vec<&str> = drawn.rig.hidden().iter().map(|hidden| hidden.id.as_str()).collect();
            assert_eq!(hidden, case.effects, "{}", case.name());
        }
    }
}
