// The features of a query: quadratic forms of quaternions, divided by their squared length.

// Count of a query's numbers for an input of a kind.
uint number_len(uint kind) {
    return kind == 1u ? 1u : (kind == 2u ? 3u : 4u);
}

// Count of features of an input of a kind.
uint feature_len(uint kind) {
    switch (kind) {
        case 3u:
            return 9u;
        case 4u:
            return 6u;
        case 2u:
        case 5u:
            return 3u;
        case 6u:
            return 2u;
    }
    return 1u;
}

float dot3(vec3 a, vec3 b) {
    precise float sum = a.x * b.x + a.y * b.y + a.z * b.z;
    return sum;
}

float squared_length(vec4 q) {
    precise float sum = dot3(q.xyz, q.xyz) + q.w * q.w;
    return sum;
}

// Angle of a twist, within half a turn, from a sine and a cosine in proportion to those of half the
// angle.
float twist_angle(float sine, float cosine) {
    bool flipped = cosine < 0.0 || (cosine == 0.0 && sine < 0.0);
    float about = flipped ? -sine : sine;
    precise float angle = 2.0 * quadrant_angle(about < 0.0 ? -about : about, flipped ? -cosine : cosine);
    return about < 0.0 ? -angle : angle;
}

// Stores a feature: clamped to its range if the query rule says so, shifted and scaled.
void put_feature(uint u, uint feature, float value) {
    uint row = params.features + 4u * feature;
    float kept = value;
    if (query_rule() == CLAMP) {
        float low = blob_float(row + 2u);
        float high = blob_float(row + 3u);
        kept = low > kept ? low : kept;
        kept = high < kept ? high : kept;
    }
    precise float scaled = (kept - blob_float(row)) * blob_float(row + 1u);
    scratch[u + feature] = scaled;
}

void put_row(uint u, uint feature, vec3 row) {
    put_feature(u, feature, row.x);
    put_feature(u, feature + 1u, row.y);
    put_feature(u, feature + 2u, row.z);
}

// Computes the features of one input, given by its row in the file, from the query's numbers at
// `number`.
void put_features(uint row, uint number, uint u, uint feature) {
    uint kind = blob[row] & 0xffu;
    for (uint i = 0u; i < number_len(kind); i++) {
        watch(queries[number + i]);
    }
    if (kind == 1u) {
        put_feature(u, feature, queries[number]);
        return;
    }
    vec3 v = vec3(queries[number], queries[number + 1u], queries[number + 2u]);
    if (kind == 2u) {
        put_row(u, feature, v);
        return;
    }
    float w = queries[number + 3u];
    vec3 axis = blob_vec3(row + 1u);
    precise float square = squared_length(vec4(v, w));
    // A quaternion of length 0 has no direction.
    if ((floatBitsToUint(square) & INFINITE) == 0u) {
        atomicOr(unsound, 1u);
    }
    watch(square);
    precise float about = dot3(v, axis);
    if (kind == 6u) {
        precise float cosine = (w * w - about * about) / square;
        precise float sine = 2.0 * w * about / square;
        put_feature(u, feature, cosine);
        put_feature(u, feature + 1u, sine);
        return;
    }
    if (kind == 7u) {
        put_feature(u, feature, twist_angle(about, w));
        return;
    }
    precise float f = 2.0 / square;
    precise vec3 s = v * f;
    precise vec3 x = vec3(
        1.0 - (v.y * s.y + v.z * s.z),
        v.x * s.y - w * s.z,
        v.x * s.z + w * s.y
    );
    precise vec3 y = vec3(
        v.x * s.y + w * s.z,
        1.0 - (v.x * s.x + v.z * s.z),
        v.y * s.z - w * s.x
    );
    precise vec3 z = vec3(
        v.x * s.z - w * s.y,
        v.y * s.z + w * s.x,
        1.0 - (v.x * s.x + v.y * s.y)
    );
    if (kind == 5u) {
        put_row(u, feature, vec3(dot3(x, axis), dot3(y, axis), dot3(z, axis)));
        return;
    }
    put_row(u, feature, x);
    put_row(u, feature + 3u, y);
    if (kind == 3u) {
        put_row(u, feature + 6u, z);
    }
}
