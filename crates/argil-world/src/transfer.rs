//! What goes to `object_store` and comes from it: settings, bodies and errors.

use bytes::{Bytes, BytesMut};
use futures_util::TryStreamExt;
use object_store::{Error, GetResult};
#[cfg(feature = "cloud")]
use std::ffi::OsString;
use std::io::ErrorKind;

/// Returns the settings of stores among variables, under the names that [`object_store`] has for them.
#[cfg(feature = "cloud")]
pub(crate) fn settings(
    variables: impl Iterator<Item = (OsString, OsString)>,
) -> impl Iterator<Item = (String, String)> {
    variables.filter_map(|(name, value)| {
        let name = name.into_string().ok()?;
        let is_setting = ["AWS_", "GOOGLE_", "AZURE_"]
            .iter()
            .any(|prefix| name.starts_with(prefix));
        is_setting.then_some((name.to_ascii_lowercase(), value.into_string().ok()?))
    })
}

/// An object is longer than it can be.
#[derive(Debug, thiserror::Error)]
#[error("it has more than {0} bytes, the most that it can have")]
struct TooLong(u64);

/// Returns what a store sends, up to some bytes. Lengths that servers name can be wrong.
pub(crate) async fn body(found: GetResult, max_bytes: u64) -> Result<Bytes, Error> {
    let too_long = || Error::Generic {
        store: "store",
        source: Box::new(TooLong(max_bytes)),
    };
    if found.range.end.saturating_sub(found.range.start) > max_bytes {
        return Err(too_long());
    }
    let mut stream = found.into_stream();
    let mut whole = Bytes::new();
    let mut parts = BytesMut::new();
    while let Some(part) = stream.try_next().await? {
        if (whole.len() + parts.len() + part.len()) as u64 > max_bytes {
            return Err(too_long());
        }
        // A body of one part is not copied.
        if whole.is_empty() && parts.is_empty() {
            whole = part;
        } else {
            parts.extend_from_slice(&std::mem::take(&mut whole));
            parts.extend_from_slice(&part);
        }
    }
    Ok(if parts.is_empty() {
        whole
    } else {
        parts.freeze()
    })
}

/// Whether an error does not mean that a store cannot give this part of an object: it gives none, or the object is empty.
///
/// Only messages tell, because the types of `object_store` are private. None of these begins with an address, which could have any
/// words in it.
pub(crate) fn gives_parts(error: &Error) -> bool {
    let Error::Generic { source, .. } = error else {
        return !matches!(error, Error::NotSupported { .. });
    };
    let reason = source.to_string();
    let reasons = [
        "Received non-partial response when range requested",
        "Content-Range header not present in partial response",
        "Requested range was invalid",
        "Invalid range: ",
        "Wanted range starting at ",
        "Range started at ",
    ];
    !reasons.iter().any(|prefix| reason.starts_with(prefix))
}

pub(crate) fn may_pass(error: &Error) -> bool {
    gives_parts(error)
        && !matches!(
            error,
            Error::PermissionDenied { .. }
                | Error::Unauthenticated { .. }
                | Error::NotSupported { .. }
                | Error::NotImplemented { .. }
                | Error::InvalidPath { .. }
                | Error::UnknownConfigurationKey { .. }
        )
        && !is_final(error)
}

/// Whether a disk is full, or an object too long. To wait does not help then.
fn is_final(error: &Error) -> bool {
    let mut cause: Option<&(dyn std::error::Error + 'static)> = Some(error);
    while let Some(error_cause) = cause {
        let io: Option<&std::io::Error> = error_cause.downcast_ref();
        if error_cause.is::<TooLong>() || io.is_some_and(|io| io.kind() == ErrorKind::StorageFull) {
            return true;
        }
        cause = error_cause.source();
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Words of a path decide nothing.
    #[test]
    fn paths_with_a_range_are_tried_again() {
        let failed = |reason: &str| Error::Generic {
            store: "store",
            source: reason.into(),
        };
        let lost = failed("Error performing GET https://host/orange/tiles/0/1_1_1 in 1s: 503");
        assert!(gives_parts(&lost) && may_pass(&lost));
        let whole = failed("Received non-partial response when range requested");
        assert!(!gives_parts(&whole) && !may_pass(&whole));
        let long = Error::Generic {
            store: "store",
            source: Box::new(TooLong(7)),
        };
        assert!(gives_parts(&long) && !may_pass(&long));
    }

    #[cfg(feature = "cloud")]
    #[test]
    fn only_variables_of_stores_are_settings() {
        let pairs = [
            ("AWS_ACCESS_KEY_ID", "a"),
            ("AZURE_STORAGE_ACCOUNT_NAME", "b"),
            ("GOOGLE_SERVICE_ACCOUNT", "c"),
            ("ENDPOINT", "d"),
            ("PROXY_URL", "e"),
            ("ALLOW_INVALID_CERTIFICATES", "true"),
            ("TOKEN", "f"),
            ("aws_region", "g"),
        ];
        let mut all: Vec<(OsString, OsString)> = pairs
            .map(|(name, value)| (name.into(), value.into()))
            .into();
        #[cfg(unix)]
        {
            use std::os::unix::ffi::OsStringExt;
            let odd = || OsString::from_vec(b"AWS_\xff".to_vec());
            all.extend([("AWS_REGION".into(), odd()), (odd(), "h".into())]);
        }
        let found: Vec<(String, String)> = settings(all.into_iter()).collect();
        let names: Vec<&str> = found.iter().map(|(name, _)| &**name).collect();
        assert_eq!(
            names,
            [
                "aws_access_key_id",
                "azure_storage_account_name",
                "google_service_account"
            ]
        );
    }
}
