//! Skins with shapes under test, with weights: the golden files, and skins with one vertex, a full
//! block, no shape and many shapes.

use ::models::{Pieces, Rng, SMALL, Shape, ShapeContent};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::Element;
use sinew_runtime::{Model, Skin};
use sinew_trainer::envelope::model::SkinModel;
use std::sync::OnceLock;

/// Number of faces (lists of weights) of a skin.
pub const FACES: usize = 70;

/// A skin with shapes under test.
pub struct ShapeSubject<'a> {
    /// The file.
    pub model: Model<&'a [u8]>,
    /// The skin.
    pub skin: Skin<'a>,
    /// Its oracle.
    pub oracle: SkinModel,
    /// Weights of all faces, one face after another: from -1 to 2, some of them 0; all weights of
    /// the first face are 0.
    pub weights: Vec<f32>,
    /// Number of faces.
    pub face_len: usize,
}

impl<'a> ShapeSubject<'a> {
    /// Loads the first skin of a file and draws weights of its shapes.
    ///
    /// # Panics
    /// If the bytes are not a model with a skin.
    pub fn new(bytes: &'a [u8], face_len: usize) -> Self {
        let model = Model::from_bytes(bytes).expect("a skin loads");
        let skin = model.first::<Skin>().and_then(|skin| skin.layout().open::<Skin>(bytes));
        let skin = skin.expect("it holds a skin");
        let mut random = Rng(2010);
        let mut weight = || {
            let number = random.unit();
            if number.abs() < 0.2 { 0.0 } else { number * 1.5 + 0.5 }
        };
        let mut weights: Vec<f32> = (0..face_len * skin.shape_len()).map(|_| weight()).collect();
        weights.iter_mut().take(skin.shape_len()).for_each(|weight| *weight = 0.0);
        Self { model, skin, oracle: SkinModel::from_file(&skin), weights, face_len }
    }

    /// Describes the subject for messages.
    pub fn described(&self) -> String {
        format!("{:?}, {:?}", self.skin, self.skin.shape_element())
    }
}

/// The files, one skin in each.
pub fn files() -> &'static [Vec<u8>] {
    static FILES: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
    FILES.get_or_init(|| {
        let of = |vertices, shape_len, element| {
            let shape = Shape { vertices, tangents: vertices % 2 == 0, ..SMALL };
            let mut pieces = Pieces::sample(Predictor::Rotational, shape);
            if shape_len > 0 {
                pieces.set_shapes(&ShapeContent::sample(element, shape_len, vertices));
            }
            pieces
        };
        let more = [
            of(1, 1, Element::I8),
            of(64, 13, Element::F16),
            of(65, 0, Element::F32),
            of(1001, 60, Element::I8),
        ];
        Pieces::shaped().into_iter().chain(more).map(|pieces| pieces.bytes()).collect()
    })
}

/// Returns every skin under test, with `face_len` faces each.
pub fn shapes(face_len: usize) -> Vec<ShapeSubject<'static>> {
    files().iter().map(|bytes| ShapeSubject::new(bytes, face_len)).collect()
}
