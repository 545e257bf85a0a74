//! One kernel with its queries, and what it makes of them.

use super::tolerances::{Tolerance, numbers_tolerance};
use super::written::Written;
use super::{Folder, VectorError};
use crate::backend::{Cpu, part};
use crate::kernels::KernelSubject;
use crate::stages::kernel::outputs_of;
use crate::tolerance::{self, Arithmetic};
use serde::Serialize;
use sinew_gpu::layout::Stage;

#[derive(Serialize)]
struct Counts {
    queries: usize,
    query_len: usize,
    output_len: usize,
}

/// Evaluates a kernel, and writes it into a folder of the case's name.
///
/// # Errors
/// [`VectorError`]
pub(super) fn write(
    case: &str,
    bytes: &[u8],
    query_len: usize,
    folder: &Folder,
) -> Result<(), VectorError> {
    let subject = KernelSubject::new(bytes, query_len);
    let (n, r, len) = (query_len, subject.kernel.query_len(), subject.kernel.result_len());
    let counts = Counts { queries: n, query_len: r, output_len: len };
    let mut written = Written::new(case, None, counts);
    let (outputs, confidences) = outputs_of(&Cpu, &subject)?;
    written.array("query", vec![n, r], &subject.queries);
    written.array("output", vec![n, len], &outputs);
    written.array("confidence", vec![n], &confidences);
    let bounds = (0..n).map(|i| {
        let query = part(&subject.queries, n, i);
        tolerance::kernel(&subject.oracle, query, Arithmetic::VULKAN)
    });
    let (numbers, certain): (Vec<_>, Vec<_>) = bounds.unzip();
    let mut tolerances = Tolerance::new();
    for (i, right) in numbers.iter().enumerate() {
        let found = part(&outputs, n, i).iter();
        let right = right.value.iter().zip(&right.error);
        found.zip(right).for_each(|(x, (value, error))| tolerances.add(*x, *value, *error));
    }
    let confidence = numbers_tolerance(&confidences, &certain);
    let outputs = vec![("output", tolerances.0), ("confidence", confidence)];
    written.stage(Stage::Kernel.name(), &["query"], outputs);
    written.write(bytes, folder)
}
