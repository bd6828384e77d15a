//! Keys and signatures, against what others make of them.

use narx_boot::Key;
use narx_boot::sign::SecretKey;

/// The public half in firmware/keys is that of the secret one, and it is what the feature `test-key` builds in.
#[test]
fn the_test_key_is_the_published_one() {
    let secret = SecretKey(digits(include_str!("../../keys/TEST-ONLY.key")));
    let public = Key(digits(include_str!("../../keys/TEST-ONLY.pub")));
    assert_eq!(secret.public(), public);
    const CHOSEN: Key = narx_boot::key::chosen();
    assert_eq!(CHOSEN, public);
}

fn digits(text: &str) -> [u8; 32] {
    let digits = text.trim();
    core::array::from_fn(|at| u8::from_str_radix(&digits[2 * at..2 * at + 2], 16).expect("hexadecimal"))
}
