//! libFuzzer over [`narx_fuzz::tx_driver`].

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| narx_fuzz::tx_driver::run(data));
