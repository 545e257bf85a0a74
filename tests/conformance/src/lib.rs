//! Tolerances and comparators shared by the conformance tests.
