//! Whose signatures a board believes.

/// The public half of a key, as Ed25519 encodes it (RFC 8032, section 5.1.5).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key(pub [u8; 32]);

// `CHOSEN: Option<Key>`, by the build script.
include!(concat!(env!("OUT_DIR"), "/key.rs"));

/// The key that this build was told: that of the file which the environment names as `NARX_UPDATE_KEY`, else with the feature `test-key`
/// the one whose secret half is in firmware/keys for everybody.
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
        None => panic!(
            "whose images does this board take? NARX_UPDATE_KEY names a file of `cargo xtask sign --new-key`, .pub"
        ),
    }
}
