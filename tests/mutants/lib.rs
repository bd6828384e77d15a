//! An empty library: the programs beside it are the tests of `cargo xtask mutants`.
