//! The commands of signals and images: `sinew signal ...`.

mod plot;
mod process;
mod superres;
mod train;

commands! {
    Train(train::Train),
    Superres(superres::Superres),
    Fit(train::Fit),
    Plot(plot::PlotArgs),
}
