#version 460
// Tints what was not measured (shared/mark.h). A workgroup takes a row.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/mark.h"

layout(local_size_x_id = 0) in;

layout(std430, set = 0, binding = 2) buffer Colours { uint colours[]; };
layout(push_constant) uniform Constants { MarkConstants constants; };

void main()
{
    uint row = gl_WorkGroupID.x * constants.width;
    for (uint x = gl_LocalInvocationID.x; x < constants.width; x += gl_WorkGroupSize.x)
        colours[row + x] = marked(colours[row + x]);
}
