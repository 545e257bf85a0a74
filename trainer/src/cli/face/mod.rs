//! The commands of faces: `sinew face ...`.

mod eval;
mod input;
mod pin;
mod pins;
mod solve;
mod train;

commands! {
    Train(train::Train),
    Pin(pin::Pin),
    Solve(solve::Solve),
    Eval(eval::Eval),
    Report(eval::ReportArgs),
}
