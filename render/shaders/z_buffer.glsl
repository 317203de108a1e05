// The z-buffer, for shaders that look at it before they draw.

layout(std430, set = 1, binding = 1) buffer ZBuffer { uint64_t zBuffer[]; };
layout(set = 1, binding = 4) uniform usamplerBuffer zTexels;

/// Whether something nearer stands at a pixel. Most of what covers several pixels is hidden already, and reading a texel
/// is cheaper than an atomic that changes nothing. What is read may be of a moment ago: then it is no greater than what
/// stands there, and nothing is lost. orderBits: of the key that would be drawn, so that what is rounded alike is not hidden.
bool isHidden(int at, uint orderBits)
{
    return texelFetch(zTexels, at).y > orderBits;
}
