//! libFuzzer over [`narx_fuzz::update`].

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| narx_fuzz::update::run(data));
