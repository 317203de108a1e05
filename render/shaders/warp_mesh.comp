#version 460
// Two triangles in each square of four samples (Nyland et al. 1999, section 5.2), rasterised here because most of them
// are smaller than a pixel: fixed hardware is built for larger ones, and a software driver sets each up one by one.
//
// One workgroup draws one tile. An invocation draws a square by itself while it is small; all invocations of a subgroup
// draw a large one together, and of a very large one graphics cards, and processors in wide tiles, list the parts, which other workgroups draw
// (shared/large_part.h), so that a wall before the eye stalls nobody. Each square warps its four samples anew: that
// costs less than sharing them does.
//
// Half a square that reaches from before the eye to behind it has no place on the screen for its corners: it is turned
// round, as facets are (shared/facet.h). Right before a wall such squares are all that is seen. They come after the
// others, in tiles that may have any, so that no other tile pays for them.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#extension GL_KHR_shader_subgroup_ballot : require

layout(local_size_x_id = 0) in; // before what takes turns

#include "render/shaders/shared/detail.h"
#include "render/shaders/shared/facet.h"
#include "render/shaders/shared/triangle.h"
#include "render/shaders/shared/z_key.h"
#include "render/shaders/read_draw.glsl"
#include "render/shaders/large_parts.glsl"

layout(set = 0, binding = 0) uniform usamplerBuffer vertices;
layout(set = 0, binding = 1) uniform usamplerBuffer quads;
layout(std430, set = 1, binding = 1) buffer ZBuffer { uint64_t zBuffer[]; };
layout(push_constant) uniform Constants { WarpConstants constants; };

const uint kIndexMask = 0x7fffu, kDrawn = 1u << 15;

/// Squares of more pixels are drawn by all lanes together. On a processor of fewer where a tile has very many: each
/// invocation may go through loops only so often.
int largePixelsOf(TileDraw draw)
{
    const uint mostSteps = 32000u;
    uint turns = (draw.span.z + gl_WorkGroupSize.x - 1u) / gl_WorkGroupSize.x;
    return MOST_STEPS != 0u ? clamp(int(mostSteps / max(turns, 1u)), 8, int(LARGE_PIXELS)) : int(LARGE_PIXELS);
}

struct Square {
    vec3 topLeft, topRight, bottomLeft, bottomRight; // projected
    uint colours[4];                                 // in the same order
    Triangle upper, lower;                           // (top left or bottom right, top right, bottom left)
    PixelBox box;
};

vec3 warpCorner(TileDraw draw, uint index, out uint colour, out bool isUsable)
{
    uvec2 vertex = texelFetch(vertices, int(draw.span.x + index)).xy;
    vec4 h = warpSample(draw, vertex.x);
    colour = vertex.y;
    isUsable = isBeforeEye(h);
    return project(h);
}

/// A square goes with its top left sample, one to the left of the one that any half of it has.
bool isSquareOfDetail(TileDraw draw, uvec2 quad)
{
    if (IS_PLAIN || !isByDetail(draw)) return true;
    uint place = texelFetch(vertices, int(draw.span.x + ((quad.x >> 16) & kIndexMask))).x;
    uvec2 at = columnAndRowOf(draw, place);
    return isOfDetail(draw, max(at.x, 1u) - 1u, at.y, warpSample(draw, place).z);
}

Square warpSquare(TileDraw draw, uint number)
{
    uvec2 quad = texelFetch(quads, int(draw.span.y + number)).xy;
    Square s;
    bool usable[4];
    s.topLeft = warpCorner(draw, quad.x & kIndexMask, s.colours[0], usable[0]);
    s.topRight = warpCorner(draw, (quad.x >> 16) & kIndexMask, s.colours[1], usable[1]);
    s.bottomLeft = warpCorner(draw, quad.y & kIndexMask, s.colours[2], usable[2]);
    s.bottomRight = warpCorner(draw, (quad.y >> 16) & kIndexMask, s.colours[3], usable[3]);
    bool bothUsable = usable[1] && usable[2] && isSquareOfDetail(draw, quad);
    bool upper = (quad.x & kDrawn) != 0u && usable[0] && bothUsable;
    bool lower = (quad.y & kDrawn) != 0u && usable[3] && bothUsable;

    // A triangle that is not drawn collapses onto the diagonal: it has no area, and covers nothing.
    if (!upper) s.topLeft = s.topRight;
    if (!lower) s.bottomRight = s.topRight;
    vec2 low = min(min(s.topLeft.xy, s.topRight.xy), min(s.bottomLeft.xy, s.bottomRight.xy));
    vec2 high = max(max(s.topLeft.xy, s.topRight.xy), max(s.bottomLeft.xy, s.bottomRight.xy));
    s.box = pixelsOf(low, high, vec2(constants.width, constants.height));
    if (!upper && !lower) s.box.last = s.box.first - 1;
    vec2 origin = vec2(s.box.first) + 0.5f;
    s.upper = setUp(s.topLeft, s.topRight, s.bottomLeft, origin);
    s.lower = setUp(s.bottomRight, s.topRight, s.bottomLeft, origin);
    return s;
}

void drawPixel(Square s, uint levelAndClass, ivec2 offset)
{
    Covered upper = cover(s.upper, s.topLeft, s.topRight, s.bottomLeft, vec2(offset));
    Covered lower = cover(s.lower, s.bottomRight, s.topRight, s.bottomLeft, vec2(offset));
    bool isLower = lower.disparity > upper.disparity;
    float disparity = max(upper.disparity, lower.disparity);
    if (disparity < 0.0f) return;
    uint colour = mixColours(isLower ? s.colours[3] : s.colours[0], s.colours[1], s.colours[2],
                             isLower ? lower.ofB : upper.ofB, isLower ? lower.ofC : upper.ofC);
    ivec2 pixel = s.box.first + offset;
    atomicMax(zBuffer[pixel.y * constants.width + pixel.x], packUint2x32(packKey(disparity, colour, levelAndClass)));
}

void drawPart(Square square, uint levelAndClass, BoxPart part, int myPlace, int lanes)
{
    int pixels = part.extent.x * part.extent.y;
    for (int i = myPlace; i < pixels; i += lanes)
        drawPixel(square, levelAndClass, part.first + ivec2(i % part.extent.x, i / part.extent.x));
}

vec4 cornerOf(TileDraw draw, uint index, out uint colour)
{
    uvec2 vertex = texelFetch(vertices, int(draw.span.x + (index & kIndexMask))).xy;
    colour = vertex.y;
    return warpSample(draw, vertex.x);
}

const uint kUpper = 1u, kLower = 2u;

/// Half a square that reaches behind the eye, turned round.
struct Cut {
    Facet facet;
    FacetView view;
    PixelBox box;
    uvec3 colours; // of its corners, in the order of mixColours
};

Cut cutOf(TileDraw draw, uint number, uint half_)
{
    uvec2 quad = texelFetch(quads, int(draw.span.y + number)).xy;
    Cut cut;
    vec4 a = cornerOf(draw, half_ == kLower ? quad.y >> 16 : quad.x, cut.colours.x);
    vec4 b = cornerOf(draw, quad.x >> 16, cut.colours.y), c = cornerOf(draw, quad.y, cut.colours.z);
    cut.facet = facetOfTriangle(a, b, c);
    cut.box = boxOfCut(a, b, c, c, vec2(constants.width, constants.height));
    cut.view = turnRound(cut.facet, vec2(cut.box.first) + 0.5f);
    return cut;
}

void drawCutPart(Cut cut, uint levelAndClass, BoxPart part, int myPlace, int lanes)
{
    for (int i = myPlace; i < part.extent.x * part.extent.y; i += lanes) {
        ivec2 offset = part.first + ivec2(i % part.extent.x, i / part.extent.x);
        FacetSight sight = look(cut.facet, cut.view, vec2(offset));
        if (sight.disparity < 0.0f) continue;
        uint colour = mixColours(cut.colours.x, cut.colours.y, cut.colours.z, sight.x, sight.y);
        ivec2 pixel = cut.box.first + offset;
        atomicMax(zBuffer[pixel.y * constants.width + pixel.x],
                  packUint2x32(packKey(sight.disparity, colour, levelAndClass)));
    }
}

/// Which halves of a square reach behind the eye.
uint cutHalvesOf(TileDraw draw, uint number)
{
    uvec2 quad = texelFetch(quads, int(draw.span.y + number)).xy;
    uint colour;
    bool topLeft = isBeforeEye(cornerOf(draw, quad.x, colour)), topRight = isBeforeEye(cornerOf(draw, quad.x >> 16, colour));
    bool bottomLeft = isBeforeEye(cornerOf(draw, quad.y, colour)), bottomRight = isBeforeEye(cornerOf(draw, quad.y >> 16, colour));
    bool some = topRight || bottomLeft, all_ = topRight && bottomLeft;
    bool upper = (quad.x & kDrawn) != 0u && (some || topLeft) && !(all_ && topLeft);
    bool lower = (quad.y & kDrawn) != 0u && (some || bottomRight) && !(all_ && bottomRight);
    return isSquareOfDetail(draw, quad) ? (upper ? kUpper : 0u) | (lower ? kLower : 0u) : 0u;
}

/// Items of the list of large parts: a square's number, and which half, if it is cut.
const uint kHalfShift = 30u, kItemBits = (1u << kHalfShift) - 1u;

void drawCuts(TileDraw draw, uint drawNumber, uint levelAndClass)
{
    uvec2 items = uvec2(0u, mayReachBehind(draw) ? draw.span.z : 0u);
    for (uint start = items.x; start < items.y; start += kTurns * gl_WorkGroupSize.x) {
        uint marks = 0u, bit = 1u;
        for (uint i = start + gl_LocalInvocationID.x; i < endOfTurns(start, items.y); i += gl_WorkGroupSize.x, bit <<= 1)
            if (cutHalvesOf(draw, i) != 0u) marks |= bit;
        // Not every lane of a subgroup need be there: the workgroup may be smaller.
        uvec4 present = subgroupBallot(true), wanting = subgroupBallot(marks != 0u);
        int lanes = int(subgroupBallotBitCount(present)), myPlace = int(subgroupBallotExclusiveBitCount(present));
        for (; wanting != uvec4(0u); wanting = subgroupBallot(marks != 0u)) {
            uint theirs = takeMarked(start, marks, wanting), drawn = cutHalvesOf(draw, theirs);
            for (uint half_ = drawn == kLower ? kLower : kUpper; half_ <= min(drawn, kLower); ++half_) {
                Cut part = cutOf(draw, theirs, half_);
                if (listParts(drawNumber, theirs | half_ << kHalfShift, part.box, myPlace, lanes)) continue;
                drawCutPart(part, levelAndClass, wholeOf(extentOf(part.box)), myPlace, lanes);
            }
        }
    }
}

bool isLarge(TileDraw draw, Square square)
{
    ivec2 extent = extentOf(square.box);
    return !IS_PLAIN && !IS_SMALL && extent.x * extent.y > largePixelsOf(draw);
}

/// Squares of many pixels, each by all lanes of the subgroup.
void drawLarge(TileDraw draw, uint drawNumber, uint levelAndClass, uvec2 items)
{
    for (uint start = items.x; start < items.y; start += kTurns * gl_WorkGroupSize.x) {
        uint marks = 0u, bit = 1u;
        for (uint i = start + gl_LocalInvocationID.x; i < endOfTurns(start, items.y); i += gl_WorkGroupSize.x, bit <<= 1)
            if (isLarge(draw, warpSquare(draw, i))) marks |= bit;
        uvec4 present = subgroupBallot(true), wanting = subgroupBallot(marks != 0u);
        int lanes = int(subgroupBallotBitCount(present)), myPlace = int(subgroupBallotExclusiveBitCount(present));
        for (; wanting != uvec4(0u); wanting = subgroupBallot(marks != 0u)) {
            uint theirs = takeMarked(start, marks, wanting);
            Square square = warpSquare(draw, theirs);
            if (listParts(drawNumber, theirs, square.box, myPlace, lanes)) continue;
            drawPart(square, levelAndClass, wholeOf(extentOf(square.box)), myPlace, lanes);
        }
    }
}

/// By as many workgroups as there are, a part at a time.
void drawListed()
{
    int myPlace = int(gl_LocalInvocationID.x), lanes = int(gl_WorkGroupSize.x);
    uint end = min(wanted, uint(parts.length()));
    for (uint i = gl_WorkGroupID.x; i < end; i += gl_NumWorkGroups.x) {
        LargePart part = parts[i];
        if (!isOfRun(part, constants)) continue;
        TileDraw draw = draws[part.draw];
        uint levelAndClass = levelAndClassOf(draw), half_ = part.item >> kHalfShift, number = part.item & kItemBits;
        if (half_ != 0u) {
            Cut cut = cutOf(draw, number, half_);
            drawCutPart(cut, levelAndClass, partOf(cut.box.first, extentOf(cut.box), part.first), myPlace, lanes);
        } else {
            Square square = warpSquare(draw, number);
            drawPart(square, levelAndClass, partOf(square.box.first, extentOf(square.box), part.first), myPlace, lanes);
        }
    }
}

uint rowOf(TileDraw draw, uint item)
{
    uint right = (texelFetch(quads, int(draw.span.y + item)).x >> 16) & kIndexMask; // that any square has
    return columnAndRowOf(draw, texelFetch(vertices, int(draw.span.x + right)).x).y;
}

#include "render/shaders/rows.glsl"

void main()
{
    if (LARGE_PIECES == kDrawsListed) {
        drawListed();
        return;
    }
    PassedDraw which = drawOf(constants.firstDraw, gl_WorkGroupID.x);
    TileDraw draw = readDraw(which.draw);
    uint levelAndClass = levelAndClassOf(draw);
    uvec2 items = itemsIn(draw, which.rows);
    bool hasLarge = false;
    for (uint number = items.x + gl_LocalInvocationID.x; number < items.y; number += gl_WorkGroupSize.x) {
        Square square = warpSquare(draw, number);
        ivec2 extent = extentOf(square.box);
        int pixels = extent.x * extent.y;
        bool isForAll = isLarge(draw, square);
        hasLarge = hasLarge || isForAll;
        ivec2 offset = ivec2(0);
        for (int i = isForAll ? pixels : 0; i < pixels; ++i) {
            drawPixel(square, levelAndClass, offset);
            offset.x += 1;
            if (offset.x == extent.x) offset = ivec2(0, offset.y + 1);
        }
    }
    if (IS_PLAIN || IS_SMALL) return;
    drawLarge(draw, which.draw, levelAndClass, subgroupBallot(hasLarge) != uvec4(0u) ? items : uvec2(0u));
    drawCuts(draw, which.draw, levelAndClass);
}
