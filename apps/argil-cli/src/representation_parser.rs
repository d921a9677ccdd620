//! Parses `--via`.

use argil::Representation;
use clap::ValueEnum;
use clap::builder::{EnumValueParser, PossibleValue, TypedValueParser};
use std::ffi::OsStr;

/// Parses any representation. The help omits those that the command rejects with a message of its own.
#[derive(Clone)]
pub(crate) struct RepresentationsExcept(pub &'static [&'static str]);

impl TypedValueParser for RepresentationsExcept {
    type Value = Representation;

    fn parse_ref(
        &self,
        command: &clap::Command,
        argument: Option<&clap::Arg>,
        value: &OsStr,
    ) -> Result<Representation, clap::Error> {
        EnumValueParser::<Representation>::new().parse_ref(command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let hidden = self.0;
        let all = Representation::value_variants();
        let values = all.iter().filter_map(|via| via.to_possible_value());
        Some(Box::new(
            values.filter(move |value| !hidden.contains(&value.get_name())),
        ))
    }
}
