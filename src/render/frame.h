// The frame: what its passes share, and the list of them (frame.cpp).
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "graph/graph.h"
#include "render/gbuffer/layout.h"
#include "render/gpu_environment.h"
#include "render/gpu_scene.h"
#include "render/pass.h"
#include "shared/types.h"

namespace latelight::render {

class Visibility;
struct LensRays;
struct TechniqueInfo;
struct FrameSetup;
struct FrameShadows;
struct Overflow;
struct SurfaceOutputs;

// Usage of a buffer of views: shaders read it by address, and draws as a vertex buffer.
inline constexpr VkBufferUsageFlags kViewUsage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT;

// A frame being built: one scene seen by V views, each a layer of every target. Passes refer to it until their graph
// has been submitted.
struct FrameContext : Builder {
  const GpuScene& scene;
  const GpuEnvironment& environment;
  const Visibility& visibility;
  const FrameSetup& setup;
  std::span<const shared::View> views;  // as the device's constants have them
  VkDeviceAddress constants;            // shared::FrameConstants
  VkBuffer viewBuffer;                  // its View[], to draw with
  uint32_t width, height;
  std::span<const shared::Light> lights;  // those of the constants, on the host
  bool environmentBackground = false;     // draw the environment where nothing else is drawn
  float aoRadius = 0, aoStrength = 1;     // ambient occlusion: metres, exponent
  FrameShadows* shadows = nullptr;        // null: nothing casts any
  const LensRays* lens = nullptr;         // null: its views are projections
  Overflow* overflow = nullptr;           // buffers whose size passes have to guess; null where there are none

  uint32_t viewCount() const { return static_cast<uint32_t>(views.size()); }
  glm::uvec3 pixels() const { return {width, height, viewCount()}; }  // the size of a dispatch over all views
};

// An image as large as the frame, with a layer a view; of several samples a pixel as FrameSetup::sampleLayers has it.
graph::ImageId createTarget(const FrameContext& f, VkFormat format, const std::string& name, uint32_t samples = 1);

// Device depth, reversed, 0 where nothing is: of pixels, and of their samples in whatever form their visibility has
// them. With one sample they are the same image.
struct FrameDepth {
  graph::ImageId pixels, samples;
};

// What a lighting technique lists of its lights, by tile or by slices of tiles.
struct LightLists {
  graph::BufferId cells, entries;
  uint32_t cellsATile = 0, entriesATile = 0;  // 0: there are none
  glm::uvec2 tiles{};
};

// A G-buffer being built: the layout's targets, and the two that every layout has.
struct Gbuffer {
  std::vector<graph::ImageId> targets;
  graph::ImageId depth;
  graph::ImageId light;  // emitted radiance and ambient occlusion; the lighting technique leaves the lit picture here
  graph::ImageId lightCounts;       // lights tested and used (kCountsFormat); one texel where they are not counted
  graph::ImageId shadows;           // the atlas of shadow maps; none where nothing casts shadows
  graph::ImageId ambientOcclusion;  // visible share of the hemisphere; none where the setup has none
  // With several samples a pixel, the targets and these two have as many; `depth` and `light` keep one sample, so that
  // passes after lighting need not know. With one sample they are the same images.
  graph::ImageId sampleDepth, sampleLight;
  graph::ImageId behind;    // what transmissive surfaces show (layered/behind.h); none: there are none
  graph::ImageId surfaces;  // of pixels, by their samples (kSurfacesFormat); none with one sample, or no targets
  bool forLighting = false;  // nothing reads the targets but lighting, which leaves surfaces with layers to render/layered
  LightLists lightLists;    // of the pixels' surfaces, once the lighting technique has made them
};

// How blended surfaces are drawn (render/transparency).
struct TransparencySetup {
  uint32_t method = 0;      // kTransparency*
  bool everyLight = false;  // loop over all lights instead of walking the light tree: the reference
  uint64_t most = 0;        // limit on the fragments that `exact` keeps; 0: that of the device
  bool operator==(const TransparencySetup&) const = default;
};

// The settings of a frame for which its shaders are specialized.
struct FrameSetup {
  const Layout* layout = nullptr;
  uint32_t normalEncoding = 0;  // kNormal_*
  const TechniqueInfo* lighting = nullptr;
  uint32_t shading = 0;                     // kShading*
  uint32_t normalSpace = 0;                 // kNormalSpace*
  uint32_t positionMethod = 0;              // kPosition*
  uint32_t volumesOrder = 0;                // kVolumes*: of the technique `volumes`
  uint32_t targets = ~0u;                   // bit i: the layout's target i is wanted
  const SurfaceOutputs* outputs = nullptr;  // packed beside the targets; of visibility in compute
  bool countLights = false;
  uint32_t ambientOcclusion = 0;  // kAo*
  uint32_t textureSlots = ~0u;    // bit i: a material may have a texture in slot i (GpuScene::textureSlots)
  uint32_t layers = 0;            // kLayer*: what a material may have (GpuMaterials::layers)
  bool lights = true;             // there may be some; else shaders of the deferred techniques need not look for any
  bool fewLights = false;         // to go through all of them takes a CPU device less than to find those that are near
  bool environment = true;        // the renderer has one
  bool vast = false;              // some triangles are (GpuInstances::anyVast)
  bool fog = false;               // the constants have some
  TransparencySetup transparency;
  uint32_t shadowFormat = 0;  // kShadow*
  uint32_t shadowFilter = 0;  // kShadowFilter*
  bool lens = false;          // pixels look along FrameConstants::rays
  bool sunInGbuffer = false;  // the layout's sunTarget is filled, and lighting reads the sun's shadow there
  uint32_t samples = 1;       // a pixel: a power of two up to shared::kMostSamples
  bool sampleLayers = false;  // several are layers of images; else images are multisampled
  bool everySample = false;   // each is shaded, even if they are alike: the reference

  // Specialization constants of every shader that includes render/glsl/setup.glsl; a shader's own start at
  // kFirstOwnConstant.
  std::vector<vk::Constant> constants() const;
  // The form of a shader that reads or writes targets of the samples.
  std::string variant(const std::string& shader) const {
    return samples == 1 ? shader : shader + (sampleLayers ? "+layers" : "+msaa");
  }
};
// Of shaders with COATED alone, so that all others are the same for scenes with and without layers.
inline constexpr uint32_t kLayersConstant = 12;     // layered/surface_layers.glsl: FrameSetup::layers
inline constexpr uint32_t kLensConstant = 14;       // glsl/pixel_ray.glsl
inline constexpr uint32_t kElsewhereConstant = 15;  // glsl/lit_pixel.glsl
inline constexpr uint32_t kEnvironmentConstant = 90;  // glsl/setup.glsl
inline constexpr uint32_t kFewLightsConstant = 91;
inline constexpr uint32_t kVastConstant = 92;
inline constexpr uint32_t kSamplesConstant = 10;    // glsl/samples.glsl: not of a frame, since some passes have one
inline constexpr uint32_t kFirstOwnConstant = 16;
inline constexpr VkFormat kCountsFormat = VK_FORMAT_R32G32B32A32_SFLOAT;  // r: lights tested, g: lights used

// What the geometry pass writes: bit i: the layout's target i; the bit after the last: emitted light.
uint32_t writtenTargets(const FrameSetup& setup, const Gbuffer& gbuffer);

// Buffers whose required size is known only on the device. After an overflow the picture is incomplete: the buffer
// grows, and the same graph is built and run again.
struct Overflow {
  uint64_t fragments = 0;    // room for blended fragments; 0: one a pixel
  uint32_t longestList = 0;  // of one pixel's fragments, a power of two
  // Queues of the raster compute.
  uint32_t rasterWork = 0, clippedTriangles = 0, mediumTriangles = 0, largeTriangles = 0, tileEntries = 0;
  // Checks of the graph being built, to be called after it has run. Each returns true if something overflowed, after
  // making room for it.
  using Check = std::function<bool(const graph::Submission& done)>;
  std::vector<Check> checks;
};

// Whether anything in the graph overflowed; waits for the graph.
bool overflowed(const std::vector<Overflow::Check>& checks, const graph::Submission& done);

// The outputs of a frame.
struct LitFrame {
  graph::ImageId picture;      // linear radiance times exposure, premultiplied; alpha 1 where something is drawn
  graph::ImageId lightCounts;  // as Gbuffer::lightCounts
  Gbuffer gbuffer;             // no targets where the technique is a forward one
};

// Adds the passes of a frame.
LitFrame addFrame(const FrameContext& f);
// The same without blended surfaces, which are in no G-buffer and in no count.
LitFrame addOpaque(const FrameContext& f);
// The same with existing depth.
LitFrame addLit(const FrameContext& f, const FrameDepth& depth);

}  // namespace latelight::render
