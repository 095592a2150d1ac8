// The whole frame as a strip of four vertices, nearer than anything else.
#version 450

void main() {
    vec2 corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1);
    gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);
}
