//! Systems of the standard FMUs, as SSP 1.0 packages.

use stickslip::fmi::Instance;
use stickslip_readers::ssp::{
    Outline, OutlineComponent, OutlineConnection, OutlineConnector, OutlineParameter,
};
use stickslip_readers::units::{BASE_UNITS, Unit};

use crate::xml::{BASES, exponents};
use crate::{Error, FmiVersion, standard_models, write_fmu_of};

/// A beam with contacts that are FMUs of their own.
struct Standard {
    name: &'static str,
    description: &'static str,
    beam: &'static str,
    contacts: &'static [Contact],
    /// Of the exciter (N), at the start.
    excitation: f64,
}

/// A contact on the beam.
struct Contact {
    name: &'static str,
    fmu: &'static str,
    /// The beam's outputs that move it, its own inputs, and their units.
    motions: &'static [(&'static str, &'static str, &'static str)],
    /// Its own forces, and the beam's inputs that take them.
    forces: &'static [(&'static str, &'static str)],
    /// Its normal load (N) where it is not that of the FMU.
    normal_load: Option<f64>,
}

/// The beam's support.
const fn support(fmu: &'static str) -> Contact {
    Contact {
        name: "contact",
        fmu,
        motions: &[("displacement", "displacement", "m")],
        forces: &[("force", "contact_force")],
        normal_load: None,
    }
}

/// Force of the exciter (N) that the systems start with: enough to make the contact slip.
const EXCITATION: f64 = 20.0;
/// The same of the beam with a pin, which a step of the force shakes less.
const EXCITATION_OF_PIN: f64 = 60.0;
/// Normal load of the friction damper (N): a tenth of the support's, so that it slips.
const DAMPER_LOAD: f64 = 15.0;

const SYSTEMS: [Standard; 4] = [
    Standard {
        name: "BeamWithValanis",
        description: "Beam in modal coordinates whose support is a contact with Valanis' law",
        beam: "ModalBeam",
        contacts: &[support("ValanisContact")],
        excitation: EXCITATION,
    },
    Standard {
        name: "BeamWithJenkins",
        description: "Beam in modal coordinates whose support is a contact with Jenkins' element",
        beam: "ModalBeam",
        contacts: &[support("JenkinsContact")],
        excitation: EXCITATION,
    },
    Standard {
        name: "BeamWithTwoContacts",
        description: "Beam in modal coordinates with a frictional support and a friction damper at midspan",
        beam: "ModalBeamTwoContacts",
        contacts: &[
            support("ValanisContact"),
            Contact {
                name: "damper",
                fmu: "JenkinsContact",
                motions: &[("displacement:x=0.3", "displacement", "m")],
                forces: &[("force", "contact_force:x=0.3")],
                normal_load: Some(DAMPER_LOAD),
            },
        ],
        excitation: EXCITATION,
    },
    Standard {
        name: "BeamWithSlipSlap",
        description: "Beam with a pin and a mass on a string, whose support slips and slaps",
        beam: "PinnedBeam",
        contacts: &[Contact {
            name: "contact",
            fmu: "SlipSlapContact",
            motions: &[
                ("displacement", "displacement", "m"),
                ("velocity", "velocity", "m/s"),
                ("opening", "opening", "m"),
                ("opening_velocity", "opening_velocity", "m/s"),
            ],
            forces: &[("force", "contact_force"), ("opening_force", "opening_force")],
            normal_load: None,
        }],
        excitation: EXCITATION_OF_PIN,
    },
];

/// Names of the standard systems.
pub fn standard_systems() -> Vec<&'static str> {
    SYSTEMS.iter().map(|system| system.name).collect()
}

/// The bytes of the package of a standard system, with the FMUs in it. The same name gives the same bytes.
///
/// ```
/// let package = stickslip_fmu_package::write_system("BeamWithValanis")?;
/// assert!(package.starts_with(b"PK"));
/// # Ok::<(), stickslip_fmu_package::Error>(())
/// ```
///
/// # Errors
/// [`Error::UnknownSystem`].
pub fn write_system(name: &str) -> Result<Vec<u8>, Error> {
    write_system_of(FmiVersion::Two, name)
}

/// As [`write_system`], with FMUs of either version of FMI.
///
/// ```
/// use stickslip_fmu_package::{FmiVersion, write_system_of};
/// assert!(write_system_of(FmiVersion::Three, "BeamWithValanis")?.starts_with(b"PK"));
/// # Ok::<(), stickslip_fmu_package::Error>(())
/// ```
///
/// # Errors
/// As [`write_system`].
pub fn write_system_of(version: FmiVersion, name: &str) -> Result<Vec<u8>, Error> {
    let system = SYSTEMS.iter().find(|system| system.name == name);
    let system = system.ok_or_else(|| Error::UnknownSystem(name.to_owned()))?;
    let mut fmus = vec![system.beam];
    fmus.extend(system.contacts.iter().map(|contact| contact.fmu));
    fmus.sort_unstable();
    fmus.dedup();
    let mut files = Vec::new();
    for fmu in fmus {
        files.push((format!("resources/{fmu}.fmu"), write_fmu_of(version, fmu, model(fmu)?)?));
    }
    Ok(outline(system)?.package(&files)?)
}

fn model(fmu: &str) -> Result<&'static str, Error> {
    let found = standard_models().into_iter().find(|(name, _)| *name == fmu);
    found.map(|(_, model_toml)| model_toml).ok_or_else(|| Error::UnknownSystem(fmu.to_owned()))
}

fn outline(system: &Standard) -> Result<Outline, Error> {
    let connector = |name: &str, input: bool, unit: &str| OutlineConnector {
        name: name.to_owned(),
        input,
        unit: unit.to_owned(),
    };
    let component = |name: &str, fmu: &str, connectors: Vec<OutlineConnector>| OutlineComponent {
        name: name.to_owned(),
        source: format!("resources/{fmu}.fmu"),
        connectors,
    };
    let end = |element: &str, connector: &str| (Some(element.to_owned()), connector.to_owned());
    // The excitation is a start value and no connector: not every program knows connectors of the system.
    let (mut beam, mut connections) = (Vec::new(), Vec::new());
    let mut contacts = Vec::new();
    let value = |name: String, value| OutlineParameter { name, value, unit: "N".to_owned() };
    let mut parameters = vec![value("beam.excitation".to_owned(), system.excitation)];
    for Contact { name, fmu, motions, forces, normal_load } in system.contacts {
        parameters.extend(normal_load.map(|load| value(format!("{name}.normal_load"), load)));
        let mut own = Vec::new();
        // Without transformations, which not every program makes.
        let mut connect = |start, end| {
            connections.push(OutlineConnection { start, end, transformation: None });
        };
        for (of_beam, of_contact, unit) in *motions {
            beam.push(connector(of_beam, false, unit));
            own.push(connector(of_contact, true, unit));
            connect(end("beam", of_beam), end(name, of_contact));
        }
        for (of_contact, of_beam) in *forces {
            beam.push(connector(of_beam, true, "N"));
            own.push(connector(of_contact, false, "N"));
            connect(end(name, of_contact), end("beam", of_beam));
        }
        contacts.push(component(name, fmu, own));
    }
    let used = |unit: &str| system.contacts.iter().flat_map(|one| one.motions).any(|(.., of)| *of == unit);
    let units = ["N", "m", "m/s"].into_iter().filter(|unit| *unit == "N" || used(unit)).map(unit).collect();
    let experiment = Instance::new(model(system.beam)?)?.description().experiment;
    Ok(Outline {
        name: system.name.to_owned(),
        description: system.description.to_owned(),
        connectors: Vec::new(),
        components: std::iter::once(component("beam", system.beam, beam)).chain(contacts).collect(),
        connections,
        parameters,
        units,
        experiment: (experiment.start, experiment.stop),
    })
}

/// A unit of the vocabulary.
fn unit(name: &str) -> Unit {
    let own = exponents(name).unwrap_or_default();
    let exponents = BASE_UNITS.map(|base| {
        let position = BASES.iter().position(|other| *other == base);
        position.map_or(0, |position| i32::from(own[position]))
    });
    Unit { name: name.to_owned(), exponents: Some(exponents), factor: 1.0, offset: 0.0 }
}
