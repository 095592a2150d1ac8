// One pixel of a mesh.
#version 450
#include "interface.glsl"

layout(constant_id = 0) const uint SHADING = 0;
// 0 is unlit.
layout(constant_id = 2) const uint LIGHTS = 0;
layout(constant_id = 3) const uint SHININESS_LOG2 = 4;

layout(std140, binding = 0) uniform FrameBlock { FrameData frame; };

layout(location = 0) in vec3 rgb;
layout(location = 1) in vec4 surface;
layout(location = 2) in vec4 at;

layout(location = 0) out vec4 color;

#include "lit.glsl"

// Of the triangle's plane; zero if it is seen from the side.
vec3 flat_normal(vec3 along_x, vec3 along_y) {
    vec3 across = cross(along_x, along_y);
    float size = length(across);
    return size > 0.0 ? across / size : vec3(0.0);
}

void main() {
    vec3 plane = flat_normal(dFdx(at.xyz), dFdy(at.xyz));
    const float LEAST = 1.0 / float(FLAT_ABOVE);
    bool has_normal = surface.w > 1.0 - LEAST;
    switch (SHADING) {
    case MESH_DEPTH:
        color = vec4(rgb, 1.0);
        return;
    case MESH_PHONG:
        float size = length(surface.xyz);
        vec3 m = has_normal && size > LEAST ? surface.xyz / size : plane;
        color = vec4(lit(m, rgb, at.w), 1.0);
        return;
    default:
        color = vec4(has_normal ? surface.xyz : lit(plane, rgb, at.w), 1.0);
    }
}
