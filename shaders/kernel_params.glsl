// Params of the stage kernel: counts, and places of arrays in words of 4 bytes.

layout(set = 0, binding = 0, std140) uniform Params {
    // Counts of the part.
    uint input_len;
    uint output_len;
    uint feature_len;
    uint metric_len;
    uint centre_len;
    uint term_len;
    uint value_len;
    // Offsets of sections from the blob's start.
    uint kernel_rule;
    uint inputs;
    uint outputs;
    uint features;
    uint metric;
    uint kernel_centres;
    uint terms;
    uint kernel_coefficients;
    // Offset of an array from the binding's start, and stride from an instance to the next. An
    // offset of NONE: the array is not written.
    uint scratch_offset;
    uint scratch_stride;
    uint queries_offset;
    uint queries_stride;
    uint outputs_offset;
    uint outputs_stride;
    uint confidences_offset;
    uint confidences_stride;
} params;
