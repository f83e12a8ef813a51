// Inputs and functions that the shaders of the instance level of worlds share.
#ifndef LATELIGHT_WORLD_BVH_GLSL
#define LATELIGHT_WORLD_BVH_GLSL
#include "render/glsl/common.glsl"
#include "render/gpu_scene/world_inputs_push.h"
#include "render/rays/worlds/world_bvh_push.h"

layout(local_size_x = kWorldBvhGroup) in;

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer JobRef { WorldBvhJob v; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer InstancesRef { Instance v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer ScenesRef { RayScene v[]; };

layout(push_constant, scalar) uniform Push { WorldBvhPush push; };

#endif
