#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the FrameConstants of each view of a frame: those of world 0, with the addresses and values of the view's own
// world.
#include "render/glsl/common.glsl"
#include "render/gpu_scene/view_constants_push.h"

layout(local_size_x = kConstantsGroup) in;

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer ConstantsRef {
  ViewConstants v;
};
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ValuesRef {
  WorldValues v[];
};
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ExposuresRef {
  float v[];
};
layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer FramesOut {
  FrameConstants v[];
};

layout(push_constant, scalar) uniform Push {
  ViewConstantsPush push;
};

void main() {
  ViewConstants job = ConstantsRef(push.constants).v;
  uint view = gl_GlobalInvocationID.x;
  if (view >= job.views) return;
  uint world = (job.firstView + view) / job.viewsPerWorld;
  FrameConstants frame = job.frame;
  uint64_t instances = uint64_t(world) * job.instanceStride;
  frame.instances += instances;
  frame.previousInstances += instances;
  frame.nextInstances += instances;
  frame.rasterInstances += uint64_t(world) * job.rasterStride;
  frame.rayScene += uint64_t(world) * job.rayStride;
  frame.shadowMaps += uint64_t(world) * job.shadowStride;
  frame.shadowBits += uint64_t(world) * job.shadowBitsStride;
  if (job.exposures != 0ul) frame.exposure = ExposuresRef(job.exposures).v[view];
  if (job.has != 0u) {
    WorldValues values = ValuesRef(job.values).v[world];
    if ((job.has & kWorldHasLights) != 0u) {
      frame.lights += uint64_t(world) * job.lightStride;
      frame.lightTree += uint64_t(world) * job.treeStride;
      frame.lightCount = values.lightCount;
      frame.directionalLights = values.directionalLights;
      frame.lightTreeLeaves = values.lightTreeLeaves;
      frame.areaLights += uint64_t(world) * job.areaStride;
      frame.areaLightCount = values.areaLightCount;
    }
    if ((job.has & kWorldHasIntensity) != 0u) frame.environmentIntensity = values.environmentIntensity;
    if ((job.has & kWorldHasEnvironment) != 0u) frame.environmentMap = values.environmentMap;
    if ((job.has & kWorldHasRotation) != 0u) {
      frame.environmentCos = values.environmentCos;
      frame.environmentSin = values.environmentSin;
    }
  }
  FramesOut(job.result).v[view] = frame;
}
