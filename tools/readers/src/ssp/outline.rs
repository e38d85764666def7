//! Writes SSP 1.0 packages.

use std::io::{Cursor, Write as _};

use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, Event};
use quick_xml::writer::Writer;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::STRUCTURE;
use crate::units::{BASE_UNITS, Linear, Unit};

/// A system to be written. It declares inputs and outputs of Real variables.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Outline {
    /// Its name.
    pub name: String,
    /// What it is.
    pub description: String,
    /// Its own connectors.
    pub connectors: Vec<OutlineConnector>,
    /// The FMUs.
    pub components: Vec<OutlineComponent>,
    /// From outputs to inputs.
    pub connections: Vec<OutlineConnection>,
    /// Values to set, for the file `resources/parameters.ssv`.
    pub parameters: Vec<OutlineParameter>,
    /// The units that connectors and parameters have.
    pub units: Vec<Unit>,
    /// Start and stop (s).
    pub experiment: (f64, f64),
}

/// An FMU.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct OutlineComponent {
    /// Its name.
    pub name: String,
    /// Its file in the package: `resources/ModalBeam.fmu`.
    pub source: String,
    /// Those that are connected: some programs take an unconnected input for zero.
    pub connectors: Vec<OutlineConnector>,
}

/// An input or output.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct OutlineConnector {
    /// Its name, for a component that of the variable.
    pub name: String,
    /// Whether values flow in.
    pub input: bool,
    /// Its unit.
    pub unit: String,
}

/// A connection; an element is absent where the connector is the system's own.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct OutlineConnection {
    /// Element and connector where the value comes from.
    pub start: (Option<String>, String),
    /// Element and connector where it goes.
    pub end: (Option<String>, String),
    /// What happens to the value; not every program does it.
    pub transformation: Option<Linear>,
}

/// A Real value.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct OutlineParameter {
    /// Its name in the system: `contact.normal_load`.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its unit.
    pub unit: String,
}

/// Where the parameters are in the package.
const PARAMETERS: &str = "resources/parameters.ssv";
const NAMESPACE: &str = "http://ssp-standard.org/SSP1/SystemStructure";

impl Outline {
    /// The package, with `files` (names in the package and contents) besides the description. The same arguments
    /// give the same bytes.
    ///
    /// # Errors
    /// Only memory can run out.
    pub fn package(&self, files: &[(String, Vec<u8>)]) -> std::io::Result<Vec<u8>> {
        let mut entries: Vec<(&str, Vec<u8>)> = vec![(STRUCTURE, self.structure()?)];
        if !self.parameters.is_empty() {
            entries.push((PARAMETERS, self.parameter_set()?));
        }
        entries.extend(files.iter().map(|(name, bytes)| (name.as_str(), bytes.clone())));
        entries.sort_by(|one, other| one.0.cmp(other.0));
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        for (name, content) in entries {
            // An FMU is a zip archive itself: nothing is left to compress. The default time is 1980-01-01.
            let method =
                if name.ends_with(".fmu") { CompressionMethod::Stored } else { CompressionMethod::Deflated };
            let options = SimpleFileOptions::default()
                .compression_method(method)
                .last_modified_time(zip::DateTime::default())
                .unix_permissions(0o644);
            archive.start_file(name, options)?;
            archive.write_all(&content)?;
        }
        Ok(archive.finish()?.into_inner())
    }

    /// `SystemStructure.ssd`.
    fn structure(&self) -> std::io::Result<Vec<u8>> {
        let mut xml = Xml::new()?;
        let common = format!("{NAMESPACE}Common");
        let description = format!("{NAMESPACE}Description");
        let root = [
            ("xmlns:ssc", common.as_str()),
            ("xmlns:ssd", &description),
            ("version", "1.0"),
            ("name", &self.name),
            ("description", &self.description),
            ("generationTool", concat!("stickslip ", env!("CARGO_PKG_VERSION"))),
        ];
        xml.open("ssd:SystemStructureDescription", &root)?;
        xml.open("ssd:System", &[("name", &self.name)])?;
        xml.connectors(&self.connectors)?;
        if !self.parameters.is_empty() {
            xml.open("ssd:ParameterBindings", &[])?;
            xml.empty("ssd:ParameterBinding", &[("source", PARAMETERS)])?;
            xml.close("ssd:ParameterBindings")?;
        }
        xml.open("ssd:Elements", &[])?;
        for component in &self.components {
            let attributes = [
                ("name", component.name.as_str()),
                ("type", "application/x-fmu-sharedlibrary"),
                ("source", &component.source),
            ];
            xml.open("ssd:Component", &attributes)?;
            xml.connectors(&component.connectors)?;
            xml.close("ssd:Component")?;
        }
        xml.close("ssd:Elements")?;
        xml.open("ssd:Connections", &[])?;
        for connection in &self.connections {
            xml.connection(connection)?;
        }
        xml.close("ssd:Connections")?;
        xml.close("ssd:System")?;
        xml.units("ssd:Units", &self.units)?;
        let (start, stop) = (number(self.experiment.0), number(self.experiment.1));
        xml.empty("ssd:DefaultExperiment", &[("startTime", &start), ("stopTime", &stop)])?;
        xml.close("ssd:SystemStructureDescription")?;
        Ok(xml.finish())
    }

    /// The set of parameter values.
    fn parameter_set(&self) -> std::io::Result<Vec<u8>> {
        let mut xml = Xml::new()?;
        let common = format!("{NAMESPACE}Common");
        let values = format!("{NAMESPACE}ParameterValues");
        let root = [
            ("xmlns:ssc", common.as_str()),
            ("xmlns:ssv", &values),
            ("version", "1.0"),
            ("name", &self.name),
        ];
        xml.open("ssv:ParameterSet", &root)?;
        xml.open("ssv:Parameters", &[])?;
        for parameter in &self.parameters {
            xml.open("ssv:Parameter", &[("name", &parameter.name)])?;
            let value = number(parameter.value);
            xml.empty("ssv:Real", &[("value", &value), ("unit", &parameter.unit)])?;
            xml.close("ssv:Parameter")?;
        }
        xml.close("ssv:Parameters")?;
        let used = |unit: &&Unit| self.parameters.iter().any(|parameter| parameter.unit == unit.name);
        let units: Vec<Unit> = self.units.iter().filter(used).cloned().collect();
        xml.units("ssv:Units", &units)?;
        xml.close("ssv:ParameterSet")?;
        Ok(xml.finish())
    }
}

/// The shortest text that is read back as the same number.
fn number(value: f64) -> String {
    let plain = value.to_string();
    let scientific = format!("{value:e}");
    if scientific.len() < plain.len() { scientific } else { plain }
}

struct Xml(Writer<Vec<u8>>);

impl Xml {
    fn new() -> std::io::Result<Self> {
        let mut xml = Self(Writer::new_with_indent(Vec::new(), b' ', 2));
        xml.0.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
        Ok(xml)
    }

    fn open(&mut self, name: &str, attributes: &[(&str, &str)]) -> std::io::Result<()> {
        let tag = BytesStart::new(name).with_attributes(attributes.iter().copied());
        self.0.write_event(Event::Start(tag))
    }

    fn empty(&mut self, name: &str, attributes: &[(&str, &str)]) -> std::io::Result<()> {
        let tag = BytesStart::new(name).with_attributes(attributes.iter().copied());
        self.0.write_event(Event::Empty(tag))
    }

    fn close(&mut self, name: &str) -> std::io::Result<()> {
        self.0.write_event(Event::End(BytesEnd::new(name)))
    }

    fn connectors(&mut self, connectors: &[OutlineConnector]) -> std::io::Result<()> {
        if connectors.is_empty() {
            return Ok(());
        }
        self.open("ssd:Connectors", &[])?;
        for connector in connectors {
            let kind = if connector.input { "input" } else { "output" };
            self.open("ssd:Connector", &[("name", &connector.name), ("kind", kind)])?;
            self.empty("ssc:Real", &[("unit", &connector.unit)])?;
            self.close("ssd:Connector")?;
        }
        self.close("ssd:Connectors")
    }

    fn connection(&mut self, connection: &OutlineConnection) -> std::io::Result<()> {
        let mut attributes = Vec::new();
        if let Some(element) = &connection.start.0 {
            attributes.push(("startElement", element.as_str()));
        }
        attributes.push(("startConnector", connection.start.1.as_str()));
        if let Some(element) = &connection.end.0 {
            attributes.push(("endElement", element.as_str()));
        }
        attributes.push(("endConnector", connection.end.1.as_str()));
        let Some(Linear { factor, offset }) = connection.transformation else {
            return self.empty("ssd:Connection", &attributes);
        };
        self.open("ssd:Connection", &attributes)?;
        let (factor, offset) = (number(factor), number(offset));
        self.empty("ssc:LinearTransformation", &[("factor", &factor), ("offset", &offset)])?;
        self.close("ssd:Connection")
    }

    fn units(&mut self, list: &str, units: &[Unit]) -> std::io::Result<()> {
        if units.is_empty() {
            return Ok(());
        }
        self.open(list, &[])?;
        for unit in units {
            self.open("ssc:Unit", &[("name", &unit.name)])?;
            let exponents = unit.exponents.unwrap_or_default();
            let mut attributes: Vec<(&str, String)> = BASE_UNITS
                .into_iter()
                .zip(exponents)
                .filter(|(_, exponent)| *exponent != 0)
                .map(|(name, exponent)| (name, exponent.to_string()))
                .collect();
            if unit.factor != 1.0 {
                attributes.push(("factor", number(unit.factor)));
            }
            if unit.offset != 0.0 {
                attributes.push(("offset", number(unit.offset)));
            }
            let attributes: Vec<(&str, &str)> =
                attributes.iter().map(|(name, value)| (*name, value.as_str())).collect();
            self.empty("ssc:BaseUnit", &attributes)?;
            self.close("ssc:Unit")?;
        }
        self.close(list)
    }

    fn finish(self) -> Vec<u8> {
        let mut bytes = self.0.into_inner();
        bytes.push(b'\n');
        bytes
    }
}
