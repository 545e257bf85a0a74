//! The golden files.

/// The golden files, one a predictor.
pub const GOLDEN: [&[u8]; 3] = [
    include_bytes!("../../golden/envelope-3-rotational.snw"),
    include_bytes!("../../golden/envelope-3-kernel.snw"),
    include_bytes!("../../golden/envelope-3-hybrid.snw"),
];
