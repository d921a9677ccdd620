//! Keeps secrets out of texts.

/// Returns a text without what addresses may hold of secrets: names and passwords before a host, and queries.
///
/// Messages of a store can quote the address of a request, which may be signed.
///
/// ```
/// let address = "s3://AKIA:wJal/K7MD@bucket/world";
/// assert_eq!(argil_world::redacted(address), "s3://bucket/world");
/// ```
pub fn redacted(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find("://") {
        let (before, after) = rest.split_at(at + 3);
        out.push_str(before);
        let ends = |c: char| c.is_whitespace() || matches!(c, '"' | '\'' | '<' | '>' | ')' | '`');
        // A password can have the characters that end other addresses.
        let word = after.split(char::is_whitespace).next().unwrap_or_default();
        let after = &after[secret_end(word)..];
        let end = after.find(ends).unwrap_or(after.len());
        let (address, others) = after.split_at(end);
        out.push_str(address.split(['?', '#']).next().unwrap_or_default());
        rest = others;
    }
    out.push_str(rest);
    out
}

/// Returns where the names and passwords before a host end. Those of AWS can contain `/`, so that they look like a path.
fn secret_end(address: &str) -> usize {
    let authority_end = address.find(['/', '?', '#']).unwrap_or(address.len());
    let authority = &address[..authority_end];
    let is_port = |text: &str| text.len() <= 5 && text.bytes().all(|c| c.is_ascii_digit());
    let searched = match authority.rsplit_once(':') {
        None => authority,
        // A path can contain `@`, too. Rather the host of such an address is left out than a password shown.
        Some((_, port)) if is_port(port) => address.split(['?', '#']).next().unwrap_or(address),
        Some(_) => address,
    };
    searched.rfind('@').map_or(0, |at| at + 1)
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
            ("https://me:pa)ss@host/w", "https://host/w"),
            (
                "get \"https://me:it's`<\"@host/w\": 403",
                "get \"https://host/w\": 403",
            ),
            ("https:// me@host", "https:// me@host"),
            (
                "s3://AKIA:wJal/K7MD+bPx/Ey@bucket/world",
                "s3://bucket/world",
            ),
            ("s3://AKIA:12/34@bucket/world?x=y", "s3://bucket/world"),
            ("s3://AKIA:a?b/c@bucket/world", "s3://bucket/world"),
            ("s3://AKIA:a@b/c@bucket", "s3://bucket"),
            ("https://host:8080/a/b?c=d@e", "https://host:8080/a/b"),
            ("https://host/a@b/c", "https://host/a@b/c"),
            ("https://host:8080/a", "https://host:8080/a"),
            (
                "(http://x/y#z) and http://u:p@v/w",
                "(http://x/y) and http://v/w",
            ),
        ] {
            assert_eq!(redacted(text), expected);
        }
    }
}
