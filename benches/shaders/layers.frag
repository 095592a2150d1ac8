#version 460
// One sample a fragment, by stages that specialization constants choose; a compiler removes the others.
layout(constant_id = 0) const uint VALUE = 1;
layout(constant_id = 1) const uint TABLE = 0;
layout(constant_id = 2) const uint SKIP = 0;
layout(constant_id = 3) const uint SHADE = 0;
layout(constant_id = 4) const uint CORRECT = 0;

layout(binding = 0) uniform sampler3D values;
layout(binding = 1) uniform sampler2D table;
layout(binding = 2) uniform sampler3D normals;
layout(binding = 3) uniform Uniform { vec4 uniform_table[1024]; };
layout(binding = 4) readonly buffer Storage { vec4 storage_table[1024]; };
layout(location = 0) in vec3 place;
layout(location = 0) out vec4 color;

vec4 look_up(float value) {
    float at = value * 1023.0;
    uint below = uint(at);
    uint above = min(below + 1, 1023);
    switch (TABLE) {
        case 1: return texture(table, vec2(value, 0.5));
        case 2: return texelFetch(table, ivec2(at + 0.5, 0), 0);
        case 3: return mix(texelFetch(table, ivec2(below, 0), 0), texelFetch(table, ivec2(above, 0), 0), fract(at));
        case 4: return uniform_table[uint(at + 0.5)];
        case 5: return storage_table[uint(at + 0.5)];
        case 6: return mix(uniform_table[below], uniform_table[above], fract(at));
        case 7: return mix(storage_table[below], storage_table[above], fract(at));
        case 8: return vec4(0.5, 0.25, 0.125, 1.0) * clamp((value - 0.5) * 0.25, 0.0, 0.25);
        default: return vec4(value * 0.015625);
    }
}

vec3 central_differences() {
    vec2 step = vec2(1.0 / 256.0, 0.0);
    vec3 above = vec3(texture(values, place + step.xyy).r, texture(values, place + step.yxy).r, texture(values, place + step.yyx).r);
    vec3 below = vec3(texture(values, place - step.xyy).r, texture(values, place - step.yxy).r, texture(values, place - step.yyx).r);
    return above - below;
}

vec3 forward_differences(float value) {
    vec2 step = vec2(1.0 / 256.0, 0.0);
    vec3 above = vec3(texture(values, place + step.xyy).r, texture(values, place + step.yxy).r, texture(values, place + step.yyx).r);
    return above - value;
}

vec4 lit(vec4 base, vec3 gradient) {
    vec3 normal = gradient * inversesqrt(max(dot(gradient, gradient), 1e-12));
    float diffuse = abs(dot(normal, vec3(0.36, 0.48, 0.8)));
    float glint = abs(dot(normal, vec3(0.6, 0.0, 0.8)));
    glint *= glint; glint *= glint; glint *= glint; glint *= glint; glint *= glint;
    return vec4(base.rgb * (0.2 + 0.7 * diffuse) + base.a * 0.3 * glint, base.a);
}

void main() {
    color = vec4(0.0);
    vec4 fetched = VALUE == 0 ? vec4(place.x) : texture(values, place);
    float value = SHADE == 4 ? fetched.a : fetched.r;
    vec4 sampled = look_up(value);
    if (SKIP == 1 && sampled.a <= 0.0) discard;
    if (SKIP == 2 && sampled.a <= 0.0) return;
    if (CORRECT == 1) {
        float alpha = 1.0 - pow(1.0 - sampled.a, 0.8 + 0.4 * place.y);
        sampled *= alpha / max(sampled.a, 1e-6);
    }
    if (SHADE == 1) sampled = lit(sampled, texture(normals, place).xyz * 2.0 - 1.0);
    if (SHADE == 2) sampled = lit(sampled, central_differences());
    if (SHADE == 3) sampled = lit(sampled, forward_differences(value));
    if (SHADE == 4) sampled = lit(sampled, fetched.xyz * 2.0 - 1.0);
    color = sampled;
}
