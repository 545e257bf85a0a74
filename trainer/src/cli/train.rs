//! `sinew train`: examples in, baked model out.

use super::bars::Bars;
use super::{Output, input, print_json, table};
use anyhow::{Context, bail};
use clap::ValueEnum;
use serde_json::json;
use sinew_trainer::bake::write_atomically;
use sinew_trainer::envelope::rotational::Options;
use sinew_trainer::envelope::rotational::proxies::ProxyCount;
use sinew_trainer::envelope::train;
use std::path::PathBuf;

/// Fits an envelope to the training frames of EXAMPLES and bakes it into MODEL.
///
/// Held-out and extreme frames are never read by the fit: every choice is made by cross-validation
/// inside the training frames. The same input gives the same bytes for any number of threads.
#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    input: input::Arguments,
    /// Where to write the model
    #[arg(long, short = 'o', value_name = "MODEL")]
    output: PathBuf,
    #[command(flatten)]
    fit: FitArguments,
    /// Write every choice, fold, candidate, score and input hash to FILE, as JSON
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
}

/// What a fit may be told.
#[derive(clap::Args)]
pub(super) struct FitArguments {
    /// What predicts the proxies from the pose
    #[arg(long, value_enum, default_value_t = Predictor::Rotational)]
    predictor: Predictor,
    /// Number of proxies [default: 40]
    #[arg(long, value_name = "P", conflicts_with = "max_error")]
    proxies: Option<usize>,
    /// The fewest proxies whose own error on the training frames is at most this, in % of the
    /// rest diagonal
    #[arg(long, value_name = "PERCENT")]
    max_error: Option<f64>,
    /// Most proxies a vertex follows
    #[arg(long, value_name = "K", default_value_t = 4)]
    influences: usize,
    /// Keep the reconstruction as published: do not refine it on the training meshes
    #[arg(long)]
    published: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Predictor {
    /// Rotational regression of key gradients, reduced Poisson reconstruction
    Rotational,
}

impl FitArguments {
    /// Checks the numbers against a character of the given diagonal.
    pub(super) fn options(&self, diagonal: f64) -> anyhow::Result<Options> {
        let Predictor::Rotational = self.predictor;
        let most = u16::MAX as usize;
        if self.influences == 0 || self.influences > sinew_trainer::envelope::blend::CANDIDATES {
            bail!(
                "--influences: expected 1 to {}, found {}",
                sinew_trainer::envelope::blend::CANDIDATES,
                self.influences
            );
        }
        let proxies = match (self.max_error, self.proxies.unwrap_or(40)) {
            (Some(percent), _) if percent > 0.0 && percent.is_finite() => {
                ProxyCount::MaxError(percent / 100.0 * diagonal)
            }
            (Some(percent), _) => bail!("--max-error: expected more than 0 %, found {percent}"),
            (None, count @ 1..) if count <= most => ProxyCount::Fixed(count),
            (None, count) => bail!("--proxies: expected 1 to {most}, found {count}"),
        };
        Ok(Options { proxies, influences: self.influences, refine: !self.published })
    }
}

pub(super) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let examples = arguments.input.load(output)?;
    let diagonal = examples.diagonal();
    let options = arguments.fit.options(diagonal)?;
    let trained = train(&examples, &options, &Bars::new(output))?;
    let model = &arguments.output;
    let inputs = arguments.input.hashes()?;
    let record = json!({
        "sinew": env!("CARGO_PKG_VERSION"),
        "inputs": inputs,
        "vertices": examples.vertex_len(),
        "joints": examples.joint_len(),
        "training_frames": examples.frames_of(sinew_trainer::examples::Split::Train),
        "diagonal": diagonal,
        "predictor": "rotational",
        "options": options,
        "proxies": trained.proxies,
        "report": trained.report,
        "model_bytes": trained.model.len(),
    });
    write_atomically(model, &trained.model)
        .with_context(|| format!("cannot write {}", model.display()))?;
    if let Some(path) = &arguments.record {
        write_atomically(path, &serde_json::to_vec_pretty(&record)?)
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
    if output.json {
        return print_json(&record);
    }
    println!("{}", input::describe(&examples));
    table::print_report(&trained.report, diagonal, trained.proxies);
    println!("wrote {} ({} bytes)", model.display(), trained.model.len());
    Ok(())
}
