//! Fits the map of one motion: chooses inputs, polynomial and kernel, and assembles the coefficients.

use super::block::{
    Block, Candidate, Fitted, LeftOutViews, Monomial, TermSet, Width, term_sets, terms,
};
use super::map::{MapOutputs, Shown, encodings, given};
use crate::Error;
use crate::numeric::columns::ends;
use crate::regression::confidence::Fade;
use crate::scattered::bound::{largest, rounded};
use crate::scattered::model::{Figures, Input, KernelModel, features};
use crate::scattered::solver::matrix::distances;
use crate::scattered::solver::scaling::{Block as Inputs, Scaling};
use crate::scattered::sum::KernelSum;
use crate::views::set::{Examples, LayerView, Values, View};
use faer::Mat;
use rayon::prelude::*;
use serde::Serialize;
use sinew_runtime::kernel::{Normalise, QueryRule};

/// Relative distance below which two views have the same parameters. The mean distance is 1.
const SAME: f64 = 1e-9;
/// Largest accepted bound of f32 rounding, over the extent of the points. A candidate with a larger bound is replaced.
/// The true rounding is at most a tenth of the bound (*measured*).
const ROUNDING: f64 = 2e-5;

/// A candidate replaces piecewise linear interpolation only if its error is below this share, because a few views rank
/// candidates poorly. *Measured* on 91 paths of `noto-tiger`, every second key left out: the error over that of
/// piecewise linear interpolation is 1.072 without this rule, 1.025 at 0.8, and 1.000 at 0.5.
const BETTER: f64 = 0.5;
/// Error, over the extent of the points, that counts as rounding. The first candidate below is taken.
const EXACT: f64 = 1e-12;

/// Options of a fit.
#[derive(Clone, Copy, Debug, Default)]
pub struct FitOptions {
    /// Whether the map must meet the points of every training view, even if another candidate predicts left-out views
    /// better.
    pub exact: bool,
}

/// A map, and the choices made for it.
#[derive(Clone, Debug)]
pub struct FittedMap {
    /// The map, with the outputs of [`MapOutputs`].
    pub model: KernelModel,
    /// Number of outputs of each kind.
    pub outputs: MapOutputs,
    /// Choices of the fit.
    pub choice: Choice,
}

/// Choices for points, depths and visibility, and all candidates for points.
#[derive(Clone, Debug, Serialize)]
pub struct Choice {
    /// Names of the inputs.
    pub inputs: Vec<String>,
    /// Candidate for points.
    pub points: Candidate,
    /// Candidate for depths.
    pub depths: Candidate,
    /// Candidate for visibility.
    pub visibility: Candidate,
    /// All candidates for points with these inputs.
    pub tried: Vec<Candidate>,
    /// Errors of the points of left-out views, pixels; `None` if the other views do not determine a fit.
    pub left_out: Option<LeftOutViews>,
}

impl FittedMap {
    /// Evaluates the map.
    ///
    /// # Errors
    /// The values are invalid.
    pub fn shown(&self, values: &Values) -> Result<Shown, Error> {
        self.outputs.evaluate(&self.model, values)
    }
}

/// Fits a map to views.
///
/// - `keys`: training view of each of the N key views; `None` for key views of other motions.
///
/// # Errors
/// The parameters of a view are invalid; two views have the same parameters; or no polynomial and no kernel can be
/// fitted.
pub fn fit(
    examples: &Examples,
    keys: &[Option<usize>],
    options: FitOptions,
) -> Result<FittedMap, Error> {
    let points = Block::new(&places(&examples.train));
    let sites =
        encodings(examples).into_iter().map(|encoding| Sites::new(encoding, &examples.train));
    let sites = sites.collect::<Result<Vec<_>, _>>()?;
    let tried: Vec<Vec<Tried>> =
        sites.iter().map(|sites| sites.all(&points, !options.exact, None)).collect();
    let best = |all: &[Tried]| best(all).map_or(f64::INFINITY, |tried| tried.error());
    let chosen = (0..sites.len()).min_by(|&a, &b| best(&tried[a]).total_cmp(&best(&tried[b])));
    let chosen = chosen.unwrap_or(0);
    let extent = extent(&examples.train);
    let error = |tried: &Tried| tried.error().max(EXACT * extent);
    let mut order: Vec<&Tried> = tried[chosen].iter().collect();
    order.sort_by(|a, b| error(a).total_cmp(&error(b)));
    if let Some(plain) = order.iter().position(|tried| tried.is_piecewise_linear())
        && error(order[0]) > BETTER * error(order[plain])
    {
        let plain = order.remove(plain);
        order.insert(0, plain);
    }
    let views = examples.train.len();
    let limit = ROUNDING * extent;
    let mut best: Option<FittedMap> = None;
    for first in order {
        let Some(made) = sites[chosen].assemble(first, examples, keys, &tried[chosen]) else {
            continue;
        };
        if made.model.fit.bound <= limit {
            return Ok(made);
        }
        best =
            Some(best.filter(|best| best.model.fit.bound <= made.model.fit.bound).unwrap_or(made));
    }
    let none = || Error::fit(format!("no polynomial and no kernel can be fitted to {views} views"));
    best.ok_or_else(none)
}

/// Fits every candidate of [`fit`] that single precision can evaluate.
///
/// # Errors
/// The parameters of a view are invalid, or two views have the same parameters.
pub fn fit_each(
    examples: &Examples,
    keys: &[Option<usize>],
    options: FitOptions,
) -> Result<Vec<FittedMap>, Error> {
    let points = Block::new(&places(&examples.train));
    let limit = ROUNDING * extent(&examples.train);
    let mut out = Vec::new();
    for encoding in encodings(examples) {
        let sites = Sites::new(encoding, &examples.train)?;
        let tried = sites.all(&points, !options.exact, None);
        let determined = tried.iter().filter(|tried| tried.candidate.left_out.is_some());
        let made = determined.filter_map(|one| sites.assemble(one, examples, keys, &tried));
        out.extend(made.filter(|made| made.model.fit.bound <= limit));
    }
    Ok(out)
}

/// Features of the views, for one encoding of the parameters.
struct Sites {
    inputs: Vec<Input>,
    /// Features, n x d.
    features: Mat<f64>,
    scaling: Scaling,
    sets: Vec<TermSet>,
}

/// A candidate, and the index of its set of monomials.
#[derive(Clone)]
struct Tried {
    set: usize,
    candidate: Candidate,
}

impl Tried {
    /// Whether the candidate is piecewise linear interpolation.
    fn is_piecewise_linear(&self) -> bool {
        self.candidate.polynomial == "linear" && self.candidate.kernel == Some(Width::LINEAR)
    }

    fn error(&self) -> f64 {
        self.candidate.left_out.unwrap_or(f64::INFINITY)
    }
}

/// Returns the candidate with the smallest error on left-out views. The first of equals wins.
fn best(all: &[Tried]) -> Option<&Tried> {
    all.iter().min_by(|a, b| a.error().total_cmp(&b.error()))
}

impl Sites {
    fn new(inputs: Vec<Input>, views: &[View]) -> Result<Self, Error> {
        let mut rows = Vec::with_capacity(views.len());
        for (view, own) in views.iter().enumerate() {
            let given = given(&inputs, &own.values)?;
            let wrong = |error: Error| error.within(format_args!("train view {view}"));
            rows.push(features(&inputs, &given).map_err(wrong)?);
        }
        let d = rows.first().map_or(0, Vec::len);
        let features = Mat::from_fn(rows.len(), d, |i, c| rows[i][c]);
        let block = |input: &Input| Inputs { len: input.kind.feature_len(), weight: input.weight };
        let scaling = Scaling::new(&features, &inputs.iter().map(block).collect::<Vec<_>>())?;
        let points = scaling.apply(&features);
        for first in 0..points.nrows() {
            let own = distances(&points, first);
            if let Some(second) = (1..own.len()).find(|&other| own[other] < SAME) {
                let second = first + second;
                let text = format!("train views {first} and {second} have the same parameters");
                return Err(Error::fit(text));
            }
        }
        let sets = term_sets(&inputs, &scaling.kept());
        Ok(Self { inputs, features, scaling, sets })
    }

    /// Returns the scaled features, n x d, times a shape parameter.
    fn points(&self, epsilon: f64) -> Mat<f64> {
        self.scaling.apply(&self.features) * faer::Scale(epsilon)
    }

    fn fit(&self, block: &Block, set: usize, kernel: Option<Width>) -> Option<Fitted> {
        let points = self.points(kernel.map_or(1.0, |width| width.epsilon));
        block.fit(&points, &self.sets[set], kernel)
    }

    /// Tries every polynomial with every kernel, or with the given kernel. If `alone` is set, also tries polynomials
    /// without a kernel.
    fn all(&self, block: &Block, alone: bool, width: Option<Width>) -> Vec<Tried> {
        let mut all: Vec<(usize, Option<Width>)> = Vec::new();
        for (number, set) in self.sets.iter().enumerate() {
            let own = width.map_or_else(|| Width::all(set), |width| vec![width]);
            let kernels = alone.then_some(None).into_iter().chain(own.into_iter().map(Some));
            all.extend(kernels.map(|kernel| (number, kernel)));
        }
        let one = |&(set, kernel): &(usize, Option<Width>)| {
            let left_out = self.fit(block, set, kernel).and_then(|fitted| fitted.left_out());
            let polynomial = self.sets[set].name;
            Tried { set, candidate: Candidate { polynomial, kernel, left_out } }
        };
        all.par_iter().map(one).collect()
    }

    /// Fits depths, visibility and numbers, and joins all outputs in one map. `None` if rounding dominates.
    fn assemble(
        &self,
        points: &Tried,
        examples: &Examples,
        keys: &[Option<usize>],
        tried: &[Tried],
    ) -> Option<FittedMap> {
        let views = &examples.train;
        let outputs = MapOutputs {
            points: views.first().map_or(0, |view| view.points.len()),
            views: keys.len(),
            layers: examples.layer_len(),
        };
        let points = self.or_piecewise_linear(points);
        let numbers = numbers(views, keys, outputs.layers);
        let blocks =
            [places(views), depths(views), visibility(views), numbers].map(|own| Block::new(&own));
        let width = points.candidate.kernel;
        let depths = self.or_piecewise_linear(best(&self.all(&blocks[1], true, width))?);
        let width = width.or(depths.candidate.kernel);
        // The map meets the known visibility of every view, so a kernel is required.
        let visibility = match changes(views) {
            true => self.or_piecewise_linear(best(&self.all(&blocks[2], false, width))?),
            // Every candidate fits constant visibility exactly, so the smallest error would be a matter of rounding.
            false => self.piecewise_linear(width),
        };
        let width = width.or(visibility.candidate.kernel).unwrap_or(Width::LINEAR);
        // The views do not determine the numbers between key views, so these are interpolated linearly.
        let numbers = self.piecewise_linear(Some(width));
        let scaled = self.points(width.epsilon);
        let rows = outputs.rows();
        let mut fitted = Vec::new();
        for (tried, block) in [&points, &depths, &visibility, &numbers].into_iter().zip(&blocks) {
            fitted.push(block.fit(&scaled, &self.sets[tried.set], tried.candidate.kernel)?);
        }
        let all = fitted.iter().flat_map(|fitted| &fitted.monomials).cloned();
        let all: Vec<Monomial> = all.collect();
        let (monomials, list) = terms(&all);
        let place = |of: &Monomial| monomials.iter().position(|other| other == of).unwrap_or(0);
        let centres = views.len();
        let mut coefficients = Mat::zeros(outputs.value_len(), centres + monomials.len());
        for (fitted, rows) in fitted.iter().zip(&rows) {
            for (column, &row) in rows.iter().enumerate() {
                (0..centres).for_each(|k| coefficients[(row, k)] = fitted.kernels[(k, column)]);
                for (term, monomial) in fitted.monomials.iter().enumerate() {
                    coefficients[(row, centres + place(monomial))] =
                        fitted.coefficients[(term, column)];
                }
            }
        }
        let sum = KernelSum {
            kernel: width.kernel,
            shift: self.scaling.shift.clone(),
            scale: self.scaling.scale.iter().map(|scale| scale * width.epsilon).collect(),
            metric: None,
            centres: scaled.transpose().to_owned(),
            terms: list,
            coefficients,
        };
        let left_out = fitted[0].report();
        let bounds = largest(&rounded(&sum), &self.features);
        let bound = rows[0].iter().map(|&value| bounds[value]).fold(0.0, f64::max);
        let mut map = FittedMap {
            model: KernelModel {
                name: examples.name.clone(),
                inputs: self.inputs.clone(),
                outputs: outputs.outputs(),
                sum,
                ranges: self.features.col_iter().map(|column| ends(column.iter())).collect(),
                query: QueryRule::Free,
                fade: Fade { start: 0.0, end: 0.0 },
                normalise: Normalise::Never,
                variance: None,
                fit: Figures {
                    left_out_rms: left_out.as_ref().map_or(0.0, |left_out| left_out.rms),
                    bound,
                    ..Figures::default()
                },
            },
            outputs,
            choice: Choice {
                inputs: self.inputs.iter().map(|input| input.name.clone()).collect(),
                points: points.candidate,
                depths: depths.candidate,
                visibility: visibility.candidate,
                tried: tried.iter().map(|tried| tried.candidate).collect(),
                left_out,
            },
        };
        map.model.fit.residual_rms = residual_rms(&map, views);
        Some(map)
    }

    /// Returns the candidate, or piecewise linear interpolation if views could not be left out.
    fn or_piecewise_linear(&self, tried: &Tried) -> Tried {
        if tried.candidate.left_out.is_some() {
            return tried.clone();
        }
        self.piecewise_linear(tried.candidate.kernel)
    }

    /// Returns piecewise linear interpolation; with the given kernel, if there is one.
    fn piecewise_linear(&self, width: Option<Width>) -> Tried {
        let set = self.sets.iter().position(|set| set.name == "linear").unwrap_or(0);
        let polynomial = self.sets[set].name;
        let kernel = Some(width.unwrap_or(Width::LINEAR));
        Tried { set, candidate: Candidate { polynomial, kernel, left_out: None } }
    }
}

/// Returns the longer side of the bounding box of all points.
fn extent(views: &[View]) -> f64 {
    let side = |axis: usize| {
        let known = views.iter().flat_map(|view| view.points.iter().flatten());
        let all: Vec<f64> = known.map(|point| point[axis]).collect();
        let [low, high] = ends(&all);
        high - low
    };
    side(0).max(side(1))
}

/// Lists x and y of all points by view.
fn places(views: &[View]) -> Vec<Vec<Option<f64>>> {
    let place = |point: &Option<[f64; 2]>| match point {
        Some([x, y]) => [Some(*x), Some(*y)],
        None => [None; 2],
    };
    views.iter().map(|view| view.points.iter().flat_map(place).collect()).collect()
}

/// Lists depths by view; 0 for an object without depths.
fn depths(views: &[View]) -> Vec<Vec<Option<f64>>> {
    let has_some = views.iter().any(|view| !view.depths.is_empty());
    let of = |view: &View| match (has_some, view.depths.is_empty()) {
        (true, true) => vec![None; view.points.len()],
        (true, false) => view.depths.iter().copied().map(Some).collect(),
        (false, _) => vec![Some(0.0); view.points.len()],
    };
    views.iter().map(of).collect()
}

fn visibility(views: &[View]) -> Vec<Vec<Option<f64>>> {
    let seen = |seen: Option<bool>| seen.map(|seen| f64::from(u8::from(seen)));
    views.iter().map(|view| view.seen().map(seen).collect()).collect()
}

/// Whether a point is visible in some views and hidden in others.
fn changes(views: &[View]) -> bool {
    let mut known: Vec<Option<bool>> = Vec::new();
    views.iter().any(|view| {
        known.resize(view.points.len(), None);
        let mut points = known.iter_mut().zip(view.seen());
        points.any(|(known, seen)| seen.is_some_and(|seen| *known.get_or_insert(seen) != seen))
    })
}

/// Lists by view the scores of key views, then opacity and order of layers. A key view scores 1 at its own parameters
/// and 0 at those of other key views. If a view has a picture of a layer without opacity or order, these are 1 and the
/// index of the layer.
fn numbers(views: &[View], keys: &[Option<usize>], layers: usize) -> Vec<Vec<Option<f64>>> {
    let of = |(number, view): (usize, &View)| {
        let is_own = keys.contains(&Some(number));
        let score = |key: &Option<usize>| match key {
            Some(key) => is_own.then_some(f64::from(u8::from(*key == number))),
            None => Some(0.0),
        };
        let number = |layer: usize, said: fn(&LayerView) -> Option<f64>, default: f64| {
            let own = |view: &View| view.layers.get(layer).and_then(said);
            let is_default =
                view.picture(layer).is_some() || views.iter().all(|view| own(view).is_none());
            own(view).or(is_default.then_some(default))
        };
        let opacity = |layer| number(layer, |own| own.opacity, 1.0);
        let order = |layer| number(layer, |own| own.order, layer as f64);
        let layers = (0..layers).map(opacity).chain((0..layers).map(order));
        keys.iter().map(score).chain(layers).collect()
    };
    views.iter().enumerate().map(of).collect()
}

/// Measures the RMS error of a map's points on its training views.
fn residual_rms(map: &FittedMap, views: &[View]) -> f64 {
    let (mut squares, mut count) = (0.0, 0);
    for view in views {
        let Ok(shown) = map.shown(&view.values) else { continue };
        for (found, known) in shown.points.iter().zip(&view.points) {
            let Some(known) = known else { continue };
            squares += (0..2).map(|axis| (found[axis] - known[axis]).powi(2)).sum::<f64>();
            count += 2;
        }
    }
    (squares / f64::from(count.max(1))).sqrt()
}
