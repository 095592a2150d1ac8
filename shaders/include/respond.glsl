// How a surface answers to light. Whoever includes this declares LIGHTS, SHININESS_LOG2, material, lights and half_ways.

// The factor of a colour and the white highlight: see src/projection/light.rs.
vec2 respond(vec3 m) {
    float diffuse = 0.0;
    float specular = 0.0;
    for (uint i = 0; i < LIGHTS; ++i) {
        float intensity = lights[i].w;
        diffuse += intensity * abs(dot(m, lights[i].xyz));
        float shine = abs(dot(m, half_ways[i].xyz));
        for (uint s = 0; s < SHININESS_LOG2; ++s) {
            shine *= shine;
        }
        specular += intensity * shine;
    }
    float size = length(m);
    return vec2(1.0 - size + material.x * size + material.y * diffuse, material.z * specular);
}
