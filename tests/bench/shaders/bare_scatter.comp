#version 460
// The least that moving samples to a z-buffer can be: load a record, transform it, one atomic. What warps are measured by.
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require

layout(local_size_x_id = 0) in;

layout(std430, set = 0, binding = 0) readonly buffer Records { uvec4 records[]; }; // x, y, z as float; colour
layout(std430, set = 0, binding = 1) buffer ZBuffer { uint64_t zBuffer[]; };
layout(push_constant) uniform Constants { mat4 imageFromRecords; uint count, width, height; };

void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) return;
    uvec4 record = records[i];
    vec4 h = imageFromRecords * vec4(uintBitsToFloat(record.xyz), 1.0f);
    float inverse = 1.0f / h.z;
    float u = h.x * inverse, v = h.y * inverse;
    uint64_t key = packUint2x32(uvec2(record.w, floatBitsToUint(inverse)));
    if (h.z > 0.0f && u >= 0.0f && u < float(width) && v >= 0.0f && v < float(height))
        atomicMax(zBuffer[uint(v) * width + uint(u)], key);
}
