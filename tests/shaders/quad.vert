#version 460
// Two triangles over the whole target; `uv` is 0 to 1 from the first pixel's first corner to the last pixel's last.
layout(location = 0) out vec2 uv;

void main() {
    uv = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1);
    gl_Position = vec4(2.0 * uv - 1.0, 0.0, 1.0);
}
