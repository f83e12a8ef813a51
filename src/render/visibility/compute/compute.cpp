#include "render/visibility/compute/compute.h"

#include <algorithm>
#include <bit>
#include <map>

#include "base/error.h"
#include "render/base/pixel_group.h"
#include "render/base/readback.h"
#include "render/frame/covered_tiles.h"
#include "render/frame/lit_maps.h"
#include "render/gbuffer/layout.h"
#include "render/lens/lens_push.h"
#include "render/lens/lens_rays.h"
#include "render/outputs/pack_push.h"
#include "render/outputs/surface_outputs.h"
#include "render/shadow/frame_shadows.h"
#include "render/shadow/pages.h"
#include "render/shadow/placed_shadows.h"
#include "render/transparency/transparency.h"
#include "render/visibility/compute/visible_motion_push.h"
#include "render/visibility/rays/trace_visible.h"
#include "render/visibility/resolve.h"
#include "render/visibility/sample_surfaces.h"
#include "vk/features.h"

namespace latelight::render {

namespace {

using namespace shared;  // kRaster*, kQueue*
using Hit = vk::ShaderKey::Hit;

}  // namespace

std::string missingForComputeRaster(const vk::Device& device) {
  const vk::Features& has = device.features();
  if (!has.v12.shaderBufferInt64Atomics) return "it has no 64-bit atomics in buffers, which the raster compute takes";
  if (!has.core.features.shaderStorageImageWriteWithoutFormat)
    return "it has no storage images of any format, which the raster compute takes";
  return "";
}

ComputeVisibility::ComputeVisibility(const GpuScene& scene, const RasterInstances& rasterInstances,
                                     ClusterOcclusion& occluded, const VisibilityOptions& options)
    : scene_(scene),
      rasterInstances_(rasterInstances),
      clusterOcclusion_(occluded),
      occlusionHistory_(options.blendedToo  ? OcclusionHistory::WithBlended
                        : options.atCenters ? OcclusionHistory::Steady
                                            : OcclusionHistory::Jittered),
      share_(options.blendedToo ? rasterInstances.all() : rasterInstances.solid()),
      leavesOutBlended_(rasterInstances.mixesBlended() && !options.blendedToo),
      traced_(options.traced),
      blendedToo_(options.blendedToo) {}

// --- visible surfaces ------------------------------------------------------------------------------------------------

namespace {

// Returns a camera's pinhole view, from the pinhole view of a camera at the origin.
View posed(const View& pinhole, const View& camera) {
  View view = pinhole;
  for (int i = 0; i < 4; ++i) view.worldToView[i] = glm::mat3(pinhole.worldToView) * camera.worldToView[i];
  for (int i = 0; i < 3; ++i) view.viewToWorld[i] = glm::mat3(camera.viewToWorld) * pinhole.viewToWorld[i];
  view.viewToWorld[3] = view.eye = camera.eye;
  view.eyeLow = camera.eyeLow;
  view.world = camera.world;
  view.group = camera.group;
  return view;
}

}  // namespace

// Adds a pass over all pixels of the visibility buffer, or those of the `covered` tiles that the pass is restricted to.
// `outputs` is OutputSlot[] or empty.
void ComputeVisibility::addResolve(const FrameContext& f, const VisibilityBuffer& visible, ComputePass pass,
                                   graph::BufferId outputs, graph::BufferId covered) const {
  pass.size = f.pixels();
  pass.constants.push_back({kSamplesConstant, f.setup.samples});
  addVastConstant(f, pass);
  pass.buffers.emplace_back(visible.ids, graph::Use::StorageRead);
  if (outputs) pass.buffers.emplace_back(outputs, graph::Use::StorageRead);
  addCompute(f, std::move(pass), [=, frame = f.constants](graph::Context& context) {
    return ResolvePush{.frame = frame,
                       .instances = visible.instances,
                       .visible = context.buffer(visible.ids).address(),
                       .outputs = outputs ? context.buffer(outputs).address() : 0,
                       .covered = coveredAddress(covered, context)};
  });
}

// Returns the views to rasterize: the frame's, or for a lens the pinhole views that cover all of its rays.
RasterViews ComputeVisibility::viewsOf(const FrameContext& f) const {
  if (f.lens) return pinholeViews(f);
  return {.constants = f.constants,
          .width = f.width,
          .height = f.height,
          .count = f.viewCount(),
          .samples = f.setup.samples};
}

RasterViews ComputeVisibility::pinholeViews(const FrameContext& f) const {
  std::vector<View> views;
  for (const View& camera : f.views)
    for (const View& pinhole : f.lens->views) views.push_back(posed(pinhole, camera));
  const LensTarget target{.frame = f.constants,
                          .starts = f.lens->starts.address(),
                          .pixels = f.lens->pixels.address(),
                          .views = static_cast<uint32_t>(f.lens->views.size()),
                          .width = f.width};
  RasterViews pinholes = viewsOf(f, views);
  pinholes.lens = true;
  pinholes.within = f.graph.constants(std::as_bytes(std::span(&target, 1)));
  return pinholes;
}

RasterViews ComputeVisibility::viewsOf(const FrameContext& f, const std::vector<shared::View>& views) const {
  const VkDeviceAddress list = f.graph.constants(std::as_bytes(std::span(views)));
  std::vector<shared::FrameConstants> frames(f.worlds ? views.size() : 1);
  for (size_t i = 0; i < frames.size(); ++i) {
    shared::FrameConstants& frame = frames[i];
    scene_.describe(frame, views[i].world);
    if (f.worlds) frame.rasterInstances = rasterInstances_.address(views[i].world);
    frame.views = frame.previousViews = frame.nextViews = list;
    frame.viewCount = static_cast<uint32_t>(views.size());
  }
  return {.constants = f.graph.constants(std::as_bytes(std::span(frames))),
          .width = static_cast<uint32_t>(views.front().size.x),
          .height = static_cast<uint32_t>(views.front().size.y),
          .count = static_cast<uint32_t>(views.size())};
}

// Returns the visibility buffer of these views, without depth images. With two-pass occlusion culling, the early pass
// renders the clusters that were not occluded in the previous frame; the late pass tests all clusters against the depth
// pyramid (HZB) of the early pass, renders those that became visible and stores the new occlusion bits.
VisibilityBuffer ComputeVisibility::addVisible(const FrameContext& f, const RasterViews& views) const {
  const RasterQueues queues(f, views, share_);
  VisibilityBuffer visible{.ids = queues.visible, .instances = rasterInstances_.address()};
  addClear(f, graph::Stage::Visibility, "raster clear", {queues.visible});
  RasterChain whole{graph::Stage::Visibility, Hit::Opaque, 0, kDrawMasked};
  RasterChain cut{graph::Stage::Visibility, Hit::Masked, kDrawMasked, kDrawMasked};
  if (leavesOutBlended_) cut.flagMask |= kDrawBlended;
  if (views.lens) whole.hit = cut.hit = Hit::Lens;  // one shader for opaque and masked
  const bool some = share_.anyOpaque;
  if (some && views.cullsOccluded) {
    whole.occluded = clusterOcclusion_.addTo(f, occlusionHistory_, (share_.parts + 31) / 32 * views.count);
    whole.culls = kCullEarly;
    addRasterChain(f, rasterInstances_, share_, views, queues, whole);
    whole.pyramid = cut.pyramid = visible.pyramid = addPyramid(f, views, queues.visible);
    whole.culls = kCullLate;
    whole.counted = [&occluded = clusterOcclusion_, of = occlusionHistory_](const RasterCounters& counters) {
      occluded.keep(of, counters.work, counters.occluded);
    };
    cut.culls = kCullByPyramid;
  }
  if (some) addRasterChain(f, rasterInstances_, share_, views, queues, whole);
  if (share_.anyMasked) addRasterChain(f, rasterInstances_, share_, views, queues, cut);
  return visible;
}

// Returns the visibility buffer of the frame's views.
VisibilityBuffer ComputeVisibility::addFrameVisible(const FrameContext& f) const {
  if (traced_) return addTracedSurfaces(f, rasterInstances_, share_, blendedToo_);
  RasterViews views = viewsOf(f);
  if (!views.lens) {
    views.cullsOccluded = clusterOcclusion_.shouldCull(f.device, occlusionHistory_, share_.parts * views.count);
    if (!f.device.isCpu()) prepareOcclusionCulling(f, views);
  }
  return addVisible(f, views);
}

VisibilityBuffer ComputeVisibility::addVisibility(const FrameContext& f) const {
  VisibilityBuffer visible = addFrameVisible(f);
  visible.pixels = createTarget(f, VK_FORMAT_R32_SFLOAT, "depth");
  addResolve(f, visible,
             {.stage = graph::Stage::Visibility,
              .name = "depth",
              .shader = "visible_depth.comp",
              .bindings = Bindings(f.device).storage(visible.pixels, graph::Use::StorageWrite)});
  if (f.setup.samples == 1) visible.samples = visible.pixels;
  return visible;
}

// --- data outputs about rasterization --------------------------------------------------------------------------------

ComputeVisibility::RasterImages ComputeVisibility::addRasterImages(const FrameContext& f,
                                                                   const VisibilityBuffer& visible) const {
  const RasterImages images{createTarget(f, VK_FORMAT_R32G32B32A32_SFLOAT, "raster numbers"),
                            createTarget(f, VK_FORMAT_R32G32_SFLOAT, "raster classes")};
  addCompute(f,
             {.stage = graph::Stage::Geometry,
              .name = "raster classes",
              .shader = "visible_raster.comp",
              .bindings = Bindings(f.device)
                              .storage(images.numbers, graph::Use::StorageWrite)
                              .storage(images.classes, graph::Use::StorageWrite),
              .size = f.pixels(),
              .buffers = {{visible.ids, graph::Use::StorageRead}}},
             [visible, frame = f.constants, size = f.pixels()](graph::Context& context) {
               return RasterPush{.buffers = {.frame = frame,
                                             .instances = visible.instances,
                                             .visible = context.buffer(visible.ids).address()},
                                 .views = size.z,
                                 .width = size.x,
                                 .height = size.y};
             });
  return images;
}

graph::ImageId ComputeVisibility::addOverdraw(const FrameContext& f) const {
  const RasterViews views{f.constants, f.width, f.height, f.viewCount()};
  const RasterQueues queues(f, views, share_);
  addClear(f, graph::Stage::Geometry, "raster clear", {queues.visible});
  if (share_.count > 0)
    addRasterChain(f, rasterInstances_, share_, views, queues, {graph::Stage::Geometry, Hit::Overdraw, 0, 0});
  const graph::ImageId overdraw = createTarget(f, VK_FORMAT_R32_SFLOAT, "overdraw");
  addCompute(f,
             {.stage = graph::Stage::Geometry,
              .name = "overdraw",
              .shader = "visible_overdraw.comp",
              .bindings = Bindings(f.device).storage(overdraw, graph::Use::StorageWrite),
              .size = f.pixels(),
              .buffers = {{queues.visible, graph::Use::StorageRead}}},
             [visible = queues.visible](graph::Context& context) {
               return ResolvePush{.visible = context.buffer(visible).address()};
             });
  return overdraw;
}

// --- G-buffer and motion ---------------------------------------------------------------------------------------------

namespace {

// Makes resolve.comp pack the setup's outputs. Returns the buffer of their addresses.
graph::BufferId packOutputs(const FrameContext& f, ComputePass& pass) {
  const SurfaceOutputs& outputs = *f.setup.outputs;
  std::vector<graph::Access> places;
  for (size_t i = 0; i < outputs.places.size(); ++i) {
    pass.constants.push_back({outputConstant(i), outputs.bits[i]});
    places.emplace_back(outputs.places[i].buffer, outputs.places[i].use);
  }
  pass.buffers = places;
  return addSmallBuffer(f, graph::Stage::Geometry, "output places", sizeof(OutputSlot) * outputs.places.size(),
                        std::move(places), [places = outputs.places](graph::Context& context) {
                          std::vector<OutputSlot> addresses;
                          for (const ResultTarget& place : places)
                            addresses.push_back({place.address(context), place.viewBytes});
                          return addresses;
                        });
}

// Returns true if surfaces with coats, which are shaded separately, write only a marker to the G-buffer. With several
// samples per pixel they write everything, because the targets decide which samples show one surface.
bool shadesLayeredSeparately(const FrameContext& f, const Gbuffer& gbuffer) {
  const bool some = (visibleMaterials(f).solid & shared::kMaterialLayered) != 0;
  return some && gbuffer.forLighting && f.setup.samples == 1 && !f.setup.outputs;
}

}  // namespace

Gbuffer ComputeVisibility::addGbuffer(const FrameContext& f, Gbuffer gbuffer) const {
  const Layout& layout = *f.setup.layout;
  if (!layout.hasTargets()) return addTriangleSurfaces(f, std::move(gbuffer));
  if (gbuffer.visible.covered && resolvesByGroup(f)) {
    addGroupResolve(f, gbuffer, addTriangles(f, gbuffer.visible, gbuffer.visible.covered));
    return gbuffer;
  }
  const uint32_t written = createTargets(f, gbuffer);
  ComputePass pass =
      resolvePass(f, gbuffer, written, "resolve.comp", {graph::Use::StorageWrite, graph::Use::StorageWrite});
  pass.constants.push_back({kLayeredSeparatelyConstant, shadesLayeredSeparately(f, gbuffer) ? 1u : 0u});
  readsTextures(f, pass);
  const graph::BufferId outputs = f.setup.outputs ? packOutputs(f, pass) : graph::BufferId{};
  addResolve(f, gbuffer.visible, std::move(pass), outputs);
  return f.setup.samples > 1 ? addSurfaces(f, std::move(gbuffer)) : gbuffer;
}

// Adds the surfaces of multisampled pixels, and the depths at which they are lit.
Gbuffer ComputeVisibility::addSurfaces(const FrameContext& f, Gbuffer gbuffer) const {
  Bindings bindings(f.device);
  bindings.sampled(gbuffer.targets).sampled(gbuffer.depth).sampled(gbuffer.sampleLight);
  return addSurfacesBy(f, std::move(gbuffer), {"surfaces_of_triangles.comp", f.setup.layout->file},
                       std::move(bindings));
}

Gbuffer ComputeVisibility::addTriangleSurfaces(const FrameContext& f, Gbuffer gbuffer) const {
  if (f.setup.samples == 1) return gbuffer;
  return addSurfacesBy(f, std::move(gbuffer), "surfaces_are_triangles.comp", Bindings(f.device));
}

Gbuffer ComputeVisibility::addSurfacesBy(const FrameContext& f, Gbuffer gbuffer, vk::ShaderKey shader,
                                         Bindings bindings) const {
  gbuffer.sampleDepth = createTarget(f, VK_FORMAT_R32_SFLOAT, "depth of surfaces", f.setup.samples);
  gbuffer.surfaces = createSurfaces(f);
  bindings.storage(gbuffer.sampleDepth, graph::Use::StorageWrite).storage(gbuffer.surfaces, graph::Use::StorageWrite);
  addResolve(f, gbuffer.visible,
             {.stage = graph::Stage::Geometry,
              .name = "surfaces of samples",
              .shader = std::move(shader),
              .bindings = std::move(bindings),
              .constants = f.setup.constants()});
  return gbuffer;
}

graph::ImageId ComputeVisibility::addMotion(const FrameContext& f, const VisibilityBuffer& visible,
                                            MotionUse use) const {
  const graph::ImageId motion = createTarget(f, motionFormat(use), "motion");
  ComputePass pass{.stage = graph::Stage::Geometry,
                   .name = "motion",
                   .shader = "visible_motion.comp",
                   .bindings = Bindings(f.device).storage(motion, graph::Use::StorageWrite),
                   .size = f.pixels(),
                   .constants = {{kSamplesConstant, f.setup.samples},
                                 {kLensConstant, f.lens ? 1u : 0u},
                                 {kMotionOfSurfacesConstant, use == MotionUse::Surfaces ? 1u : 0u}}};
  addVastConstant(f, pass);
  pass.buffers.emplace_back(visible.ids, graph::Use::StorageRead);
  const VkDeviceAddress lenses = f.lens ? f.graph.constants(std::as_bytes(std::span(f.lens->lenses))) : 0;
  addCompute(f, std::move(pass), [=, frame = f.constants](graph::Context& context) {
    return VisibleMotionPush{.frame = frame,
                             .instances = visible.instances,
                             .visible = context.buffer(visible.ids).address(),
                             .lenses = lenses};
  });
  return motion;
}

graph::ImageId ComputeVisibility::addTriangles(const FrameContext& f, const VisibilityBuffer& visible) const {
  return addTriangles(f, visible, {});
}

// `covered`: the only tiles whose triangles are read.
graph::ImageId ComputeVisibility::addTriangles(const FrameContext& f, const VisibilityBuffer& visible,
                                               graph::BufferId covered) const {
  const graph::ImageId triangles = createTarget(f, VK_FORMAT_R32G32_UINT, "triangles");
  ComputePass pass{.stage = graph::Stage::Geometry,
                   .name = "triangles",
                   .shader = "visible_triangles.comp",
                   .bindings = Bindings(f.device).storage(triangles, graph::Use::StorageWrite),
                   .groupX = kPixelGroupX,
                   .groupY = kPixelGroupY};
  restrictTo(covered, pass);
  addResolve(f, visible, std::move(pass), {}, covered);
  return triangles;
}

// --- shadow maps -----------------------------------------------------------------------------------------------------

namespace {

// Depth range in meters along the map's axis.
struct ShadowDepths {
  float near, far;
};
ShadowDepths depthsOf(const shared::Projection& map) {
  const float range = 0.5f / map.A, near = -2 * map.B * range;
  return {near, near + range};
}

// Returns the shadow map's view with reversed depth, as the visibility pass expects.
shared::View reversed(const ShadowView& map) {
  shared::View view = map.view;
  shared::Projection& p = view.projection;
  const auto [near, far] = depthsOf(p);
  if (p.kind == shared::kPerspective) {
    p.B = std::max(near, 1e-6f * far);
    p.A = 0;
  } else {
    p.A = -1 / (far - near);
    p.B = far / (far - near);
  }
  return view;
}

ShadowTarget targetOf(const FrameShadows::Map& map, uint32_t firstRow, uint32_t rowStep) {
  const shared::Projection& p = map.view->view.projection;
  const float far = p.kind == shared::kPerspective ? depthsOf(p).far : 0;
  return {map.tile.x, map.tile.y, map.tile.layer, p.A, p.B, map.view->unit, far, firstRow, rowStep};
}

}  // namespace

// Shadow maps of one size that are rasterized together, and their pages to render.
struct ComputeVisibility::ShadowMaps {
  uint32_t size;
  std::vector<const FrameShadows::Map*> maps;
  graph::BufferId pages;
};

// Overwrites the rendered pages in `atlas`.
void ComputeVisibility::addShadowMapsOf(const FrameContext& f, const ShadowMaps& together, graph::ImageId atlas,
                                        graph::Use use) const {
  const vk::ImageDesc& atlasDesc = f.shadows->atlas().desc();
  const uint32_t step = pageWordStep(atlasDesc);
  std::vector<shared::View> views;
  std::vector<RasterMap> within;
  std::vector<ShadowTarget> targets;
  for (const FrameShadows::Map* map : together.maps) {
    constexpr float kEverywhere = 1e18f;  // its square is finite
    const Sphere sphere = map->view->within.value_or(Sphere{glm::vec3(0), kEverywhere});
    const uint32_t first = firstPageWord(atlasDesc, map->tile);
    views.push_back(reversed(*map->view));
    within.push_back({glm::vec4(sphere.center, std::min(sphere.radius, kEverywhere)), first, step});
    targets.push_back(targetOf(*map, first, step));
  }
  RasterViews maps = viewsOf(f, views);
  maps.within = f.graph.constants(std::as_bytes(std::span(within)));
  maps.pages = together.pages;
  storeShadowMaps(f, maps, f.graph.constants(std::as_bytes(std::span(targets))), atlas, use);
}

// Rasterizes the maps and overwrites their rendered pages in `atlas`. `targets`: ShadowTarget[].
void ComputeVisibility::storeShadowMaps(const FrameContext& f, const RasterViews& maps, VkDeviceAddress targets,
                                        graph::ImageId atlas, graph::Use use) const {
  const VisibilityBuffer visible = addVisible(f, maps);
  const uint32_t size = maps.width;
  addCompute(f,
             {.stage = graph::Stage::Shadows,
              .name = "shadow maps",
              .shader = "shadow_store.comp",
              .bindings = Bindings(f.device).storage(atlas, use),
              .size = {size, size, maps.count},
              .constants = f.setup.constants(),
              .buffers = {{visible.ids, graph::Use::StorageRead}, {maps.pages, graph::Use::StorageRead}}},
             [=, constants = maps.constants, pages = maps.pages](graph::Context& context) {
               const auto address = [&](graph::BufferId buffer) { return context.buffer(buffer).address(); };
               return ShadowStorePush{constants, visible.instances, address(visible.ids), targets, address(pages), size,
                                      0};
             });
}

// Renders the maps that shaders have fitted, and returns their atlas.
graph::ImageId ComputeVisibility::addPlacedShadowMaps(const FrameContext& f) const {
  const PlacedShadows& shadows = *f.placedShadows;
  const graph::ImageId atlas = f.graph.create(shadows.atlas(shadowImageFormat(f.setup.shadowFormat, true)));
  const graph::BufferId pages = f.graph.import(shadows.pages(), graph::Use::StorageRead);
  graph::Use use = graph::Use::StorageWrite;
  for (const shared::PlacedMaps& group : shadows.groups())
    for (uint32_t i = 0; i < group.count; i += group.mapsAtOnce) {
      const RasterViews maps{.constants = shadows.frames(group.first + i),
                             .width = group.size,
                             .height = group.size,
                             .count = std::min(group.mapsAtOnce, group.count - i),
                             .within = shadows.within(group.first + i),
                             .pages = pages};
      storeShadowMaps(f, maps, shadows.targets(group.first + i), atlas,
                      std::exchange(use, graph::Use::StorageReadWrite));
    }
  return atlas;
}

void ComputeVisibility::addShadowMaps(const FrameContext& f, const Gbuffer& gbuffer, graph::ImageId atlas) const {
  constexpr uint64_t kTexelsAtOnce = 1u << 24;  // texels of the visibility buffer per batch
  const uint64_t mostWork =
      (1u << 31) / std::bit_ceil(std::max(share_.parts, size_t{1}));  // the work counter has 32 bits
  const graph::BufferId pages = addShadowPages(f, gbuffer);
  std::map<uint32_t, std::vector<const FrameShadows::Map*>> bySize;
  for (const FrameShadows::Map& map : f.shadows->maps()) bySize[map.tile.size].push_back(&map);
  graph::Use use = f.shadows->keepsAtlas(f.shadowState) ? graph::Use::StorageReadWrite : graph::Use::StorageWrite;
  for (const auto& [size, maps] : bySize) {
    const uint64_t atOnce =
        std::clamp<uint64_t>(kTexelsAtOnce / (uint64_t{size} * size), 1, std::max<uint64_t>(mostWork, 1));
    for (size_t first = 0; first < maps.size(); first += atOnce) {
      const auto begin = maps.begin() + static_cast<std::ptrdiff_t>(first);
      const auto end = begin + static_cast<std::ptrdiff_t>(std::min<size_t>(atOnce, maps.size() - first));
      addShadowMapsOf(f, {size, {begin, end}, pages}, atlas, std::exchange(use, graph::Use::StorageReadWrite));
    }
  }
}

// --- blended surfaces ------------------------------------------------------------------------------------------------

void ComputeVisibility::addFragments(const FrameContext& f, const Gbuffer& gbuffer,
                                     const FragmentBuffers& buffers) const {
  const RasterViews views = viewsOf(f);
  const std::vector<graph::BufferId> filled{buffers.fragments, buffers.counts, buffers.totals};
  const graph::BufferId lists =
      addSmallBuffer(f, graph::Stage::Transparency, "fragment lists", sizeof(FragmentLists),
                     {{buffers.fragments, graph::Use::StorageWrite},
                      {buffers.counts, graph::Use::StorageReadWrite},
                      {buffers.totals, graph::Use::StorageReadWrite}},
                     [=](graph::Context& context) { return std::array{listsOf(context, buffers)}; });
  RasterChain chain{graph::Stage::Transparency, Hit::Blended, kDrawBlended, kDrawBlended, lists, filled};
  if (gbuffer.visible.pyramid) {
    chain.culls = kCullByPyramid;
    chain.pyramid = gbuffer.visible.pyramid;
  }
  if (views.lens) chain.hit = Hit::LensBlended;
  addRasterChain(f, rasterInstances_, rasterInstances_.all(), views,
                 RasterQueues(f, views, rasterInstances_.all(), gbuffer.visible.ids), chain);
}

void ComputeVisibility::lightFragments(const FrameContext& f, const Gbuffer& gbuffer,
                                       const FragmentBuffers& buffers) const {
  ComputePass pass{
      .stage = graph::Stage::Transparency,
      .name = "transparency light",
      .shader = "light_fragments.comp",
      .bindings = blendedMaps(f, gbuffer, graph::Use::SampledCompute),
      .size = {std::min(buffers.capacity, kFragmentRow), (buffers.capacity + kFragmentRow - 1) / kFragmentRow, 1},
      .buffers = {{buffers.fragments, graph::Use::StorageReadWrite},
                  {buffers.totals, graph::Use::StorageRead},
                  {buffers.lists, graph::Use::StorageRead}},
      .groupX = 256,
      .groupY = 1};
  pass.shader.coated = blendedHaveLayers(f);
  readsTextures(f, pass);
  const TransparencySetup& setup = f.setup.transparency;
  pass.constants.insert(pass.constants.end(), {{kEveryLightConstant, setup.everyLight ? 1u : 0u},
                                               {kSortedConstant, setup.method == kTransparencySorted ? 1u : 0u},
                                               {kSamplesConstant, f.setup.samples}});
  if (blendedHaveLayers(f)) pass.constants.push_back({kLayersConstant, f.setup.layers});
  const FragmentLightPush push{.frame = f.constants,
                               .instances = rasterInstances_.address(),
                               .firstTriangle = rasterInstances_.solidTriangles(),
                               .width = f.width,
                               .height = f.height};
  addCompute(f, std::move(pass), [=](graph::Context& context) {
    FragmentLightPush filled = push;
    filled.lists = listsOf(context, buffers);
    return filled;
  });
}

}  // namespace latelight::render
