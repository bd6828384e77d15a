//! libFuzzer over [`narx_fuzz::master`].

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| narx_fuzz::master::run(data));
