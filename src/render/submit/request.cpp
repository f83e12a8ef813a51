#include "render/submit/request.h"

#include "render/base/readback.h"
#include "render/lighting/technique.h"
#include "render/post/resolve.h"
#include "render/submit/frame_passes.h"
#include "render/surface_coordinates/surface_coordinates.h"
#include "render/transparency/transparency.h"

namespace latelight::render {

namespace {

// Determines FrameConfig::sunInGbuffer. The G-buffer stores one value of the sun's shadow per pixel. Multisampled edges
// need more, so lighting looks up the shadow for them. The raster compute looks it up as well, because writing a single
// channel requires the graphics pipeline.
bool keepsSun(const FrameConfig& setup, const Settings& s) {
  return setup.shadowFormat && !setup.lighting->forward && setup.layout->sunTarget >= 0 && setup.samples == 1 &&
         !rastersInCompute(s);
}

}  // namespace

FrameConfig frameSetup(const Settings& s, bool shadows) {
  FrameConfig setup{.layout = s.layout,
                    .normalEncoding = s.normals->index,
                    .lighting = s.lighting,
                    .shading = indexOf(s.shading),
                    .normalSpace = indexOf(s.normalSpace),
                    .positionMethod = indexOf(s.position),
                    .volumesOrder = indexOf(s.volumesOrder),
                    .ambientOcclusion = indexOf(s.ambientOcclusion),
                    .fog = s.fogDensity > 0,
                    .transparency = {indexOf(s.transparency)},
                    .samples = s.aa.samples,
                    .sampleLayers = s.aa.samples > 1 && rastersInCompute(s),
                    .indirect = indexOf(s.indirect),
                    .paths = s.samples,
                    .filtersIndirect = s.indirectFilter != IndirectFilter::None,
                    .ground = s.ground == Ground::Shadow,
                    .everySample = s.everySample && s.aa.samples > 1};
  setup.rayShadows = shadows && s.shadows == ShadowFormat::Rays;
  if (s.shadows == ShadowFormat::Rays) setup.areaShadowRays = s.samples;
  if (shadows && !setup.rayShadows) {
    setup.shadowFormat = indexOf(s.shadows);
    setup.shadowFilter = indexOf(s.shadowFilter);
    setup.sunInGbuffer = keepsSun(setup, s);
  }
  return setup;
}

bool isLit(const Settings& s) {
  return showsPicture(s) || requestsOutput(s, Origin::LightCounts);
}

bool tracesPaths(const Settings& settings) {
  return settings.indirect != Indirect::None || settings.lighting->traces || settings.ground != Ground::None;
}

FrameGraphBuilder::FrameGraphBuilder(const RenderState& state, const Settings& settings, bool yUp,
                                     const ViewsInTime& steady, const ViewsInTime& jittered,
                                     const FrameShadows* shadows, ShadowMapState shadowState,
                                     const ResultArrays& arrays)
    : state_(state),
      settings_(settings),
      steadyViews_(steady),
      jitteredViews_(jittered),
      shadows_(shadows),
      shadowState_(shadowState),
      graph_(state.executor),
      outputs_(settings, yUp, steady.lens != nullptr, arrays) {}

bool FrameGraphBuilder::isSteady() const {
  return settings_.aa.samples == 1 && jitteredViews_.centered;
}

// Returns true if materials of visible surfaces are evaluated into a G-buffer or data outputs.
bool FrameGraphBuilder::resolvesSurfaces() const {
  const bool lit = showsPicture(settings_) && !settings_.lighting->forward && settings_.layout->hasTargets();
  return lit || requestsOutput(settings_, Origin::Surface);
}

ViewSet& FrameGraphBuilder::steady() {
  const VisibilityOptions options{.resolves = resolvesSurfaces() || requestsOutput(settings_, Origin::Coordinates),
                                  .atCenters = true};
  if (!steady_) steady_.emplace(state_, steadyViews_, settings_, shadows_, options);
  return *steady_;
}

ViewSet& FrameGraphBuilder::jittered() {
  if (isSteady()) return steady();
  const VisibilityOptions options{.resolves = resolvesSurfaces(), .atCenters = settings_.aa.samples == 1};
  if (!jittered_) jittered_.emplace(state_, jitteredViews_, settings_, shadows_, options);
  return *jittered_;
}

// Finds the surfaces at pixel centers once, for everything that needs them.
const VisibilityBuffer& FrameGraphBuilder::steadyVisible() {
  if (!steadyVisible_) steadyVisible_ = addVisibility(steady().frame(graph_, FrameConfig{}));
  return *steadyVisible_;
}

FrameContext FrameGraphBuilder::litContext(const ViewSet& set, const FrameConfig& setup) {
  FrameContext f = set.frame(graph_, setup);
  f.shadowState = shadowState_;
  return f;
}

// Adds the lit frame of the picture. The frame also counts lights if it can, because lights are counted at pixel
// centers.
LitFrame FrameGraphBuilder::addPicture(const SurfaceOutputs* outputs, const Histories& histories) {
  FrameConfig setup = frameSetup(settings_, shadows_ || state_.placesShadows());
  setup.outputs = outputs;
  setup.countLights = isSteady() && requestsOutput(settings_, Origin::LightCounts);
  FrameContext f = litContext(jittered(), setup);
  if (histories.indirect) {
    if (!histories.continuesIndirect) histories.indirect->begin(f);
    f.indirectHistory = histories.indirect;
  }
  LitFrame lit = isSteady() ? addLit(f, steadyVisible()) : addOpaque(f);
  shadowState_ = lit.shadowState;
  addTransparency(f, lit.gbuffer);
  if (anyBlended(f)) lit.gbuffer.covered = {};  // they are visible outside of these tiles, too
  return lit;
}

void FrameGraphBuilder::accumulate(const vk::Image& sum, bool first) {
  const graph::ImageId total = graph_.import(sum, first ? std::nullopt : std::optional(graph::Use::StorageReadWrite));
  addAccumulate({state_.device, graph_}, addPicture().picture, total, first);
  graph_.exports(total, graph::Use::StorageReadWrite);
}

// Adds the picture's last or only frame, and returns it with all frames before it.
graph::ImageId FrameGraphBuilder::addLastFrame(const PictureSum& sum, const Histories& histories) {
  lit_ = addPicture(packsWithPicture() ? packSurfaces() : nullptr, histories);
  graph::ImageId picture = lit_->picture;
  if (sum.image) {
    const graph::ImageId total = graph_.import(sum.image, graph::Use::StorageReadWrite);
    addAccumulate({state_.device, graph_}, picture, total, false);
    picture = total;
  }
  if (!histories.temporal) return picture;
  const FrameContext f = jittered().frame(graph_, FrameConfig{});
  const VisibilityBuffer& visible = lit_->gbuffer.visible;
  const graph::ImageId motion = addMotion(f, visible, MotionUse::Reproject);
  return addTemporal(f, {picture, visible.pixels, motion}, *histories.temporal, !histories.continues);
}

void FrameGraphBuilder::finish(const PictureSum& sum, const Histories& histories) {
  if (showsPicture(settings_)) {
    const graph::ImageId picture =
        sum.complete ? graph_.import(sum.image, graph::Use::StorageReadWrite) : addLastFrame(sum, histories);
    const bool ofLastFrame = lit_ && picture == lit_->picture;
    addPost(picture, histories.temporal ? 1 : sum.count, ofLastFrame ? lit_->gbuffer.covered : graph::BufferId{});
  }
  if (requestsOutput(settings_, Origin::LightCounts)) addLightCounts();
  if (requestsOutput(settings_, Origin::SampleCounts)) addSampleCounts();
  if (requestsSurfaces(settings_)) addData();
  if (requestsOutput(settings_, Origin::Raster)) addRasterData();
}

void FrameGraphBuilder::exportResults(Results results) {
  outputs_.exportResults({state_.device, graph_}, results);
}

void FrameGraphBuilder::addConstants() {
  for (const std::optional<ViewSet>* set : {&steady_, &jittered_, &solid_, &rastered_})
    if (*set) (*set)->addConstants(graph_);
}

void FrameGraphBuilder::update(const ViewsInTime& views, const FrameShadows* shadows) {
  shadows_ = shadows;
  for (std::optional<ViewSet>* set : {&steady_, &jittered_})
    if (*set) (*set)->update(views, shadows);
  for (std::optional<ViewSet>* set : {&solid_, &rastered_})
    if (*set) (*set)->update(views, nullptr);
}

// `covered`: tiles outside of which the picture is 0.
void FrameGraphBuilder::addPost(graph::ImageId picture, uint32_t count, graph::BufferId covered) {
  const Builder b{state_.device, graph_};
  std::optional<ResultTarget> display;
  if (settings_.display) display = outputs_.addDisplay(b, texels(graph_, picture));
  const FinishedPicture finished =
      finishPicture(b, picture, 1.0f / static_cast<float>(count), settings_, display, covered);
  outputs_.add(
      b, Origin::Picture, [&](std::string_view) { return finished.linear; }, 0, finished.scale);
  if (settings_.countSurfaces && lit_ && lit_->gbuffer.surfaces)
    surfaces_ = addReadback(graph_, lit_->gbuffer.surfaces);
}

// Adds the number of lights evaluated at each pixel's center: from the picture's own frame, or from a similar frame
// without blended surfaces.
void FrameGraphBuilder::addLightCounts() {
  graph::ImageId counts;
  if (lit_ && isSteady()) {
    counts = lit_->lightCounts;
  } else {
    FrameConfig setup = frameSetup(settings_, shadows_ || state_.placesShadows());
    setup.countLights = true;
    setup.fog = false;
    setup.ground = false;
    setup.samples = 1;
    setup.sampleLayers = false;
    setup.everySample = false;
    setup.sunInGbuffer = shadows_ && keepsSun(setup, settings_);
    counts = addLit(litContext(steady(), setup), steadyVisible()).lightCounts;
  }
  outputs_.add({state_.device, graph_}, Origin::LightCounts, [&](std::string_view) { return counts; });
}

// Adds how often the picture's own frame shades each pixel. If no picture is requested, no export depends on its
// lighting, so the graph culls it.
void FrameGraphBuilder::addSampleCounts() {
  graph::ImageId counts;
  if (settings_.aa.samples > 1) {
    if (!lit_) lit_ = addOpaque(litContext(jittered(), frameSetup(settings_, shadows_ || state_.placesShadows())));
    counts = lit_->gbuffer.surfaces ? lit_->gbuffer.surfaces : lit_->gbuffer.depth;
  } else {
    counts = steadyVisible().pixels;
  }
  outputs_.add({state_.device, graph_}, Origin::SampleCounts, [&](std::string_view) { return counts; });
}

bool FrameGraphBuilder::showsBlendedData() {
  return settings_.dataSurfaces == DataSurfaces::Any && anyBlended(steady().frame(graph_, FrameConfig{}));
}

// Returns true if the picture's own frame resolves exactly the surfaces that the data outputs describe.
bool FrameGraphBuilder::packsWithPicture() {
  return requestsOutput(settings_, Origin::Surface) && !settings_.lighting->forward && settings_.layout->hasTargets() &&
         isSteady() && !showsBlendedData();
}

const SurfaceOutputs* FrameGraphBuilder::packSurfaces() {
  surfaceOutputs_ = outputs_.addSurfaces({state_.device, graph_}, steady().frame(graph_, FrameConfig{}).pixels());
  return &*surfaceOutputs_;
}

// Data outputs are evaluated at pixel centers, in full precision, for any layout and anti-aliasing of the picture.
void FrameGraphBuilder::addData() {
  ViewSet* set = &steady();
  VisibilityBuffer visible;
  if (showsBlendedData()) {
    solid_.emplace(state_, steadyViews_, settings_, nullptr,
                   VisibilityOptions{.blendedToo = true, .resolves = true, .atCenters = true});
    set = &*solid_;
    visible = addVisibility(solid_->frame(graph_, FrameConfig{}));
  } else {
    visible = steadyVisible();
  }
  if (requestsOutput(settings_, Origin::Surface) && !surfaceOutputs_) addSurfaceData(*set, visible);
  if (requestsOutput(settings_, Origin::Coordinates)) addCoordinates(*set, visible);
  if (!requestsOutput(settings_, Origin::Motion)) return;
  const FrameContext f = set->frame(graph_, FrameConfig{});
  const graph::ImageId motion = addMotion(f, visible, MotionUse::Data);
  outputs_.add(f, Origin::Motion, [&](std::string_view) { return motion; });
}

// Packs outputs without a picture, where surfaces are resolved or evaluated.
void FrameGraphBuilder::addSurfaceData(ViewSet& set, const VisibilityBuffer& visible) {
  const FrameConfig setup{.layout = &findLayout("exact"), .targets = 0, .outputs = packSurfaces()};
  addGbuffer(set.frame(graph_, setup), gbufferOf(visible));
}

void FrameGraphBuilder::addCoordinates(ViewSet& set, const VisibilityBuffer& visible) {
  const FrameContext f = set.frame(graph_, FrameConfig{});
  const graph::ImageId triangles = addTriangles(f, visible);
  outputs_.add(
      f, Origin::Coordinates, [&](std::string_view name) { return addSurfaceCoordinate(f, triangles, name); },
      f.constants);
}

void FrameGraphBuilder::addRasterData() {
  ViewSet* set = &steady();
  VisibilityBuffer visible;
  if (rastersInCompute(settings_)) {
    visible = steadyVisible();
  } else {
    set = &rastered_.emplace(state_, steadyViews_, settings_, nullptr, VisibilityOptions{.inCompute = true});
    visible = addVisibility(set->frame(graph_, FrameConfig{}));
  }
  const FrameContext f = set->frame(graph_, FrameConfig{});
  const auto& raster = std::get<ComputeVisibility>(set->visibility());
  const ComputeVisibility::RasterImages images = raster.addRasterImages(f, visible);
  outputs_.add(f, Origin::Raster, [&](std::string_view name) {
    if (name == "overdraw") return raster.addOverdraw(f);
    return name == "classes" ? images.classes : images.numbers;
  });
}

void FrameGraphBuilder::read(const graph::Submission& done, std::vector<output::FrameOutput>& pictures) const {
  outputs_.read(state_.device, state_.executor, done, pictures);
}

void FrameGraphBuilder::countShadings(const graph::Submission& done, std::optional<ShadingCounts>& counts) const {
  if (!surfaces_) return;
  if (!counts) counts.emplace();
  const shared::vec2 size = steadyViews_.now.front().size;
  render::countShadings(*counts, done.buffer(surfaces_), static_cast<size_t>(size.x) * static_cast<size_t>(size.y),
                        steadyViews_.now.size(), settings_.aa.samples);
}

}  // namespace latelight::render
