//! See `sturz_tests::decoders`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| sturz_tests::decoders::read("rockable", bytes));
