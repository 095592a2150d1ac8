// A pixel a tile of the frame: whether light still passes through one of the tile's. See src/projection/open.rs.
#version 450
#include "interface.glsl"

layout(binding = 0) uniform sampler2D accumulated;

// (Not read: which tile it is says the pixel.)
layout(location = 0) in vec2 at;

layout(location = 0) out float open;

void main() {
    ivec2 first = ivec2(gl_FragCoord.xy) * int(OPEN_TILE);
    ivec2 end = min(first + int(OPEN_TILE), textureSize(accumulated, 0));
    open = 0.0;
    for (int y = first.y; y < end.y; ++y) {
        for (int x = first.x; x < end.x; ++x) {
            float through = 1.0 - texelFetch(accumulated, ivec2(x, y), 0).a;
            if (through * float(HIDES_ALL_BUT) > 1.0) {
                open = 1.0;
                return;
            }
        }
    }
}
