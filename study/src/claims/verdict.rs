//! Verdicts on claims.

use crate::record::Record;

/// The verdict of records on a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// All measurements agree.
    Confirmed,
    /// All measurements disagree.
    Refuted,
    /// Some measurements agree and some disagree, or there are none.
    Undecided,
}

impl Verdict {
    /// Returns the verdict as a word.
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
    /// The section of the study.
    pub place: &'static str,
    /// The claim.
    pub text: &'static str,
    /// The reason why records disagree, where they do.
    pub reason: &'static str,
    /// Judges the claim from records of one device.
    pub judge: fn(&[&Record]) -> (Verdict, String),
}

/// The verdict of a device's records on a claim.
pub(crate) struct DeviceVerdict {
    /// The device.
    pub device: String,
    /// The verdict.
    pub verdict: Verdict,
    /// What was measured.
    pub reason: String,
}
