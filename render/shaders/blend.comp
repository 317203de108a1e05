#version 460
// Adds the samples that stand at the front surface, each as a smooth spot. One workgroup draws one tile; its
// invocations take the samples in turns.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require

#include "render/shaders/shared/blend.h"

layout(local_size_x_id = 0) in;

layout(set = 0, binding = 0) uniform usamplerBuffer vertices;
layout(set = 1, binding = 4) uniform usamplerBuffer zTexels;
layout(std430, set = 2, binding = 0) readonly buffer Draws { BlendDraw draws[]; };
layout(std430, set = 2, binding = 1) buffer Sums { uint64_t sums[]; };
layout(push_constant) uniform Constants { WarpConstants constants; };

void main()
{
    BlendDraw draw = draws[constants.firstDraw + gl_WorkGroupID.x];
    uint pixelClass = levelAndClassOf(draw.tile);
    vec2 size = vec2(constants.width, constants.height);
    for (uint i = gl_LocalInvocationID.x; i < draw.tile.span.z; i += gl_WorkGroupSize.x) {
        uvec2 vertex = texelFetch(vertices, int(draw.tile.span.y + i)).xy;
        vec4 h = warpSample(draw.tile, vertex.x);
        if (!isBeforeEye(h)) continue;
        vec3 seen = project(h);
        ivec2 columns = touchedBy(seen.x, draw.reach.x, size.x), rows = touchedBy(seen.y, draw.reach.y, size.y);
        for (int y = rows.x; y < rows.y; ++y)
            for (int x = columns.x; x < columns.y; ++x) {
                int pixel = y * constants.width + x;
                if (!isAtFront(seen.z, pixelClass, texelFetch(zTexels, pixel).xy, draw.reach.z)) continue;
                uint count = countOf(draw.spot, vec2(x, y) + 0.5f - seen.xy);
                if (count == 0u) continue;
                atomicAdd(sums[2 * pixel], packUint2x32(redGreenOf(vertex.y, count)));
                atomicAdd(sums[2 * pixel + 1], packUint2x32(blueWeightOf(vertex.y, count)));
            }
    }
}
