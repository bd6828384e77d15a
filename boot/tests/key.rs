//! Keys and signatures, against what others make of them.

use narx_boot::Key;
use narx_boot::key::TEST_ONLY;
use narx_boot::sign::SecretKey;

/// The two halves in boot/keys belong together.
#[test]
fn the_published_key_is_the_published_one() {
    assert_eq!(SecretKey::TEST_ONLY.public(), TEST_ONLY);
    assert_ne!(TEST_ONLY, Key([0; 32]));
}
