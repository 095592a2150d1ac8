#version 460
// What a 2D image has at this pixel, plus what is pushed.
layout(binding = 0) uniform sampler2D image;
layout(push_constant) uniform Push { vec4 pushed; };
layout(location = 0) out vec4 color;

void main() {
    color = texelFetch(image, ivec2(gl_FragCoord.xy), 0) + pushed;
}
