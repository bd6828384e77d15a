//! libFuzzer over [`narx_fuzz::boot`].

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| narx_fuzz::boot::run(data));
