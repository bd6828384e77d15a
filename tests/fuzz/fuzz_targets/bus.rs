//! libFuzzer over [`narx_fuzz::bus`].

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| narx_fuzz::bus::run(data));
