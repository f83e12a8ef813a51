// The frame of the deferred renderer: the data that its passes share. submit/frame_passes.h adds them to a graph.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "graph/graph.h"
#include "render/base/constant_ids.h"
#include "render/base/pass.h"
#include "render/gbuffer/layout.h"
#include "render/gpu_scene/gpu_environment.h"
#include "render/gpu_scene/gpu_scene.h"
#include "shared/environment.h"
#include "shared/types.h"

namespace latelight::render {

class HardwareVisibility;
class ComputeVisibility;
using Visibility = std::variant<HardwareVisibility, ComputeVisibility>;  // visibility/visibility.h
struct LensRays;
struct TechniqueInfo;
class FrameHistory;
class FrameShadows;
class PlacedShadows;
enum class ShadowMapState : uint8_t;  // shadow/frame_shadows.h
struct Overflow;
struct SurfaceOutputs;

// How blended surfaces are rendered (render/transparency).
struct TransparencySetup {
  uint32_t method = 0;      // kTransparency*
  bool everyLight = false;  // reference: loop over all lights instead of traversing the light tree
  uint64_t most = 0;        // limit on the fragments that `exact` stores; 0: the device's limit
  bool operator==(const TransparencySetup&) const = default;
};

// The settings of a frame for which its shaders are specialized (specialization constants).
struct FrameConfig {
  const Layout* layout = nullptr;
  uint32_t normalEncoding = 0;  // kNormal_*
  const TechniqueInfo* lighting = nullptr;
  uint32_t shading = 0;                     // kShading*
  uint32_t normalSpace = 0;                 // kNormalSpace*
  uint32_t positionMethod = 0;              // kPosition*
  uint32_t volumesOrder = 0;                // kVolumes*, for the technique `volumes`
  uint32_t targets = ~0u;                   // bit i: the layout's target i is required
  const SurfaceOutputs* outputs = nullptr;  // packed in addition to the targets
  bool countLights = false;
  uint32_t ambientOcclusion = 0;     // kAo*
  uint32_t textureSlots = ~0u;       // bit i: a material may have a texture in slot i (GpuMaterials::textureSlots)
  uint32_t codedTextureSlots = ~0u;  // bit i: such a texture may be coded in sRGB
  uint32_t traits = 0;               // kTrait*: all materials or meshes have these traits (GpuScene::traits)
  uint32_t layers = 0;               // kLayer*: coats that a material may have (GpuMaterials::layers)
  bool lights = true;                // lights may exist; false: shaders of the deferred techniques have no light loops
  bool culledLights = true;          // light lists are faster than shading pixels with all local lights
  bool fewLights = false;            // on a CPU device, a loop over all lights is faster than light culling
  uint32_t areaLights = 0;           // kAreaLights*
  uint32_t environment = shared::kEnvironmentOneType;  // kEnvironment*
  bool vast = false;                                   // some triangles are vast (GpuInstances::anyVast)
  bool fog = false;                                    // the constants define fog
  TransparencySetup transparency;
  uint32_t shadowFormat = 0;     // kShadow*
  uint32_t shadowFilter = 0;     // kShadowFilter*
  bool lens = false;             // pixels use the rays of FrameConstants::rays
  bool sunInGbuffer = false;     // the layout's sunTarget holds the sun's shadow, which lighting reads there
  uint32_t samples = 1;          // per pixel: a power of two up to shared::kMaxSamples
  bool sampleLayers = false;     // several samples are array layers; false: images are multisampled
  uint32_t areaShadowRays = 0;   // per surface and area light, for shadows; 0: area lights cast none
  bool rayShadows = false;       // rays find the shadows of lights; shadowFormat is then 0
  uint32_t indirect = 0;         // kIndirect*: light between surfaces, by rays
  uint32_t paths = 16;           // number of them per surface of a pixel
  bool filtersIndirect = false;  // a spatial filter replaces noise by bias
  bool ground = false;           // a plane receives shadows (FrameContext::groundHeight)
  bool everySample = false;      // reference: every sample is shaded, even if they are alike

  // Returns the specialization constants of every shader that includes render/glsl/setup.glsl.
  std::vector<vk::Constant> constants() const;
  // Returns the variant of a shader that reads or writes targets of the samples.
  vk::ShaderKey variant(vk::ShaderKey shader) const {
    using Samples = vk::ShaderKey::Samples;
    shader.samples = samples == 1 ? Samples::One : sampleLayers ? Samples::SampleLayers : Samples::Multisampled;
    return shader;
  }
};

// Usage of a buffer of views: shaders read it by address, and draws bind it as a vertex buffer.
inline constexpr VkBufferUsageFlags kViewUsage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT;

// A frame under construction: one scene seen from V views, each of which is an array layer of every target. Passes
// capture copies. The objects that it refers to live until the graph has been submitted.
struct FrameContext : Builder {
  const GpuScene& scene;
  const GpuEnvironment& environment;
  const Visibility& visibility;
  FrameConfig setup;
  std::span<const shared::View> views;  // as in the device's constants
  VkDeviceAddress constants;            // shared::FrameConstants; with worlds, one per view
  VkBuffer viewBuffer;                  // their View[], for draws
  uint32_t width, height;
  bool environmentBackground = false;            // draw the environment behind all surfaces
  float aoRadius = 0, aoStrength = 1;            // ambient occlusion: meters, exponent
  const FrameShadows* shadows = nullptr;         // null: no light casts shadows
  ShadowMapState shadowState{};                  // of the maps before this frame
  const PlacedShadows* placedShadows = nullptr;  // instead of `shadows`, if shaders fit the maps
  // The constants without the lights whose shadows rays find, which a pass after the lighting technique adds; 0: the
  // lighting technique adds all lights.
  VkDeviceAddress otherConstants = 0;
  const FrameShadows* omitted = nullptr;    // for the technique: FrameShadows::omits() these lights
  uint32_t emitters = 0;                    // RayScene::emitterCount: triangles that paths sample
  float groundHeight = 0;                   // along Z of the device's world space
  const LensRays* lens = nullptr;           // null: all views are projections
  FrameHistory* indirectHistory = nullptr;  // of filtered indirect light, which the frame advances; null: there is none
  Overflow* overflow = nullptr;             // buffers whose size passes have to estimate; null: there are none

  VkDeviceAddress constantsOf(uint32_t view) const {
    return constants + (worlds ? view * sizeof(shared::FrameConstants) : 0);
  }
  std::span<const shared::Light> lightsOf(uint32_t view) const { return scene.lightsOf(views[view].world).lights; }
  uint32_t viewCount() const { return static_cast<uint32_t>(views.size()); }
  glm::uvec3 pixels() const { return {width, height, viewCount()}; }  // the size of a dispatch over all views
};

// Creates an image of the frame's size with an array layer per view. Several samples per pixel are array layers or a
// multisampled image, as FrameConfig::sampleLayers states.
graph::ImageId createTarget(const FrameContext& f, VkFormat format, const std::string& name, uint32_t samples = 1);

// The visible surface of each sample, as the depth pass found it.
struct VisibilityBuffer {
  // Reversed device depth, 0 for the background: per pixel, and per sample in the form that the frame's visibility
  // uses. With one sample per pixel, they are the same image. `samples` is null if `ids` holds the samples' depths.
  graph::ImageId pixels, samples;
  // With the raster compute only: depth and triangle id per sample, the instances that the ids refer to
  // (shared::InstanceList), and the depth pyramid (HZB) of occlusion culling, null without it.
  graph::BufferId ids{};
  VkDeviceAddress instances = 0;
  graph::BufferId pyramid{};
  // With the raster hardware only, and null unless addVisibility() draws them at once: the visible triangles
  // (addTriangles()).
  graph::ImageId triangles{};
  // The tiles of `pixels` with surfaces (frame/covered_tiles.h); null with several samples per pixel, and on a GPU.
  graph::BufferId covered{};
};

// The light lists of a lighting technique, per tile or per slice of a tile (clustered light culling).
struct LightLists {
  graph::BufferId cells, entries;                 // null: all local lights are in each list
  uint32_t cellsPerTile = 0, entriesPerTile = 0;  // lists and capacity per tile; 0: the frame has no lights
  glm::uvec2 tiles{};
};

// A G-buffer under construction: the layout's targets, and depth and light, which every layout has.
struct Gbuffer {
  VisibilityBuffer visible;  // what the targets are resolved from
  std::vector<graph::ImageId> targets;
  graph::ImageId depth;
  graph::ImageId light;  // emitted radiance and ambient occlusion; the lighting technique writes the lit picture here
  graph::ImageId lightCounts;       // lights tested and used (kCountsFormat); one texel if they are not counted
  graph::ImageId shadows;           // the shadow atlas; none if no light casts shadows
  graph::ImageId ambientOcclusion;  // visible share of the hemisphere; none if the setup disables it
  // With several samples per pixel, the targets and these two images store every sample; `depth` and `light` store one
  // value per pixel, so that passes after lighting do not depend on the number of samples. With one sample they are the
  // same images.
  graph::ImageId sampleDepth, sampleLight;
  graph::ImageId behind;    // background of transmissive surfaces (layered/behind.h); none: there are no such surfaces
  graph::ImageId surfaces;  // samples of each surface in a pixel (kSurfacesFormat); none with one sample, or no targets
  bool forLighting = false;  // only lighting reads the targets, and it leaves surfaces with coats to render/layered
  bool onlyCovered = false;  // nothing reads the targets outside of visible.covered
  // Tiles outside of which `light` is 0 and remains 0; null: unknown.
  graph::BufferId covered{};
  LightLists lightLists;  // of the pixels' surfaces, after the lighting technique has built them
};
// Returns a G-buffer that has nothing but its depth.
Gbuffer gbufferOf(const VisibilityBuffer& visible);

inline constexpr VkFormat kCountsFormat = VK_FORMAT_R32G32B32A32_SFLOAT;  // r: lights tested, g: lights used

// Returns the targets that the geometry pass writes. Bit i: the layout's target i; the bit after the last: emitted
// light.
uint32_t writtenTargets(const FrameConfig& setup, const Gbuffer& gbuffer);

// Buffers whose required size only the device knows. After an overflow the picture is incomplete: the buffer grows, and
// the same graph is built and run again.
struct Overflow {
  uint64_t fragments = 0;    // capacity for blended fragments; 0: one per pixel
  uint32_t longestList = 0;  // longest per-pixel list, in fragments; a power of two
  // Capacities of the queues of the raster compute.
  uint32_t rasterWork = 0, clippedTriangles = 0, mediumTriangles = 0, largeTriangles = 0, tileEntries = 0;
  // Checks of the graph under construction, to be called after it has run. If something overflowed, the check increases
  // the capacity and returns true.
  using Check = std::function<bool(const graph::Submission& done)>;
  std::vector<Check> checks;
};

// Waits for the graph and returns true if anything in it overflowed.
bool overflowed(const std::vector<Overflow::Check>& checks, const graph::Submission& done);

}  // namespace latelight::render
