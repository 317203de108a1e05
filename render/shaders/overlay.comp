#version 460
// Lines, letters and the dark rim over a resolved picture. One workgroup draws one bin; its invocations take the pixels
// in turns.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/overlay_draw.h"

layout(local_size_x_id = 0) in;

layout(std430, set = 0, binding = 2) buffer Colours { uint colours[]; };
layout(std430, set = 0, binding = 3) readonly buffer Depths { float depths[]; };
layout(std430, set = 1, binding = 0) readonly buffer Strokes { OverlayStroke strokes[]; };
layout(std430, set = 1, binding = 1) readonly buffer Entries { uint entries[]; };
layout(std430, set = 1, binding = 2) readonly buffer Bins { OverlayBin bins[]; };
layout(push_constant) uniform Constants { OverlayConstants constants; };

void main()
{
    OverlayBin bin = bins[constants.firstBin + gl_WorkGroupID.x];
    uint left = (bin.place & 0xffffu) * kBinSide, top = (bin.place >> 16) * kBinSide;
    for (uint i = gl_LocalInvocationID.x; i < kBinSide * kBinSide; i += gl_WorkGroupSize.x) {
        uint x = left + i % kBinSide, y = top + i / kBinSide;
        if (x >= uint(constants.width) || y >= uint(constants.height)) continue;
        uint pixel = y * uint(constants.width) + x;
        vec2 centre = vec2(float(x) + 0.5f, float(y) + 0.5f);
        uint was = colours[pixel];
        float depth = depths[pixel];
        float surfaceDisparity = depth > 0.0f ? 1.0f / depth : 0.0f;
        vec3 colour = colourOf(was);
        for (uint entry = bin.first; entry < bin.first + bin.count; ++entry) {
            OverlayStroke stroke = strokes[entries[entry]];
            colour = mix(colour, colourOf(stroke.colour), shareOfStroke(stroke, centre, surfaceDisparity));
        }
        colour *= lightAt(constants, centre);
        colours[pixel] = packColour(colour) | (was & 0xff000000u);
    }
}
