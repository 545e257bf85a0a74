//! `sinew`: learns how a skin moves, measures the result, and prints the contents of a model.

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
