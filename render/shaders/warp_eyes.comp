#version 460
// The points of warp_points.comp and the splats of warp_splats.comp for two eyes: a sample is read once and warped twice.
// One workgroup draws one tile; its invocations take the samples in turns. Each eye keeps its own draw of the tile, and
// so its own level of detail, order and size: its picture is the same to the byte as if it were drawn alone.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require

#include "render/shaders/shared/detail.h"
#include "render/shaders/shared/splat.h"
#include "render/shaders/shared/stereo.h"
#include "render/shaders/shared/z_key.h"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint IS_SPLATS = 0u;

layout(set = 0, binding = 0) uniform usamplerBuffer vertices;
layout(std430, set = 1, binding = 0) readonly buffer LeftDraws { TileDraw leftDraws[]; };
layout(std430, set = 1, binding = 1) buffer LeftZBuffer { uint64_t leftZBuffer[]; };
layout(set = 1, binding = 4) uniform usamplerBuffer leftZTexels;
layout(std430, set = 2, binding = 0) readonly buffer RightDraws { TileDraw rightDraws[]; };
layout(std430, set = 2, binding = 1) buffer RightZBuffer { uint64_t rightZBuffer[]; };
layout(set = 2, binding = 4) uniform usamplerBuffer rightZTexels;
layout(std430, set = 3, binding = 0) readonly buffer Pairs { PairDraw pairs[]; };
layout(push_constant) uniform Constants { WarpConstants constants; };

/// How an eye draws the tile: alike for all of its samples.
struct EyeDraw {
    TileDraw draw;
    uint eye;
    vec2 rows; // first and end of those that it draws
    uint levelAndClass;
    int side; // of a sample, pixels
    int moreRows; // of a splat that covers more than two pixels: its side
    float radius; // of a splat, pixels
    float perRadius2; // 1 / radius^2
};

EyeDraw eyeDrawOf(uint eye, TileDraw draw, uint rows)
{
    EyeDraw own;
    own.draw = draw;
    own.eye = eye;
    own.rows = vec2(float(int(rows & 0xffu)), float(int(rows >> 8)));
    own.levelAndClass = levelAndClassOf(draw);
    own.radius = splatRadiusOf(draw);
    own.side = IS_SPLATS != 0u ? splatSideOf(own.radius) : footprintOf(draw);
    own.moreRows = coversTwoAtMost(own.radius) ? 0 : own.side;
    precise float perRadius2 = 1.0f / (own.radius * own.radius);
    own.perRadius2 = perRadius2;
    return own;
}

/// Unless something nearer stands there (z_buffer.glsl).
void put(uint eye, int pixel, uint64_t key)
{
    uint disparity = unpackUint2x32(key).y;
    if (eye == kLeft) {
        if (texelFetch(leftZTexels, pixel).y <= disparity) atomicMax(leftZBuffer[pixel], key);
    } else {
        if (texelFetch(rightZTexels, pixel).y <= disparity) atomicMax(rightZBuffer[pixel], key);
    }
}

void drawSquare(EyeDraw own, ivec2 corner, vec3 seen, uint colour) // as in warp_points.comp
{
    ivec2 first = max(corner, 0), end = min(corner + own.side, ivec2(constants.width, constants.height));
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x)
            put(own.eye, y * constants.width + x,
                packUint2x32(keyOfPoint(seen.z, colour, own.levelAndClass, ivec2(x, y), seen.xy)));
}

void drawPixel(EyeDraw own, ivec2 pixel, vec3 seen, uint colour)
{
    vec2 offset = offsetOfPixel(pixel, seen.xy);
    float disparity = splatDisparity(seen.z, offset, own.perRadius2);
    bool isInside = uint(pixel.x) < uint(constants.width) && uint(pixel.y) < uint(constants.height);
    if (disparity >= 0.0f && isInside)
        put(own.eye, pixel.y * constants.width + pixel.x, packUint2x32(keyOfSplat(disparity, offset, colour, own.levelAndClass)));
}

void drawCircle(EyeDraw own, ivec2 corner, vec3 seen, uint colour) // as in warp_splats.comp
{
    ivec2 pixel = ivec2(floor(seen.xy));
    drawPixel(own, pixel, seen, colour);
    drawPixel(own, pixel + nextOfSplat(offsetOfPixel(pixel, seen.xy)), seen, colour);
    for (int y = 0; y < own.moreRows; ++y)
        for (int x = 0; x < own.side; ++x)
            drawPixel(own, corner + ivec2(x, y), seen, colour);
}

/// Conditions are gathered instead of returned upon: processors run what is behind a return all the same, and slower.
void drawSample(EyeDraw own, vec3 at, vec3 chances, uint colour)
{
    vec4 h = warpPlace(own.draw, at);
    bool isShown = isBeforeEye(h) && at.y >= own.rows.x && at.y < own.rows.y;
    if (isByDetail(own.draw)) isShown = isShown && isOfDetail(own.draw, chances, h.z);
    vec3 seen = project(h);
    int side = own.side;
    float left = IS_SPLATS != 0u ? firstOfSplat(seen.x, own.radius) : firstOfFootprint(seen.x, side);
    float top = IS_SPLATS != 0u ? firstOfSplat(seen.y, own.radius) : firstOfFootprint(seen.y, side);
    // Compared as floats: far outside, the conversion to int is undefined.
    isShown = isShown && left > -float(side) && left < float(constants.width) && top > -float(side) &&
              top < float(constants.height);
    if (!isShown) return;
    ivec2 corner = ivec2(left, top);
    if (IS_SPLATS != 0u) {
        drawCircle(own, corner, seen, colour);
        return;
    }
    if (side == 1)
        put(own.eye, corner.y * constants.width + corner.x,
            packUint2x32(keyOfPoint(seen.z, colour, own.levelAndClass, corner, seen.xy)));
    else
        drawSquare(own, corner, seen, colour);
}

void main()
{
    PairDraw pair = pairs[constants.firstDraw + gl_WorkGroupID.x];
    bool drawsLeft = pair.left != kNoDraw, drawsRight = pair.right != kNoDraw;
    TileDraw left = leftDraws[drawsLeft ? pair.left : 0u], right = rightDraws[drawsRight ? pair.right : 0u];
    TileDraw tile = left; // what both have in common
    if (!drawsLeft) tile = right;
    bool isLeftByDetail = drawsLeft && isByDetail(left), isRightByDetail = drawsRight && isByDetail(right);
    EyeDraw toLeft = eyeDrawOf(kLeft, left, pair.leftRows), toRight = eyeDrawOf(kRight, right, pair.rightRows);
    for (uint i = gl_LocalInvocationID.x; i < tile.span.z; i += gl_WorkGroupSize.x) {
        uvec2 vertex = texelFetch(vertices, int(tile.span.y + i)).xy;
        vec3 at = placeInTile(tile, vertex.x), chances = vec3(0.0f);
        if (isLeftByDetail || isRightByDetail) {
            uvec2 place = columnAndRowOf(tile, vertex.x);
            chances = chancesOf(tile, place.x, place.y);
        }
        if (drawsLeft) drawSample(toLeft, at, chances, vertex.y);
        if (drawsRight) drawSample(toRight, at, chances, vertex.y);
    }
}
