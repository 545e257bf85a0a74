// What the stage filter is told: counts, and where everything lies, in words of 4 bytes.

struct Params {
    // The part's counts.
    factor: u32,
    tap_len: u32,
    // Samples of a signal, and numbers of a sample.
    sample_len: u32,
    lane_len: u32,
    // A section, from the blob's start.
    filter_taps: u32,
    // Arrays from the binding's start: the first instance's, and from an instance to the next.
    samples_offset: u32,
    samples_stride: u32,
    outputs_offset: u32,
    outputs_stride: u32,
}
