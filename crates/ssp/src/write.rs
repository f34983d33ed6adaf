//! [`SystemStructure`] -> `SystemStructure.ssd`.

use crate::document::{Component, Connector, SystemStructure, Type};
use crate::unit::Unit;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};
use std::io;

type Out<'a> = Writer<&'a mut Vec<u8>>;

impl SystemStructure {
    /// As XML, without parameters; the same structure gives the same text.
    pub fn to_xml(&self) -> String {
        let mut bytes = Vec::new();
        // Writing into memory does not fail.
        let _ = write(&mut Writer::new_with_indent(&mut bytes, b' ', 2), self);
        bytes.push(b'\n');
        String::from_utf8_lossy(&bytes).into_owned()
    }
}

fn write(out: &mut Out, structure: &SystemStructure) -> io::Result<()> {
    out.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let root = out.create_element("ssd:SystemStructureDescription").with_attributes([
        ("xmlns:ssc", "http://ssp-standard.org/SSP1/SystemStructureCommon"),
        ("xmlns:ssd", "http://ssp-standard.org/SSP1/SystemStructureDescription"),
        ("version", "1.0"),
        ("name", &structure.name),
        ("generationTool", concat!("LEMONS-FMU ", env!("CARGO_PKG_VERSION"))),
    ]);
    root.write_inner_content(|out| {
        let system = out.create_element("ssd:System").with_attribute(("name", structure.name.as_str()));
        system.write_inner_content(|out| {
            out.create_element("ssd:Elements").write_inner_content(|out| {
                structure.components.iter().try_for_each(|component| write_component(out, component))
            })?;
            if structure.connections.is_empty() {
                return Ok(());
            }
            out.create_element("ssd:Connections")
                .write_inner_content(|out| write_connections(out, structure))?;
            Ok(())
        })?;
        if !structure.units.is_empty() {
            out.create_element("ssd:Units").write_inner_content(|out| {
                structure.units.values().try_for_each(|unit| write_unit(out, unit))
            })?;
        }
        let times = [("startTime", structure.start), ("stopTime", structure.stop)];
        let times = times.map(|(name, time)| time.map(|time| (name, number(time))));
        if times.iter().any(Option::is_some) {
            let times = times.iter().flatten().map(|(name, time)| (*name, time.as_str()));
            out.create_element("ssd:DefaultExperiment").with_attributes(times).write_empty()?;
        }
        Ok(())
    })?;
    Ok(())
}

/// So that it reads back to the same double.
fn number(value: f64) -> String {
    format!("{value:?}")
}

fn write_component(out: &mut Out, component: &Component) -> io::Result<()> {
    let element = out.create_element("ssd:Component").with_attributes([
        ("name", component.name.as_str()),
        ("type", "application/x-fmu-sharedlibrary"),
        ("source", &component.source),
        ("implementation", "CoSimulation"),
    ]);
    if component.connectors.is_empty() {
        element.write_empty()?;
        return Ok(());
    }
    element.write_inner_content(|out| {
        out.create_element("ssd:Connectors").write_inner_content(|out| {
            component.connectors.iter().try_for_each(|connector| write_connector(out, connector))
        })?;
        Ok(())
    })?;
    Ok(())
}

fn write_connector(out: &mut Out, connector: &Connector) -> io::Result<()> {
    let element = out
        .create_element("ssd:Connector")
        .with_attributes([("name", connector.name.as_str()), ("kind", connector.kind.name())]);
    let Some(of) = &connector.of else {
        element.write_empty()?;
        return Ok(());
    };
    element.write_inner_content(|out| {
        let name = format!("ssc:{}", of.name());
        let mut element = out.create_element(name.as_str());
        match of {
            Type::Real(Some(unit)) => element = element.with_attribute(("unit", unit.as_str())),
            Type::Enumeration(name) => element = element.with_attribute(("name", name.as_str())),
            _ => {}
        }
        element.write_empty()?;
        Ok(())
    })?;
    Ok(())
}

fn write_connections(out: &mut Out, structure: &SystemStructure) -> io::Result<()> {
    for connection in &structure.connections {
        let ((start, output), (end, input)) =
            (structure.port(connection.from), structure.port(connection.to));
        let mut element = out.create_element("ssd:Connection").with_attributes([
            ("startElement", start.name.as_str()),
            ("startConnector", &output.name),
            ("endElement", &end.name),
            ("endConnector", &input.name),
        ]);
        if connection.suppress_unit_conversion {
            element = element.with_attribute(("suppressUnitConversion", "true"));
        }
        let Some(map) = connection.transformation else {
            element.write_empty()?;
            continue;
        };
        let (factor, offset) = (number(map.factor), number(map.offset));
        element.write_inner_content(|out| {
            out.create_element("ssc:LinearTransformation")
                .with_attributes([("factor", factor.as_str()), ("offset", offset.as_str())])
                .write_empty()?;
            Ok(())
        })?;
    }
    Ok(())
}

fn write_unit(out: &mut Out, unit: &Unit) -> io::Result<()> {
    out.create_element("ssc:Unit").with_attribute(("name", unit.name.as_str())).write_inner_content(
        |out| {
            let mut base = out.create_element("ssc:BaseUnit");
            for (name, exponent) in Unit::BASE.iter().zip(unit.exponents) {
                if exponent != 0 {
                    base = base.with_attribute((*name, exponent.to_string().as_str()));
                }
            }
            for (name, value, default) in [("factor", unit.factor, 1.0), ("offset", unit.offset, 0.0)] {
                if value != default {
                    base = base.with_attribute((name, number(value).as_str()));
                }
            }
            base.write_empty()?;
            Ok(())
        },
    )?;
    Ok(())
}
