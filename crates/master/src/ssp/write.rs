//! [`SystemStructure`] -> `SystemStructure.ssd`.

use crate::ssp::document::{Component, Connector, Extent, SystemStructure};
use crate::ssp::unit::Unit;
use lemons_core::xml::{Layout, Out, number};

impl SystemStructure {
    /// As XML of SSP 1.0, or of SSP 2.0 if there are arrays, without parameters and conversions; the same structure
    /// gives the same text.
    pub fn to_xml(&self) -> String {
        let arrays = self.has_arrays();
        let root = [
            ("xmlns:ssc", "http://ssp-standard.org/SSP1/SystemStructureCommon"),
            ("xmlns:ssd", "http://ssp-standard.org/SSP1/SystemStructureDescription"),
            ("version", if arrays { "2.0" } else { "1.0" }),
            ("name", self.name.as_str()),
            ("generationTool", concat!("LEMONS-FMU ", env!("CARGO_PKG_VERSION"))),
        ];
        Out::document(Layout::STANDARD, "ssd:SystemStructureDescription", &root, |out| {
            out.element("ssd:System", &[("name", &self.name)], |out| {
                out.element("ssd:Elements", &[], |out| {
                    self.components.iter().for_each(|component| write_component(out, component, arrays));
                });
                if !self.connections.is_empty() {
                    out.element("ssd:Connections", &[], |out| write_connections(out, self));
                }
                if let Some(step) = self.step {
                    write_annotation(out, step);
                }
            });
            if !self.units.is_empty() {
                out.element("ssd:Units", &[], |out| {
                    self.units.values().for_each(|unit| write_unit(out, unit));
                });
            }
            let times = [("startTime", self.start), ("stopTime", self.stop)];
            let times = times.map(|(name, time)| time.map(|time| (name, number(time))));
            let times: Vec<_> = times.iter().flatten().map(|(name, time)| (*name, time.as_str())).collect();
            if !times.is_empty() {
                out.empty("ssd:DefaultExperiment", &times);
            }
        })
    }
}

/// OMSimulator reads the kind of a system from here, and refuses a structure without it. `oms-ma` is its algorithm with
/// a fixed communication step \[s\].
fn write_annotation(out: &mut Out, step: f64) {
    const SCHEMA: &str = "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd";
    let step = number(step);
    let master = [
        ("description", "oms-ma"),
        ("stepSize", &step),
        ("absoluteTolerance", "0.0001"),
        ("relativeTolerance", "0.0001"),
    ];
    out.element("ssd:Annotations", &[], |out| {
        out.element("ssc:Annotation", &[("type", "org.openmodelica")], |out| {
            out.element("oms:Annotations", &[("xmlns:oms", SCHEMA)], |out| {
                out.element("oms:SimulationInformation", &[], |out| {
                    out.empty("oms:FixedStepMaster", &master);
                });
            });
        });
    });
}

fn write_component(out: &mut Out, component: &Component, arrays: bool) {
    let attributes = [
        ("name", component.name.as_str()),
        ("type", "application/x-fmu-sharedlibrary"),
        ("source", &component.source),
        ("implementation", "CoSimulation"),
    ];
    if component.connectors.is_empty() {
        return out.empty("ssd:Component", &attributes);
    }
    out.element("ssd:Component", &attributes, |out| {
        out.element("ssd:Connectors", &[], |out| {
            component.connectors.iter().for_each(|connector| write_connector(out, connector, arrays));
        });
    });
}

fn write_connector(out: &mut Out, connector: &Connector, arrays: bool) {
    let attributes = [("name", connector.name.as_str()), ("kind", connector.kind.name())];
    let Some(of) = connector.of else { return out.empty("ssd:Connector", &attributes) };
    out.element("ssd:Connector", &attributes, |out| {
        let detail = [("unit", &connector.unit), ("name", &connector.enumeration)];
        let detail = detail.map(|(name, text)| Some((name, text.as_deref()?)));
        let of = if arrays { of } else { of.class() };
        out.empty(&format!("ssc:{of}"), &detail.into_iter().flatten().collect::<Vec<_>>());
        for dimension in &connector.dimensions {
            match dimension {
                Extent::Size(size) => out.empty("ssc:Dimension", &[("size", &size.to_string())]),
                Extent::Parameter(name) => out.empty("ssc:Dimension", &[("sizeConnector", name)]),
                Extent::Unsaid => out.empty("ssc:Dimension", &[]),
            }
        }
    });
}

fn write_connections(out: &mut Out, structure: &SystemStructure) {
    for connection in &structure.connections {
        let ((start, output), (end, input)) =
            (structure.port(&connection.from), structure.port(&connection.to));
        let written = |indices: &[usize]| indices.iter().map(usize::to_string).collect::<Vec<_>>().join(" ");
        let (from, to) = (written(&connection.from.indices), written(&connection.to.indices));
        let attributes = [
            ("startElement", start.name.as_str()),
            ("startConnector", &output.name),
            ("startIndices", &from),
            ("endElement", &end.name),
            ("endConnector", &input.name),
            ("endIndices", &to),
        ];
        let there = |(name, value): &(&str, &str)| !name.ends_with("Indices") || !value.is_empty();
        let attributes: Vec<(&str, &str)> = attributes.into_iter().filter(there).collect();
        out.empty("ssd:Connection", &attributes);
    }
}

fn write_unit(out: &mut Out, unit: &Unit) {
    let exponents = Unit::BASE.iter().zip(unit.exponents).filter(|&(_, exponent)| exponent != 0);
    let exponents = exponents.map(|(name, exponent)| (*name, exponent.to_string()));
    let scale = [("factor", unit.factor, 1.0), ("offset", unit.offset, 0.0)];
    let scale = scale.iter().filter(|(_, value, default)| value != default);
    let scale = scale.map(|&(name, value, _)| (name, number(value)));
    let base: Vec<(&str, String)> = exponents.chain(scale).collect();
    let base: Vec<(&str, &str)> = base.iter().map(|(name, value)| (*name, value.as_str())).collect();
    out.element("ssc:Unit", &[("name", &unit.name)], |out| out.empty("ssc:BaseUnit", &base));
}
