//! Numbers as they are read.

/// Three significant digits, without exponents between a thousandth and a million.
pub(super) fn short(number: f64) -> String {
    let size = number.abs();
    if number == 0.0 {
        "0".to_owned()
    } else if !size.is_finite() {
        "\u{2013}".to_owned()
    } else if (0.001..1e6).contains(&size) {
        let digits = (2 - size.log10().floor() as i32).clamp(0, 6) as usize;
        let text = format!("{number:.digits$}");
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    } else {
        let exponent = size.log10().floor();
        let mantissa = short(number / 10.0f64.powf(exponent));
        format!("{mantissa}e{exponent}")
    }
}

/// A share as a percentage with one decimal.
pub(super) fn percent(share: f64) -> String {
    format!("{:.1}", share * 100.0)
}

/// Bytes in the largest unit that keeps a digit before the point.
pub(super) fn bytes(bytes: u64) -> String {
    let units = ["B", "KiB", "MiB", "GiB"];
    let mut size = bytes as f64;
    let mut unit = 0;
    while size >= 1024.0 && unit + 1 < units.len() {
        size /= 1024.0;
        unit += 1;
    }
    format!("{} {}", short(size), units[unit])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_digits_are_kept() {
        for (number, text) in [
            (0.0, "0"),
            (1234.5, "1234"),
            (12.345, "12.3"),
            (0.012_345, "0.0123"),
            (0.5, "0.5"),
            (-2.0, "-2"),
            (3.2e-7, "3.2e-7"),
            (1e-4, "1e-4"),
            (f64::NAN, "\u{2013}"),
        ] {
            assert_eq!(short(number), text);
        }
        assert_eq!(bytes(1536), "1.5 KiB");
        assert_eq!(percent(0.4372), "43.7");
    }
}
