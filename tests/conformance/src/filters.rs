//! Filters under test, with signals: one lane and many, one signal and the rows of an image.

use ::models::{FilterContent, Pieces, Rng};
use sinew_runtime::filter::Samples;
use sinew_runtime::{Filter, Model};
use std::sync::OnceLock;

/// Number of signals of a filter.
pub const SIGNALS: usize = 23;

/// A filter under test.
pub struct FilterSubject<'a> {
    /// The file.
    pub model: Model<&'a [u8]>,
    /// The filter.
    pub filter: Filter<'a>,
    /// Layout of the samples.
    pub shape: Samples,
    /// The samples, of several magnitudes.
    pub samples: Vec<f32>,
}

impl<'a> FilterSubject<'a> {
    /// Loads the first filter of a file and draws signals that are slightly longer than the
    /// filter's window.
    ///
    /// # Panics
    /// If the bytes are not a model with a filter.
    pub fn new(bytes: &'a [u8], signal_len: usize, lane_len: usize) -> Self {
        let model = Model::from_bytes(bytes).expect("a filter loads");
        let filter =
            model.first::<Filter>().and_then(|filter| filter.layout().open::<Filter>(bytes));
        let filter = filter.expect("it holds a filter");
        let shape = Samples { signal_len, sample_len: filter.tap_len() + 7, lane_len };
        let mut random = Rng(1960);
        let mut number =
            || random.unit() * [1e-3, 1.0, 250.0][(random.unit().abs() * 3.0) as usize % 3];
        let samples = (0..signal_len * shape.sample_len * lane_len).map(|_| number()).collect();
        Self { model, filter, shape, samples }
    }

    /// Describes the subject for messages.
    pub fn described(&self) -> String {
        format!("{:?}, {:?}", self.filter, self.shape)
    }
}

/// The files, one filter in each.
pub fn files() -> &'static [Vec<u8>] {
    static FILES: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
    FILES.get_or_init(|| {
        let mut random = Rng(61);
        let of = |(factor, tap_len)| {
            let mut content = FilterContent::sample(factor, tap_len);
            content.taps.iter_mut().for_each(|tap| *tap += random.unit());
            Pieces::filter(&content).bytes()
        };
        [(1, 1), (2, 9), (3, 5), (4, 17)].map(of).to_vec()
    })
}

/// Returns every filter under test, with `signal_len` signals each.
pub fn filters(signal_len: usize) -> Vec<FilterSubject<'static>> {
    let each = files().iter().zip([1, 3, 64, 5]);
    each.map(|(bytes, lane_len)| FilterSubject::new(bytes, signal_len, lane_len)).collect()
}
