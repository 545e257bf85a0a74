//! `sinew`: learns how a skin moves, measures the result, and prints the contents of a model.

fn main() -> std::process::ExitCode {
    sinew_trainer::cli::main()
}
