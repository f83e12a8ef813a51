// The frame: what its passes share, and the list of them (frame.cpp).
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "graph/graph.h"
#include "render/gbuffer/layout.h"
#include "render/gpu_environment.h"
#include "render/gpu_scene.h"
#include "shared/types.h"

namespace latelight::render {

class DepthPass;
class GeometryPass;
class LightingTechnique;
struct TechniqueInfo;
class BackgroundPass;
class AmbientOcclusionPass;
class FogPass;
class Transparency;
class ShadowPass;
class SunOcclusionPass;
struct ShadowMaps;
class SampleSurfacesPass;
class PixelDepthPass;

// What a frame draws: one scene seen by V views, each a layer of every target.
struct FrameInputs {
  const GpuScene& scene;
  const GpuEnvironment& environment;
  std::span<const shared::View> views;  // as the device's constants have them
  VkDeviceAddress constants;            // shared::FrameConstants
  uint32_t width, height;
  bool environmentBackground = false;  // draw the environment where nothing else is
  bool blendedToo = false;  // what is blended is a surface like any other where its alpha is above 0: for data outputs
  std::span<const shared::Light> lights;  // those of the constants, on the host

  float aoRadius = 0, aoStrength = 1;  // ambient occlusion: metres, exponent
  ShadowMaps* shadows = nullptr;       // null: nothing casts any. Fitted to a view: there is one view then
  bool atCentres = false;              // pixels have one sample, at their centre: what holds none is not drawn
};

// An image as large as the frame, with a layer a view.
graph::ImageId createTarget(graph::Graph& graph, const FrameInputs& inputs, VkFormat format, const std::string& name,
                            uint32_t samples = 1);

// A G-buffer being built: the layout's targets, and the two that every layout has.
struct Gbuffer {
  std::vector<graph::ImageId> targets;
  graph::ImageId depth;
  graph::ImageId light;  // emitted radiance and ambient occlusion; the lighting technique leaves the lit picture here
  graph::ImageId lightCounts;       // lights tested and used (kCountsFormat); one texel where they are not counted
  graph::ImageId shadows;           // the atlas of shadow maps; none where nothing casts shadows
  graph::ImageId ambientOcclusion;  // visible share of the hemisphere; one texel, 1, where there is none
  // With several samples a pixel the targets have them, and these two, which the geometry pass draws to; `depth` and
  // `light` keep one a pixel, so that what comes after lighting need not know. With one sample they are the same
  // images.
  graph::ImageId sampleDepth, sampleLight;
  graph::ImageId surfaces;  // of pixels, by their samples (kSurfacesFormat); none with one sample, or no targets
};

// How blended surfaces are drawn (render/transparency).
struct TransparencySetup {
  uint32_t method = 0;      // kTransparency*
  bool everyLight = false;  // go through all lights, not through those that the light tree has near: the reference
  uint64_t fragments = 0;   // that `exact` has room for at first; 0: one a pixel
  uint64_t most = 0;        // fragments that it may keep; 0: as many as the device takes
  bool operator==(const TransparencySetup&) const = default;
};

// The form of a shader that draws to or reads targets of several samples a pixel.
inline std::string shaderVariant(const std::string& shader, uint32_t samples) {
  return samples > 1 ? shader + "+msaa" : shader;
}

// What pipelines are made for. What does not matter to a setup is left at its default, so that setups that are drawn
// alike are equal.
struct FrameSetup {
  const Layout* layout = nullptr;
  uint32_t normalEncoding = 0;  // kNormal_*
  const TechniqueInfo* lighting = nullptr;
  uint32_t shading = 0;         // kShading*
  uint32_t normalSpace = 0;     // kNormalSpace*
  uint32_t positionMethod = 0;  // kPosition*
  uint32_t volumesOrder = 0;    // kVolumes*: of the technique `volumes`
  bool countLights = false;
  uint32_t ambientOcclusion = 0;  // kAo*
  uint32_t textureSlots = ~0u;    // bit i: a material may have a texture in slot i (GpuScene::textureSlots)
  bool fog = false;               // the constants have some
  TransparencySetup transparency;
  uint32_t shadowFormat = 0;  // kShadow*
  uint32_t shadowFilter = 0;  // kShadowFilter*
  bool sunInGbuffer = false;  // the layout's sunTarget is filled, and lighting reads the sun's shadow there
  uint32_t samples = 1;       // a pixel: 1 or 4
  bool everySample = false;   // each is shaded, alike or not: the reference
  bool operator==(const FrameSetup&) const = default;

  // Of every shader that includes render/glsl/setup.glsl; a shader's own start at kFirstOwnConstant.
  std::vector<vk::Constant> constants() const;
  std::string variant(const std::string& shader) const { return shaderVariant(shader, samples); }
};
inline constexpr uint32_t kFirstOwnConstant = 16;
inline constexpr VkFormat kCountsFormat = VK_FORMAT_R32G32B32A32_SFLOAT;  // r: lights tested, g: lights used

// What leaves a frame.
struct LitFrame {
  graph::ImageId picture;      // linear radiance times exposure, premultiplied; alpha 1 where something is drawn
  graph::ImageId lightCounts;  // as Gbuffer::lightCounts
  Gbuffer gbuffer;             // no targets where the technique is a forward one
};

// The pipelines of a setup, and the passes they run.
class Frame {
 public:
  Frame(vk::Device& device, const GpuScene& scene, const FrameSetup& setup);
  ~Frame();
  // Adds the frame's passes.
  LitFrame add(graph::Graph& graph, const FrameInputs& inputs) const;
  // The same but for blended surfaces, which are in no G-buffer and in no count.
  LitFrame addOpaque(graph::Graph& graph, const FrameInputs& inputs) const;
  // After a run of the graph that add() filled last: whether the picture lacks something that memory had no room for.
  // The frame has made room; the same has to be added and run again.
  bool outgrown(const graph::Executor& done) const;

 private:
  FrameSetup setup_;
  bool onCpu_;
  std::unique_ptr<DepthPass> depth_;
  std::unique_ptr<PixelDepthPass> pixelDepth_;    // null with one sample
  std::unique_ptr<ShadowPass> shadows_;           // null where the setup has none
  std::unique_ptr<GeometryPass> geometry_;        // null for forward techniques
  std::unique_ptr<SampleSurfacesPass> surfaces_;  // null for forward techniques, and with one sample
  std::unique_ptr<AmbientOcclusionPass> ambientOcclusion_;
  std::unique_ptr<SunOcclusionPass> sun_;  // null where the layout has no channel for it
  std::unique_ptr<LightingTechnique> lighting_;
  std::unique_ptr<BackgroundPass> background_;
  std::unique_ptr<FogPass> fog_;                // null without fog
  std::unique_ptr<Transparency> transparency_;  // null where nothing is blended
};

}  // namespace latelight::render
