//! libFuzzer over [`narx_fuzz::transcript`].

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| narx_fuzz::transcript::run(data));
