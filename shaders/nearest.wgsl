// The rotation nearest to a matrix.

// Newton steps.
const STEPS: u32 = 7u;

// Scales a matrix to the norm of a rotation.
fn normed(m: mat3x3<f32>) -> mat3x3<f32> {
    let square = dot3(m[0], m[0]) + dot3(m[1], m[1]) + dot3(m[2], m[2]);
    let scale = sqrt(3.0 / square);
    return mat3x3<f32>(m[0] * scale, m[1] * scale, m[2] * scale);
}

// The orthogonal matrix nearest to a matrix of the norm of a rotation, by Newton's iteration
// X <- (X + X^-T) / 2.
fn nearest_rotation(m: mat3x3<f32>) -> mat3x3<f32> {
    var x = m[0];
    var y = m[1];
    var z = m[2];
    for (var i = 0u; i < STEPS; i++) {
        let a = cross3(y, z);
        let b = cross3(z, x);
        let c = cross3(x, y);
        let share = 0.5 / dot3(x, a);
        x = 0.5 * x + share * a;
        y = 0.5 * y + share * b;
        z = 0.5 * z + share * c;
    }
    return mat3x3<f32>(x, y, z);
}
