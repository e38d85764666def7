//! Systems of the standard FMUs, as SSP 1.0 packages.

use stickslip::slave::Instance;
use stickslip_readers::ssp::{
    Outline, OutlineComponent, OutlineConnection, OutlineConnector, OutlineParameter,
};
use stickslip_readers::units::{BASE_UNITS, Linear, Unit};

use crate::xml::{BASES, exponents};
use crate::{Error, standard_models, write_fmu};

/// A beam with contacts that are FMUs of their own.
struct Standard {
    name: &'static str,
    description: &'static str,
    beam: &'static str,
    contacts: &'static [Contact],
    /// Force of the exciter (N) at the start; none where a contact acts through that input.
    excitation: Option<f64>,
}

/// A contact on the beam.
struct Contact {
    name: &'static str,
    fmu: &'static str,
    /// The beam's output that moves it.
    motion: &'static str,
    /// How far what it rubs against is from its place (m).
    displaced: f64,
    /// The beam's input that takes its force, and the sign of restoring forces there.
    force: (&'static str, f64),
}

/// The beam's support.
const fn support(fmu: &'static str) -> Contact {
    Contact { name: "contact", fmu, motion: "displacement", displaced: 0.0, force: ("contact_force", 1.0) }
}

/// Force of the exciter (N) that the systems start with: enough to make the contact slip.
const EXCITATION: f64 = 20.0;

const SYSTEMS: [Standard; 3] = [
    Standard {
        name: "BeamWithValanis",
        description: "Beam in modal coordinates whose support is a contact with Valanis' law",
        beam: "ModalBeam",
        contacts: &[support("ValanisContact")],
        excitation: Some(EXCITATION),
    },
    Standard {
        name: "BeamWithJenkins",
        description: "Beam in modal coordinates whose support is a contact with Jenkins' element",
        beam: "ModalBeam",
        contacts: &[support("JenkinsContact")],
        excitation: Some(EXCITATION),
    },
    Standard {
        name: "BeamWithTwoContacts",
        description: "Beam in modal coordinates with a frictional support and a friction damper at x = 0.55 m, which \
                      is pulled 0.02 mm aside at the start",
        beam: "ModalBeam",
        contacts: &[
            support("ValanisContact"),
            Contact {
                name: "damper",
                fmu: "JenkinsContact",
                motion: "displacement:x=0.55",
                displaced: 2e-5,
                // The exciter pushes where the damper resists.
                force: ("excitation", -1.0),
            },
        ],
        excitation: None,
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
    let system = SYSTEMS.iter().find(|system| system.name == name);
    let system = system.ok_or_else(|| Error::UnknownSystem(name.to_owned()))?;
    let mut fmus = vec![system.beam];
    fmus.extend(system.contacts.iter().map(|contact| contact.fmu));
    fmus.sort_unstable();
    fmus.dedup();
    let mut files = Vec::new();
    for fmu in fmus {
        files.push((format!("resources/{fmu}.fmu"), write_fmu(fmu, model(fmu)?)?));
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
    for Contact { name, fmu, motion, displaced, force: (force, sign) } in system.contacts {
        beam.push(connector(force, true, "N"));
        beam.push(connector(motion, false, "m"));
        let own = vec![connector("displacement", true, "m"), connector("force", false, "N")];
        contacts.push(component(name, fmu, own));
        let linear = |factor: f64, offset: f64| {
            let linear = Linear { factor, offset };
            (linear != Linear::IDENTITY).then_some(linear)
        };
        connections.push(OutlineConnection {
            start: end("beam", motion),
            end: end(name, "displacement"),
            transformation: linear(1.0, -displaced),
        });
        connections.push(OutlineConnection {
            start: end(name, "force"),
            end: end("beam", force),
            transformation: linear(*sign, 0.0),
        });
    }
    let experiment = Instance::new(model(system.beam)?)?.description().experiment;
    Ok(Outline {
        name: system.name.to_owned(),
        description: system.description.to_owned(),
        connectors: Vec::new(),
        components: std::iter::once(component("beam", system.beam, beam)).chain(contacts).collect(),
        connections,
        parameters: system
            .excitation
            .map(|value| OutlineParameter { name: "beam.excitation".to_owned(), value, unit: "N".to_owned() })
            .into_iter()
            .collect(),
        units: ["N", "m"].into_iter().map(unit).collect(),
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
