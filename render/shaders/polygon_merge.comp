#version 460
// Puts the picture of the polygons into the z-buffer of the warped samples. One workgroup merges one row.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/polygons.h"

layout(local_size_x_id = 0) in;

layout(std430, set = 0, binding = 1) buffer ZBuffer { uvec2 zBuffer[]; };
layout(set = 1, binding = 0) uniform sampler2D colours;
layout(set = 1, binding = 1) uniform sampler2D depths;
layout(push_constant) uniform Constants { PolygonMergeConstants constants; };

void main()
{
    int y = int(gl_WorkGroupID.x);
    for (int x = int(gl_LocalInvocationID.x); x < constants.width; x += int(gl_WorkGroupSize.x)) {
        float depth = texelFetch(depths, ivec2(x, y), 0).x;
        if (depth <= 0.0) continue;
        int pixel = y * constants.width + x;
        uint colour = packUnorm4x8(vec4(texelFetch(colours, ivec2(x, y), 0).rgb, 0.0));
        zBuffer[pixel] = mergedKey(zBuffer[pixel], depth, colour);
    }
}
