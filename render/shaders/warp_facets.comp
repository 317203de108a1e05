#version 460
// The adaptive mesh: textured facets (shared/facet.h). One workgroup draws one tile. An invocation draws a facet by
// itself while it is small; all invocations of a subgroup draw a large one together, and of a very large one graphics
// cards, and processors in wide tiles, list the parts, which other workgroups draw (shared/large_part.h). What is hidden already is passed over before
// its texture is read: tiles that are likely seen come first.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#extension GL_KHR_shader_subgroup_ballot : require

layout(local_size_x_id = 0) in; // before what takes turns

#include "render/shaders/shared/detail.h"
#include "render/shaders/shared/facet.h"
#include "render/shaders/shared/z_key.h"
#include "render/shaders/read_draw.glsl"
#include "render/shaders/z_buffer.glsl"
#include "render/shaders/large_parts.glsl"

layout(set = 0, binding = 2) uniform usamplerBuffer facets;
layout(set = 0, binding = 3) uniform usamplerBuffer texels;
layout(push_constant) uniform Constants { WarpConstants constants; };

struct Piece {
    Facet facet;
    FacetView view;
    PixelBox box;
    ivec2 place; // in the tile
};

Piece pieceOf(TileDraw draw, uint number)
{
    int at = 2 * int(draw.span.y + number);
    uvec2 first = texelFetch(facets, at).xy, second = texelFetch(facets, at + 1).xy;
    Piece piece;
    piece.place = ivec2(int(first.x & 63u), int((first.x >> 6) & 63u));
    piece.facet = facetOf(draw, first.x, uintBitsToFloat(first.y), uintBitsToFloat(second.x), uintBitsToFloat(second.y));
    piece.box = boxOf(piece.facet, vec2(constants.width, constants.height));
    piece.view = turnRound(piece.facet, vec2(piece.box.first) + 0.5f);
    return piece;
}

uint textureAt(TileDraw draw, Piece piece, FacetSight sight)
{
    float most = piece.facet.side - 1.0f;
    float left = clamp(floor(sight.x), 0.0f, most), top = clamp(floor(sight.y), 0.0f, most);
    int stride = int((draw.source.z >> 8) & 0xfffu);
    int at = int(draw.span.x) + (piece.place.y + int(top)) * stride + piece.place.x + int(left);
    uvec2 above = texelFetch(texels, at).xy, below = texelFetch(texels, at + stride).xy;
    float x = clamp(sight.x - left, 0.0f, 1.0f), y = clamp(sight.y - top, 0.0f, 1.0f);
    // Half a square has three samples.
    if (!piece.facet.isLower) return mixColours(above.x, above.y, below.x, x, y);
    if (!piece.facet.isUpper) return mixColours(below.y, above.y, below.x, 1.0f - y, 1.0f - x);
    uint ofRight = shareOf256(x);
    return mixTwo(mixTwo(above.x, above.y, ofRight), mixTwo(below.x, below.y, ofRight), shareOf256(y));
}

void drawPixel(TileDraw draw, Piece piece, uint levelAndClass, ivec2 offset)
{
    FacetSight sight = look(piece.facet, piece.view, vec2(offset));
    if (sight.disparity < 0.0f) return;
    ivec2 pixel = piece.box.first + offset;
    int at = pixel.y * constants.width + pixel.x;
    if (isHidden(at, orderBitsOf(sight.disparity))) return;
    if (!IS_PLAIN && isByDetail(draw)) {
        uint x = uint(max(piece.place.x + int(floor(sight.x + 0.5f)), 0));
        uint y = uint(max(piece.place.y + int(floor(sight.y + 0.5f)), 0));
        if (!isOfDetail(draw, x, y, sight.w)) return;
    }
    uint colour = textureAt(draw, piece, sight);
    atomicMax(zBuffer[at], packUint2x32(packKey(sight.disparity, colour, levelAndClass)));
}

/// Four lanes beside one another, the others below them, go over a part of a facet's box together.
void drawPart(TileDraw draw, Piece piece, uint levelAndClass, BoxPart part, int myPlace, int lanes)
{
    int across = min(lanes, 4), down = max(lanes / 4, 1);
    ivec2 mine = ivec2(myPlace & 3, myPlace >> 2);
    bool takesPart = mine.x < across && mine.y < down;
    for (int y = takesPart ? mine.y : part.extent.y; y < part.extent.y; y += down)
        for (int x = mine.x; x < part.extent.x; x += across)
            drawPixel(draw, piece, levelAndClass, part.first + ivec2(x, y));
}

/// By as many workgroups as there are, a part at a time.
void drawListed()
{
    uint end = min(wanted, uint(parts.length()));
    for (uint i = gl_WorkGroupID.x; i < end; i += gl_NumWorkGroups.x) {
        LargePart part = parts[i];
        if (!isOfRun(part, constants)) continue;
        TileDraw draw = draws[part.draw];
        Piece piece = pieceOf(draw, part.item);
        drawPart(draw, piece, levelAndClassOf(draw), partOf(piece.box.first, extentOf(piece.box), part.first),
                 int(gl_LocalInvocationID.x), int(gl_WorkGroupSize.x));
    }
}

void main()
{
    if (LARGE_PIECES == kDrawsListed) {
        drawListed();
        return;
    }
    PassedDraw which = drawOf(constants.firstDraw, gl_WorkGroupID.x);
    TileDraw draw = readDraw(which.draw);
    uint levelAndClass = levelAndClassOf(draw);
    for (uint start = 0u; start < draw.span.z; start += kTurns * gl_WorkGroupSize.x) {
        uint marks = 0u, bit = 1u, end = endOfTurns(start, draw.span.z);
        for (uint number = start + gl_LocalInvocationID.x; number < end; number += gl_WorkGroupSize.x, bit <<= 1) {
            Piece piece = pieceOf(draw, number);
            ivec2 extent = extentOf(piece.box);
            int pixels = extent.x * extent.y;
            bool isLarge = pixels > int(LARGE_PIXELS);
            if (isLarge) marks |= bit;
            ivec2 offset = ivec2(0);
            for (int i = isLarge ? pixels : 0; i < pixels; ++i) {
                drawPixel(draw, piece, levelAndClass, offset);
                offset.x += 1;
                if (offset.x == extent.x) offset = ivec2(0, offset.y + 1);
            }
        }
        // Not every lane of a subgroup need be there: the workgroup may be smaller.
        uvec4 present = subgroupBallot(true), wanting = subgroupBallot(marks != 0u);
        int lanes = int(subgroupBallotBitCount(present)), myPlace = int(subgroupBallotExclusiveBitCount(present));
        for (; wanting != uvec4(0u); wanting = subgroupBallot(marks != 0u)) {
            uint theirs = takeMarked(start, marks, wanting);
            Piece piece = pieceOf(draw, theirs);
            if (listParts(which.draw, theirs, piece.box, myPlace, lanes)) continue;
            drawPart(draw, piece, levelAndClass, wholeOf(extentOf(piece.box)), myPlace, lanes);
        }
    }
}
