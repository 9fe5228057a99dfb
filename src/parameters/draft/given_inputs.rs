//! Which inputs of a column nobody has given.

use super::Draft;
use crate::parameters::assumed::AssumedInput;
use crate::parameters::parameter::Parameter;
use crate::parameters::table::PARAMETERS;
use crate::parameters::value::Value;

/// The parameters of which each one says which section a column has.
const SECTION: [&str; 2] = ["section.name", "section.area"];
/// The list of them.
const ASSUMED: &str = "assessment.assumed";
/// Whoever gives a column its name has a column of his own, even if he says nothing else of it.
const NAME: &str = "column_id";

impl Draft {
    /// Lets the list follow a change of the section where that is the one of the built-in column, of which nobody has said anything.
    /// An HEB220 that somebody has described may have the same values, but has its own `column_id`.
    pub(super) fn open_list_of_built_in(&mut self) {
        let has_default = |name: &str| {
            let index = Parameter::index_of(name);
            index.is_some_and(|it| self.slots[it].value == PARAMETERS[it].default_value())
        };
        let mut names = [NAME, ASSUMED].into_iter().chain(SECTION);
        let is_built_in = names.all(has_default);
        if let Some(index) = Parameter::index_of(ASSUMED).filter(|_| is_built_in) {
            self.slots[index].place = None;
        }
    }

    /// Which inputs of a column whose name or section is given nobody has given. A list that is given itself, as in what this program writes,
    /// loses an input of which another value is given later. Of the built-in column whose section is replaced, an input with the
    /// built-in value counts as given only where it is given together with the section.
    pub(super) fn follow_given_inputs(&mut self) {
        let Some(index) = Parameter::index_of(ASSUMED) else {
            return;
        };
        let list = &self.slots[index];
        let given = |name: &str| self.slot(name).filter(|it| it.group > 0 && !it.is_same);
        let is_own_column = given(NAME).is_some()
            || SECTION
                .iter()
                .filter_map(|name| given(name))
                .any(|it| it.value != Value::from("") && it.value != Value::from(0.0));
        let is_assumed = |input: &AssumedInput| {
            let mut slots = input.given_by().iter().filter_map(|name| {
                let index = Parameter::index_of(name)?;
                let slot = &self.slots[index];
                let is_default = slot.value == PARAMETERS[index].default_value();
                // A number with its default stands for that of the name.
                let is_given = slot.group > 0 && *name == input.name();
                (is_given || !is_default).then_some(slot)
            });
            match list.place {
                Some(_) => slots.all(|it| it.is_same || it.group <= list.group),
                None => is_own_column && slots.next().is_none(),
            }
        };
        let candidates = match (&list.place, &list.value) {
            // In the order in which they are given.
            (Some(_), Value::StringArray(names)) => names
                .iter()
                .filter_map(|name| AssumedInput::ALL.into_iter().find(|it| it.name() == name))
                .collect(),
            _ => AssumedInput::ALL.to_vec(),
        };
        let names = candidates.into_iter().filter(is_assumed);
        let names = names.map(|it| it.name().to_owned()).collect();
        self.slots[index].value = Value::StringArray(names);
    }
}
