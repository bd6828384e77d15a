//! libFuzzer over [`narx_fuzz::slcan`].

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| narx_fuzz::slcan::run(data));
