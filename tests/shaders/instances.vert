#version 460
// A square of one pixel an instance, at the pixel whose place is in the instance's buffer element.
layout(location = 0) in vec2 pixel;
layout(location = 0) flat out uint instance;
layout(constant_id = 7) const float TARGET_EDGE = 1.0;

void main() {
    vec2 corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1);
    gl_Position = vec4(2.0 * (pixel + corner) / TARGET_EDGE - 1.0, 0.0, 1.0);
    instance = gl_InstanceIndex;
}
