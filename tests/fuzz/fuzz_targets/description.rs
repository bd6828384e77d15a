//! libFuzzer over [`narx_fuzz::description`].

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| narx_fuzz::description::run(data));
