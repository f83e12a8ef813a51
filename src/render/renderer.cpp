#include "render/renderer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>

#include "base/log.h"
#include "base/memory.h"
#include "render/aov_read.h"
#include "render/gbuffer/geometry_pass.h"
#include "render/gbuffer/raw_read.h"
#include "render/lighting/technique.h"
#include "render/post/ambient_occlusion/ambient_occlusion.h"
#include "render/post/resolve.h"
#include "render/registry.h"
#include "render/shadow/shadow_pass.h"
#include "render/transparency/transparency.h"
#include "render/view.h"
#include "render/visibility/hardware.h"
#include "render/visibility/motion.h"

namespace latelight::render {

// Cameras that are rendered at once, and where they were and will be.
struct Renderer::Views {
  std::span<const scene::Camera> now, previous, next;

  Views(std::span<const scene::Camera> cameras, const Moment& moment)
      : now(cameras),
        previous(moment.previousCameras.empty() ? cameras : moment.previousCameras),
        next(moment.nextCameras.empty() ? cameras : moment.nextCameras) {}
  Views part(size_t first, size_t count) const {
    Views some = *this;
    for (std::span<const scene::Camera>* cameras : {&some.now, &some.previous, &some.next})
      *cameras = cameras->subspan(first, count);
    return some;
  }
};

// Some views of a call of render(): its settings and what it builds, a strip of their pictures at a time.
struct Renderer::Job {
  const Views& cameras;
  const Settings& settings;
  Strip strip{0, settings.height};
  std::vector<output::FrameOutput> pictures;  // of the strip
  std::vector<shared::View> views;
  vk::Buffer viewBuffer, constants;
  std::optional<ShadowMaps> shadows;  // none where no light casts any
  MemoryClaim memory;                 // of the pictures
  size_t strips = 1;                  // that are rendered one after the other
  std::optional<Progress> progress;   // over all of them, and the frames that each takes
  bool continues = false;             // the history of temporal anti-aliasing is that of these views, a frame before

  size_t pixels() const { return size_t{settings.width} * strip.rows; }
  shared::View viewOf(const scene::Camera& camera, glm::vec2 jitter = glm::vec2(0)) const {
    return render::viewOf(makeView(camera, settings.width, settings.height, jitter), strip);
  }
};

namespace {

// More views are rendered in turn, so that many cameras take no more memory than a few: targets of a GiB, data
// outputs, the sum of super-sampled frames and what post-processing needs included.
size_t viewsAtOnce(const Settings& settings, bool shadows) {
  if (shadows) return 1;  // cascades and the choice of lights are fitted to a view
  constexpr uint64_t kBudget = uint64_t{1} << 30;
  constexpr uint64_t kLayers = 256;  // the least maxImageArrayLayers of Vulkan
  const auto bytesOf = [](std::string_view layout) { return uint64_t{findLayout(layout).bytesPerPixel(0).total()}; };
  const uint64_t bytes =
      bytesOf("exact") + settings.samples * (bytesOf(settings.layout) + 32) + (settings.temporal ? 112 : 48);
  return std::clamp<uint64_t>(kBudget / (bytes * settings.width * settings.height), 1, kLayers);
}

// Of what leaves.
uint64_t bytesAPixel(const Settings& settings) {
  uint64_t bytes = settings.display ? 4 : 0;
  for (output::Aov aov : settings.aovs) bytes += 4 * output::info(aov).channels;
  return bytes;
}

// Outputs that nothing is in yet, of so many rows.
output::FrameOutput emptyOutput(const Settings& settings, uint32_t rows) {
  output::FrameOutput empty{.width = settings.width, .height = rows, .aovs = {}, .display = {}};
  for (output::Aov aov : settings.aovs) empty.aovs.push_back({aov, settings.width, rows, {}, {}});
  return empty;
}

// Data alone need no light.
bool lightsSomething(const Settings& settings) {
  return settings.display || std::any_of(settings.aovs.begin(), settings.aovs.end(), [](output::Aov aov) {
           return aov == output::Aov::Color || isLightCount(aov);
         });
}

scene::Light lightOf(const SunLight& sun) {
  scene::Light light;
  light.name = "sun";
  light.type = shared::kLightDirectional;
  light.intensity = sun.illuminance;
  light.direction = -glm::vec3(std::cos(sun.elevation) * std::sin(sun.azimuth),
                               -std::cos(sun.elevation) * std::cos(sun.azimuth), std::sin(sun.elevation));
  return light;
}

FrameSetup setupOf(const Settings& s, bool shadows) {
  FrameSetup setup{.layout = &findLayout(s.layout),
                   .normalEncoding = findNormalEncoding(s.normals).index,
                   .lighting = &findTechnique(s.lighting),
                   .shading = indexByName(shadings(), s.shading, "shading model"),
                   .normalSpace = indexByName(normalSpaces(), s.normalSpace, "space of normals"),
                   .positionMethod = indexByName(positionMethods(), s.position, "position method"),
                   .volumesOrder = indexByName(volumesOrders(), s.volumesOrder, "order of light volumes"),
                   .ambientOcclusion = indexByName(ambientOcclusions(), s.ao.method, "ambient occlusion"),
                   .fog = s.fog.density > 0,
                   .transparency = {indexByName(transparencies(), s.transparency, "method of transparency")},
                   .samples = s.samples,
                   .everySample = s.everySample && s.samples > 1};
  if (shadows) {
    setup.shadowFormat = indexByName(shadowFormats(), s.shadows, "shadow format");
    setup.shadowFilter = indexByName(shadowFilters(), s.shadowFilter, "shadow filter");
  }
  return setup;
}

// Lights are counted at pixel centres, and where they are lit: what is laid over that has no part in it.
FrameSetup countingSetupOf(const Settings& s, bool shadows) {
  FrameSetup setup = setupOf(s, shadows);
  setup.countLights = true;
  setup.fog = false;
  setup.transparency = {kTransparencyNone};
  setup.samples = 1;
  setup.everySample = false;
  return setup;
}

}  // namespace

// The pipelines of temporal anti-aliasing.
struct Renderer::Temporal {
  TemporalPass blend;
  MotionPass motion;
};

// The pipelines of renderData().
struct Renderer::DataPasses {
  DepthPass depth;
  GeometryPass geometry;
  std::unique_ptr<MotionPass> motion;  // once it is asked for
  DataPasses(vk::Device& device, const GpuScene& scene, const Layout& layout)
      : depth(device, scene),
        geometry(device, scene, FrameSetup{.layout = &layout, .textureSlots = scene.textureSlots()}) {}
};

Renderer::Renderer(vk::Device& device, const scene::Scene& scene, const scene::Environment* environment)
    : device_(device),
      scene_(scene),
      gpuScene_(device, scene),
      environment_(device, environment),
      hasEnvironment_(environment != nullptr),
      executor_(device),
      post_(device),
      boundsRadius_(scene::worldBounds(scene).radius()) {}

Renderer::~Renderer() = default;

void Renderer::begin(const Settings& settings, const Moment& moment) {
  checkSettings(settings);
  if (settings.background == Background::Environment && !hasEnvironment_)
    badUsage(
        "the environment can't be the background where there is none: choose one (a .hdr or .exr file, or studio)");
  if (settings.sun != sun_) {
    sun_ = settings.sun;
    std::vector<scene::Light> lights = scene_.lights;
    if (sun_) lights.push_back(lightOf(*sun_));
    gpuScene_.setLights(std::move(lights));
  }
  gpuScene_.setAnisotropy(settings.anisotropy.value_or(usualAnisotropy(device_)));
  gpuScene_.setPoses(moment.poses);
  times_.clear();
  shadingCounts_.reset();
  graphviz_.clear();
}

std::vector<output::FrameOutput> Renderer::render(std::span<const scene::Camera> cameras, const Settings& settings,
                                                  const Moment& moment) {
  begin(settings, moment);
  const Views views(cameras, moment);
  std::vector<output::FrameOutput> pictures;
  const bool shadows = settings.shadows != "none" && gpuScene_.lightCount() > 0 && lightsSomething(settings);
  const size_t atOnce = viewsAtOnce(settings, shadows);
  for (size_t first = 0; first < cameras.size(); first += atOnce) {
    std::vector<output::FrameOutput> some = renderViews(views.part(first, std::min(atOnce, cameras.size() - first)),
                                                        settings, moment.continues && atOnce >= cameras.size());
    std::move(some.begin(), some.end(), std::back_inserter(pictures));
  }
  return pictures;
}

std::vector<output::FrameOutput> Renderer::renderViews(const Views& views, const Settings& settings, bool continues) {
  Job job{.cameras = views, .settings = settings};
  job.continues = continues && history_.fits(settings.width, settings.height, views.now.size());
  const std::vector<Strip> strips = stripsOf(settings);
  uint64_t rows = settings.height;
  if (strips.size() > 1) rows += strips.front().rows;  // of the strip in work
  job.memory.grow(bytesAPixel(settings) * settings.width * rows * views.now.size(), "the pictures");
  if (lightsSomething(settings)) prepareShadows(job);
  job.strips = strips.size();
  if (strips.size() == 1) {
    renderStrip(job, strips.front());
    return std::move(job.pictures);
  }
  std::vector<output::FrameOutput> whole(views.now.size(), emptyOutput(settings, settings.height));
  for (const Strip strip : strips) {
    renderStrip(job, strip);
    for (size_t view = 0; view < whole.size(); ++view) append(whole[view], job.pictures[view]);
  }
  return whole;
}

output::FrameOutput Renderer::renderStrip(const scene::Camera& camera, const Settings& settings, Strip strip,
                                          const Moment& moment) {
  begin(settings, moment);
  const Views views({&camera, 1}, moment);
  Job job{.cameras = views, .settings = settings};
  job.memory.grow(bytesAPixel(settings) * settings.width * strip.rows, "the pictures");
  if (lightsSomething(settings)) prepareShadows(job);
  renderStrip(job, strip);
  return std::move(job.pictures.front());
}

// Fills the job's pictures with that strip of them.
void Renderer::renderStrip(Job& job, Strip strip) {
  const Settings& s = job.settings;
  job.strip = strip;
  job.pictures.assign(job.cameras.now.size(), emptyOutput(s, strip.rows));
  auto asked = [&](auto&& wanted) { return std::any_of(s.aovs.begin(), s.aovs.end(), wanted); };
  if (s.display || output::contains(s.aovs, output::Aov::Color)) renderColor(job);
  if (asked(isLightCount)) renderLightCounts(job);
  if (output::contains(s.aovs, output::Aov::Samples)) renderSampleCounts(job);
  if (asked(isData)) renderData(job);
}

// For the first view, whatever its jitter and all of its strips: samples of one picture share their shadow maps'
// places.
void Renderer::prepareShadows(Job& job) {
  const ShadowScene scene{gpuScene_.lights(), gpuScene_.lightSources(), gpuScene_.sceneLights(),
                          gpuScene_.posed() ? gpuScene_.posedBounds() : scene::worldBounds(scene_)};
  ShadowPlan plan =
      planShadows(scene, makeView(job.cameras.now.front(), job.settings.width, job.settings.height), job.settings);
  std::vector<GpuScene::LightShadow> shadows;
  if (!plan.empty()) {
    shared::FrameConstants frame{};
    gpuScene_.describe(frame);
    job.shadows = uploadShadows(device_, std::move(plan), frame,
                                indexByName(shadowFormats(), job.settings.shadows, "shadow format"));
    const ShadowPlan::Entry* sun = job.shadows->plan.sun(gpuScene_.lights());
    for (const ShadowPlan::Entry& entry : job.shadows->plan.lights)
      shadows.push_back({entry.light, job.shadows->addressOf(entry, &entry == sun)});
  }
  gpuScene_.setShadows(shadows);
}

// Views and constants of one frame, in device memory.
FrameInputs Renderer::prepareViews(Job& job, glm::vec2 jitter) {
  const Settings& s = job.settings;
  job.views.clear();
  for (const scene::Camera& camera : job.cameras.now) job.views.push_back(job.viewOf(camera, jitter));
  std::vector<shared::View> all = job.views;
  for (const scene::Camera& camera : job.cameras.previous) all.push_back(job.viewOf(camera));
  for (const scene::Camera& camera : job.cameras.next) all.push_back(job.viewOf(camera));
  vk::BufferDesc upload{.kind = vk::MemoryKind::Upload};
  upload.name = "views";
  upload.size = all.size() * sizeof(shared::View);
  job.viewBuffer = vk::Buffer(device_, upload);
  std::memcpy(job.viewBuffer.mapped(), all.data(), upload.size);

  shared::FrameConstants frame{};
  gpuScene_.describe(frame);
  frame.views = job.viewBuffer.address();
  frame.previousViews = frame.views + job.views.size() * sizeof(shared::View);
  frame.nextViews = frame.previousViews + job.views.size() * sizeof(shared::View);
  frame.viewCount = static_cast<uint32_t>(job.views.size());
  frame.exposure = std::exp2(s.exposure);
  frame.environmentIntensity = hasEnvironment_ ? s.environmentIntensity : 0.0f;
  frame.environmentCos = std::cos(s.environmentRotation);
  frame.environmentSin = std::sin(s.environmentRotation);
  frame.environmentLevels = static_cast<float>(environment_.levels());
  frame.fog = {.color = s.fog.color,
               .density = s.fog.density,
               .falloff = s.fog.height > 0 ? 1 / s.fog.height : 0.0f,
               .base = s.fog.base};
  upload.name = "frame constants";
  upload.size = sizeof(frame);
  job.constants = vk::Buffer(device_, upload);
  std::memcpy(job.constants.mapped(), &frame, sizeof(frame));

  return {.scene = gpuScene_,
          .environment = environment_,
          .views = job.views,
          .constants = job.constants.address(),
          .width = s.width,
          .height = job.strip.rows,
          .environmentBackground = hasEnvironment_ && s.background == Background::Environment,
          .lights = gpuScene_.lights(),
          .aoRadius = s.ao.radius.value_or(kAoRadiusShare * boundsRadius_),
          .aoStrength = s.ao.strength,
          .shadows = job.shadows ? &*job.shadows : nullptr,
          .atCentres = s.samples == 1};
}

Frame& Renderer::frameFor(FrameSetup setup) {
  setup.textureSlots = gpuScene_.textureSlots();
  constexpr size_t kKept = 8;  // a picture's frame and the one that counts its lights, for a few choices in turn
  auto kept = std::find_if(frames_.begin(), frames_.end(), [&](const KeptFrame& k) { return k.setup == setup; });
  if (kept == frames_.end()) {
    if (frames_.size() == kKept) frames_.pop_back();
    frames_.push_back({setup, std::make_unique<Frame>(device_, gpuScene_, setup)});
    kept = frames_.end() - 1;
  }
  std::rotate(frames_.begin(), kept, kept + 1);
  return *frames_.front().frame;
}

graph::Executor& Renderer::run(const graph::Graph& graph) {
  executor_.run(graph, graph.compile());
  for (const graph::PassTime& time : executor_.times()) {
    auto known =
        std::find_if(times_.begin(), times_.end(), [&](const graph::PassTime& t) { return t.name == time.name; });
    if (known == times_.end())
      times_.push_back(time);
    else
      known->milliseconds += time.milliseconds;
  }
  return executor_;
}

// The samples of a picture, a frame each, as offsets from the pixel's centre.
std::vector<glm::vec2> Renderer::jittersOf(const Job& job) const {
  const Settings& s = job.settings;
  if (s.temporal) {
    const std::vector<glm::vec2>& all = temporalJitters();
    if (!job.continues) return all;
    return {all[history_.frames() % all.size()]};
  }
  const uint32_t side = s.superSampling;
  std::vector<glm::vec2> jitters;
  for (uint32_t i = 0; i < side * side; ++i) {
    const glm::vec2 cell(static_cast<float>(i % side), static_cast<float>(i / side));
    jitters.push_back((cell + 0.5f) / static_cast<float>(side) - 0.5f);
  }
  return jitters;
}

graph::ImageId Renderer::addTemporal(graph::Graph& graph, const FrameInputs& inputs, const LitFrame& lit,
                                     graph::ImageId picture, bool begins) {
  if (!temporal_)
    temporal_.reset(new Temporal{TemporalPass(device_), MotionPass(device_, gpuScene_, MotionUse::Reproject)});
  const TemporalPass::Sources sources{picture, lit.gbuffer.depth,
                                      temporal_->motion.add(graph, inputs, lit.gbuffer.depth)};
  return begins ? temporal_->blend.begin(graph, inputs, sources, history_)
                : temporal_->blend.resume(graph, inputs, sources, history_);
}

void Renderer::renderColor(Job& job) {
  const Settings& s = job.settings;
  Frame& frame = frameFor(setupOf(s, job.shadows.has_value()));
  const std::vector<glm::vec2> jitters = jittersOf(job);
  const size_t n = jitters.size();
  vk::Image sum;
  if (n > 1) {
    sum = vk::Image(device_,
                    {.format = VK_FORMAT_R32G32B32A32_SFLOAT,
                     .width = s.width,
                     .height = job.strip.rows,
                     .layers = static_cast<uint32_t>(job.cameras.now.size()),
                     .usage = VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                     .name = "sum"});
  }
  const bool linear = output::contains(s.aovs, output::Aov::Color);

  if (!job.progress) job.progress.emplace("Rendering", n * job.strips);
  for (size_t i = 0; i < n; ++i) {
    const bool last = i + 1 == n;
    FrameInputs inputs = prepareViews(job, jitters[i]);

    graph::Graph graph;
    const LitFrame lit = frame.add(graph, inputs);
    graph::ImageId picture = lit.picture;
    if (n > 1) {
      graph::ImageId total = graph.import(sum, i == 0 ? std::nullopt : std::optional(graph::Use::StorageReadWrite));
      post_.accumulate(graph, picture, total, i == 0);
      picture = total;
      if (!last) graph.exports(total, graph::Use::StorageReadWrite);
    }
    if (last && s.temporal) picture = addTemporal(graph, inputs, lit, picture, n > 1);
    FinishedPicture finished;
    graph::BufferId values, surfaces;
    if (last) {
      finished = post_.add(graph, picture, s.temporal ? 1.0f : 1.0f / static_cast<float>(n), s);
      if (linear) values = addReadback(graph, finished.linear);
      if (s.countSurfaces && lit.gbuffer.surfaces) surfaces = addReadback(graph, lit.gbuffer.surfaces);
      graphviz_ = graph.graphviz();
    }
    graph::Executor& done = run(graph);
    if (frame.outgrown(done)) {  // from the first frame on: the sum has one that lacks something
      if (last && s.temporal) history_.undo();
      i = ~size_t{0};
      continue;
    }
    job.progress->step();
    if (!last) continue;
    const bool floats = graph.desc(finished.linear).format == VK_FORMAT_R32G32B32A32_SFLOAT;
    if (surfaces) {
      if (!shadingCounts_) shadingCounts_.emplace();
      countShadings(*shadingCounts_, done.buffer(surfaces), job.pixels() * job.pictures.size());
    }
    for (size_t view = 0; view < job.pictures.size(); ++view) {
      output::FrameOutput& result = job.pictures[view];
      if (s.display) {
        const uint8_t* from = done.buffer(finished.display).as<uint8_t>() + view * job.pixels() * 4;
        result.display.assign(from, from + job.pixels() * 4);
      }
      if (linear) readColor(result, done.buffer(values), view, floats, finished.scale);
    }
  }
}

// How many lights each pixel's centre cost: the picture's own frame, counting.
void Renderer::renderLightCounts(Job& job) {
  FrameInputs inputs = prepareViews(job, glm::vec2(0));
  graph::Graph graph;
  const Frame& frame = frameFor(countingSetupOf(job.settings, job.shadows.has_value()));
  graph::BufferId counts = addReadback(graph, frame.addOpaque(graph, inputs).lightCounts);
  graph::Executor& done = run(graph);
  for (size_t view = 0; view < job.pictures.size(); ++view)
    readLightCounts(job.pictures[view], done.buffer(counts), view);
}

// How often the picture's own frame shades each pixel. Its lighting leads to nothing that is read, so it does not run.
void Renderer::renderSampleCounts(Job& job) {
  FrameInputs inputs = prepareViews(job, glm::vec2(0));
  graph::Graph graph;
  const Frame& frame = frameFor(setupOf(job.settings, job.shadows.has_value()));
  const Gbuffer gbuffer = frame.addOpaque(graph, inputs).gbuffer;
  const bool surfaces{gbuffer.surfaces};
  const graph::BufferId counts = addReadback(graph, surfaces ? gbuffer.surfaces : gbuffer.depth);
  graph::Executor& done = run(graph);
  for (size_t view = 0; view < job.pictures.size(); ++view)
    readSampleCounts(job.pictures[view], done.buffer(counts), view, surfaces);
}

// Data leaves at pixel centres, in full precision, whatever layout and anti-aliasing the picture has: a geometry pass
// of its own into the layout `exact`.
void Renderer::renderData(Job& job) {
  FrameInputs inputs = prepareViews(job, glm::vec2(0));
  inputs.blendedToo = job.settings.dataSurfaces == "any";
  const Layout& exact = findLayout("exact");
  if (!data_) data_ = std::make_unique<DataPasses>(device_, gpuScene_, exact);
  graph::Graph graph;
  Gbuffer gbuffer{.depth = data_->depth.add(graph, inputs)};
  gbuffer.light = createTarget(graph, inputs, kLightFormat, "light");
  gbuffer.sampleDepth = gbuffer.depth;
  gbuffer.sampleLight = gbuffer.light;
  data_->geometry.add(graph, inputs, gbuffer);
  graph::ImageId motion;
  if (output::contains(job.settings.aovs, output::Aov::Motion)) {
    if (!data_->motion) data_->motion = std::make_unique<MotionPass>(device_, gpuScene_, MotionUse::Data);
    motion = data_->motion->add(graph, inputs, gbuffer.depth);
  }
  DataReadback readback(graph, exact, gbuffer, motion, job.settings.aovs);
  if (graphviz_.empty()) graphviz_ = graph.graphviz();
  graph::Executor& done = run(graph);
  for (size_t view = 0; view < job.pictures.size(); ++view)
    readback.read(done, job.views[view], view, job.settings, scene_.yUp && !job.settings.zUp, job.pictures[view]);
}

output::RawGbuffer Renderer::readTargets(const scene::Camera& camera, const Settings& settings, const Moment& moment) {
  begin(settings, moment);
  if (findTechnique(settings.lighting).forward)
    badUsage("{} lighting has no G-buffer whose targets could be shown: choose a deferred technique",
             settings.lighting);
  Settings atCentres = settings;
  atCentres.samples = 1;
  const Views views({&camera, 1}, moment);
  Job job{.cameras = views, .settings = atCentres};
  const Layout& layout = findLayout(settings.layout);
  if (layout.sunTarget >= 0) prepareShadows(job);  // else nothing in the targets is lit
  const FrameInputs inputs = prepareViews(job, glm::vec2(0));
  const Frame& frame = frameFor(setupOf(atCentres, job.shadows.has_value()));
  graph::Graph graph;
  const LitFrame lit = frame.addOpaque(graph, inputs);
  const RawReadback readback(graph, layout, findNormalEncoding(settings.normals).index, lit.gbuffer);
  graphviz_ = graph.graphviz();
  return readback.read(run(graph), job.views.front());
}

}  // namespace latelight::render
