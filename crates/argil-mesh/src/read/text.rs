//! Text of mesh files: bytes that may be UTF-8, Latin-1 or anything else beside their numbers.

use super::error::ReadFault;
use glam::Vec3;

/// Maximum characters of a line in a message.
const QUOTED: usize = 60;

/// Returns the text after a byte order mark.
///
/// # Errors
/// If the bytes are UTF-16, or hold a NUL.
pub(super) fn checked(bytes: &[u8]) -> Result<&[u8], ReadFault> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        let reason = "its text is UTF-16: save it as UTF-8";
        return Err(ReadFault::Unsupported(reason.into()));
    }
    if bytes.contains(&0) {
        return Err("not text: it contains a zero byte".into());
    }
    Ok(without_mark(bytes))
}

/// Returns the bytes after a UTF-8 byte order mark, if there is one.
pub(super) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// Iterates over lines that end in a line feed, a carriage return or both, with their numbers from 1.
pub(super) fn lines(bytes: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    let mut rest = Some(bytes);
    let next = move || {
        let bytes = rest?;
        let end = bytes.iter().position(|&b| b == b'\n' || b == b'\r');
        let Some(end) = end else {
            rest = None;
            return Some(bytes);
        };
        let is_pair = bytes[end..].starts_with(b"\r\n");
        rest = Some(&bytes[end + 1 + usize::from(is_pair)..]);
        Some(&bytes[..end])
    };
    (1..).zip(std::iter::from_fn(next))
}

/// Iterates over the words of a line.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
}

/// Parses a number. What old C libraries write for infinite and invalid numbers is NaN.
pub(super) fn number<T: std::str::FromStr + From<f32>>(word: &[u8]) -> Option<T> {
    let text = std::str::from_utf8(word).ok()?;
    let is_odd = || {
        let text = text.trim_start_matches(['-', '+']);
        text.starts_with("1.#")
            || text
                .get(..3)
                .is_some_and(|nan| nan.eq_ignore_ascii_case("nan"))
    };
    text.parse()
        .ok()
        .or_else(|| is_odd().then(|| f32::NAN.into()))
}

/// Parses a point from the next three words.
pub(super) fn point<'a>(words: &mut impl Iterator<Item = &'a [u8]>) -> Option<Vec3> {
    let mut next = || number(words.next()?);
    Some(Vec3::new(next()?, next()?, next()?))
}

/// Returns the beginning of a line, for a message.
pub(super) fn quoted(line: &[u8]) -> String {
    let text = String::from_utf8_lossy(line);
    text.trim().chars().take(QUOTED).collect()
}

/// Returns a fault in a line.
pub(super) fn bad_line(number: usize, line: &[u8]) -> ReadFault {
    ReadFault::Damaged(format!("line {number}: \"{}\"", quoted(line)))
}
