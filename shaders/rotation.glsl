// The quaternion x, y, z, w of a rotation matrix, up to its length, with w >= 0; computed by its
// largest component.
vec4 quaternion(mat3 m) {
    float xx = m[0].x;
    float yy = m[1].y;
    float zz = m[2].z;
    precise float trace = xx + yy + zz;
    precise vec3 v;
    precise float w;
    if (trace >= 0.0) {
        v = vec3(m[1].z - m[2].y, m[2].x - m[0].z, m[0].y - m[1].x);
        w = 1.0 + trace;
    } else if (xx >= yy && xx >= zz) {
        v = vec3(1.0 + (xx - yy - zz), m[1].x + m[0].y, m[2].x + m[0].z);
        w = m[1].z - m[2].y;
    } else if (yy >= zz) {
        v = vec3(m[1].x + m[0].y, 1.0 + (yy - xx - zz), m[2].y + m[1].z);
        w = m[2].x - m[0].z;
    } else {
        v = vec3(m[2].x + m[0].z, m[2].y + m[1].z, 1.0 + (zz - xx - yy));
        w = m[0].y - m[1].x;
    }
    return w < 0.0 ? vec4(-v, -w) : vec4(v, w);
}
