// For a skinning shader: the normal of a vertex with four influences, from the file's tangent coefficients. Cofactors of
// the blended matrix alone are off by some ten degrees where a character bends.
//
// - normal, tangent: directions at rest; the tangent is 0 in a mesh without tangents.
// - blended: 3x3 of the sum of the weighted transforms.
// - moved: the vertex, moved by each of its transforms; any if a skin has fewer.
// - coefficients: of the second to fourth influences, from `Skin::tangent_coefficients`; 0 where it lists fewer.
// - side: -1 if the palette's first transform mirrors, so if its determinant is negative; else 1.
vec3 skinned_normal(
    vec3 normal, vec3 tangent, mat3 blended, vec3 moved[4], vec2 coefficients[3], float side
) {
    vec3 v = cross(normal, tangent);
    vec3 u = cross(v, normal);
    if (dot(tangent, tangent) == 0.0) {
        float s = normal.z < 0.0 ? -1.0 : 1.0;
        float w = normal.x / (s + normal.z);
        u = vec3(1.0 - s * normal.x * w, -s * normal.y * w, -s * normal.x);
        v = cross(normal, u);
    }
    u = blended * u;
    v = blended * v;
    for (int l = 0; l < 3; l++) {
        vec3 apart = moved[l + 1] - moved[0];
        u += coefficients[l].x * apart;
        v += coefficients[l].y * apart;
    }
    vec3 found = cross(u, v);
    float square = dot(found, found);
    // Folded skin has no direction.
    return square > 0.0 ? side * found * inversesqrt(square) : blended * normal;
}
