// The features of a query: quadratic forms of quaternions, divided by their squared length.

// Count of a query's numbers for an input of a kind.
fn number_len(kind: u32) -> u32 {
    switch kind {
        case 1u: {
            return 1u;
        }
        case 2u: {
            return 3u;
        }
        default: {
            return 4u;
        }
    }
}

// Count of features of an input of a kind.
fn feature_len(kind: u32) -> u32 {
    switch kind {
        case 3u: {
            return 9u;
        }
        case 4u: {
            return 6u;
        }
        case 2u, 5u: {
            return 3u;
        }
        case 6u: {
            return 2u;
        }
        default: {
            return 1u;
        }
    }
}

fn dot3(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

fn squared_length(q: vec4<f32>) -> f32 {
    return dot3(q.xyz, q.xyz) + q.w * q.w;
}

// Angle of a twist, within half a turn, from a sine and a cosine in proportion to those of half the
// angle.
fn twist_angle(sine: f32, cosine: f32) -> f32 {
    let flipped = cosine < 0.0 || (cosine == 0.0 && sine < 0.0);
    let about = select(sine, -sine, flipped);
    let angle = 2.0 * quadrant_angle(select(about, -about, about < 0.0), select(cosine, -cosine, flipped));
    return select(angle, -angle, about < 0.0);
}

// Stores a feature: clamped to its range if the query rule says so, shifted and scaled.
fn put_feature(u: u32, feature: u32, value: f32) {
    let row = params.features + 4u * feature;
    var kept = value;
    if query_rule() == CLAMP {
        let low = blob_float(row + 2u);
        let high = blob_float(row + 3u);
        kept = select(kept, low, low > kept);
        kept = select(kept, high, high < kept);
    }
    scratch[u + feature] = (kept - blob_float(row)) * blob_float(row + 1u);
}

fn put_row(u: u32, feature: u32, row: vec3<f32>) {
    put_feature(u, feature, row.x);
    put_feature(u, feature + 1u, row.y);
    put_feature(u, feature + 2u, row.z);
}

// Computes the features of one input, given by its row in the file, from the query's numbers at
// number.
fn put_features(row: u32, number: u32, u: u32, feature: u32) {
    let kind = blob[row] & 0xffu;
    for (var i = 0u; i < number_len(kind); i++) {
        watch(queries[number + i]);
    }
    if kind == 1u {
        put_feature(u, feature, queries[number]);
        return;
    }
    let v = vec3<f32>(queries[number], queries[number + 1u], queries[number + 2u]);
    if kind == 2u {
        put_row(u, feature, v);
        return;
    }
    let w = queries[number + 3u];
    let axis = blob_vec3(row + 1u);
    let square = squared_length(vec4<f32>(v, w));
    // A quaternion of length 0 has no direction.
    if (bitcast<u32>(square) & INFINITE) == 0u {
        atomicStore(&unsound, 1u);
    }
    watch(square);
    let about = dot3(v, axis);
    if kind == 6u {
        put_feature(u, feature, (w * w - about * about) / square);
        put_feature(u, feature + 1u, 2.0 * w * about / square);
        return;
    }
    if kind == 7u {
        put_feature(u, feature, twist_angle(about, w));
        return;
    }
    let f = 2.0 / square;
    let s = v * f;
    let x = vec3<f32>(
        1.0 - (v.y * s.y + v.z * s.z),
        v.x * s.y - w * s.z,
        v.x * s.z + w * s.y,
    );
    let y = vec3<f32>(
        v.x * s.y + w * s.z,
        1.0 - (v.x * s.x + v.z * s.z),
        v.y * s.z - w * s.x,
    );
    let z = vec3<f32>(
        v.x * s.z - w * s.y,
        v.y * s.z + w * s.x,
        1.0 - (v.x * s.x + v.y * s.y),
    );
    if kind == 5u {
        put_row(u, feature, vec3<f32>(dot3(x, axis), dot3(y, axis), dot3(z, axis)));
        return;
    }
    put_row(u, feature, x);
    put_row(u, feature + 3u, y);
    if kind == 3u {
        put_row(u, feature + 6u, z);
    }
}
