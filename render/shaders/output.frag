#version 460
// A pixel of a finished eye, for somebody else's images of colour and depth. Beyond the picture its last row and column
// go on.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/eye_output.h"
#include "render/shaders/shared/srgb.h"

layout(constant_id = 0) const uint IS_SRGB = 0u;
layout(constant_id = 1) const uint HAS_DEPTH = 0u;

layout(std430, set = 0, binding = 0) readonly buffer Colours { uint colours[]; };
layout(std430, set = 0, binding = 1) readonly buffer Depths { float depths[]; };
layout(push_constant) uniform Constants { EyeOutputConstants constants; };

layout(location = 0) out vec4 colour;

void main()
{
    ivec2 pixel = min(ivec2(gl_FragCoord.xy), ivec2(constants.width, constants.height) - 1);
    int at = pixel.y * constants.width + pixel.x;
    colour = unpackUnorm4x8(colours[at]);
    if (IS_SRGB != 0u)
        colour.rgb = vec3(decodedChannel(colour.r), decodedChannel(colour.g), decodedChannel(colour.b));
    gl_FragDepth = HAS_DEPTH != 0u ? nearOverDepth(constants.nearMetres, depths[at]) : 0.0;
}
