//! A map of one motion: inputs, polynomial and kernel chosen, coefficients put together.

use super::block::{
    Block, Candidate, Fitted, LeftOutViews, Monomial, TermSet, Width, term_sets, terms,
};
use super::map::{FitError, MapOutputs, Shown, given, ways};
use crate::kernel::bound::{largest, rounded};
use crate::kernel::fade::Fade;
use crate::kernel::model::{Figures, Input, KernelModel, features};
use crate::kernel::scattered::matrix::distances;
use crate::kernel::scattered::scaling::{Block as Inputs, Scaling};
use crate::kernel::sum::KernelSum;
use crate::numeric::columns::ends;
use crate::views::set::{Examples, LayerView, Values, View};
use faer::Mat;
use rayon::prelude::*;
use serde::Serialize;
use sinew_runtime::kernel::{Kernel, Normalise, QueryRule};

/// Distance, over the mean one, below which two views have the same parameters.
const SAME: f64 = 1e-9;
/// Share of the points' extent by which f32 arithmetic may be bound to be off, before another candidate is
/// taken; what it is off by is a tenth of that at most (*measured*).
const ROUNDING: f64 = 2e-5;

/// Share of the error of lines from view to view that another candidate must come below: a few views say little of
/// which is better. *Measured* on 91 paths of `noto-tiger`, every second key left out: 1.072 times the error of lines
/// without this, 1.025 at 0.8, 1.000 here.
const BETTER: f64 = 0.5;
/// Share of the points' extent below which an error is rounding: the first of such candidates is taken.
const EXACT: f64 = 1e-12;

/// What a fit is asked for.
#[derive(Clone, Copy, Debug, Default)]
pub struct FitOptions {
    /// Whether the points of every example are to be met, whatever predicts left-out views best.
    pub exact: bool,
}

/// A map, and how it was chosen.
#[derive(Clone, Debug)]
pub struct FittedMap {
    /// The map; its outputs are those of [`MapOutputs`].
    pub model: KernelModel,
    /// How many outputs it has.
    pub outputs: MapOutputs,
    /// How it was chosen.
    pub choice: Choice,
}

/// What was chosen for points, depths and visibility, and what else was tried for points.
#[derive(Clone, Debug, Serialize)]
pub struct Choice {
    /// The inputs, by name.
    pub inputs: Vec<String>,
    /// For points.
    pub points: Candidate,
    /// For depths.
    pub depths: Candidate,
    /// For visibility.
    pub visibility: Candidate,
    /// All that was tried for points with these inputs.
    pub tried: Vec<Candidate>,
    /// Points of views that are left out, pixels; none where the others do not determine a fit.
    pub left_out: Option<LeftOutViews>,
}

impl FittedMap {
    /// Evaluates the map.
    ///
    /// # Errors
    /// [`FitError`] of the values.
    pub fn shown(&self, values: &Values) -> Result<Shown, FitError> {
        self.outputs.evaluate(&self.model, values)
    }
}

/// Fits a map to views.
///
/// - `keys`: N key views of the object, each the training view that it is, or none of this motion's.
///
/// # Errors
/// [`FitError`].
pub fn fit(
    examples: &Examples,
    keys: &[Option<usize>],
    options: FitOptions,
) -> Result<FittedMap, FitError> {
    let points = Block::new(&places(&examples.train));
    let sites = ways(examples).into_iter().map(|way| Sites::new(way, &examples.train));
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
    if let Some(plain) = order.iter().position(|tried| tried.is_plain())
        && error(order[0]) > BETTER * error(order[plain])
    {
        let plain = order.remove(plain);
        order.insert(0, plain);
    }
    let views = examples.train.len();
    let limit = ROUNDING * extent;
    let mut best: Option<FittedMap> = None;
    for first in order {
        let Some(made) = sites[chosen].put_together(first, examples, keys, &tried[chosen]) else {
            continue;
        };
        if made.model.fit.bound <= limit {
            return Ok(made);
        }
        best =
            Some(best.filter(|best| best.model.fit.bound <= made.model.fit.bound).unwrap_or(made));
    }
    best.ok_or(FitError::None { views })
}

/// Fits every candidate that [`fit`] chooses from: those that single precision can evaluate.
///
/// # Errors
/// [`FitError`].
pub fn fit_each(
    examples: &Examples,
    keys: &[Option<usize>],
    options: FitOptions,
) -> Result<Vec<FittedMap>, FitError> {
    let points = Block::new(&places(&examples.train));
    let limit = ROUNDING * extent(&examples.train);
    let mut out = Vec::new();
    for way in ways(examples) {
        let sites = Sites::new(way, &examples.train)?;
        let tried = sites.all(&points, !options.exact, None);
        let determined = tried.iter().filter(|tried| tried.candidate.left_out.is_some());
        let made = determined.filter_map(|one| sites.put_together(one, examples, keys, &tried));
        out.extend(made.filter(|made| made.model.fit.bound <= limit));
    }
    Ok(out)
}

/// Views at which the values of a map are given.
struct Sites {
    inputs: Vec<Input>,
    /// Features, n x d.
    features: Mat<f64>,
    scaling: Scaling,
    sets: Vec<TermSet>,
}

/// A candidate, and the set that its name stands for.
#[derive(Clone)]
struct Tried {
    set: usize,
    candidate: Candidate,
}

impl Tried {
    /// Whether it is lines from view to view.
    fn is_plain(&self) -> bool {
        self.candidate.polynomial == "linear" && self.candidate.kernel == Some(Width::PLAIN)
    }

    fn error(&self) -> f64 {
        self.candidate.left_out.unwrap_or(f64::INFINITY)
    }
}

/// Returns what predicts left-out views best, the first of equals.
fn best(all: &[Tried]) -> Option<&Tried> {
    all.iter().min_by(|a, b| a.error().total_cmp(&b.error()))
}

impl Sites {
    fn new(inputs: Vec<Input>, views: &[View]) -> Result<Self, FitError> {
        let mut rows = Vec::with_capacity(views.len());
        for (view, own) in views.iter().enumerate() {
            let given = given(&inputs, &own.values)?;
            rows.push(features(&inputs, &given).map_err(|error| FitError::Site { view, error })?);
        }
        let d = rows.first().map_or(0, Vec::len);
        let features = Mat::from_fn(rows.len(), d, |i, c| rows[i][c]);
        let block = |input: &Input| Inputs { len: input.kind.feature_len(), weight: input.weight };
        let scaling = Scaling::new(&features, &inputs.iter().map(block).collect::<Vec<_>>())?;
        let points = scaling.apply(&features);
        for first in 0..points.nrows() {
            let own = distances(&points, first);
            if let Some(second) = (1..own.len()).find(|&other| own[other] < SAME) {
                return Err(FitError::Same { first, second: first + second });
            }
        }
        let sets = term_sets(&inputs, &scaling.kept());
        Ok(Self { inputs, features, scaling, sets })
    }

    /// Returns the views, n x d, scaled by a width.
    fn points(&self, epsilon: f64) -> Mat<f64> {
        self.scaling.apply(&self.features) * faer::Scale(epsilon)
    }

    fn fit(&self, block: &Block, set: usize, kernel: Option<Width>) -> Option<Fitted> {
        let points = self.points(kernel.map_or(1.0, |width| width.epsilon));
        block.fit(&points, &self.sets[set], kernel)
    }

    /// Tries every polynomial, alone where that is allowed, and with every kernel or with the one that is
    /// given.
    fn all(&self, block: &Block, alone: bool, width: Option<Width>) -> Vec<Tried> {
        let kernels = |set: &TermSet| {
            let own = match width {
                Some(width) => vec![width],
                None => Width::all(set),
            };
            let none = alone.then_some(None);
            none.into_iter().chain(own.into_iter().map(Some)).collect::<Vec<_>>()
        };
        let all: Vec<(usize, Option<Width>)> = self
            .sets
            .iter()
            .enumerate()
            .flat_map(|(set, own)| kernels(own).into_iter().map(move |kernel| (set, kernel)))
            .collect();
        let one = |&(set, kernel): &(usize, Option<Width>)| {
            let left_out = self.fit(block, set, kernel).and_then(|fitted| fitted.left_out());
            let polynomial = self.sets[set].name;
            Tried { set, candidate: Candidate { polynomial, kernel, left_out } }
        };
        all.par_iter().map(one).collect()
    }

    /// Fits depths and visibility beside points, and makes one function of all; none where rounding decides.
    fn put_together(
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
        let points = self.or_plain(points);
        let numbers = numbers(views, keys, outputs.layers);
        let blocks =
            [places(views), depths(views), visibility(views), numbers].map(|own| Block::new(&own));
        let mut width = points.candidate.kernel;
        let depths = self.or_plain(best(&self.all(&blocks[1], true, width))?);
        width = width.or(depths.candidate.kernel);
        // Every example is met: what is seen there is known.
        let visibility = match changes(views) {
            true => self.or_plain(best(&self.all(&blocks[2], false, width))?),
            // Whatever is fitted to what never changes is exact, and the least error a matter of rounding.
            false => self.lines(width),
        };
        width = width.or(visibility.candidate.kernel);
        // Of what lies between key views the examples say nothing: lines from one to the next.
        let numbers = self.lines(width);
        width = width.or(numbers.candidate.kernel);
        let epsilon = width.map_or(1.0, |width| width.epsilon);
        let scaled = self.points(epsilon);
        let parts = [
            (&points, outputs.places()),
            (&depths, outputs.depths()),
            (&visibility, outputs.visibility()),
            (&numbers, outputs.numbers()),
        ];
        let mut fitted = Vec::new();
        for ((tried, _), block) in parts.iter().zip(&blocks) {
            fitted.push(block.fit(&scaled, &self.sets[tried.set], tried.candidate.kernel)?);
        }
        let all = fitted.iter().flat_map(|fitted| &fitted.monomials).cloned();
        let all: Vec<Monomial> = all.collect();
        let (monomials, list) = terms(&all);
        let place = |of: &Monomial| monomials.iter().position(|other| other == of).unwrap_or(0);
        let centres = if width.is_some() { views.len() } else { 0 };
        let mut coefficients = Mat::zeros(outputs.value_len(), centres + monomials.len());
        for (fitted, (_, rows)) in fitted.iter().zip(&parts) {
            for (column, &row) in rows.iter().enumerate() {
                (0..centres).for_each(|k| coefficients[(row, k)] = fitted.kernels[(k, column)]);
                for (term, monomial) in fitted.monomials.iter().enumerate() {
                    coefficients[(row, centres + place(monomial))] =
                        fitted.coefficients[(term, column)];
                }
            }
        }
        let sum = KernelSum {
            kernel: width.map_or(Kernel::Linear, |width| width.kernel),
            shift: self.scaling.shift.clone(),
            scale: self.scaling.scale.iter().map(|scale| scale * epsilon).collect(),
            metric: None,
            centres: scaled.transpose().subcols(0, centres).to_owned(),
            terms: list,
            coefficients,
        };
        let left_out = fitted[0].report();
        let bounds = largest(&rounded(&sum), &self.features);
        let bound = outputs.places().iter().map(|&value| bounds[value]).fold(0.0, f64::max);
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

    /// Takes what was tried; where views could not be left out, lines from view to view.
    fn or_plain(&self, tried: &Tried) -> Tried {
        if tried.candidate.left_out.is_some() {
            return tried.clone();
        }
        self.lines(tried.candidate.kernel)
    }

    /// Returns lines from view to view; what goes along them by a kernel that is given.
    fn lines(&self, width: Option<Width>) -> Tried {
        let set = self.sets.iter().position(|set| set.name == "linear").unwrap_or(0);
        let polynomial = self.sets[set].name;
        let kernel = Some(width.unwrap_or(Width::PLAIN));
        Tried { set, candidate: Candidate { polynomial, kernel, left_out: None } }
    }
}

/// Returns the longer side of the box of all points.
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

/// Lists depths by view: 0 of an object that has none.
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

/// Whether a point is seen in some views and not in others.
fn changes(views: &[View]) -> bool {
    let mut known: Vec<Option<bool>> = Vec::new();
    views.iter().any(|view| {
        known.resize(view.points.len(), None);
        let mut points = known.iter_mut().zip(view.seen());
        points.any(|(known, seen)| seen.is_some_and(|seen| *known.get_or_insert(seen) != seen))
    })
}

/// Lists by view what key views score, 1 at their own parameters and 0 at those of others, and opacity and order of
/// layers. Of a view that does not say them and has a picture of the layer, these are 1 and the layer's number.
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

/// Measures what a map leaves of the points of its examples.
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
