// What the stage filter is told: counts, and where everything lies, in words of 4 bytes.

layout(set = 0, binding = 0, std140) uniform Params {
    // The part's counts.
    uint factor;
    uint tap_len;
    // Samples of a signal, and numbers of a sample.
    uint sample_len;
    uint lane_len;
    // A section, from the blob's start.
    uint filter_taps;
    // Arrays from the binding's start: the first instance's, and from an instance to the next.
    uint samples_offset;
    uint samples_stride;
    uint outputs_offset;
    uint outputs_stride;
} params;
