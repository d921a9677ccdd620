//! Formats images, text and numbers.

/// Pixels along the longer side of a stored image.
const SHOWN: u32 = 400;

/// Scales an image for storage.
pub(crate) fn shown(picture: &image::RgbImage) -> image::RgbImage {
    if picture.width().max(picture.height()) <= SHOWN {
        return picture.clone();
    }
    let filter = image::imageops::FilterType::Triangle;
    image::DynamicImage::from(picture.clone())
        .resize(SHOWN, SHOWN, filter)
        .to_rgb8()
}

/// Escapes text for HTML.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// Formats a count with its noun, which takes an `s` unless the count is 1.
pub(crate) fn counted(count: usize, noun: &str) -> String {
    let ending = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{ending}")
}

/// Formats a number with its significant digits.
pub(crate) fn number(value: f64) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    let size = value.abs();
    if size >= 1000.0 || value == value.trunc() {
        let whole = format!("{:.0}", value.abs());
        let mut grouped = String::new();
        for (i, digit) in whole.chars().enumerate() {
            if i > 0 && (whole.len() - i).is_multiple_of(3) {
                grouped.push(',');
            }
            grouped.push(digit);
        }
        return format!("{}{grouped}", if value < 0.0 { "−" } else { "" });
    }
    let digits = if size >= 100.0 {
        0
    } else if size >= 10.0 {
        1
    } else if size >= 0.1 {
        2
    } else {
        4
    };
    format!("{value:.digits$}")
}
