#ifndef RENDER_SHADERS_SHARED_LANGUAGE_H
#define RENDER_SHADERS_SHARED_LANGUAGE_H
// What GLSL and C++ need so that both can read the headers of this folder. In C++ the vector types are GLM's.
//
// PRECISE forbids fused multiply-adds: the same sum must round alike in both languages, in neighbouring
// triangles and in neighbouring tiles (C++ is compiled with -ffp-contract=off).

#ifdef __cplusplus
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/integer.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <cstdint>

#define SHARED_BEGIN namespace render {
#define SHARED_END }
#define SHARED_FUNCTION inline
#define SHARED_CONSTANT inline constexpr
#define PRECISE

namespace render {
using uint = std::uint32_t;
using glm::abs, glm::clamp, glm::floor, glm::ceil, glm::max, glm::min, glm::floatBitsToUint, glm::uintBitsToFloat;
using glm::findLSB, glm::findMSB;
using glm::ivec2, glm::vec2, glm::vec3, glm::vec4, glm::uvec2, glm::uvec4;
using glm::mat4;
using glm::sqrt, glm::mix, glm::pow;
} // namespace render
#else
#define SHARED_BEGIN
#define SHARED_END
#define SHARED_FUNCTION
#define SHARED_CONSTANT const
#define PRECISE precise
#endif

#endif
