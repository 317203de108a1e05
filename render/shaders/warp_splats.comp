#version 460
// Every kept sample of a tile is a quadratic splat. One workgroup draws one tile; its invocations take the samples in
// turns.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require

#include "render/shaders/shared/detail.h"
#include "render/shaders/shared/splat.h"
#include "render/shaders/shared/z_key.h"
#include "render/shaders/read_draw.glsl"
#include "render/shaders/z_buffer.glsl"

layout(local_size_x_id = 0) in;

layout(set = 0, binding = 0) uniform usamplerBuffer vertices;
layout(push_constant) uniform Constants { WarpConstants constants; };

void drawPixel(ivec2 pixel, vec3 seen, float perRadius2, uint colour, uint levelAndClass)
{
    vec2 offset = offsetOfPixel(pixel, seen.xy);
    float disparity = splatDisparity(seen.z, offset, perRadius2);
    bool isInside = uint(pixel.x) < uint(constants.width) && uint(pixel.y) < uint(constants.height);
    if (!(disparity >= 0.0f && isInside)) return;
    int at = pixel.y * constants.width + pixel.x;
    uvec2 key = keyOfSplat(disparity, offset, colour, levelAndClass);
    if (isHidden(at, key.y)) return;
    atomicMax(zBuffer[at], packUint2x32(key));
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
    uint levelAndClass = levelAndClassOf(draw);
    // Alike for all samples of the tile: no invocation waits for another's wider circle.
    float radius = splatRadiusOf(draw);
    int side = splatSideOf(radius);
    precise float perRadius2 = 1.0f / (radius * radius);
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
        float left = firstOfSplat(seen.x, radius), top = firstOfSplat(seen.y, radius);
        // Compared as floats: far outside, the conversion to int is undefined.
        if (!(left > -float(side) && left < width && top > -float(side) && top < height)) continue;
        if (IS_PLAIN) { // two pixels at most
            ivec2 own = ivec2(floor(seen.xy));
            drawPixel(own, seen, perRadius2, vertex.y, levelAndClass);
            drawPixel(own + nextOfSplat(offsetOfPixel(own, seen.xy)), seen, perRadius2, vertex.y, levelAndClass);
            continue;
        }
        ivec2 first = ivec2(left, top);
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x)
                drawPixel(first + ivec2(x, y), seen, perRadius2, vertex.y, levelAndClass);
    }
}
