#version 460
// The instance's number.
layout(location = 0) flat in uint instance;
layout(location = 0) out vec4 color;

void main() {
    color = vec4(instance);
}
