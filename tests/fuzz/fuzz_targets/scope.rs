//! libFuzzer over [`narx_fuzz::scope`].

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| narx_fuzz::scope::run(data));
