//! Keeps secrets out of texts.

/// Returns a text without what addresses may hold of secrets: names and passwords before a host, and queries.
///
/// Messages of a store can quote the address of a request, which may be signed.
pub(crate) fn redacted(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find("://") {
        let (before, after) = rest.split_at(at + 3);
        out.push_str(before);
        let ends = |c: char| c.is_whitespace() || matches!(c, '"' | '\'' | '<' | '>' | ')' | '`');
        let end = after.find(ends).unwrap_or(after.len());
        let (address, others) = after.split_at(end);
        let authority_end = address.find(['/', '?', '#']).unwrap_or(address.len());
        let (authority, path) = address.split_at(authority_end);
        out.push_str(authority.rsplit('@').next().unwrap_or_default());
        out.push_str(path.split(['?', '#']).next().unwrap_or_default());
        rest = others;
    }
    out.push_str(rest);
    out
}

#[cfg(test)]
mod tests {
    use super::redacted;

    #[test]
    fn secrets_are_left_out() {
        for (text, expected) in [
            ("plain text: a?b@c", "plain text: a?b@c"),
            ("s3://key:secret@bucket/world", "s3://bucket/world"),
            (
                "get \"https://host/a/b?X-Amz-Signature=abc&c=d\": 403",
                "get \"https://host/a/b\": 403",
            ),
            ("https://a@b@host", "https://host"),
            (
                "(http://x/y#z) and http://u:p@v/w",
                "(http://x/y) and http://v/w",
            ),
        ] {
            assert_eq!(redacted(text), expected);
        }
    }
}
