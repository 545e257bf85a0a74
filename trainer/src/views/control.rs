//! The negative control: networks from parameters to pixels, which S1 says cannot work (S1 appendix 2, METHOD §6.7).
//! They are compared with control points and warping.
//!
//! A network is linear in the pictures, and so is the Fourier transform. A network over transforms, transformed back,
//! gives the same picture. By Parseval the error is the same, too. So one figure is reported for both.

use super::evaluate::{PictureError, add_picture};
use super::fit::FitOptions;
use super::model::parts;
use super::player::{Player, multiplied};
use super::set::{Image, Parameter, View, ViewSet, check_places};
use super::train::train;
use crate::Error;
use crate::bake::bake;
use crate::scattered::solver::fit::Fit;
use crate::scattered::solver::options::Options;
use crate::scattered::solver::samples::Samples;
use crate::scattered::solver::scaling::Block;
use faer::Mat;
use serde::Serialize;
use sinew_runtime::Model;
use sinew_runtime::format::Space;
use sinew_runtime::kernel::Kernel;

/// Smallest number of key views for a fit of a network.
const KEYS: usize = 3;

/// PSNR of the model and of the networks, on the same views.
#[derive(Clone, Debug, Serialize)]
pub struct Control {
    /// Number of predicted views.
    pub views: usize,
    /// Whether the predicted views are key views, each left out of its fit, because the set has no test views with a
    /// picture.
    pub is_left_out: bool,
    /// Control points and warping first, then the networks that could be fitted for every view.
    pub rows: Vec<Row>,
}

/// A method and its PSNR over RGBA times alpha, dB. `None` without such pixels. Infinite without an error, which JSON
/// writes as null.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Name of the method.
    pub name: String,
    /// PSNR over whole pictures.
    pub psnr: Option<f64>,
    /// PSNR over the pixels that are opaque in the model's picture.
    pub psnr_opaque: Option<f64>,
}

/// Kernel and shape parameter (one over the width, in mean distances of the views) of each network over pixels.
pub const NETWORKS: [(Kernel, f64); 7] = [
    (Kernel::Linear, 1.0),
    (Kernel::Multiquadric, 1.0),
    (Kernel::Gaussian, 0.75),
    (Kernel::Gaussian, 1.0),
    (Kernel::Gaussian, 1.5),
    (Kernel::Gaussian, 2.0),
    (Kernel::Gaussian, 4.0),
];

/// Returns the weights with which a network over the parameters mixes the views' pictures at `at`. A network is linear
/// in the pictures, so these weights determine its picture.
///
/// # Errors
/// The network cannot be fitted to the views.
pub fn network_weights(
    (kernel, epsilon): (Kernel, f64),
    parameters: &[Parameter],
    views: &[&View],
    at: &View,
) -> Result<Vec<f64>, Error> {
    let names: Vec<&str> = parameters.iter().flat_map(Parameter::names).collect();
    let value = |view: &View, c: usize| view.values.get(names[c]).copied().unwrap_or_default();
    let sites = Mat::from_fn(views.len(), names.len(), |i, c| value(views[i], c));
    let blocks = vec![Block { len: 1, weight: 1.0 }; names.len()];
    let samples = Samples::of_weights(&sites, &blocks)?;
    let fit = Fit::new(&samples, &Options { epsilon, ..Options::new(kernel) })?;
    Ok(fit.sum.evaluate(&(0..names.len()).map(|c| value(at, c)).collect::<Vec<_>>()))
}

/// Loads the pictures of views, times alpha.
///
/// # Errors
/// A picture cannot be read or is damaged.
pub(super) fn pictures(views: &[&View], size: [usize; 2]) -> Result<Vec<Vec<f64>>, Error> {
    let load = |image: &Image| {
        Ok(multiplied(&image.load(size)?).rgba.into_iter().map(f64::from).collect())
    };
    views.iter().filter_map(|view| view.image.as_ref()).map(load).collect()
}

/// Mixes pictures of equal length by their weights.
pub fn mixed(weights: &[f64], pictures: &[impl AsRef<[f64]>]) -> Vec<f64> {
    let mut out = vec![0.0; pictures.first().map_or(0, |first| first.as_ref().len())];
    for (weight, picture) in weights.iter().zip(pictures) {
        out.iter_mut().zip(picture.as_ref()).for_each(|(out, x)| *out += weight * x);
    }
    out
}

/// Rounds a picture to bytes.
pub(super) fn bytes(picture: &[f64]) -> Vec<u8> {
    picture.iter().map(|x| x.round().clamp(0.0, 255.0) as u8).collect()
}

/// A training set, and views of one motion to predict.
struct Case {
    set: ViewSet,
    map: usize,
    views: Vec<View>,
    /// Name of the set in errors.
    named: String,
}

/// Predicts pictures by control points and warping, and by every network over pixels.
///
/// Predicts the test views that have a picture of the whole object. Without such views, leaves each key view out of the
/// set and predicts that view.
///
/// # Errors
/// There are no pictures; a key view has only pictures of layers; a motion has too few key views to predict one from
/// the others; the set, or the set without one view, cannot be trained on; a view cannot be drawn; or a picture cannot
/// be read or is damaged.
pub fn control(set: &ViewSet, options: FitOptions) -> Result<Control, Error> {
    if let Some(&key) = set.key_views().iter().find(|&&key| set.view(key).image.is_none()) {
        let text = "expected an `image` of the whole, found pictures of layers alone";
        return Err(Error::missing(text).within(set.view_name(key)));
    }
    let mut cases = tested(set)?;
    let is_left_out = cases.is_empty();
    if is_left_out {
        cases = left_out(set)?;
    }
    if cases.is_empty() {
        return Err(Error::missing("there are no pictures"));
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
fn check(set: &ViewSet, map: usize, expected: usize) -> Result<(), Error> {
    let examples = &set.maps[map];
    let found = examples.train.iter().filter(|view| view.is_key()).count();
    if found < expected {
        let map = &examples.name;
        return Err(Error::missing(format!(
            "\"{map}\": expected {expected} key views or more, found {found}"
        )));
    }
    Ok(())
}

/// Lists the cases of motions with test views that have a picture.
fn tested(set: &ViewSet) -> Result<Vec<Case>, Error> {
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

/// Lists one case for each left-out key view of every motion.
fn left_out(set: &ViewSet) -> Result<Vec<Case>, Error> {
    let mut out = Vec::new();
    for (map, number) in set.key_views() {
        check(set, map, KEYS + 1)?;
        let named = format!("without {}", set.view_name((map, number)));
        let mut rest = set.clone();
        let view = rest.maps[map].train.remove(number);
        check_places(&rest.maps[map]).map_err(|error| error.within(&named))?;
        out.push(Case { set: rest, map, views: vec![view], named });
    }
    Ok(out)
}

impl Case {
    /// Trains on the set, predicts the views, and adds the errors of the model and of every network.
    fn add(
        &self,
        options: FitOptions,
        errors: &mut [Option<[PictureError; 2]>],
    ) -> Result<(), Error> {
        let Self { set, map, views, named } = self;
        let examples = &set.maps[*map];
        let keys: Vec<&View> = examples.train.iter().filter(|view| view.image.is_some()).collect();
        let pictures = pictures(&keys, set.size)?;
        let wrong = |error: Error| error.within(named);
        let trained = train(set, options).map_err(wrong)?;
        let file = bake(Space::default(), &parts(&trained.model)?)?;
        let file = Model::from_bytes(file).map_err(|error| wrong(error.into()))?;
        let player = Player::new(&file, Some(&examples.name)).map_err(wrong)?;
        // Key views of other motions have no weight in this motion.
        let own = set.key_views().iter().map(|(other, _)| other == map).collect::<Vec<_>>();
        for view in views {
            let Some(image) = &view.image else { continue };
            let truth = multiplied(&image.load(set.size)?);
            let played = player.play(&view.values).map_err(wrong)?;
            let (picture, _) = player.draw(&played).map_err(wrong)?;
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
