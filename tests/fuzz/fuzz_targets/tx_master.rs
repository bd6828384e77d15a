//! libFuzzer over [`narx_fuzz::tx_master`].

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| narx_fuzz::tx_master::run(data));
