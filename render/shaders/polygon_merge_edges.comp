#version 460
// As polygon_merge.comp, of a picture of several samples a pixel: edges are mixed with what stands behind them.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/polygons.h"

layout(local_size_x_id = 0) in;

layout(std430, set = 0, binding = 1) buffer ZBuffer { uvec2 zBuffer[]; };
layout(set = 1, binding = 0) uniform sampler2DMS colours;
layout(set = 1, binding = 1) uniform sampler2DMS depths;
layout(push_constant) uniform Constants { PolygonMergeConstants constants; };

void main()
{
    int y = int(gl_WorkGroupID.x);
    for (int x = int(gl_LocalInvocationID.x); x < constants.width; x += int(gl_WorkGroupSize.x)) {
        int pixel = y * constants.width + x;
        uvec2 key = zBuffer[pixel];
        int before = 0;
        float depthSum = 0.0;
        vec3 colourSum = vec3(0.0);
        for (int i = 0; i < constants.samples; ++i) {
            float depth = texelFetch(depths, ivec2(x, y), i).x;
            if (!isPolygonBefore(key, depth)) continue;
            ++before;
            depthSum += depth;
            colourSum += 255.0 * texelFetch(colours, ivec2(x, y), i).rgb;
        }
        if (before > 0) zBuffer[pixel] = mergedEdge(key, constants.samples, before, depthSum / float(before), colourSum);
    }
}
