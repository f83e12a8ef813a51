// Macros and functions with which one header compiles as GLSL, HLSL and C++. Use only what all three accept.
//
// Rules for every header in src/shared: no swizzles (name each component); vector constructors list every component
// (HLSL has no float3(x)); ternaries only on scalars; no samplers; no double or bool in structs; functions are SH_FUNC,
// constants SH_CONST, out parameters SH_OUT(T) and SH_INOUT(T), and parameters that a function does not use begin with
// SH_UNUSED, because C++ compilers warn of them. In C++ everything is in namespace latelight::shared.
#ifndef LATELIGHT_SHARED_LANG_H
#define LATELIGHT_SHARED_LANG_H

#if defined(__cplusplus)

#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

#define SH_BEGIN namespace latelight::shared {
#define SH_END }
#define SH_FUNC inline
#define SH_CONST inline constexpr
#define SH_OUT(T) T&
#define SH_INOUT(T) T&
#define SH_UNUSED [[maybe_unused]]

namespace latelight::shared {
using uint = uint32_t;
using glm::mat3;
using glm::mat4;
using glm::mat4x3;
using glm::uvec2;
using glm::uvec3;
using glm::uvec4;
using glm::vec2;
using glm::vec3;
using glm::vec4;

using glm::clamp;
using glm::cross;
using glm::dot;
using glm::exp2;
using glm::floor;
using glm::length;
using glm::log2;
using glm::max;
using glm::min;
using glm::mix;
using glm::normalize;
using glm::reflect;
using glm::smoothstep;
using std::abs;
using std::acos;
using std::atan2;
using std::cos;
using std::exp;
using std::pow;
using std::sin;
using std::sqrt;

inline float saturate(float x) {
  return clamp(x, 0.0f, 1.0f);
}
inline float inversesqrt(float x) {
  return 1.0f / std::sqrt(x);
}
inline float fract(float x) {
  return x - std::floor(x);
}
inline float sign(float x) {
  return x > 0.0f ? 1.0f : (x < 0.0f ? -1.0f : 0.0f);
}
inline uint floatBitsToUint(float x) {
  return std::bit_cast<uint>(x);
}
inline float uintBitsToFloat(uint x) {
  return std::bit_cast<float>(x);
}
}  // namespace latelight::shared

#elif defined(__HLSL_VERSION) || defined(SH_HLSL)

#define SH_BEGIN
#define SH_END
#define SH_FUNC
#define SH_CONST static const
#define SH_OUT(T) out T
#define SH_INOUT(T) inout T
#define SH_UNUSED
#define vec2 float2
#define vec3 float3
#define vec4 float4
#define uvec2 uint2
#define uvec3 uint3
#define uvec4 uint4
#define mat3 float3x3
#define mat4 float4x4
#define mat4x3 float3x4  // HLSL states the number of rows first
#define uint64_t uint2   // glslang's HLSL has no 64-bit integers; these hold only buffer addresses
#define mix lerp
#define fract frac
#define inversesqrt rsqrt
#define floatBitsToUint asuint
#define uintBitsToFloat asfloat

#else  // GLSL

#define SH_BEGIN
#define SH_END
#define SH_FUNC
#define SH_CONST const
#define SH_OUT(T) out T
#define SH_INOUT(T) inout T
#define SH_UNUSED
#define saturate(x) clamp(x, 0.0, 1.0)
#define atan2(y, x) atan(y, x)

#endif

SH_BEGIN
SH_CONST float kPi = 3.14159265358979f;
SH_CONST float kInvPi = 0.318309886183791f;
SH_END

#endif
