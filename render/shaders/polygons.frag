#version 460
// A pixel of a polygon: its texture's colour in its light; nothing where the texture is cut out.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/polygons.h"

layout(set = 0, binding = 0) uniform sampler2D colourTexture;
layout(set = 0, binding = 1) uniform sampler2D alphaTexture;

layout(push_constant) uniform Constants { PolygonConstants constants; };

layout(location = 0) in vec2 texturePlace;
layout(location = 1) in vec3 colour;

layout(location = 0) out vec4 outColour;

void main()
{
    vec3 textured = texture(colourTexture, texturePlace).rgb;
    if (texture(alphaTexture, texturePlace).a < constants.colour.a) discard;
    vec3 linear = colour * textured;
    outColour = vec4(encodedChannel(linear.r), encodedChannel(linear.g), encodedChannel(linear.b), 1.0);
}
