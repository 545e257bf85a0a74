// Stage filter: samples of signals to finer samples. One thread a number.

@group(0) @binding(2) var<storage, read> samples: array<f32>;
@group(0) @binding(3) var<storage, read_write> out: array<f32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(global_invocation_id) thread: vec3<u32>,
) {
    let instance = workgroup.y;
    let own = thread.x;
    let fine = own / params.lane_len;
    let coarse = fine / params.factor;
    if coarse >= params.sample_len {
        return;
    }
    let phase = fine - params.factor * coarse;
    // The window is centred on the sample; near an end of the signal the window stays inside.
    let middle = params.tap_len / 2u;
    let start = min(max(coarse, middle) - middle, params.sample_len - params.tap_len);
    let row = (coarse - start) * params.factor + phase;
    let taps = params.filter_taps + row * params.tap_len;
    var at = params.samples_offset + instance * params.samples_stride
        + start * params.lane_len + (own - fine * params.lane_len);
    var sum = 0.0;
    for (var tap = 0u; tap < params.tap_len; tap++) {
        sum += blob_float(taps + tap) * samples[at];
        at += params.lane_len;
    }
    out[params.outputs_offset + instance * params.outputs_stride + own] = sum;
}
