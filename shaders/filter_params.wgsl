// Params of the stage filter: counts, and places of arrays in words of 4 bytes.

struct Params {
    // Counts of the part.
    factor: u32,
    tap_len: u32,
    // Samples of a signal, and numbers of a sample.
    sample_len: u32,
    lane_len: u32,
    // Offset of a section from the blob's start.
    filter_taps: u32,
    // Offset of an array from the binding's start, and stride from an instance to the next.
    samples_offset: u32,
    samples_stride: u32,
    outputs_offset: u32,
    outputs_stride: u32,
}
