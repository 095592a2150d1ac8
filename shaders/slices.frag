// One sample: the voxels at a point of a slice, classified, lit, and ready to be blended over what is behind it.
#version 450
#include "interface.glsl"

layout(constant_id = 0) const uint MODE = 0;
// What texels are; normals are beside values alone.
layout(constant_id = 1) const uint TEXELS = TEXELS_VALUES;
// 0 is unlit.
layout(constant_id = 2) const uint LIGHTS = 0;
layout(constant_id = 3) const uint SHININESS_LOG2 = 4;
layout(constant_id = 4) const bool PERSPECTIVE = false;
layout(constant_id = 5) const uint HELD_LIGHTS = 1;

layout(binding = 0) uniform sampler3D values;
layout(binding = 1) uniform sampler3D normals;
layout(binding = 2) uniform sampler1D table;

// (Not noperspective, although every w is 1: lavapipe 22.3 then interpolates wrongly on polygons that it clips.)
layout(location = 0) in vec3 texture_at;
layout(location = 1) in vec2 ray_slope;
layout(location = 2) flat in float cue;
// What a frame's lights are, by the vertex shader: lavapipe gathers from a uniform for each pixel what it hands on for nothing.
layout(location = 3) flat in vec4 material;
layout(location = 4) flat in vec4 lights[HELD_LIGHTS];
layout(location = 9) flat in vec4 half_ways[HELD_LIGHTS];
// The thickness of a slab in the unit lengths that opacities of colours hold for.
layout(location = 14) flat in float slab_units;

layout(location = 0) out vec4 color;

const bool MIXED = TEXELS == TEXELS_MIXED;

// A premultiplied colour of a path that is so many times as long.
vec4 lengthened(vec4 c, float times) {
    if (c.a > 0.0) {
        float longer = 1.0 - pow(max(1.0 - c.a, 0.0), times);
        c = vec4(c.rgb * (longer / c.a), longer);
    }
    return c;
}

// Premultiplied colour and opacity of one slab of ray.
vec4 classify(float fraction, float path_per_depth) {
    // The middle of the entry; the sampler clamps to the first and the last one.
    const float ENTRY = 1.0 / float(TABLE_LEN);
    vec4 c = texture(table, fraction * (1.0 - ENTRY) + 0.5 * ENTRY);
    return PERSPECTIVE ? lengthened(c, path_per_depth) : c;
}

// Likewise of a colour that is classified already. Filtering may round it above its opacity.
vec4 colored(vec4 stored, float path_per_depth) {
    return lengthened(vec4(min(stored.rgb, stored.a), stored.a), slab_units * path_per_depth);
}

// A normal of stored numbers, of which 32768 stands for 0.
vec3 normal(vec3 stored) {
    return (stored * 65535.0 - 32768.0) / 32767.0;
}

#include "respond.glsl"

void main() {
    vec4 stored = texture(values, texture_at);
    float coverage = MIXED ? stored.g : 1.0;
    float weighted = stored.r;
    float path_per_depth = PERSPECTIVE ? sqrt(1.0 + dot(ray_slope, ray_slope)) : 1.0;
    switch (MODE) {
    case MODE_MIP:
        color = vec4(vec3(weighted), coverage);
        return;
    case MODE_MINIP:
        color = vec4(vec3(coverage - weighted), coverage);
        return;
    case MODE_AVERAGE:
        color = vec4(vec3(weighted), coverage) * path_per_depth;
        return;
    }
    // Where nothing is covered the quotient is any number, and its colour weighs nothing.
    vec4 c = TEXELS == TEXELS_COLORS
        ? colored(stored, path_per_depth)
        : classify(MIXED ? weighted / max(coverage, 1e-6) : weighted, path_per_depth);
    if (MODE == MODE_XRAY) {
        color = vec4(c.a * coverage);
        return;
    }
    vec2 light;
    switch (LIGHTS) {
    case 0:
        light = vec2(1.0, 0.0);
        break;
    default:
        light = respond(normal((TEXELS == TEXELS_VALUES ? stored : texture(normals, texture_at)).gba));
    }
    color = vec4(cue * (light.x * c.rgb + light.y * c.a), c.a) * coverage;
}
