//! Systems of the standard FMUs, as SSP 1.0 packages.

use stickslip::fmi::Instance;
use stickslip_readers::ssp::{
    Outline, OutlineComponent, OutlineConnection, OutlineConnector, OutlineParameter,
};
use stickslip_readers::units::{BASE_UNITS, Unit};

use crate::xml::{BASES, exponents};
use crate::{Error, standard_models, write_fmu};

/// A beam with contacts that are FMUs of their own.
struct Standard {
    name: &'static str,
    description: &'static str,
    beam: &'static str,
    contacts: &'static [Contact],
}

/// A contact on the beam.
struct Contact {
    name: &'static str,
    fmu: &'static str,
    /// The beam's output that moves it.
    motion: &'static str,
    /// The beam's input that takes its force.
    force: &'static str,
    /// Its normal load (N) where it is not that of the FMU.
    normal_load: Option<f64>,
}

/// The beam's support.
const fn support(fmu: &'static str) -> Contact {
    Contact { name: "contact", fmu, motion: "displacement", force: "contact_force", normal_load: None }
}

/// Force of the exciter (N) that the systems start with: enough to make the contact slip.
const EXCITATION: f64 = 20.0;
/// Normal load of the friction damper (N): a tenth of the support's, so that it slips.
const DAMPER_LOAD: f64 = 15.0;

const SYSTEMS: [Standard; 3] = [
    Standard {
        name: "BeamWithValanis",
        description: "Beam in modal coordinates whose support is a contact with Valanis' law",
        beam: "ModalBeam",
        contacts: &[support("ValanisContact")],
    },
    Standard {
        name: "BeamWithJenkins",
        description: "Beam in modal coordinates whose support is a contact with Jenkins' element",
        beam: "ModalBeam",
        contacts: &[support("JenkinsContact")],
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
                motion: "displacement:x=0.3",
                force: "contact_force:x=0.3",
                normal_load: Some(DAMPER_LOAD),
            },
        ],
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
    let value = |name: String, value| OutlineParameter { name, value, unit: "N".to_owned() };
    let mut parameters = vec![value("beam.excitation".to_owned(), EXCITATION)];
    for Contact { name, fmu, motion, force, normal_load } in system.contacts {
        parameters.extend(normal_load.map(|load| value(format!("{name}.normal_load"), load)));
        beam.push(connector(force, true, "N"));
        beam.push(connector(motion, false, "m"));
        let own = vec![connector("displacement", true, "m"), connector("force", false, "N")];
        contacts.push(component(name, fmu, own));
        // Without transformations, which not every program makes.
        for (start, end) in
            [(end("beam", motion), end(name, "displacement")), (end(name, "force"), end("beam", force))]
        {
            connections.push(OutlineConnection { start, end, transformation: None });
        }
    }
    let experiment = Instance::new(model(system.beam)?)?.description().experiment;
    Ok(Outline {
        name: system.name.to_owned(),
        description: system.description.to_owned(),
        connectors: Vec::new(),
        components: std::iter::once(component("beam", system.beam, beam)).chain(contacts).collect(),
        connections,
        parameters,
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
