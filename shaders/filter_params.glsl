// Params of the stage filter: counts, and places of arrays in words of 4 bytes.

layout(set = 0, binding = 0, std140) uniform Params {
    // Counts of the part.
    uint factor;
    uint tap_len;
    // Samples of a signal, and numbers of a sample.
    uint sample_len;
    uint lane_len;
    // Offset of a section from the blob's start.
    uint filter_taps;
    // Offset of an array from the binding's start, and stride from an instance to the next.
    uint samples_offset;
    uint samples_stride;
    uint outputs_offset;
    uint outputs_stride;
} params;
