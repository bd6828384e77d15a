//! Floating-point numbers in texts.

use narx_core::shown::Shown;

#[test]
fn numbers_read_as_they_are_written() {
    for (value, text) in [
        (0.0, "0"),
        (-0.0, "0"),
        (17.9, "17.9"),
        (-3.25, "-3.25"),
        (1234567.0, "1234567"),
        (0.000012, "0.000012"),
        (1e300, "1e300"),
        (-2.5e-9, "-2.5e-9"),
        (f64::NAN, "NaN"),
        (f64::NEG_INFINITY, "-inf"),
    ] {
        assert_eq!(Shown::Plain(value).to_string(), text);
    }
    for (value, decimals, text) in [(6.54, 1, "6.5"), (6.0, 1, "6.0"), (-0.04, 1, "0.0"), (3312.7, 0, "3313")]
    {
        assert_eq!(Shown::Rounded(value, decimals).to_string(), text);
    }
}
