//! The golden kernels, and the hash of each over seeded queries, which is equal on all CPUs.

use super::{Rng, add, cut};
use sinew_runtime::{CallError, KernelMap, Model};

/// A file with every kernel; rules, inputs and options vary.
pub(crate) const KERNELS: &[u8] = include_bytes!("kernel-11.snw");

/// Hash of each kernel, the promise of METHOD §7: change these only with a reason that the commit
/// states.
pub(crate) const BITS: [u64; 15] = [
    0x36fc_5eb1_fc02_5e6c,
    0x2f47_7421_80f8_b9dd,
    0xdeee_0988_03f3_1cd9,
    0x98af_42ec_8731_dc3a,
    0xf04d_2e6e_4a06_a77d,
    0x43d1_b2b5_af7b_a60f,
    0xc278_b021_114a_5ac7,
    0x4efa_8654_353f_f43e,
    0x18f8_4426_c8f0_d683,
    0x0e40_cce5_115e_a1bb,
    0xbc5c_cd4e_44dc_4c59,
    0x3c52_9d2e_1fbf_62b5,
    0x08a8_b0fc_b20c_9bb8,
    0x20be_8749_530e_3f77,
    0xb205_5dea_5bc3_05b7,
];

/// Queries per hash.
const QUERIES: usize = 1024;
/// One query in this many has its derivatives hashed.
const DERIVED: usize = 16;
/// Largest length of a query.
const NUMBERS: usize = 8;

/// Hashes a kernel over seeded queries: outputs and confidence, derivatives, variances. `nudge` is
/// added to each number of a query.
///
/// # Errors
/// Errors of the calls; a length error if the kernel does not fit in the memory.
pub(crate) fn hash(
    map: &KernelMap<'_>,
    nudge: f32,
    scratch: &mut [f32],
    out: &mut [f32],
) -> Result<u64, CallError> {
    let counts = map.counts();
    let m = counts.value_len as usize;
    let mut hash = 0;
    let mut rng = Rng(1992);
    let mut query = [0.0; NUMBERS];
    let query = cut(&mut query, map.query_len());
    for number in 0..QUERIES {
        // Near the centres, among them, and outside.
        let size = [0.3, 1.0, 3.0, 20.0][number % 4];
        query.iter_mut().for_each(|x| *x = size * rng.unit() + nudge);
        let outputs = cut(out, map.result_len());
        let confidence = map.evaluate(query, cut(scratch, counts.scratch_len()), outputs)?;
        add(&mut hash, outputs);
        add(&mut hash, &[confidence]);
        if number % DERIVED == 0 {
            let jacobian = cut(out, m * query.len());
            map.jacobian(query, cut(scratch, counts.jacobian_scratch_len()), jacobian)?;
            add(&mut hash, jacobian);
        }
        if map.has_variance() {
            let variances = cut(out, m);
            map.variance(query, cut(scratch, counts.variance_scratch_len()), variances)?;
            add(&mut hash, variances);
        }
    }
    Ok(hash)
}

/// Loads the golden kernels; `None` on failure.
pub(crate) fn load() -> Option<Model<&'static [u8]>> {
    Model::from_bytes(KERNELS).ok()
}
