// Holds the nearest depth wherever what is accumulated hides what is behind: see src/projection/bands.rs.
#version 450
#include "interface.glsl"

layout(binding = 0) uniform sampler2D accumulated;

layout(location = 0) in vec2 at;

void main() {
    float through = 1.0 - texture(accumulated, at).a;
    if (through * float(HIDES_ALL_BUT) > 1.0) {
        discard;
    }
}
