//! Numbers as text.

/// A finite decimal number; white space around it is allowed.
pub fn decimal(text: &str) -> Option<f64> {
    // Rust's own parser takes "inf" and "nan" as well, which are not finite.
    text.trim().parse().ok().filter(|value: &f64| value.is_finite())
}

/// The shortest decimal that reads back to the same double.
pub fn number(value: f64) -> String {
    format!("{value:?}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    #[test]
    fn numbers_are_finite_decimals() {
        for (text, value) in [("1", 1.0), (" -2.5e-3\t", -2.5e-3), ("+.5", 0.5), ("1.", 1.0), ("2E+06", 2e6)]
        {
            assert_eq!(decimal(text), Some(value), "{text:?}");
        }
        let bad = [
            "", " ", ".", "+", "e", "e5", ".e5", "nan", "NaN", "-nan", "inf", "-inf", "+INF", "infinity",
            "Infinity", "1e999", "0x10", "1_000", "1,5", "1 2", "٣", "--1", "1e", "1e+", "1f", "1d0",
        ];
        for text in bad {
            assert_eq!(decimal(text), None, "{text:?}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(7), ..ProptestConfig::default() })]

        #[test]
        fn a_number_reads_back_to_the_same_bits(bits: u64) {
            let value = f64::from_bits(bits);
            let back = decimal(&number(value)).map(f64::to_bits);
            prop_assert_eq!(back, value.is_finite().then_some(bits));
        }
    }
}
