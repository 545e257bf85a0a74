//! Errors of faces on real data, measured with the runtime and the bytes of a file.

mod bars;
mod meshes;

use sinew_runtime::Model;
use sinew_trainer::envelope::model::{FileModel, ShapeNumbers};
use sinew_trainer::face::basis::Basis;
use sinew_trainer::face::source::{self, Source};
use sinew_trainer::face::take::{self, Take};
use sinew_trainer::face::train::{Options, of_take};

pub(crate) fn options() -> Options {
    Options { name: "head".to_owned(), tolerance: None, numbers: ShapeNumbers::F32 }
}

/// Reads the head and the take; `None` without shared data.
pub(crate) fn head() -> Option<(Basis, Take)> {
    let file = models::shared("ict-facekit/ict_head.npz")?;
    let take = models::shared("arkit-rom/alex_rom_3.csv")?;
    let Source::Shapes(basis) = source::read(&file).unwrap() else { panic!("it has shapes") };
    let take = take::read(&take, &basis.names()).unwrap();
    Some((basis, take))
}

pub(crate) fn trained(basis: &Basis, frames: &[Vec<f64>]) -> FileModel {
    of_take(basis, frames, &options()).unwrap()
}

pub(crate) fn loaded(model: &FileModel) -> Model<Vec<u8>> {
    Model::from_bytes(model.bake().unwrap()).unwrap()
}
