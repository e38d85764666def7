//! A case: it is its name, and its name is its seed.

use std::fmt;

use crate::motion::drive::Drive;
use crate::records::random::Random;
use crate::records::record::Record;
use crate::records::spoilt::Spoilt;
use crate::rigs::beam::Beam;
use crate::rigs::effect::{Hidden, MICRO_SLIP_OF, UNKNOWN};
use crate::rigs::oscillator::Oscillator;
use crate::rigs::prescribed::Prescribed;
use crate::rigs::rig::Rig;
use crate::rigs::setting::Setting;

/// The effects that a joint can have in every kind of model, but wear of a beam.
const OF_JOINTS: [&str; 9] = [
    "micro_slip",
    "residual_stiffness",
    "normal_load_variation",
    "contact_damping",
    "velocity_weakening",
    "wear",
    "backlash",
    "stiffening",
    "asymmetry",
];

/// Physics and faults outside the catalogue that came later than those of [`Kind::outside`].
pub(super) const LATER_OUTSIDE: [&str; 7] = [
    "unknown:stick_ageing",
    "unknown:power_law_damping",
    "unknown:lugre",
    "unknown:stiffness_drift",
    "unknown:hum",
    "unknown:clipping",
    "unknown:drop_outs",
];

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

    /// The catalogue's effects that can be hidden in it, in the order from which the cases' seeds follow.
    pub fn effects(self) -> Vec<&'static str> {
        let own: &[&str] = match self {
            Kind::Contact => &["normal_hardening", "impact_damping", "sensor_delay", "sensor_offset"],
            Kind::Oscillator => &[
                "geometric_stiffening",
                "quadratic_damping",
                "added_mass",
                "hanging_mass",
                "sensor_delay",
                "sensor_gain",
                "sensor_offset",
            ],
            Kind::Beam => &[
                "geometric_stiffening",
                "quadratic_damping",
                "added_mass",
                "support_compliance",
                "hanging_mass",
                "sensor_delay",
                "sensor_gain",
                "sensor_offset",
            ],
        };
        let of_joints = OF_JOINTS.iter().filter(|id| self != Kind::Beam || **id != "wear");
        of_joints.chain(own).copied().collect()
    }

    /// Whether its experiments know such a setting.
    fn has(self, setting: Setting) -> bool {
        match setting {
            Setting::Usual => true,
            Setting::Records32 => self != Kind::Beam,
            Setting::Further | Setting::Records128 | Setting::LongDelay => self == Kind::Contact,
            Setting::NoiseUntold | Setting::MassOff | Setting::Coarse => self == Kind::Oscillator,
            Setting::HeldLevels => self == Kind::Beam,
        }
    }

    pub(super) fn pairs(self) -> &'static [[&'static str; 2]] {
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

    pub(super) fn outside(self) -> &'static [&'static str] {
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
    /// Fraction of a channel's root mean square.
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
    /// What else is unlike the usual.
    pub setting: Setting,
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
    spoilt: Option<Spoilt>,
    hidden: Vec<Hidden>,
}

impl Case {
    /// The name, which is the folder's.
    pub fn name(&self) -> String {
        let effects = if self.effects.is_empty() { "none".to_owned() } else { self.effects.join("+") };
        let colour = if self.noise.coloured { "coloured" } else { "white" };
        let setting = match self.setting.word() {
            "" => String::new(),
            word => format!("-{word}"),
        };
        format!(
            "{}-{}-{}-{}%-{colour}-{}{}{setting}",
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
        if !self.kind.has(self.setting) {
            return Err(format!("no case of kind {} is {}", self.kind, self.setting.word()));
        }
        let (spoiling, effects): (Vec<&str>, Vec<&str>) =
            self.effects.iter().partition(|id| Spoilt::IDS.contains(id));
        let rig: Box<dyn Rig> = match self.kind {
            Kind::Contact => {
                Box::new(Prescribed::draw(self.drive, self.setting, &effects, strength, &mut system)?)
            }
            Kind::Oscillator => Box::new(Oscillator::draw(self.setting, &effects, strength, &mut system)?),
            Kind::Beam => Box::new(Beam::draw(self.setting, &effects, strength, &mut system)?),
        };
        let mut ignorance = random.fork();
        let off = rig.ignorance().iter().map(|half_width| ignorance.about_one(*half_width)).collect();
        let noise_seed = random.bits();
        let spoilt = spoiling.first().and_then(|id| Spoilt::draw(id, strength, &mut random.fork()));
        let mut hidden = rig.hidden().to_vec();
        hidden.extend(spoiling.iter().map(|id| Hidden::new(id, &[])));
        Ok(Drawn { rig, off, noise: self.noise, noise_seed, spoilt, hidden })
    }

    /// What the case asks that the first cases did not, in a word; `None` for these.
    pub fn question(&self) -> Option<&str> {
        let later = |id: &&&str| id.starts_with(MICRO_SLIP_OF) || LATER_OUTSIDE.contains(id);
        match (self.setting, self.drive) {
            (Setting::Usual, Drive::Ramped) => Some("ramped"),
            (Setting::Usual, _) => {
                self.effects.iter().find(later).map(|id| id.rsplit(':').next().unwrap_or(id))
            }
            (setting, _) => Some(setting.word()),
        }
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
        if let Some(spoilt) = &self.spoilt {
            spoilt.spoil(&mut records, &mut random);
        }
        // Where no level gave a steady state nothing was measured.
        records.retain(|record| !record.is_silent());
        records
    }

    /// The true model with all that is hidden in it; `None` when the catalogue has no words for it.
    pub fn true_model(&self) -> Option<String> {
        let exact = vec![1.0; self.off.len()];
        let entries: Option<Vec<String>> = self.hidden.iter().map(Hidden::entry).collect();
        let model = self.rig.model(&exact);
        let model = match self.hidden.iter().find_map(Hidden::law_lines) {
            Some(law) => model.replacen("law = \"jenkins\"", &law, 1),
            None => model,
        };
        Some(model + &entries?.concat())
    }

    /// What is hidden, in the experiment and in what was written down of it.
    pub fn hidden(&self) -> &[Hidden] {
        &self.hidden
    }

    /// The names by which a program may tell what spoilt the measurement.
    pub fn faults(&self) -> &'static [&'static str] {
        self.spoilt.as_ref().map_or(&[], Spoilt::names)
    }

    /// The engineer's model.
    pub fn model(&self) -> String {
        self.rig.model(&self.off)
    }
}

/// FNV-1a.
pub(super) fn fingerprint(name: &str) -> u64 {
    name.bytes()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
}
