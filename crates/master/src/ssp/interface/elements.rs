//! The names of single values.
//!
//! An element of an array is called `Name[i,j]`: the naming convention of FMI 3.0, with indices from 1 as in
//! `fmi3GetVariableDependencies`. Elements of people have the names that they have in FMI 2.0, with indices from 0: an
//! array whose first dimension is the structural parameter `Agents` or `Chests` has the elements `agent[i].Name`; with a second
//! dimension of 2 they are `agent[i].Name.x` and `agent[i].Name.y`. In the same way an array `WallName` of the structural
//! parameter `WallSegments` has the elements `wall[k].Name`; one of `Panels`, `Doors` or `Exits` has those of `barrier[k]`,
//! `door[k]` or `exit[k]`. Where an array of people has the name that FMI 2.0 gives to
//! a number of the whole crowd, this number is called `TotalName` in FMI 3.0, and `Name` here.

use super::{ArrayDimension, FmuVariable, Interface, Single};
use crate::error::{Result, require};
use crate::ssp::document::Causality;

/// The structural parameters that are the number of people: of all, and where the load on chests is found.
const OF_PEOPLE: [&str; 2] = ["Agents", "Chests"];
/// Those that are the numbers of parts of a room; what names of arrays of them begin with, and what elements are called.
const OF_ROOM: [(&str, &str, &str); 4] = [
    ("WallSegments", "Wall", "wall"),
    ("Panels", "Barrier", "barrier"),
    ("Doors", "Door", "door"),
    ("Exits", "Exit", "exit"),
];
const TOTAL: &str = "Total";
const AXES: [&str; 2] = ["x", "y"];

impl Interface {
    /// Returns a single value by its name.
    pub fn single(&self, name: &str) -> Option<Single<'_>> {
        match self.places.get(name) {
            Some(&place) if !self.variables[place].is_array() => {
                Some(Single { variable: &self.variables[place], element: 0 })
            }
            _ => self.parsed(name),
        }
    }

    /// Returns a single value by its name.
    ///
    /// # Errors
    /// There is none.
    pub fn known(&self, name: &str) -> Result<Single<'_>> {
        let missing = || format!("the FMU has no variable {name:?}; see lemons info");
        Ok(self.single(name).ok_or_else(missing)?)
    }

    /// Returns all single values, with their names.
    pub fn singles(&self) -> impl Iterator<Item = (String, Single<'_>)> {
        self.variables.iter().flat_map(move |variable| {
            let single = move |element| (self.name_of(variable, element), Single { variable, element });
            (0..variable.count()).map(single)
        })
    }

    /// Returns the name of a value of one of the variables.
    pub fn name_of(&self, variable: &FmuVariable, element: usize) -> String {
        self.name_with(&variable.name, variable, element)
    }

    /// Returns the name of a value of a variable that has this name, or this alias.
    fn name_with(&self, name: &str, variable: &FmuVariable, element: usize) -> String {
        if !variable.is_array() {
            let of_agents = name
                .strip_prefix(TOTAL)
                .filter(|of| self.variable(of).is_some_and(|array| self.is_of_agents(array)));
            return of_agents.unwrap_or(name).to_owned();
        }
        let indices = variable.indices(element);
        if !self.is_of_agents(variable) {
            let of_room = OF_ROOM.iter().find_map(|(size, begin, element)| {
                Some((element, name.strip_prefix(begin).filter(|_| self.is_of(size, variable))?))
            });
            return match (of_room, &indices[..]) {
                (Some((element, name)), [place]) => format!("{element}[{}].{name}", place - 1),
                _ => format!("{name}{}", written(&indices)),
            };
        }
        let agent = indices[0] - 1;
        match (&indices[1..], &variable.dimensions[1..]) {
            ([], _) => format!("agent[{agent}].{name}"),
            ([axis], [second]) if second.size == AXES.len() && second.parameter.is_none() => {
                format!("agent[{agent}].{name}.{}", AXES[axis - 1])
            }
            (inner, _) => format!("agent[{agent}].{name}{}", written(inner)),
        }
    }

    /// Returns whether the variable has an element, or elements, for each of some people.
    pub fn is_of_agents(&self, variable: &FmuVariable) -> bool {
        OF_PEOPLE.iter().any(|size| self.is_of(size, variable))
    }

    /// Returns whether the first dimension of the variable is the structural parameter of this name.
    fn is_of(&self, size: &str, variable: &FmuVariable) -> bool {
        let first = variable.dimensions.first().and_then(|first| first.parameter);
        first.is_some_and(|place| self.variables[place].name == size)
    }

    /// Returns the value that a name means which is not that of a single variable: the one that has this name.
    pub(super) fn parsed(&self, name: &str) -> Option<Single<'_>> {
        let of = |kind: &str| name.strip_prefix(kind).and_then(|rest| rest.split_once("]."));
        let wall = OF_ROOM.iter().find_map(|(_, begin, element)| {
            let (place, inner) = of(&format!("{element}["))?;
            Some((place, format!("{begin}{inner}")))
        });
        let (agent, inner) = match (of("agent["), &wall) {
            (Some((agent, inner)), _) => (Some(agent), inner),
            (None, Some((segment, inner))) => (Some(*segment), &inner[..]),
            (None, None) => (None, name),
        };
        let axis = inner.rsplit_once('.').and_then(|(array, axis)| {
            Some((array, AXES.iter().zip(["1", "2"]).find(|(known, _)| **known == axis)?.1))
        });
        let bracket = inner.strip_suffix(']').and_then(|inner| inner.rsplit_once('['));
        let total = format!("{TOTAL}{name}");
        let candidates = [axis, bracket, agent.map(|_| (inner, "")), Some((&total, ""))];
        candidates.into_iter().flatten().find_map(|(known, inner)| {
            let inner = inner.split(',').filter(|index| !index.is_empty());
            let inner = inner.map(|index| index.parse().ok()).collect::<Option<Vec<usize>>>()?;
            let agent = agent.map(|agent| agent.parse::<usize>().ok()?.checked_add(1));
            let indices = agent.into_iter().flatten().chain(inner).collect::<Vec<_>>();
            let variable = self.variable(known)?;
            let element = place_of(&variable.dimensions, &indices)?;
            (self.name_with(known, variable, element) == name).then_some(Single { variable, element })
        })
    }

    /// Chooses the value of a structural parameter: other arrays than those of the description come about.
    ///
    /// # Errors
    /// There is no such parameter that is the size of arrays, or the arrays become too large.
    pub fn resize(&mut self, name: &str, size: u64) -> Result<(), String> {
        let place = self.places.get(name).copied();
        let place = place.filter(|place| self.variables[*place].kind == Some(Causality::StructuralParameter));
        let place = place.ok_or("the FMU has no structural parameter of this name")?;
        let new = usize::try_from(size).unwrap_or(usize::MAX);
        let mut variables = self.variables.clone();
        for variable in &mut variables {
            let before = variable.sizes();
            for dimension in variable.dimensions.iter_mut().filter(|of| of.parameter == Some(place)) {
                dimension.size = new;
            }
            // Those of other elements.
            if variable.sizes() != before && variable.start.len() > 1 {
                variable.start.clear();
            }
        }
        let (most, all) = (super::variables::MOST_VALUES, variables.iter().map(FmuVariable::checked_count));
        let few = all.sum::<Option<usize>>().is_some_and(|all| all <= most);
        require(few, || format!("the variables would have more than {most} values in all"))?;
        variables[place].start = vec![size.to_string()];
        self.variables = variables;
        Ok(())
    }
}

/// Returns indices from 1 as they are written.
pub(crate) fn written(indices: &[usize]) -> String {
    let indices: Vec<String> = indices.iter().map(usize::to_string).collect();
    format!("[{}]", indices.join(","))
}

/// Returns the place of the element with indices from 1, in row-major order, if there is such an element.
pub(crate) fn place_of(dimensions: &[ArrayDimension], indices: &[usize]) -> Option<usize> {
    let next = |place: usize, (index, dimension): (&usize, &ArrayDimension)| {
        let index = index.checked_sub(1).filter(|index| *index < dimension.size)?;
        Some(place * dimension.size + index)
    };
    let all = indices.len() == dimensions.len();
    indices.iter().zip(dimensions).try_fold(0, next).filter(|_| all)
}
