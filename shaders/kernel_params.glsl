// What the stages of a kernel are told: where everything lies, in words of 4 bytes.

layout(set = 0, binding = 0, std140) uniform Params {
    // The part's counts.
    uint input_len;
    uint output_len;
    uint feature_len;
    uint metric_len;
    uint centre_len;
    uint term_len;
    uint value_len;
    // Sections, from the blob's start.
    uint kernel_rule;
    uint inputs;
    uint outputs;
    uint features;
    uint metric;
    uint kernel_centres;
    uint terms;
    uint kernel_coefficients;
    // Arrays from the binding's start: the first instance's, and from an instance to the next. An offset of NONE
    // stands for what is not written.
    uint scratch_offset;
    uint scratch_stride;
    uint queries_offset;
    uint queries_stride;
    uint outputs_offset;
    uint outputs_stride;
    uint confidences_offset;
    uint confidences_stride;
} params;
