#version 460
// Every kept sample of a tile is a square of pixels of one depth and colour (Nyland et al. 1999, section 5.1);
// those of its pixels that it does not stand in give way to what does (z_key.h).
// One workgroup draws one tile; its invocations take the samples in turns.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require

#include "render/shaders/shared/detail.h"
#include "render/shaders/shared/sample_place.h"
#include "render/shaders/shared/z_key.h"
#include "render/shaders/read_draw.glsl"
#include "render/shaders/z_buffer.glsl"

layout(local_size_x_id = 0) in;

layout(set = 0, binding = 0) uniform usamplerBuffer vertices;
layout(push_constant) uniform Constants { WarpConstants constants; };

void drawPixel(int at, uvec2 key)
{
    if (!isHidden(at, key.y)) atomicMax(zBuffer[at], packUint2x32(key));
}

/// A pixel that a point covers, if it is of the picture.
void coverPixel(ivec2 at, ivec2 end, vec3 seen, uint colour, uint levelAndClass)
{
    if (at.x < 0 || at.y < 0 || at.x >= end.x || at.y >= end.y) return;
    drawPixel(at.y * constants.width + at.x, keyOfPoint(seen.z, colour, levelAndClass, at, seen.xy));
}

uint rowOf(TileDraw draw, uint item)
{
    return columnAndRowOf(draw, texelFetch(vertices, int(draw.span.y + item)).x).y;
}

#include "render/shaders/rows.glsl"

void main()
{
    PassedDraw which = drawOf(constants.firstDraw, gl_WorkGroupID.x);
    TileDraw draw = readDraw(which.draw);
    int size = footprintOf(draw);
    uint levelAndClass = levelAndClassOf(draw);
    float width = float(constants.width), height = float(constants.height);
    uvec2 items = itemsIn(draw, which.rows);
    for (uint i = items.x + gl_LocalInvocationID.x; i < items.y; i += gl_WorkGroupSize.x) {
        uvec2 vertex = texelFetch(vertices, int(draw.span.y + i)).xy;
        vec4 h = warpSample(draw, vertex.x);
        if (!isBeforeEye(h)) continue;
        if (isByDetail(draw)) {
            uvec2 at = columnAndRowOf(draw, vertex.x);
            if (!isOfDetail(draw, at.x, at.y, h.z)) continue;
        }
        vec3 seen = project(h);
        float left = firstOfFootprint(seen.x, size), top = firstOfFootprint(seen.y, size);
        // Compared as floats: far outside, the conversion to int is undefined.
        if (IS_PLAIN) { // one pixel
            if (left >= 0.0f && left < width && top >= 0.0f && top < height) {
                ivec2 own = ivec2(left, top);
                drawPixel(own.y * constants.width + own.x,
                          keyWherePointStands(seen.z, vertex.y, levelAndClass, offsetOfPixel(own, seen.xy)));
            }
            continue;
        }
        if (!(left > -float(size) && left < width && top > -float(size) && top < height)) continue;
        if (IS_SMALL) { // two at most
            ivec2 at = ivec2(left, top), end = min(at + size, ivec2(constants.width, constants.height));
            coverPixel(at, end, seen, vertex.y, levelAndClass);
            coverPixel(at + ivec2(1, 0), end, seen, vertex.y, levelAndClass);
            coverPixel(at + ivec2(0, 1), end, seen, vertex.y, levelAndClass);
            coverPixel(at + ivec2(1, 1), end, seen, vertex.y, levelAndClass);
            continue;
        }
        ivec2 first = max(ivec2(left, top), 0);
        ivec2 end = min(ivec2(left, top) + size, ivec2(constants.width, constants.height));
        for (int y = first.y; y < end.y; ++y)
            for (int x = first.x; x < end.x; ++x)
                drawPixel(y * constants.width + x, keyOfPoint(seen.z, vertex.y, levelAndClass, ivec2(x, y), seen.xy));
    }
}
