//! Kernels on a device, compared bit by bit with the CPU's results. Both APIs use this code.

use super::case::{POISON, differing};
use super::load;
use models::{KernelContent, Pieces, Rng};
use sinew_gpu::headless::Device;
use sinew_gpu::layout::{Array, DeviceLimits, KernelBatch, Plan, Resource};
use sinew_runtime::KernelMap;
use sinew_runtime::kernel::{Kernel, Normalise, QueryRule};

/// A batch of a kernel; the first `instance_len` queries are evaluated.
pub(crate) struct KernelCase<'a> {
    pub(crate) content: &'a KernelContent,
    pub(crate) batch: &'a KernelBatch,
    pub(crate) limits: &'a DeviceLimits,
    pub(crate) instance_len: usize,
}

impl KernelCase<'_> {
    /// Asserts that every bit equals the CPU's, that the confidence of a refused query is NaN, and
    /// that no other float has changed; returns the number of chunks.
    pub(crate) fn check(&self, device: &dyn Device, bytes: &[u8]) -> usize {
        let queries = queries(self.content, self.instance_len.min(61));
        let (differ, chunks) = self.differing(device, bytes, &queries, |_| {});
        let (content, rule) = (self.content, self.content.rule);
        let model = load(bytes);
        let kernel = model.named::<KernelMap>(&content.name).unwrap();
        let is_sound = |query: &&Vec<f32>| {
            evaluate(&kernel, query, &mut vec![0.0; kernel.result_len()]).is_some()
        };
        assert!(2 * queries.iter().filter(is_sound).count() > queries.len(), "{}", content.name);
        assert_eq!(
            differ, 0,
            "{}, {rule:?}, {} of {:?}",
            content.name, self.instance_len, self.batch
        );
        chunks
    }

    /// Evaluates queries, taken in turn, after `change` has edited their buffer. Counts the floats
    /// that differ from the CPU's results for the unchanged queries, or that should not have
    /// changed. Also returns the number of chunks.
    pub(crate) fn differing(
        &self,
        device: &dyn Device,
        bytes: &[u8],
        queries: &[Vec<f32>],
        change: impl Fn(&mut [f32]),
    ) -> (usize, usize) {
        let Self { batch, limits, instance_len, content } = *self;
        let model = load(bytes);
        let kernel = model.named::<KernelMap>(&content.name).unwrap();
        let plan = Plan::of_kernel(&model, &kernel, batch, limits).unwrap();
        let mut uploaded = device.upload(model.blob(), &plan).unwrap();
        let poisoned = |resource| vec![POISON; plan.bytes(resource) as usize / 4];
        let queries: Vec<_> = queries.iter().cycle().take(instance_len).collect();
        let mut flat = poisoned(Resource::Queries);
        for (n, query) in queries.iter().enumerate() {
            let at = batch.queries.offset + n * batch.queries.stride;
            flat[at..at + query.len()].copy_from_slice(query);
        }
        change(&mut flat);
        uploaded.write(Resource::Queries, 0, &flat).unwrap();
        for resource in [Resource::Scratch, Resource::Out] {
            uploaded.write(resource, 0, &poisoned(resource)).unwrap();
        }
        uploaded.run(instance_len).unwrap();
        let mut found = uploaded.read(Resource::Out).unwrap();
        let mut expected = poisoned(Resource::Out);
        for (n, query) in queries.iter().enumerate() {
            let own = batch.outputs.offset + n * batch.outputs.stride;
            let own = own..own + kernel.result_len();
            let at = batch.confidences.map(|array| array.offset + n * array.stride);
            match evaluate(&kernel, query, &mut expected[own.clone()]) {
                Some(confidence) => {
                    at.into_iter().for_each(|at| expected[at] = confidence);
                }
                None => {
                    // Meaningless outputs; the confidence is NaN.
                    found[own].fill(POISON);
                    let marked = at.is_none_or(|at| found[at].is_nan());
                    at.filter(|_| marked).into_iter().for_each(|at| found[at] = POISON);
                }
            }
        }
        (differing(&found, &expected, &content.name), plan.chunks().len())
    }
}

/// Evaluates a query on the CPU; writes nothing and returns `None` if the CPU refuses.
pub(crate) fn evaluate(kernel: &KernelMap<'_>, query: &[f32], out: &mut [f32]) -> Option<f32> {
    let mut scratch = vec![POISON; kernel.counts().scratch_len()];
    kernel.evaluate(query, &mut scratch, out).ok()
}

/// Draws queries near the centres, around them and far from them; some at ends of ranges, some of
/// zeros, and some of numbers that overflow.
fn queries(content: &KernelContent, count: usize) -> Vec<Vec<f32>> {
    let mut random = Rng(68);
    let query = |n: usize| {
        let size = [0.3, 1.0, 3.0, 20.0][n % 4];
        let mut query = content.query(&mut random, size);
        let values = [-1.0, -0.0, 0.0, 0.7, 1.0];
        match n % 12 {
            7 => query.iter_mut().enumerate().for_each(|(i, x)| *x = values[i % 5]),
            9 => query.iter_mut().step_by(3).for_each(|x| *x = 0.0),
            10 => query.iter_mut().for_each(|x| *x *= 1e-7),
            11 => query.iter_mut().for_each(|x| *x *= 1e15),
            _ => {}
        }
        query
    };
    (0..count).map(query).collect()
}

/// Every kernel that a file may name by its number and its parameter.
pub(crate) fn every_kernel() -> Vec<Kernel> {
    let pairs = (0..=u8::MAX).flat_map(|number| (0..=u8::MAX).map(move |of| (number, of)));
    pairs.filter_map(|(number, of)| Kernel::from_number(number, of)).collect()
}

/// Kernels with every kind of input and output, every query rule and every normalisation, with or
/// without a fade, a metric and a polynomial.
fn every_rule() -> Vec<KernelContent> {
    let mut out = Vec::new();
    for (i, kernel) in every_kernel().into_iter().enumerate() {
        let mut content = KernelContent::every(kernel);
        content.name = format!("{kernel:?}");
        let is_free = i % 2 == 0;
        content.rule.query = QueryRule::ALL[if is_free { i / 2 % 2 } else { i / 2 % 3 }];
        content.rule.normalise = Normalise::ALL[i / 3 % 3];
        if is_free {
            content.rule.fade = (0.0, 0.0);
        }
        if i % 5 < 2 {
            content.metric.clear();
            let mut random = Rng(i as u64);
            for centre in &mut content.centres {
                *centre = content.features.iter().map(|_| random.unit()).collect();
            }
        }
        if i % 7 < 3 {
            let n = content.centres.len();
            content.terms.clear();
            content.coefficients.iter_mut().for_each(|row| row.truncate(n));
            content.variance = None;
        }
        out.push(content);
    }
    out
}

/// Kernels with more values than a workgroup has threads, more centres than a tile, and none of
/// each.
fn every_size() -> Vec<KernelContent> {
    let sizes = [
        [1, 1, 1],
        [3, 200, 3],
        [2, 255, 64],
        [2, 256, 65],
        [1, 257, 130],
        [70, 600, 9],
        [27, 64, 480],
        [4, 0, 5],
    ];
    let sized = sizes.into_iter().enumerate().map(|(i, size)| {
        let kernel = Kernel::ALL[(4 * i + 1) % Kernel::ALL.len()];
        let mut content = KernelContent::plain(kernel, size);
        content.name = format!("{size:?}");
        if i % 2 == 1 {
            content.rule.fade = (0.25, 6.0);
        }
        content
    });
    let mut out: Vec<_> = sized.collect();
    // Terms without a centre, each built from the term before it; as many as a workgroup has
    // threads, and more.
    let powers = |len: u16| (0..len).map(|t| if t == 0 { [u16::MAX; 2] } else { [t - 1, 0] });
    for (name, n, len) in [("powers", 0, 9), ("many powers", 3, 130)] {
        let mut content = KernelContent::plain(Kernel::Gaussian, [2, n, 5]);
        content.name = name.to_owned();
        content.terms = powers(len).collect();
        let terms = usize::from(len);
        for (r, row) in content.coefficients.iter_mut().enumerate() {
            row.extend((0..terms).map(|t| 0.1 * (r as f32 + 1.0) / (t as f32 + 1.0)));
        }
        out.push(content);
    }
    out
}

/// Evaluates every kernel, rule and size on a device.
pub(crate) fn every_kernel_has_the_cpus_bits(device: &dyn Device) {
    let limits = &device.limits();
    let goldens = KernelContent::goldens().into_iter().chain([KernelContent::servo()]);
    let contents: Vec<_> = goldens.chain(every_rule()).chain(every_size()).collect();
    // A file has a limited number of sections.
    for contents in contents.chunks(30) {
        let bytes = Pieces::kernels(contents).bytes();
        let model = load(&bytes);
        for content in contents {
            let kernel = model.named::<KernelMap>(&content.name).unwrap();
            let batch = &KernelBatch::new(&kernel, 61);
            KernelCase { content, batch, limits, instance_len: 61 }.check(device, &bytes);
        }
    }
}

/// Evaluates queries at odd offsets and strides, in chunks, and fewer queries than the batch has
/// room for.
pub(crate) fn odd_queries_have_the_cpus_bits(device: &dyn Device) {
    for content in [KernelContent::every(Kernel::Matern52), KernelContent::servo()] {
        let content = &content;
        let bytes = Pieces::kernels(std::slice::from_ref(content)).bytes();
        let model = load(&bytes);
        let kernel = model.first::<KernelMap>().unwrap();
        let whole = odd_batch(&kernel, 200);
        let storage_binding_bytes = model.blob().len().next_multiple_of(4) as u64;
        for batch in [
            whole.clone(),
            KernelBatch { confidences: None, ..whole.clone() },
            KernelBatch { queries: Array { offset: 3, stride: 0 }, ..whole },
        ] {
            for instance_len in [1, 130, 200] {
                let case = |limits: &DeviceLimits| {
                    let case = KernelCase { content, batch: &batch, limits, instance_len };
                    if batch.queries.stride > 0 {
                        return case.check(device, &bytes);
                    }
                    let one = [content.query(&mut Rng(3), 1.0)];
                    let (differ, chunks) = case.differing(device, &bytes, &one, |_| {});
                    assert_eq!(differ, 0);
                    chunks
                };
                assert_eq!(case(&device.limits()), 1);
                assert!(case(&DeviceLimits { storage_binding_bytes, ..device.limits() }) > 1);
            }
        }
    }
}

/// Lays out queries with gaps; outputs, a gap, the confidence, a gap.
pub(crate) fn odd_batch(kernel: &KernelMap<'_>, instance_len: usize) -> KernelBatch {
    let (result_len, stride) = (kernel.result_len(), kernel.result_len() + 3);
    KernelBatch {
        instance_len,
        queries: Array { offset: 5, stride: kernel.query_len() + 2 },
        outputs: Array { offset: 67, stride },
        confidences: Some(Array { offset: 67 + result_len + 1, stride }),
    }
}

/// Evaluates more queries than a dispatch has workgroups along an axis: all but the last five of a
/// batch.
pub(crate) fn past_65535_queries(device: &dyn Device) {
    const INSTANCES: usize = 65_535 + 70;
    let content = &KernelContent::servo();
    let bytes = Pieces::kernels(std::slice::from_ref(content)).bytes();
    let model = load(&bytes);
    let batch = &odd_batch(&model.first::<KernelMap>().unwrap(), INSTANCES);
    let limits = &device.limits();
    let case = KernelCase { content, batch, limits, instance_len: INSTANCES - 5 };
    assert!(case.check(device, &bytes) > 1);
}

/// Asserts that the comparison detects a changed query. Also asserts that a query with a number
/// that is not finite, or with a zero quaternion, has confidence NaN, even if the outputs are
/// numbers.
pub(crate) fn a_query_that_is_wrong_is_seen(device: &dyn Device) {
    let content = &KernelContent::every(Kernel::Gaussian);
    let bytes = Pieces::kernels(std::slice::from_ref(content)).bytes();
    let model = load(&bytes);
    let kernel = model.first::<KernelMap>().unwrap();
    let batch = &KernelBatch::new(&kernel, 3);
    let limits = &device.limits();
    let case = KernelCase { content, batch, limits, instance_len: 3 };
    let queries = queries(content, 3);
    let r = kernel.query_len();
    let of = |change: &dyn Fn(&mut [f32])| case.differing(device, &bytes, &queries, change).0;
    assert_eq!(of(&|_| {}), 0);
    assert!(of(&|flat| flat[3 * r - 1] += 1e-3) > 0);
    // The last query is refused, so its confidence must be NaN.
    let wrong = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::from_bits(0xffff_ffff)];
    for number in 0..r {
        for wrong in wrong {
            let mut query = queries[2].clone();
            query[number] = wrong;
            assert!(is_marked(&case, device, &bytes, &query), "{number} {wrong}");
        }
    }
    for first in (4..r).step_by(4) {
        for tiny in [0.0, 1e-30] {
            let mut query = queries[2].clone();
            query[first..][..4].fill(tiny);
            assert!(is_marked(&case, device, &bytes, &query), "{first} {tiny}");
        }
    }
    assert!(!is_marked(&case, device, &bytes, &queries[2]));

    // A NaN distance may give values that are numbers, so the shader must check the query itself.
    let content = &KernelContent::plain(Kernel::Gaussian, [3, 5, 2]);
    let bytes = Pieces::kernels(std::slice::from_ref(content)).bytes();
    let model = load(&bytes);
    let batch = &KernelBatch::new(&model.first::<KernelMap>().unwrap(), 1);
    let case = KernelCase { content, batch, limits, instance_len: 1 };
    for wrong in wrong {
        assert!(is_marked(&case, device, &bytes, &[0.1, wrong, 0.2]), "{wrong}");
    }
    assert!(!is_marked(&case, device, &bytes, &[0.1, 0.3, 0.2]));
}

/// Whether the device and the CPU refuse a query; asserts that they agree.
fn is_marked(case: &KernelCase<'_>, device: &dyn Device, bytes: &[u8], query: &[f32]) -> bool {
    let model = load(bytes);
    let kernel = model.first::<KernelMap>().unwrap();
    let plan = Plan::of_kernel(&model, &kernel, case.batch, case.limits).unwrap();
    let mut uploaded = device.upload(model.blob(), &plan).unwrap();
    uploaded.write(Resource::Queries, 0, query).unwrap();
    uploaded.run(1).unwrap();
    let found = uploaded.read(Resource::Out).unwrap()[kernel.result_len()];
    let mut out = vec![0.0; kernel.result_len()];
    let refused = evaluate(&kernel, query, &mut out).is_none();
    assert_eq!(found.is_nan(), refused);
    refused
}
