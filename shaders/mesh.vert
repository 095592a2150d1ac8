// One vertex of a mesh: projected, and lit if it is Gouraud's.
#version 450
#include "interface.glsl"

layout(constant_id = 0) const uint SHADING = 0;
// Whether each vertex has a colour of its own.
layout(constant_id = 1) const bool OWN_COLORS = false;
// 0 is unlit.
layout(constant_id = 2) const uint LIGHTS = 0;
layout(constant_id = 3) const uint SHININESS_LOG2 = 4;
layout(constant_id = 4) const bool PERSPECTIVE = false;

layout(std140, binding = 0) uniform FrameBlock { FrameData frame; };
layout(push_constant) uniform Push { MeshData mesh; };

// In the world.
layout(location = 0) in vec3 position;
// Of unit length, or zero.
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 own_color;

layout(location = 0) out vec3 rgb;
// Gouraud: the lit colour; Phong: the normal. Then 1 if there is a normal.
layout(location = 1) out vec4 surface;
// The position, and how far it is along the depth cue.
layout(location = 2) out vec4 at;

#include "lit.glsl"

void main() {
    vec4 world = vec4(position, 1.0);
    vec3 eye = vec3(dot(frame.eye_from_model[0], world), dot(frame.eye_from_model[1], world), dot(frame.eye_from_model[2], world));
    at = vec4(position, (eye.z - frame.cue.x) * frame.cue.y);
    rgb = OWN_COLORS ? own_color.rgb : mesh.rgb.rgb;
    switch (SHADING) {
    case MESH_DEPTH:
        rgb = vec3(eye.z);
        surface = vec4(0.0);
        break;
    case MESH_PHONG:
        surface = vec4(normal, dot(normal, normal) > 0.0);
        break;
    default:
        surface = vec4(lit(normal, rgb, at.w), dot(normal, normal) > 0.0);
    }
    gl_Position = vec4(eye.xy * frame.lens.xy, frame.lens.z * eye.z + frame.lens.w, PERSPECTIVE ? eye.z : 1.0);
}
