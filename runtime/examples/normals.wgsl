// For a skinning shader: the normal of a vertex with four influences, from the file's tangent coefficients. Cofactors of
// the blended matrix alone are off by some ten degrees where a character bends.
//
// - normal, tangent: directions at rest; the tangent is 0 in a mesh without tangents.
// - blended: 3x3 of the sum of the weighted transforms.
// - moved: the vertex, moved by each of its transforms; any if a skin has fewer.
// - coefficients: of the second to fourth influences, from `Skin::tangent_coefficients`; 0 where it lists fewer.
// - side: -1 if the palette's first transform mirrors, so if its determinant is negative; else 1.
fn skinned_normal(
    normal: vec3<f32>,
    tangent: vec3<f32>,
    blended: mat3x3<f32>,
    moved: array<vec3<f32>, 4>,
    coefficients: array<vec2<f32>, 3>,
    side: f32,
) -> vec3<f32> {
    var v = cross(normal, tangent);
    var u = cross(v, normal);
    if dot(tangent, tangent) == 0.0 {
        let s = select(1.0, -1.0, normal.z < 0.0);
        let w = normal.x / (s + normal.z);
        u = vec3<f32>(1.0 - s * normal.x * w, -s * normal.y * w, -s * normal.x);
        v = cross(normal, u);
    }
    u = blended * u;
    v = blended * v;
    for (var l = 0; l < 3; l++) {
        let apart = moved[l + 1] - moved[0];
        u += coefficients[l].x * apart;
        v += coefficients[l].y * apart;
    }
    let found = cross(u, v);
    let square = dot(found, found);
    // Folded skin has no direction.
    return select(blended * normal, side * found * inverseSqrt(square), square > 0.0);
}
