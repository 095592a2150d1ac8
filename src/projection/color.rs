//! Colours as text.

/// Display-referred RGB in [0, 1] from `#rrggbb`, or `None` when `text` is something else.
pub fn rgb_from_hex(text: &str) -> Option<[f32; 3]> {
    let digits = text.strip_prefix('#')?;
    if digits.len() != 6 || !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
        return None;
    }
    let rgb = u32::from_str_radix(digits, 16).ok()?;
    Some([16, 8, 0].map(|shift| (rgb >> shift & 0xff) as f32 / 255.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_hexadecimal_digits_make_a_colour() {
        assert_eq!(rgb_from_hex("#ff0033"), Some([1.0, 0.0, 0.2]));
        for bad in ["ff0033", "#ff003", "#ff00333", "#gg0033", "#+f0033", "#αβγ", ""] {
            assert_eq!(rgb_from_hex(bad), None, "{bad}");
        }
    }
}
