// A pixel a tile of the frame, in rows from its first pixel on: whether light still passes through one of the tile's. See
// src/projection/open.rs.
#version 450
#include "interface.glsl"

layout(binding = 0) uniform sampler2D accumulated;
// Of each tile, in rows: 1 if it is open, else 0.
layout(std430, binding = 1) writeonly buffer Tiles { uint open_tiles[]; };

// (Not read: which tile it is says the pixel.)
layout(location = 0) in vec2 at;

bool is_open(ivec2 first, ivec2 end) {
    for (int y = first.y; y < end.y; ++y) {
        for (int x = first.x; x < end.x; ++x) {
            float through = 1.0 - texelFetch(accumulated, ivec2(x, y), 0).a;
            if (through * float(HIDES_ALL_BUT) > 1.0) {
                return true;
            }
        }
    }
    return false;
}

void main() {
    const int EDGE = int(OPEN_TILE);
    ivec2 tile = ivec2(gl_FragCoord.xy);
    ivec2 size = textureSize(accumulated, 0);
    int across = (size.x + EDGE - 1) / EDGE;
    bool open = is_open(EDGE * tile, min(EDGE * (tile + 1), size));
    open_tiles[tile.x + across * tile.y] = uint(open);
}
