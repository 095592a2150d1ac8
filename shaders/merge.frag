// A band as it is, to be blended under what is nearer.
#version 450

layout(binding = 0) uniform sampler2D band;

layout(location = 0) in vec2 at;

layout(location = 0) out vec4 color;

void main() {
    color = texture(band, at);
}
