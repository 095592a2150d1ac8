// One sample: the voxels at a point of a slice, classified, lit, and ready to be blended over what is behind it.
#version 450
#include "interface.glsl"

layout(constant_id = 0) const uint MODE = 0;
// Whether texels hold value times coverage and coverage (normals apart), or a value (in a lit target its normal beside it).
layout(constant_id = 1) const bool MIXED = false;
// 0 is unlit.
layout(constant_id = 2) const uint LIGHTS = 0;
layout(constant_id = 3) const uint SHININESS_LOG2 = 4;
layout(constant_id = 4) const bool PERSPECTIVE = false;

layout(binding = 0) uniform sampler3D values;
layout(binding = 1) uniform sampler3D normals;
layout(binding = 2) uniform sampler2D table;
layout(std140, binding = 3) uniform FrameBlock { FrameData frame; };

layout(location = 0) in vec3 texture_at;
layout(location = 1) in vec2 ray_slope;
layout(location = 2) flat in float cue;

layout(location = 0) out vec4 color;

// Premultiplied colour and opacity of one slab of ray.
vec4 classify(float fraction, float path_per_depth) {
    int entry = int(clamp(fraction, 0.0, 1.0) * float(TABLE_LEN - 1) + 0.5);
    vec4 c = texelFetch(table, ivec2(entry, 0), 0);
    if (PERSPECTIVE && c.a > 0.0) {
        float longer = 1.0 - pow(max(1.0 - c.a, 0.0), path_per_depth);
        c = vec4(c.rgb * (longer / c.a), longer);
    }
    return c;
}

// The factor of a colour and the white highlight: see src/projection/light.rs.
vec2 respond(vec3 m) {
    float diffuse = 0.0;
    float specular = 0.0;
    for (uint i = 0; i < LIGHTS; ++i) {
        float intensity = frame.lights[i].w;
        diffuse += intensity * abs(dot(m, frame.lights[i].xyz));
        float shine = abs(dot(m, frame.half_ways[i].xyz));
        for (uint s = 0; s < SHININESS_LOG2; ++s) {
            shine *= shine;
        }
        specular += intensity * shine;
    }
    float size = length(m);
    return vec2(1.0 - size + frame.material.x * size + frame.material.y * diffuse, frame.material.z * specular);
}

void main() {
    vec4 stored = textureLod(values, texture_at, 0.0);
    float coverage = MIXED ? stored.g : 1.0;
    float weighted = frame.values.x * stored.r + frame.values.y * coverage;
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
    vec4 c = classify(MIXED ? weighted / max(coverage, 1e-6) : weighted, path_per_depth);
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
        light = respond(MIXED
            ? textureLod(normals, texture_at, 0.0).gba * frame.normals.z + frame.normals.w
            : stored.gba * frame.normals.x + frame.normals.y);
    }
    color = vec4(cue * (light.x * c.rgb + light.y * c.a), c.a) * coverage;
}
