// The colour that a surface of unit normal m sends to the eye: see src/surface/view.rs. After respond.glsl, with the strength of
// the depth cue in material.w.
vec3 lit(vec3 m, vec3 rgb, float along_cue) {
    float cue = 1.0 - material.w * clamp(along_cue, 0.0, 1.0);
    if (LIGHTS == 0) {
        return cue * rgb;
    }
    vec2 light = respond(m);
    return cue * (light.x * rgb + light.y);
}
