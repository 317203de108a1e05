#version 460
// A corner of a polygon, lit.
#extension GL_GOOGLE_include_directive : require

#include "render/shaders/shared/polygons.h"

layout(location = 0) in vec3 position;
layout(location = 1) in vec4 normal;
layout(location = 2) in vec2 texturePlace;
layout(location = 3) in vec4 colour;

layout(push_constant) uniform Constants { PolygonConstants constants; };

layout(location = 0) out vec2 outTexturePlace;
layout(location = 1) out vec3 outColour;

void main()
{
    gl_Position = constants.clipFromMesh * vec4(position, 1.0);
    outTexturePlace = texturePlace;
    float facingUp = dot(constants.upFromNormal.xyz, normal.xyz);
    outColour = colour.rgb * constants.colour.rgb * skyLight(clamp(facingUp, -1.0, 1.0));
}
