//! Evaluates baked Sinew models.
#![no_std]
#![forbid(unsafe_code)]
