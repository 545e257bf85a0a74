//! The negative control: networks over pixels beside control points and warping (S1 appendix 2, METHOD §6.7).
//!
//! A network is linear in the pictures, and so is their Fourier transform: a network over transforms, transformed back,
//! gives the same picture. By Parseval its error is the same, too. So one figure is reported for both.
//! S1's appendix 2: a network from parameters to pixels, which it says cannot work. It shows what points and
//! warping are for.

use super::evaluate::{PictureError, add_picture};
use super::fit::FitOptions;
use super::model::parts;
use super::player::{PlayError, Player, multiplied};
use super::set::{Parameter, SetError, View, ViewSet};
use super::train::{TrainError, train};
use crate::bake::{BakeError, bake};
use crate::kernel::scattered::error::KernelError;
use crate::kernel::scattered::fit::Fit;
use crate::kernel::scattered::options::Options;
use crate::kernel::scattered::samples::Samples;
use crate::kernel::scattered::scaling::Block;
use faer::Mat;
use serde::Serialize;
use sinew_runtime::Model;
use sinew_runtime::format::Space;
use sinew_runtime::kernel::Kernel;

/// Fewest key views that a network is fitted to.
const KEYS: usize = 3;

/// PSNR of the model and of the networks, on the same views.
#[derive(Clone, Debug, Serialize)]
pub struct Control {
    /// Views that were predicted.
    pub views: usize,
    /// Whether they are key views, each left out of the fit: the set has no test views with a picture.
    pub is_left_out: bool,
    /// Control points and warping first, then networks over pixels: those that could be fitted for every view.
    pub rows: Vec<Row>,
}

/// One way to make pictures, and its PSNR over RGBA times alpha, dB; infinite, which JSON has as null, where nothing is
/// off. `None` where there are no such pixels.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The way.
    pub name: String,
    /// Over whole pictures.
    pub psnr: Option<f64>,
    /// Over the pixels that are opaque in the model's picture.
    pub psnr_opaque: Option<f64>,
}

/// A set that the control cannot be measured on.
#[derive(Debug, thiserror::Error)]
pub enum ControlError {
    /// There are too few pictures to predict one from others.
    #[error("\"{map}\": expected {expected} key views or more, found {found}")]
    Few {
        /// The motion.
        map: String,
        /// Key views at the least.
        expected: usize,
        /// Its key views.
        found: usize,
    },
    /// A key view has pictures of layers alone.
    #[error("{0}: expected an `image` of the whole, found pictures of layers alone")]
    Whole(String),
    /// The set, or a set without one of its views, cannot be taken.
    #[error("{of}: {error}")]
    Train {
        /// The set that was trained on.
        of: String,
        /// Why.
        error: Box<TrainError>,
    },
    /// A view cannot be shown.
    #[error("{of}: {error}")]
    Play {
        /// The view.
        of: String,
        /// Why.
        error: PlayError,
    },
    /// A picture cannot be read.
    #[error(transparent)]
    Set(#[from] SetError),
    /// A model cannot be written.
    #[error(transparent)]
    Bake(#[from] BakeError),
}

/// A set to learn from, and views of one of its motions to predict.
struct Case {
    set: ViewSet,
    map: usize,
    views: Vec<View>,
    /// How the set is named in errors.
    named: String,
}

/// Predicts pictures by control points and warping, and by every network over pixels.
///
/// Test views with a picture of the whole are predicted; where there are none, each key view, left out of the set.
///
/// # Errors
/// [`ControlError`].
pub fn control(set: &ViewSet, options: FitOptions) -> Result<Control, ControlError> {
    if let Some(&key) =
        set.key_views().iter().find(|(map, view)| set.maps[*map].train[*view].image.is_none())
    {
        return Err(ControlError::Whole(set.view_name(key)));
    }
    let mut cases = tested(set)?;
    let is_left_out = cases.is_empty();
    if is_left_out {
        cases = left_out(set)?;
    }
    if cases.is_empty() {
        return Err(SetError::Empty("pictures").into());
    }
    let mut names = vec![
        "control points and warping".to_owned(),
        "pixels, by the inputs of the points".to_owned(),
    ];
    names.extend(NETWORKS.map(|(kernel, epsilon)| match kernel {
        Kernel::Linear => "pixels, linear".to_owned(),
        _ => format!("pixels, {}, width {:.2}", kernel.name(), 1.0 / epsilon),
    }));
    let mut errors = vec![Some([PictureError::default(); 2]); names.len()];
    for case in &cases {
        case.add(options, &mut errors)?;
    }
    let row = |(name, errors): (String, Option<[PictureError; 2]>)| {
        let [psnr, psnr_opaque] = errors?.map(|error| error.psnr());
        Some(Row { name, psnr, psnr_opaque })
    };
    let views = cases.iter().map(|case| case.views.len()).sum();
    let rows = names.into_iter().zip(errors).filter_map(row).collect();
    Ok(Control { views, is_left_out, rows })
}

/// Checks that a motion has enough key views.
fn check(set: &ViewSet, map: usize, expected: usize) -> Result<(), ControlError> {
    let examples = &set.maps[map];
    let found = examples.train.iter().filter(|view| view.is_key()).count();
    let map = examples.name.clone();
    if found < expected { Err(ControlError::Few { map, expected, found }) } else { Ok(()) }
}

/// Lists the motions with test views that have a picture.
fn tested(set: &ViewSet) -> Result<Vec<Case>, ControlError> {
    let mut out = Vec::new();
    for (map, examples) in set.maps.iter().enumerate() {
        let test = examples.test.iter().filter(|view| view.image.is_some());
        let views: Vec<View> = test.cloned().collect();
        if !views.is_empty() {
            check(set, map, KEYS)?;
            out.push(Case { set: set.clone(), map, views, named: examples.name.clone() });
        }
    }
    Ok(out)
}

/// Leaves out each key view of every motion that has some.
fn left_out(set: &ViewSet) -> Result<Vec<Case>, ControlError> {
    let mut out = Vec::new();
    for (map, number) in set.key_views() {
        check(set, map, KEYS + 1)?;
        let named = without(set, map, number);
        let mut rest = set.clone();
        let view = rest.maps[map].train.remove(number);
        let nowhere = |k: &usize| rest.maps[map].train.iter().all(|own| own.points[*k].is_none());
        if let Some(point) = (0..view.points.len()).find(nowhere) {
            let map = set.maps[map].name.clone();
            let error = Box::new(SetError::Nowhere { map, point }.into());
            return Err(ControlError::Train { of: named, error });
        }
        out.push(Case { set: rest, map, views: vec![view], named });
    }
    Ok(out)
}

fn without(set: &ViewSet, map: usize, view: usize) -> String {
    format!("without {}", set.view_name((map, view)))
}

impl Case {
    /// Trains on the set, predicts the views, and adds the errors of the model and of every network.
    fn add(
        &self,
        options: FitOptions,
        errors: &mut [Option<[PictureError; 2]>],
    ) -> Result<(), ControlError> {
        let Self { set, map, views, named } = self;
        let examples = &set.maps[*map];
        let keys: Vec<&View> = examples.train.iter().filter(|view| view.image.is_some()).collect();
        let mut pictures = Vec::new();
        for image in keys.iter().filter_map(|view| view.image.as_ref()) {
            let picture = multiplied(&image.load(set.size)?);
            pictures.push(picture.rgba.into_iter().map(f64::from).collect::<Vec<f64>>());
        }
        let pictures: Vec<&[f64]> = pictures.iter().map(Vec::as_slice).collect();
        let trained = train(set, options)
            .map_err(|error| ControlError::Train { of: named.clone(), error: Box::new(error) })?;
        let file = bake(Space::default(), &parts(&trained.model)?)?;
        let play = |error| ControlError::Play { of: named.clone(), error };
        let file =
            Model::from_bytes(file).map_err(|error| play(PlayError::Missing(error.to_string())))?;
        let player = Player::new(&file, Some(&examples.name)).map_err(play)?;
        // Key views of other motions have no part in this one.
        let own = set.key_views().iter().map(|(other, _)| other == map).collect::<Vec<_>>();
        for view in views {
            let Some(image) = &view.image else { continue };
            let truth = multiplied(&image.load(set.size)?);
            let played = player.play(&view.values).map_err(play)?;
            let (picture, _) = player.draw(&played).map_err(play)?;
            let scores = played.scores.iter().zip(&own).filter(|(_, own)| **own);
            let own = Some(scores.map(|(score, _)| f64::from(*score)).collect::<Vec<_>>());
            let fitted = NETWORKS
                .map(|network| network_weights(network, &examples.parameters, &keys, view).ok());
            let networks = std::iter::once(own).chain(fitted);
            let networks = networks.map(|weights| Some(bytes(&mixed(&weights?, &pictures))));
            let found = std::iter::once(Some(picture.rgba.clone())).chain(networks);
            for (error, found) in errors.iter_mut().zip(found) {
                match (&mut *error, found) {
                    (Some(own), Some(found)) => add_picture(own, &truth, &found, &picture),
                    _ => *error = None,
                }
            }
        }
        Ok(())
    }
}

/// Rounds a picture to bytes.
fn bytes(picture: &[f64]) -> Vec<u8> {
    picture.iter().map(|x| x.round().clamp(0.0, 255.0) as u8).collect()
}

/// One over the widths of gaussians, in mean distances of the views.
const EPSILONS: [f64; 5] = [0.75, 1.0, 1.5, 2.0, 4.0];

/// A network of pixels by what it is made of: a kernel and one over its width.
pub const NETWORKS: [(Kernel, f64); 7] = [
    (Kernel::Linear, 1.0),
    (Kernel::Multiquadric, 1.0),
    (Kernel::Gaussian, EPSILONS[0]),
    (Kernel::Gaussian, EPSILONS[1]),
    (Kernel::Gaussian, EPSILONS[2]),
    (Kernel::Gaussian, EPSILONS[3]),
    (Kernel::Gaussian, EPSILONS[4]),
];

/// Returns how much of each view's picture a network over the parameters shows at others: a network is
/// linear in the pictures, so that its weights are all of it.
///
/// # Errors
/// [`KernelError`] of the fit.
pub fn network_weights(
    (kernel, epsilon): (Kernel, f64),
    parameters: &[Parameter],
    views: &[&View],
    at: &View,
) -> Result<Vec<f64>, KernelError> {
    let names: Vec<&str> = parameters.iter().flat_map(Parameter::names).collect();
    let value = |view: &View, c: usize| view.values.get(names[c]).copied().unwrap_or_default();
    let sites = Mat::from_fn(views.len(), names.len(), |i, c| value(views[i], c));
    let blocks = vec![Block { len: 1, weight: 1.0 }; names.len()];
    let samples = Samples::of_weights(&sites, &blocks)?;
    let fit = Fit::new(&samples, &Options { epsilon, ..Options::new(kernel) })?;
    Ok(fit.sum.evaluate(&(0..names.len()).map(|c| value(at, c)).collect::<Vec<_>>()))
}

/// Mixes pictures by their weights: numbers of equal length.
pub fn mixed(weights: &[f64], pictures: &[&[f64]]) -> Vec<f64> {
    let mut out = vec![0.0; pictures.first().map_or(0, |first| first.len())];
    for (weight, picture) in weights.iter().zip(pictures) {
        out.iter_mut().zip(*picture).for_each(|(out, x)| *out += weight * x);
    }
    out
}
