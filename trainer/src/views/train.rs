//! From a set of views to a model.

use super::fit::{Choice, FitError, FitOptions, FittedMap, fit};
use super::model::{KeyView, Reached, ViewsModel};
use super::set::{SetError, ViewSet};

/// A model, and how each of its maps was chosen.
#[derive(Clone, Debug)]
pub struct Trained {
    /// The model.
    pub model: ViewsModel,
    /// By map.
    pub choices: Vec<Choice>,
}

/// A set that no model was made of.
#[derive(Debug, thiserror::Error)]
pub enum TrainError {
    /// It cannot be taken.
    #[error(transparent)]
    Set(#[from] SetError),
    /// A motion cannot be fitted.
    #[error("\"{map}\": {error}")]
    Fit {
        /// The motion.
        map: String,
        /// Why.
        error: FitError,
    },
}

/// Fits every motion of a set, and takes the pictures of its key views.
///
/// # Errors
/// [`TrainError`].
pub fn train(set: &ViewSet, options: FitOptions) -> Result<Trained, TrainError> {
    let keys = set.key_views();
    if keys.is_empty() {
        return Err(SetError::Empty("pictures").into());
    }
    let pictures = keys.iter().map(|&(map, view)| key_view(set, map, view));
    let pictures = pictures.collect::<Result<Vec<_>, _>>()?;
    let mut maps: Vec<FittedMap> = Vec::new();
    for (number, examples) in set.maps.iter().enumerate() {
        let own: Vec<Option<usize>> =
            keys.iter().map(|&(map, view)| (map == number).then_some(view)).collect();
        let wrong = |error| TrainError::Fit { map: examples.name.clone(), error };
        maps.push(fit(examples, &own, options).map_err(wrong)?);
    }
    let model = ViewsModel {
        name: set.name.clone(),
        point_len: set.point_len(),
        elements: set.elements.clone(),
        keys: pictures,
        fit: reached(set, &maps),
        maps: maps.iter().map(|map| map.model.clone()).collect(),
    };
    Ok(Trained { model, choices: maps.into_iter().map(|map| map.choice).collect() })
}

fn key_view(set: &ViewSet, map: usize, view: usize) -> Result<KeyView, SetError> {
    let view = &set.maps[map].train[view];
    let image = view.image.as_ref().ok_or(SetError::Empty("pictures"))?;
    let stem = image.file.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    Ok(KeyView {
        name: stem.unwrap_or_default(),
        picture: image.load(set.size)?,
        points: view.known(),
        visible: view.visible.clone(),
        reference: None,
    })
}

/// Measures maps at their examples.
fn reached(set: &ViewSet, maps: &[FittedMap]) -> Reached {
    let rms = |of: &dyn Fn(&FittedMap) -> f64| {
        let squares = maps.iter().map(|map| of(map).powi(2)).sum::<f64>();
        (squares / maps.len().max(1) as f64).sqrt()
    };
    let (mut right, mut count) = (0, 0);
    for (examples, map) in set.maps.iter().zip(maps) {
        for view in &examples.train {
            let Ok(shown) = map.shown(&view.values) else { continue };
            right += shown.visible.iter().zip(&view.visible).filter(|(a, b)| a == b).count();
            count += view.visible.len();
        }
    }
    Reached {
        rms: rms(&|map| map.model.fit.residual_rms),
        left_out: rms(&|map| map.model.fit.left_out_rms),
        visibility: right as f64 / count.max(1) as f64,
    }
}
