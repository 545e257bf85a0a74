//! The machine that builds.

/// Prints a text.
pub fn print(text: &str) {
    std::print!("{text}");
}
