//! tests/must-have.md names its evidence, and the evidence exists.
