//! The commands of scattered data: `sinew kernel ...`.

mod eval;
mod plot;
mod train;

commands! {
    Train(train::Train),
    Eval(eval::Eval),
    Check(eval::Check),
    Plot(plot::PlotArgs),
}
