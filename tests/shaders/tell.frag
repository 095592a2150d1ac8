// Each pixel of a target of 4² tells its place, and is drawn.
#version 460

layout(push_constant) uniform Push { vec4 color; };
layout(std430, binding = 0) writeonly buffer Told { uint told[]; };

layout(location = 0) out vec4 result;

void main() {
    uvec2 at = uvec2(gl_FragCoord.xy);
    told[at.x + 4 * at.y] = at.x + 10 * at.y;
    result = color;
}
