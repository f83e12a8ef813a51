#include "render/visibility/visibility.h"

#include "base/error.h"
#include "render/frame/covered_tiles.h"
#include "render/visibility/compute/compute.h"
#include "render/visibility/hardware.h"

namespace latelight::render {

VisibilityBuffer addVisibility(const FrameContext& f) {
  VisibilityBuffer visible =
      std::visit([&](const auto& technique) { return technique.addVisibility(f); }, f.visibility);
  if (f.setup.samples == 1) visible.covered = addCoveredTiles(f, visible.pixels);
  return visible;
}

Gbuffer addGbuffer(const FrameContext& f, Gbuffer gbuffer) {
  return std::visit([&](const auto& technique) { return technique.addGbuffer(f, std::move(gbuffer)); }, f.visibility);
}

graph::ImageId addMotion(const FrameContext& f, const VisibilityBuffer& visible, MotionUse use) {
  return std::visit([&](const auto& technique) { return technique.addMotion(f, visible, use); }, f.visibility);
}

graph::ImageId addTriangles(const FrameContext& f, const VisibilityBuffer& visible) {
  return std::visit([&](const auto& technique) { return technique.addTriangles(f, visible); }, f.visibility);
}

void addShadowMaps(const FrameContext& f, const Gbuffer& gbuffer, graph::ImageId atlas) {
  std::visit([&](const auto& technique) { technique.addShadowMaps(f, gbuffer, atlas); }, f.visibility);
}

graph::ImageId addPlacedShadowMaps(const FrameContext& f) {
  return std::get<ComputeVisibility>(f.visibility).addPlacedShadowMaps(f);
}

void addFragments(const FrameContext& f, const Gbuffer& gbuffer, const FragmentBuffers& buffers) {
  std::visit([&](const auto& technique) { technique.addFragments(f, gbuffer, buffers); }, f.visibility);
}

// The graphics pipeline lights fragments when it stores them.
void lightFragments(const FrameContext& f, const Gbuffer& gbuffer, const FragmentBuffers& buffers) {
  if (const auto* compute = std::get_if<ComputeVisibility>(&f.visibility)) compute->lightFragments(f, gbuffer, buffers);
}

bool anyBlended(const FrameContext& f) {
  return std::visit([](const auto& technique) { return technique.anyBlended(); }, f.visibility);
}

VisibleMaterials visibleMaterials(const FrameContext& f) {
  return std::visit([](const auto& technique) { return technique.materials(); }, f.visibility);
}

const HardwareVisibility& hardwareOf(const FrameContext& f, const char* user) {
  if (const auto* hardware = std::get_if<HardwareVisibility>(&f.visibility)) return *hardware;
  badUsage("{} uses the graphics pipeline: it requires the raster hardware", user);
}

void readVisibleSurfaces(const FrameContext& f, const VisibilityBuffer& visible, ComputePass& pass) {
  bindTextures(f, pass);
  pass.buffers.emplace_back(visible.ids, graph::Use::StorageRead);
}

shared::VisibleSurfacePush surfacePush(const VisibilityBuffer& visible, graph::Context& context) {
  if (!visible.ids || !context.declares(visible.ids)) return {};
  return {visible.instances, context.buffer(visible.ids).address()};
}

}  // namespace latelight::render
