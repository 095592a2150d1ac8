#version 460
#extension GL_GOOGLE_include_directive : require
#include "interface.glsl"
// Reads every shared structure, as uniform and as storage data.
layout(binding = 0) uniform Uniform { Lighting lighting; };
layout(binding = 1) readonly buffer Storage { Lighting stored; };
layout(location = 0) out vec4 color;

void main() {
    color = lighting.ambient + stored.ambient;
    for (uint i = 0; i < lighting.count.x; ++i) color += lighting.lights[i].color * stored.lights[i].direction;
}
