// Evaluates one portable function per row (y) for one set of arguments per column (x), in HLSL.
#define SH_HLSL
#include "shared/portable_cases.h"

static const uint kColumns = 4096;

[[vk::binding(0, 0)]] StructuredBuffer<PortableArguments> arguments;
[[vk::binding(1, 0)]] RWStructuredBuffer<float4> results;

[numthreads(64, 1, 1)] void main(uint3 id : SV_DispatchThreadID) {
  results[id.y * kColumns + id.x] = evaluatePortable(id.y, arguments[id.x]);
}
