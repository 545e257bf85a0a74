// The rotation nearest to a matrix.

// Newton steps.
const uint STEPS = 7u;

// Scales a matrix to the norm of a rotation.
mat3 normed(mat3 m) {
    precise float square = dot3(m[0], m[0]) + dot3(m[1], m[1]) + dot3(m[2], m[2]);
    precise float scale = sqrt(3.0 / square);
    precise vec3 x = m[0] * scale;
    precise vec3 y = m[1] * scale;
    precise vec3 z = m[2] * scale;
    return mat3(x, y, z);
}

// The orthogonal matrix nearest to a matrix of the norm of a rotation, by Newton's iteration
// X <- (X + X^-T) / 2.
mat3 nearest_rotation(mat3 m) {
    precise vec3 x = m[0];
    precise vec3 y = m[1];
    precise vec3 z = m[2];
    for (uint i = 0u; i < STEPS; i++) {
        vec3 a = cross3(y, z);
        vec3 b = cross3(z, x);
        vec3 c = cross3(x, y);
        precise float share = 0.5 / dot3(x, a);
        x = 0.5 * x + share * a;
        y = 0.5 * y + share * b;
        z = 0.5 * z + share * c;
    }
    return mat3(x, y, z);
}
