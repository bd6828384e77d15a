//! libFuzzer over [`narx_fuzz::candump`].

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| narx_fuzz::candump::run(data));
