// Params of the stage kernel: counts, and places of arrays in words of 4 bytes.

struct Params {
    // Counts of the part.
    input_len: u32,
    output_len: u32,
    feature_len: u32,
    metric_len: u32,
    centre_len: u32,
    term_len: u32,
    value_len: u32,
    // Offsets of sections from the blob's start.
    kernel_rule: u32,
    inputs: u32,
    outputs: u32,
    features: u32,
    metric: u32,
    kernel_centres: u32,
    terms: u32,
    kernel_coefficients: u32,
    // Offset of an array from the binding's start, and stride from an instance to the next. An
    // offset of NONE: the array is not written.
    scratch_offset: u32,
    scratch_stride: u32,
    queries_offset: u32,
    queries_stride: u32,
    outputs_offset: u32,
    outputs_stride: u32,
    confidences_offset: u32,
    confidences_stride: u32,
}
