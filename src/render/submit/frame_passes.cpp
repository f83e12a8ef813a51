// Deferred shading: adds the passes of a frame to the graph, in this order: depth, G-buffer, shadow maps, ambient
// occlusion, lighting, layered materials, ground, background and fog.
#include "render/submit/frame_passes.h"

#include <utility>

#include "base/error.h"
#include "render/layered/layered.h"
#include "render/lighting/reference/paths.h"
#include "render/lighting/technique.h"
#include "render/post/ambient_occlusion/ambient_occlusion.h"
#include "render/post/background.h"
#include "render/post/fog/fog.h"
#include "render/post/ground/ground.h"
#include "render/shadow/area_shadows.h"
#include "render/shadow/frame_shadows.h"
#include "render/shadow/pages.h"
#include "render/shadow/ray_shadows.h"
#include "render/shadow/sun_occlusion.h"
#include "render/visibility/visibility.h"

namespace latelight::render {

namespace {

// Creates one texel if lights are not counted, because shaders that can count require a bound image.
graph::ImageId createCounts(const FrameContext& f) {
  if (f.setup.countLights) return createTarget(f, kCountsFormat, "light counts");
  return f.graph.create(
      vk::ImageDesc{.format = kCountsFormat, .width = 1, .height = 1, .layers = 1, .name = "no light counts"});
}

// lavapipe silently ends a shader's loops after 65535 iterations in total. Each light that reaches a subgroup needs
// one, and up to two to find the light if a fragment shader has few active lanes. The remaining lights would be
// missing.
void rejectTooManyUnbounded(const FrameContext& f) {
  constexpr uint32_t kMax = 20'000;  // for one sample per pixel
  const uint32_t most = kMax / f.setup.samples, unbounded = f.scene.unboundedLights();
  if (f.device.isCpu() && unbounded > most)
    badUsage("a CPU device supports at most {} lights without a range, but the scene has {}", most, unbounded);
}

void rejectTooManyAreaLights(const FrameContext& f) {
  if (f.scene.areaLights() > shared::kMaxAreaLights)
    badUsage("at most {} area lights are supported, but the scene has {}: remove some, or use emissive surfaces",
             shared::kMaxAreaLights, f.scene.areaLights());
}

struct Shadows {
  graph::ImageId atlas;
  ShadowMapState state;  // after the frame
};

// Draws the shadow maps unless they are complete. Reads the G-buffer as it is at this point.
Shadows addShadows(const FrameContext& f, const Gbuffer& g) {
  if (f.placedShadows) return {addPlacedShadowMaps(f), f.shadowState};
  if (!f.shadows || f.shadows->tracesRays()) return {{}, f.shadowState};
  if (f.shadows->maps().empty() || f.shadowState == ShadowMapState::Complete)
    return {f.graph.import(f.shadows->atlas(), graph::Use::SampledCompute), f.shadowState};
  const bool keeps = f.shadows->keepsAtlas(f.shadowState);
  const graph::ImageId atlas =
      f.graph.import(f.shadows->atlas(), keeps ? std::optional(graph::Use::SampledCompute) : std::nullopt);
  f.graph.exports(atlas, graph::Use::SampledCompute);
  addShadowMaps(f, g, atlas);
  return {atlas, drawsPages(f) ? ShadowMapState::Paged : ShadowMapState::Complete};
}

// Returns true if all passes after the geometry pass write light only where surfaces are.
bool lightsSurfacesOnly(const FrameContext& f) {
  const FrameConfig& s = f.setup;
  const bool everywhere = f.environmentBackground || s.fog || s.ground || s.countLights;
  const bool traced = s.lighting->traces || s.indirect || s.rayShadows;
  return !everywhere && !traced;
}

// Returns the tiles outside of which the light target is 0 after the frame. The geometry pass clears it there if it
// writes it and has one sample per pixel.
graph::BufferId litTiles(const FrameContext& f, const Gbuffer& g) {
  const bool cleared = !f.setup.lighting->forward && f.setup.samples == 1 && !g.targets.empty();
  return cleared && lightsSurfacesOnly(f) ? g.visible.covered : graph::BufferId{};
}

// Paths add blended surfaces to the picture before the ground. The ground lies over fog, which lies over these
// surfaces, so with fog its shadows fall on them, too.
GroundOrder groundOrder(const FrameContext& f) {
  return tracesPaths(f.setup) && !f.setup.fog ? GroundOrder::UnderBlended : GroundOrder::OverPicture;
}

}  // namespace

LitFrame addOpaque(const FrameContext& f) {
  return addLit(f, addVisibility(f));
}

LitFrame addLit(const FrameContext& f, const VisibilityBuffer& visible) {
  rejectTooManyUnbounded(f);
  rejectTooManyAreaLights(f);
  const bool multisampled = f.setup.samples > 1;
  Gbuffer g = gbufferOf(visible);
  g.light = createTarget(f, kLightFormat, "light");
  g.sampleLight = multisampled ? createTarget(f, kLightFormat, "light of samples", f.setup.samples) : g.light;
  g.lightCounts = createCounts(f);
  g.forLighting = !f.setup.countLights && !f.setup.ambientOcclusion && !f.setup.sunInGbuffer;
  g.onlyCovered = g.forLighting && lightsSurfacesOnly(f);
  if (!f.setup.lighting->forward) g = addGbuffer(f, std::move(g));
  g.covered = litTiles(f, g);
  const Shadows shadows = addShadows(f, g);
  g.shadows = shadows.atlas;
  g.ambientOcclusion = addAmbientOcclusion(f, g);
  if (f.setup.sunInGbuffer) addSunOcclusion(f, g);
  const bool rayShadows = f.otherConstants && !f.setup.lighting->traces;  // paths find shadows themselves
  FrameContext others = f;
  if (rayShadows) others.constants = f.otherConstants, others.omitted = std::exchange(others.shadows, nullptr);
  g.lightLists = f.setup.lighting->add(others, g);
  if (rayShadows) addRayShadows(f, g);
  if (f.setup.areaShadowRays && !f.setup.indirect && !f.setup.lighting->traces) addAreaShadows(f, g);
  if (f.setup.indirect && !f.setup.lighting->traces) addIndirect(f, g);
  addLayered(f, g);
  const GroundOrder order = groundOrder(f);
  if (f.setup.ground && order == GroundOrder::UnderBlended) addGround(f, g, order);
  if (f.setup.fog && multisampled) addFogOfUncovered(f, g);
  if (f.environmentBackground) addBackground(f, g);
  if (f.setup.fog && !multisampled) addFog(f, g);
  if (f.setup.ground && order == GroundOrder::OverPicture) addGround(f, g, order);
  return {g.light, g.lightCounts, g, shadows.state};
}

}  // namespace latelight::render
