//! `sinew`: learns how a skin moves, measures what it learned, and shows what a model holds.

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
