#version 460
// Fills the holes on a row's list (list_holes.comp): side by side, though they lie far apart. One workgroup fills those of
// a row, or several do.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/hole_fill.h"
#include "render/shaders/shared/hole_words.h"
#include "render/shaders/shared/tile_draw.h"
#include "render/shaders/shared/z_key.h"

layout(local_size_x_id = 0) in;

layout(std430, set = 0, binding = 2) writeonly buffer Colours { uint colours[]; };
layout(std430, set = 0, binding = 3) writeonly buffer Depths { float depths[]; };
layout(set = 0, binding = 4) uniform usamplerBuffer zTexels;
layout(std430, set = 0, binding = 5) readonly buffer Holes { uint holes[]; };
layout(push_constant) uniform Constants { ResolveConstants constants; };

uvec2 keyAt(ivec2 pixel)
{
    bool isInside = pixel.x >= 0 && pixel.y >= 0 && pixel.x < constants.width && pixel.y < constants.height;
    return isInside ? texelFetch(zTexels, pixel.y * constants.width + pixel.x).xy : uvec2(0u);
}

void main()
{
    int y = int(gl_WorkGroupID.y), row = y * constants.width;
    int count = int(holes[holeCountAt(constants.width, constants.height, y)]);
    int columns = holeColumnsAt(constants.width, constants.height, y);
    int invocations = int(gl_WorkGroupSize.x * gl_NumWorkGroups.x);
    for (int i = int(gl_GlobalInvocationID.x); i < count; i += invocations) {
        int x = int(holes[columns + i]);
        uvec2 own = texelFetch(zTexels, row + x).xy, key = filled(ivec2(x, y), own, constants.fill);
        if (key == own) key = filledAtRim(ivec2(x, y), ivec2(constants.width, constants.height), own);
        if (key == own) continue; // resolve's colour, which may be interpolated, stays
        colours[row + x] = colourAndClassOf(key);
        depths[row + x] = depthOf(key);
    }
}
