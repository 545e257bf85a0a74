// Stage confidence: the confidence in a pose. One workgroup an instance, with one active thread.

@group(0) @binding(2) var<storage, read> poses: array<f32>;
@group(0) @binding(3) var<storage, read> scratch: array<f32>;
@group(0) @binding(4) var<storage, read_write> confidences: array<f32>;

const ROTATIONAL: u32 = 1u;

// 1 up to most; falls to 0 where a value exceeds it by half the range plus 0.1.
fn within(value: f32, most: f32, range: f32) -> f32 {
    let excess = max(value - most, 0.0) / (0.5 * range + 0.1);
    return 1.0 - smooth_step(min(excess, 1.0));
}

// The confidence in a joint from its strain; 0 for a hidden joint.
fn of_strain(base: u32, pose: u32, joint: u32) -> f32 {
    if is_hidden(linear_part(pose + 12u * joint)) {
        return 0.0;
    }
    if !stretches() {
        return 1.0;
    }
    let at = base + params.strains + 6u * joint;
    let stretch = vec3<f32>(scratch[at], scratch[at + 3u], scratch[at + 5u]);
    let shear = vec3<f32>(scratch[at + 1u], scratch[at + 2u], scratch[at + 4u]);
    let norm = sqrt(dot3(stretch, stretch) + 2.0 * dot3(shear, shear));
    let range = blob_float(params.stretch_ranges + joint);
    return within(norm, 1.5 * range, range);
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let instance = workgroup.y;
    if thread != 0u {
        return;
    }
    let pose = params.poses_offset + instance * params.poses_stride;
    let base = params.scratch_offset + instance * params.scratch_stride;
    var confidence = 1.0;
    if params.predictor == ROTATIONAL {
        for (var joint = 0u; joint < params.joint_len; joint++) {
            let theta = load(base + params.rotations + 3u * joint);
            let angle = sqrt(dot3(theta, theta));
            let range = blob_float(params.pose_ranges + joint);
            confidence = min(confidence, within(angle, range, range));
            confidence = min(confidence, of_strain(base, pose, joint));
        }
    } else if params.group_len > 0u {
        var explained_error = 0.0;
        var unexplained_error = 0.0;
        for (var i = 0u; i < params.group_len; i++) {
            let error = base + params.group_confidences + 2u * i;
            explained_error += scratch[error];
            unexplained_error += scratch[error + 1u];
        }
        let total = 1.0 + explained_error;
        confidence = total / (total + unexplained_error);
        for (var joint = 0u; joint < params.joint_len; joint++) {
            let at = base + params.features + 12u * joint;
            let trace = scratch[at] + scratch[at + 5u] + scratch[at + 10u];
            let angle = 2.0 * sqrt(max(0.0, -trace));
            let range = blob_float(params.pose_ranges + joint);
            confidence = min(confidence, within(angle, 1.5 * range, range));
            confidence = min(confidence, of_strain(base, pose, joint));
        }
        for (var curve = 0u; curve < params.curve_len; curve++) {
            let least = blob_float(params.curve_ranges + 2u * curve);
            let range = 0.5 * (blob_float(params.curve_ranges + 2u * curve + 1u) - least);
            let apart = abs(scratch[base + params.curve_features + curve] - (least + range));
            confidence = min(confidence, within(apart, 1.5 * range, range));
        }
    }
    confidences[params.confidences_offset + instance * params.confidences_stride] = confidence;
}
