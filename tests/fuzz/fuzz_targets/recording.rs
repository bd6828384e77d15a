//! libFuzzer over [`narx_fuzz::recording`].

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| narx_fuzz::recording::run(data));
