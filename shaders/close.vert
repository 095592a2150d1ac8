// A rectangle of the frame as a strip of four vertices, nearer than anything else.
#version 450
#include "interface.glsl"

layout(push_constant) uniform Push { RectData rect; };

// Texture coordinates of an image of the frame's size. (With them lavapipe reads a pixel faster than texelFetch does.)
layout(location = 0) out vec2 at;

void main() {
    at = mix(rect.ends.xy, rect.ends.zw, vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1));
    gl_Position = vec4(2.0 * at - 1.0, 0.0, 1.0);
}
