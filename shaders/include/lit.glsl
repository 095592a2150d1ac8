// How vertices and pixels of a mesh are lit. Whoever includes this declares LIGHTS, SHININESS_LOG2 and the uniform frame.

// (Not handed on from vertices, as for slices: triangles of meshes are small, and lavapipe draws 1.4 million of them 1.7 times as
// fast where pixels gather the lights instead of triangles carrying them.)
vec4 material;
vec4 lights[MAX_LIGHTS];
vec4 half_ways[MAX_LIGHTS];

#include "respond.glsl"

// The colour that a surface of unit normal m sends to the eye: see src/surface/view.rs.
vec3 lit(vec3 m, vec3 rgb, float along_cue) {
    float cue = 1.0 - frame.cue.z * clamp(along_cue, 0.0, 1.0);
    if (LIGHTS == 0) {
        return cue * rgb;
    }
    material = frame.material;
    lights = frame.lights;
    half_ways = frame.half_ways;
    vec2 light = respond(m);
    return cue * (light.x * rgb + light.y);
}
