//! libFuzzer over [`narx_fuzz::storage`].

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| narx_fuzz::storage::run(data));
