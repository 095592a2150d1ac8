#version 460
// Pixel (x, y) shows the 3D image at (x, y, z) + shift, in texels.
layout(binding = 0) uniform sampler3D image;
layout(push_constant) uniform Push { vec4 shift; };
layout(location = 0) out vec4 color;

void main() {
    vec3 texel = vec3(gl_FragCoord.xy, 0.5) + shift.xyz;
    color = texture(image, texel / vec3(textureSize(image, 0)));
}
