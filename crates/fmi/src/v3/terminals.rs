//! `terminalsAndIcons/terminalsAndIcons.xml`: which variables one line of a graphical tool connects.

use super::arrays::ArrayModel;
use lemons_core::xml::{Layout, Out};

/// Name of the terminal with which a crowd and what drives it are connected. Its members have the same names in both.
/// Not all need to be there: the matching rule is `bus`.
pub const CROWD: &str = "crowd";

/// A terminal: variables that are connected together with those of the same member names of another FMU.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Terminal<'a> {
    /// Name; two FMUs are connected at terminals of the same kind.
    pub name: &'a str,
    /// Description for users.
    pub description: &'a str,
    /// Names of the variables, which are those of the members too.
    pub variables: &'a [&'a str],
}

/// Returns the file with one terminal, and the icon `icon.png` if there is one.
pub fn terminals_xml<M: ArrayModel>(terminal: &Terminal, icon: bool) -> String {
    let arrays = M::arrays();
    let root = [("fmiVersion", "3.0")];
    Out::document(Layout::STANDARD, "fmiTerminalsAndIcons", &root, |out| {
        if icon {
            out.element("GraphicalRepresentation", &[], |out| {
                let corners = [("x1", "-100"), ("y1", "-100"), ("x2", "100"), ("y2", "100")];
                let mut system = corners.to_vec();
                system.push(("suggestedScalingFactorTo_mm", "0.1"));
                out.empty("CoordinateSystem", &system);
                out.empty("Icon", &corners);
            });
        }
        out.element("Terminals", &[], |out| {
            let attributes = [
                ("name", terminal.name),
                ("matchingRule", "bus"),
                ("terminalKind", "org.lemons-fmu.crowd"),
                ("description", terminal.description),
            ];
            out.element("Terminal", &attributes, |out| {
                for array in arrays.iter().filter(|array| terminal.variables.contains(&array.name)) {
                    out.empty(
                        "TerminalMemberVariable",
                        &[
                            ("variableName", array.name),
                            ("memberName", array.name),
                            ("variableKind", "signal"),
                        ],
                    );
                }
            });
        });
    })
}
