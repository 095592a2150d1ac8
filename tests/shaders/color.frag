#version 460
// The colour that is pushed.
layout(push_constant) uniform Push { vec4 pushed; };
layout(location = 0) out vec4 color;

void main() {
    color = pushed;
}
