#version 460
// Two triangles in each square of four samples (Nyland et al. 1999, section 5.2), rasterised here because most of them
// are smaller than a pixel: fixed hardware is built for larger ones, and a software driver sets each up one by one.
//
// One workgroup draws one tile. An invocation draws a square by itself while it is small; all invocations of a subgroup
// draw a large one together, so that a wall before the eye stalls nobody. Each square warps its four samples anew: that
// costs less than sharing them does.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#extension GL_KHR_shader_subgroup_ballot : require

#include "render/shaders/shared/tile_draw.h"
#include "render/shaders/shared/triangle.h"
#include "render/shaders/shared/z_key.h"

layout(local_size_x_id = 0) in;

layout(std430, set = 0, binding = 0) readonly buffer Vertices { uint64_t vertices[]; };
layout(std430, set = 0, binding = 1) readonly buffer Quads { uint64_t quads[]; };
layout(std430, set = 1, binding = 0) readonly buffer Draws { TileDraw draws[]; };
layout(std430, set = 1, binding = 1) buffer ZBuffer { uint64_t zBuffer[]; };
layout(push_constant) uniform Constants { WarpConstants constants; };

const uint kIndexMask = 0x1fffu, kDrawn = 1u << 15;
const int kLargeSquare = 256; // pixels of its box

struct Square {
    Corner topLeft, topRight, bottomLeft, bottomRight;
    bool upper, lower; // which triangles are drawn
    PixelBox box;
};

bool warpCorner(TileDraw draw, uint index, inout vec2 low, inout vec2 high, bool needed, out Corner corner)
{
    uvec2 vertex = unpackUint2x32(vertices[draw.span.x + index]);
    vec4 h = warpSample(draw, vertex.x);
    corner.seen = project(h);
    corner.colour = vertex.y;
    if (needed) {
        low = min(low, corner.seen.xy);
        high = max(high, corner.seen.xy);
    }
    return isBeforeEye(h);
}

Square warpSquare(TileDraw draw, uint number)
{
    uvec2 quad = unpackUint2x32(quads[draw.span.y + number]);
    Square square;
    square.upper = (quad.x & kDrawn) != 0u;
    square.lower = (quad.y & kDrawn) != 0u;
    vec2 low = vec2(1e30), high = vec2(-1e30);
    bool shared_ = warpCorner(draw, (quad.x >> 16) & kIndexMask, low, high, true, square.topRight);
    shared_ = warpCorner(draw, quad.y & kIndexMask, low, high, true, square.bottomLeft) && shared_;
    square.upper = warpCorner(draw, quad.x & kIndexMask, low, high, square.upper, square.topLeft) && shared_ && square.upper;
    square.lower = warpCorner(draw, (quad.y >> 16) & kIndexMask, low, high, square.lower, square.bottomRight) && shared_ && square.lower;
    square.box = pixelsOf(low, high, vec2(constants.width, constants.height));
    if (!square.upper && !square.lower) square.box.last = square.box.first - 1;
    return square;
}

uint64_t keyAt(Square square, ivec2 pixel)
{
    vec2 centre = vec2(pixel) + 0.5f;
    uint64_t key = 0ul;
    if (square.upper) key = packUint2x32(keyOfTriangle(square.topLeft, square.topRight, square.bottomLeft, centre));
    if (square.lower)
        key = max(key, packUint2x32(keyOfTriangle(square.topRight, square.bottomRight, square.bottomLeft, centre)));
    return key;
}

void drawPixel(Square square, ivec2 pixel)
{
    uint64_t key = keyAt(square, pixel);
    if (key != 0ul) atomicMax(zBuffer[pixel.y * constants.width + pixel.x], key);
}

void main()
{
    TileDraw draw = draws[constants.firstDraw + gl_WorkGroupID.x];
    for (uint start = 0u; start < draw.span.z; start += gl_WorkGroupSize.x) {
        uint number = start + gl_LocalInvocationID.x;
        bool isLarge = false;
        if (number < draw.span.z) {
            Square square = warpSquare(draw, number);
            ivec2 extent = square.box.last - square.box.first + 1;
            bool isEmpty = extent.x <= 0 || extent.y <= 0;
            isLarge = !isEmpty && extent.x * extent.y > kLargeSquare;
            if (!isEmpty && !isLarge) {
                for (int y = square.box.first.y; y <= square.box.last.y; ++y)
                    for (int x = square.box.first.x; x <= square.box.last.x; ++x) drawPixel(square, ivec2(x, y));
            }
        }
        uvec4 large = subgroupBallot(isLarge);
        while (large != uvec4(0u)) {
            uint lane = subgroupBallotFindLSB(large);
            large &= ~subgroupBallot(gl_SubgroupInvocationID == lane);
            Square square = warpSquare(draw, subgroupBroadcast(number, lane));
            int wide = square.box.last.x - square.box.first.x + 1;
            int pixels = wide * (square.box.last.y - square.box.first.y + 1);
            for (int i = int(gl_SubgroupInvocationID); i < pixels; i += int(gl_SubgroupSize))
                drawPixel(square, square.box.first + ivec2(i % wide, i / wide));
        }
    }
}
