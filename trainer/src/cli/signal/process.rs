//! The process of a signal, as the command line states it.

use crate::Error;
use crate::cli::{OfFile, Output, named};
use crate::signal::choose::{TAPS, best, estimated, of_images, variance};
use crate::signal::covariance::{Covariance, Subject};
use crate::signal::grid::{Grid, GridFilter, Sample, Shape};
use crate::signal::kriging::{Mean, Process};
use crate::signal::table::read_table;
use std::path::Path;

/// Assumed process of a signal.
#[derive(clap::Args)]
#[command(next_help_heading = "Process")]
pub(super) struct ProcessArguments {
    /// Covariance of samples by their distance in samples
    ///
    /// auto (the family that predicts left-out samples best; ornstein-uhlenbeck:3 for images), "squared exponential:L",
    /// "ornstein-uhlenbeck:L", "matern 3/2:L", "matern 5/2:L", "oscillating:L,T", estimated (from the signal), or a
    /// .csv of covariances at lags 0, 1, 2, ...
    #[arg(long, default_value = "auto")]
    covariance: String,
    /// Mean of the samples
    #[arg(long, default_value = "constant", value_parser = named(MEANS))]
    mean: Mean,
    /// Variance of the noise over that of the signal; above 0 samples are smoothed
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    noise: f64,
    /// Samples of a CSV are means over the time between them, not values
    #[arg(long)]
    pub(super) averages: bool,
    /// Number of coarse samples that make a fine sample, odd
    #[arg(long, value_name = "N", default_value_t = TAPS)]
    taps: usize,
}

/// Mean functions.
const MEANS: [(&str, Mean); 3] =
    [("zero", Mean::Zero), ("constant", Mean::Constant), ("linear", Mean::Linear)];

impl ProcessArguments {
    /// Returns the process of a signal; warns of a covariance that was clipped.
    ///
    /// - `file`: file of the signal, which errors name.
    pub(super) fn process(
        &self,
        samples: &[f64],
        file: &Path,
        output: Output,
    ) -> anyhow::Result<Process> {
        let covariance = match self.covariance.as_str() {
            "auto" => best(samples, self.sample()).of(file)?,
            "estimated" => clipped(estimated(samples).of(file)?, output, file),
            _ => self.given(Subject::Signal, output).of(file)?,
        };
        Ok(self.of(covariance))
    }

    /// Makes a signal finer. Returns its process, the fine samples and their variances.
    ///
    /// - `file`: file of the signal, which errors name.
    pub(super) fn finer(
        &self,
        samples: &[f64],
        factor: usize,
        file: &Path,
        output: Output,
    ) -> anyhow::Result<(Process, Vec<f64>, Vec<f64>)> {
        let (sample, n) = (self.sample(), samples.len());
        let process = self.process(samples, file, output)?;
        let filter = self.filter(&process, factor, sample)?;
        let fine = filter.apply(samples, Shape { samples: n, lanes: 1 }).of(file)?;
        let scale = variance(samples, sample, &process.covariance);
        let variances = filter.variances_of(n).iter().map(|x| scale * x).collect();
        Ok((process, fine, variances))
    }

    /// Returns the process of images.
    pub(super) fn process_of_images(&self, output: Output) -> anyhow::Result<Process> {
        Ok(self.of(match self.covariance.as_str() {
            "auto" => of_images(),
            _ => self.given(Subject::Image, output)?,
        }))
    }

    /// Returns the filter of a process.
    pub(super) fn filter(
        &self,
        process: &Process,
        factor: usize,
        sample: Sample,
    ) -> Result<GridFilter, Error> {
        GridFilter::new(process, Grid { factor, taps: self.taps, sample })
    }

    /// Returns the kind of the samples.
    pub(super) fn sample(&self) -> Sample {
        if self.averages { Sample::Average } else { Sample::Value }
    }

    fn of(&self, covariance: Covariance) -> Process {
        Process { covariance, mean: self.mean, noise: self.noise }
    }

    fn given(&self, subject: Subject, output: Output) -> anyhow::Result<Covariance> {
        let path = Path::new(&self.covariance);
        if path.extension().is_none_or(|ending| ending != "csv") {
            return Ok(Covariance::parse(&self.covariance, subject)?);
        }
        let found = read_table(path).of(path)?;
        Ok(clipped(found, output, path))
    }
}

/// Warns of a covariance with a spectrum that was partly negative.
fn clipped((covariance, share): (Covariance, f64), output: Output, file: &Path) -> Covariance {
    if share > 0.0 {
        let percent = 100.0 * share;
        let what = format!(
            "the covariance was indefinite: {percent:.2} % of its spectrum was negative and is clipped"
        );
        output.warn(file.display(), what);
    }
    covariance
}
