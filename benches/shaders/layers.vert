#version 460
// Full-screen quads, an instance a layer, through the unit cube along an oblique axis.
layout(location = 0) out vec3 place;
layout(push_constant) uniform Push { mat4 cube_from_quad; };

void main() {
    vec2 corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1);
    place = (cube_from_quad * vec4(corner, (gl_InstanceIndex + 0.5) / 256.0, 1.0)).xyz;
    gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);
}
