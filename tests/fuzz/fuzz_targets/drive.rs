//! libFuzzer over [`narx_fuzz::drive`].

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| narx_fuzz::drive::run(data));
