//! libFuzzer over [`narx_fuzz::log`].

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| narx_fuzz::log::run(data));
