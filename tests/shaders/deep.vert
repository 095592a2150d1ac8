// A strip that fills the target, at the depth of the last push constant.
#version 450

layout(push_constant) uniform Push { vec4 color; };

void main() {
    gl_Position = vec4(2.0 * vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) - 1.0, color.a, 1.0);
}
