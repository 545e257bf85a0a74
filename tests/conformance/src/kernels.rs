//! Kernels under test: each kernel with every kind of input and output, the golden kernels, and
//! large ones; with oracles and queries.

use ::models::{KernelContent, Pieces, Rng};
use sinew_runtime::kernel::Kernel;
use sinew_runtime::{KernelMap, Model};
use sinew_trainer::scattered::model::KernelModel;
use std::sync::OnceLock;

/// Number of queries of a kernel.
pub const QUERIES: usize = 140;

/// A kernel under test.
pub struct KernelSubject<'a> {
    /// The file.
    pub model: Model<&'a [u8]>,
    /// The kernel.
    pub kernel: KernelMap<'a>,
    /// Its oracle.
    pub oracle: KernelModel,
    /// Queries, one after another: near the centres, around them and far from them.
    pub queries: Vec<f32>,
}

impl<'a> KernelSubject<'a> {
    /// Loads the first kernel of a file and draws queries. The CPU accepts each query.
    ///
    /// # Panics
    /// If the bytes are not a model with a kernel.
    pub fn new(bytes: &'a [u8], query_len: usize) -> Self {
        let model = Model::from_bytes(bytes).expect("a kernel loads");
        let kernel =
            model.first::<KernelMap>().and_then(|kernel| kernel.layout().open::<KernelMap>(bytes));
        let kernel = kernel.expect("it holds a kernel");
        let mut random = Rng(1992);
        let query = |number: usize| {
            let size = [0.3, 1.0, 3.0, 20.0][number % 4];
            (0..kernel.query_len()).map(|_| size * random.unit()).collect::<Vec<_>>()
        };
        let queries = (0..query_len).flat_map(query).collect();
        Self { model, kernel, oracle: KernelModel::from_file(&kernel), queries }
    }

    /// Returns the number of queries.
    pub fn query_len(&self) -> usize {
        self.queries.len() / self.kernel.query_len()
    }

    /// Describes the subject for messages.
    pub fn described(&self) -> String {
        format!("{:?}, {:?}", self.kernel, self.kernel.rule())
    }
}

/// The files, one kernel in each. For every kernel: the golden file, and one with every kind of
/// input and output. Then a servo, a function of 27 numbers with 480 values, and a kernel with more
/// centres than a shader evaluates at a time.
pub fn files() -> &'static [Vec<u8>] {
    static FILES: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
    FILES.get_or_init(|| {
        let every = Kernel::ALL.map(KernelContent::every);
        let large = [
            KernelContent::servo(),
            KernelContent::plain(Kernel::Gaussian, [27, 64, 480]),
            KernelContent::plain(Kernel::ThinPlate, [3, 600, 3]),
        ];
        let all = KernelContent::goldens().into_iter().chain(every).chain(large);
        all.map(|content| Pieces::kernels(&[content]).bytes()).collect()
    })
}

/// Returns every kernel under test, with `query_len` queries each.
pub fn kernels(query_len: usize) -> Vec<KernelSubject<'static>> {
    files().iter().map(|bytes| KernelSubject::new(bytes, query_len)).collect()
}
