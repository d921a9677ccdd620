//! Whether a claim holds.

use crate::record::Record;

/// What records say of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// All that was measured agrees.
    Confirmed,
    /// All that was measured disagrees.
    Refuted,
    /// Some agrees and some does not, or nothing was measured.
    Undecided,
}

impl Verdict {
    /// In one word.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Confirmed => "confirmed",
            Self::Refuted => "refuted",
            Self::Undecided => "undecided",
        }
    }
}

/// A claim, and how it is judged.
pub(crate) struct Claim {
    /// Where it stands.
    pub place: &'static str,
    /// What it says.
    pub text: &'static str,
    /// Where records say otherwise, why that is so.
    pub reason: &'static str,
    /// What records say of it.
    pub judge: fn(&[&Record]) -> (Verdict, String),
}
