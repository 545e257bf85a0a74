// The quaternion x, y, z, w of a rotation matrix, up to its length, with w >= 0; computed by its
// largest component. As in numeric.wgsl, the signs leave a compiler no sum to split.
fn quaternion(m: mat3x3<f32>) -> vec4<f32> {
    let xx = m[0].x;
    let yy = m[1].y;
    let zz = m[2].z;
    var v: vec3<f32>;
    var w: f32;
    if xx + yy + zz >= 0.0 {
        v = vec3<f32>(m[1].z - m[2].y, m[2].x - m[0].z, m[0].y - m[1].x);
        w = 1.0 - (-xx - yy - zz);
    } else if xx >= yy && xx >= zz {
        v = vec3<f32>(1.0 - (yy - xx + zz), m[1].x + m[0].y, m[2].x + m[0].z);
        w = m[1].z - m[2].y;
    } else if yy >= zz {
        v = vec3<f32>(m[1].x + m[0].y, 1.0 - (xx - yy + zz), m[2].y + m[1].z);
        w = m[2].x - m[0].z;
    } else {
        v = vec3<f32>(m[2].x + m[0].z, m[2].y + m[1].z, 1.0 - (xx - zz + yy));
        w = m[0].y - m[1].x;
    }
    return select(vec4<f32>(v, w), vec4<f32>(-v, -w), w < 0.0);
}
