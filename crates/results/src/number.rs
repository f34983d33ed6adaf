//! Numbers as text that reads back to the same bits.

use std::fmt::Write as _;

/// Appends `{value:?}`: the same text, but `zmij` takes a quarter of the time.
pub(crate) fn put(text: &mut String, value: f64) {
    // The two differ in what is rare in a table:
    // - Where two shortest texts are equally near, std takes the upper one, zmij the even one. Then the exact value ends
    //   one digit later; so it has at most 25 binary digits after the point, as all from 1e16 on have, infinity and NaN.
    // - From 1e-5 to 1e-4 std has an exponent.
    let differs = binary_digits(value) <= 25 || (1e-5..1e-4).contains(&value.abs());
    if value.to_bits() == 0 {
        text.push_str("0.0");
    } else if differs {
        _ = write!(text, "{value:?}");
    } else {
        text.push_str(zmij::Buffer::new().format_finite(value));
    }
}

/// Number of binary digits after the point; not positive for whole numbers and for what is not finite.
fn binary_digits(value: f64) -> i32 {
    /// Of the fraction of a double.
    const DIGITS: u32 = 52;
    let bits = value.to_bits();
    let exponent = (bits >> DIGITS & 0x7ff) as i32 - 1023;
    (DIGITS - bits.trailing_zeros().min(DIGITS)) as i32 - exponent
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn check(value: f64) {
        let mut text = String::from("before ");
        put(&mut text, value);
        assert_eq!(text, format!("before {value:?}"), "{:x}", value.to_bits());
    }

    /// Xorshift64*, as in every textbook.
    fn random() -> impl FnMut() -> u64 {
        let mut state = 1u64;
        move || {
            state ^= state >> 12;
            state ^= state << 25;
            state ^= state >> 27;
            state.wrapping_mul(0x2545_f491_4f6c_dd1d)
        }
    }

    #[test]
    fn special_numbers_are_those_of_std() {
        for value in [
            0.0,
            1.0,
            0.1,
            0.5,
            1e-4,
            0.000_099_999_999_999_999_99,
            1e-5,
            0.000_009_999_999_999_999_999,
            1e-7,
            123_456.0,
            9_007_199_254_740_993.0,
            1e15,
            9_999_999_999_999_998.0,
            1e16,
            1e21,
            1e23,
            f64::MAX,
            f64::MIN_POSITIVE,
            f64::from_bits(1),
            f64::from_bits((1 << 52) - 1),
            f64::EPSILON,
            PI,
            f64::INFINITY,
            f64::NAN,
            // Between two shortest texts.
            1.0 + 1.0 / 131_072.0,
            30_659_149.278_320_313,
            1_169_320_452_386_249.3,
        ] {
            check(value);
            check(-value);
        }
    }

    #[test]
    fn random_bits_are_those_of_std() {
        let mut random = random();
        (0..200_000).for_each(|_| check(f64::from_bits(random())));
    }

    /// All powers of two and of ten that a table has, and numbers of few binary digits, of which some are ties.
    #[test]
    fn numbers_of_all_sizes_are_those_of_std() {
        let mut random = random();
        for exponent in -40..60 {
            for _ in 0..2_000 {
                let part = 1.0 + (random() >> 12) as f64 / f64::from(1u32 << 26).powi(2);
                check(part * 2f64.powi(exponent));
                check((random() % 1_000_000) as f64 * 10f64.powi(exponent / 3));
                // 1 to 53 digits of it.
                let kept = (!0u64) << (random() % 53);
                check(f64::from_bits((part * 2f64.powi(exponent)).to_bits() & kept));
            }
        }
    }
}
