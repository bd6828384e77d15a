//! Whose signatures a board believes.

// `CHOSEN` and `PUBLISHED`, by the build script.
include!(concat!(env!("OUT_DIR"), "/key.rs"));

/// The public half of a key, as Ed25519 encodes it (RFC 8032, section 5.1.5).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key(pub [u8; 32]);

/// The key whose secret half is in boot/keys for everybody: for the bench, the emulator and tests. A
/// board that believes it runs anybody's program.
pub const TEST_ONLY: Key = Key(PUBLISHED);

/// The key that this build was told: that of the file which the environment names as `NARX_UPDATE_KEY`, else
/// with the feature `test-key` [`TEST_ONLY`].
///
/// ```
/// # #[cfg(feature = "test-key")]
/// const KEY: narx_boot::Key = narx_boot::key::chosen();
/// ```
///
/// # Panics
/// Without either; as the value of a constant it then does not compile.
pub const fn chosen() -> Key {
    match CHOSEN {
        Some(key) => key,
        None => {
            panic!(
                "NARX_UPDATE_KEY must name a public key (`cargo xtask sign --new-key`), or the feature test-key be set"
            )
        }
    }
}
