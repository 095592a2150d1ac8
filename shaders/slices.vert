// One vertex of a slice polygon: the template's moving vertex at the slice's depth, placed in its box, projected after.
#version 450
#include "interface.glsl"

// 0 is unlit.
layout(constant_id = 2) const uint LIGHTS = 0;
layout(constant_id = 4) const bool PERSPECTIVE = false;
// Lights that a vertex hands on: no array has no element. (Lavapipe copies what is handed on for each vertex, used or not.)
layout(constant_id = 5) const uint HELD_LIGHTS = 1;

layout(std140, binding = 3) uniform FrameBlock { FrameData frame; };
layout(std430, binding = 4) readonly buffer Boxes { BoxData boxes[]; };
layout(std430, binding = 5) readonly buffer Vertices { MovingVertexData vertices[]; };
layout(std430, binding = 6) readonly buffer Slices { SliceData slices[]; };

layout(location = 0) out vec3 texture_at;
// Eye-space x and y over depth: constant on a pixel, whatever the slice.
layout(location = 1) out vec2 ray_slope;
layout(location = 2) flat out float cue;
layout(location = 3) flat out vec4 material;
layout(location = 4) flat out vec4 lights[HELD_LIGHTS];
layout(location = 9) flat out vec4 half_ways[HELD_LIGHTS];
layout(location = 14) flat out float slab_units;

void main() {
    SliceData slice = slices[gl_VertexIndex / MAX_VERTICES];
    BoxData b = boxes[slice.box_index];
    MovingVertexData v = vertices[slice.first_vertex + gl_VertexIndex % MAX_VERTICES];
    vec3 unit = v.base.xyz + slice.t_mm * v.slope.xyz;
    vec4 lattice = vec4(b.origin.xyz + b.size.xyz * unit, 1.0);
    vec2 eye = vec2(dot(frame.eye_from_model[0], lattice), dot(frame.eye_from_model[1], lattice));
    float depth_mm = b.origin.w + slice.t_mm;
    texture_at = b.texture_origin.xyz + b.texture_size.xyz * unit;
    ray_slope = PERSPECTIVE ? eye / depth_mm : vec2(0.0);
    slab_units = frame.cue.w;
    cue = 1.0 - frame.cue.z * clamp((depth_mm - frame.cue.x) * frame.cue.y, 0.0, 1.0);
    switch (LIGHTS) {
    case 0:
        break;
    default:
        material = frame.material;
        for (uint n = 0; n < LIGHTS; ++n) {
            lights[n] = frame.lights[n];
            half_ways[n] = frame.half_ways[n];
        }
    }
    float tested = frame.lens.z * (PERSPECTIVE ? 1.0 : depth_mm) + frame.lens.w / (PERSPECTIVE ? depth_mm : 1.0);
    gl_Position = vec4((PERSPECTIVE ? ray_slope : eye) * frame.lens.xy, clamp(tested, 0.0, 1.0), 1.0);
}
