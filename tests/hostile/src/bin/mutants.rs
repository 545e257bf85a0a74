//! A million mutated files: each is refused or evaluates to finite values.
//!
//! `cargo run --release -p hostile --bin mutants [COUNT]`

use hostile::recipe::mutant;
use hostile::targets;
use std::process::ExitCode;
use std::time::{Duration, Instant};

const COUNT: u64 = 1_000_000;

fn main() -> ExitCode {
    let Some(count) = std::env::args().nth(1).map_or(Some(COUNT), |count| count.parse().ok())
    else {
        eprintln!("usage: mutants [COUNT]");
        return ExitCode::from(2);
    };
    let start = Instant::now();
    let (mut accepted, mut findings) = (0, 0);
    let mut slowest = (Duration::ZERO, 0);
    for number in 0..count {
        let file = mutant(number);
        let start = Instant::now();
        match std::panic::catch_unwind(|| targets::run(&file)) {
            Ok(done) => accepted += u64::from(done.is_ok()),
            Err(_) => {
                eprintln!("mutant {number} is a finding");
                findings += 1;
            }
        }
        slowest = slowest.max((start.elapsed(), number));
    }
    let (seconds, (time, number)) = (start.elapsed().as_secs_f64(), slowest);
    println!("{count} files in {seconds:.0} s: {accepted} accepted, {findings} findings");
    println!("the slowest, number {number}, took {:.1} ms", time.as_secs_f64() * 1e3);
    if findings == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
