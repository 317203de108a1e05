#version 460
// The least order disparity in each block of the z-buffer (shared/occlusion.h). One invocation a block.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/occlusion.h"

layout(local_size_x_id = 0) in;

layout(set = 0, binding = 4) uniform usamplerBuffer zTexels;
layout(std430, set = 0, binding = 6) writeonly buffer Occluders { uint leastDisparity[]; };
layout(push_constant) uniform Constants { OccluderConstants constants; };

void main()
{
    int across = occludersAlong(constants.width), row = int(gl_WorkGroupID.x);
    for (int column = int(gl_LocalInvocationID.x); column < across; column += int(gl_WorkGroupSize.x)) {
        ivec2 first = ivec2(column, row) * kOccluderSide;
        ivec2 end = min(first + kOccluderSide, ivec2(constants.width, constants.height));
        uint least = 0xffffffffu;
        for (int y = first.y; y < end.y && least > 0u; ++y)
            for (int x = first.x; x < end.x; ++x)
                least = min(least, texelFetch(zTexels, y * constants.width + x).y);
        leastDisparity[row * across + column] = least;
    }
}
