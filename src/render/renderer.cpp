#include "render/renderer.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>

#include "base/log.h"
#include "render/aov_read.h"
#include "render/gbuffer/geometry_pass.h"
#include "render/gbuffer/raw_read.h"
#include "render/lighting/technique.h"
#include "render/post/resolve.h"
#include "render/registry.h"
#include "render/shadow/shadow_pass.h"
#include "render/view.h"
#include "render/visibility/hardware.h"

namespace latelight::render {

// Some views of a call of render(): its settings and what it builds.
struct Renderer::Job {
  std::span<const scene::Camera> cameras;
  const Settings& settings;
  std::vector<output::FrameOutput> pictures;
  std::vector<shared::View> views;
  vk::Buffer viewBuffer, constants;
  std::optional<ShadowMaps> shadows;  // none where no light casts any

  size_t pixels() const { return size_t{settings.width} * settings.height; }
};

namespace {

// More views are rendered in turn, so that many cameras take no more memory than a few: targets of a GiB, data
// outputs and the sum of super-sampled frames included.
size_t viewsAtOnce(const Settings& settings, bool shadows) {
  if (shadows) return 1;  // cascades and the choice of lights are fitted to a view
  constexpr uint64_t kBudget = uint64_t{1} << 30;
  constexpr uint64_t kLayers = 256;  // the least maxImageArrayLayers of Vulkan
  const auto bytesOf = [](std::string_view layout) { return uint64_t{findLayout(layout).bytesPerPixel(0).total()}; };
  const uint64_t bytes = bytesOf("exact") + bytesOf(settings.layout) + 32;
  return std::clamp<uint64_t>(kBudget / (bytes * settings.width * settings.height), 1, kLayers);
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

}  // namespace

// The pipelines of renderData().
struct Renderer::DataPasses {
  DepthPass depth;
  GeometryPass geometry;
  DataPasses(vk::Device& device, const GpuScene& scene, const Layout& layout)
      : depth(device, scene), geometry(device, scene, FrameSetup{.layout = &layout}) {}
};

// The pipelines that finish a picture, whatever frame it comes from.
struct Renderer::PostPasses {
  AccumulatePass accumulate;
  ComposePass compose;
  explicit PostPasses(vk::Device& device) : accumulate(device), compose(device) {}
};

Renderer::Renderer(vk::Device& device, const scene::Scene& scene, const scene::Environment* environment)
    : device_(device),
      scene_(scene),
      gpuScene_(device, scene),
      environment_(device, environment),
      hasEnvironment_(environment != nullptr),
      executor_(device) {}

Renderer::~Renderer() = default;

void Renderer::begin(const Settings& settings) {
  checkSettings(settings);
  if (settings.background == Background::Environment && !hasEnvironment_)
    badUsage(
        "the environment can't be the background where there is none: choose one (a .hdr or .exr file, or studio)");
  gpuScene_.setExposure(std::exp2(settings.exposure));
  if (settings.sun != sun_) {
    sun_ = settings.sun;
    std::vector<scene::Light> lights = scene_.lights;
    if (sun_) lights.push_back(lightOf(*sun_));
    gpuScene_.setLights(std::move(lights));
  }
  times_.clear();
  graphviz_.clear();
}

std::vector<output::FrameOutput> Renderer::render(std::span<const scene::Camera> cameras, const Settings& settings) {
  begin(settings);
  std::vector<output::FrameOutput> pictures;
  const bool shadows = settings.shadows != "none" && gpuScene_.lightCount() > 0 && lightsSomething(settings);
  const size_t atOnce = viewsAtOnce(settings, shadows);
  for (size_t first = 0; first < cameras.size(); first += atOnce) {
    std::vector<output::FrameOutput> some =
        renderViews(cameras.subspan(first, std::min(atOnce, cameras.size() - first)), settings);
    std::move(some.begin(), some.end(), std::back_inserter(pictures));
  }
  return pictures;
}

std::vector<output::FrameOutput> Renderer::renderViews(std::span<const scene::Camera> cameras,
                                                       const Settings& settings) {
  Job job{.cameras = cameras, .settings = settings};
  job.pictures.resize(cameras.size());
  for (output::FrameOutput& picture : job.pictures) {
    picture.width = settings.width;
    picture.height = settings.height;
    for (output::Aov aov : settings.aovs) picture.aovs.push_back({aov, settings.width, settings.height, {}, {}});
  }
  auto asked = [&](auto&& wanted) { return std::any_of(settings.aovs.begin(), settings.aovs.end(), wanted); };
  bool linear = asked([](output::Aov aov) { return aov == output::Aov::Color; });
  if (lightsSomething(settings)) prepareShadows(job);
  if (settings.display || linear) renderColor(job);
  if (asked(isLightCount)) renderLightCounts(job);
  if (asked([](output::Aov aov) { return aov != output::Aov::Color && !isLightCount(aov); })) renderData(job);
  return std::move(job.pictures);
}

// For the first view, whatever its jitter: samples of one picture share their shadow maps' places.
void Renderer::prepareShadows(Job& job) {
  const ShadowScene scene{gpuScene_.lights(), gpuScene_.lightSources(), gpuScene_.sceneLights(),
                          scene::worldBounds(scene_)};
  ShadowPlan plan =
      planShadows(scene, makeView(job.cameras.front(), job.settings.width, job.settings.height), job.settings);
  std::vector<GpuScene::LightShadow> shadows;
  if (!plan.empty()) {
    shared::FrameConstants frame{};
    gpuScene_.describe(frame);
    job.shadows = uploadShadows(device_, std::move(plan), frame);
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
  for (const scene::Camera& camera : job.cameras) job.views.push_back(makeView(camera, s.width, s.height, jitter));
  vk::BufferDesc upload{.kind = vk::MemoryKind::Upload};
  upload.name = "views";
  upload.size = job.views.size() * sizeof(shared::View);
  job.viewBuffer = vk::Buffer(device_, upload);
  std::memcpy(job.viewBuffer.mapped(), job.views.data(), upload.size);

  shared::FrameConstants frame{};
  gpuScene_.describe(frame);
  frame.views = job.viewBuffer.address();
  frame.viewCount = static_cast<uint32_t>(job.views.size());
  frame.exposure = std::exp2(s.exposure);
  frame.environmentIntensity = hasEnvironment_ ? s.environmentIntensity : 0.0f;
  frame.environmentCos = std::cos(s.environmentRotation);
  frame.environmentSin = std::sin(s.environmentRotation);
  frame.environmentLevels = static_cast<float>(environment_.levels());
  upload.name = "frame constants";
  upload.size = sizeof(frame);
  job.constants = vk::Buffer(device_, upload);
  std::memcpy(job.constants.mapped(), &frame, sizeof(frame));

  return {.scene = gpuScene_,
          .environment = environment_,
          .views = job.views,
          .constants = job.constants.address(),
          .width = s.width,
          .height = s.height,
          .environmentBackground = hasEnvironment_ && s.background == Background::Environment,
          .lights = gpuScene_.lights(),
          .shadows = job.shadows ? &*job.shadows : nullptr};
}

Frame& Renderer::frameFor(const Job& job, bool countLights) {
  const Settings& s = job.settings;
  const std::string shadows = job.shadows ? s.shadows : "none";
  std::string key = countLights ? "counting/" : "";
  for (const std::string& choice :
       {s.layout, s.normals, s.normalSpace, s.position, s.lighting, s.shading, s.volumesOrder, shadows, s.shadowFilter})
    key += choice + "/";
  if (frame_ && key == frameKey_) return *frame_;
  FrameSetup setup{.layout = &findLayout(s.layout),
                   .normalEncoding = findNormalEncoding(s.normals).index,
                   .lighting = &findTechnique(s.lighting),
                   .shading = indexByName(shadings(), s.shading, "shading model"),
                   .normalSpace = indexByName(normalSpaces(), s.normalSpace, "space of normals"),
                   .positionMethod = indexByName(positionMethods(), s.position, "position method"),
                   .volumesOrder = indexByName(volumesOrders(), s.volumesOrder, "order of light volumes"),
                   .countLights = countLights,
                   .shadowFormat = indexByName(shadowFormats(), shadows, "shadow format"),
                   .shadowFilter = indexByName(shadowFilters(), s.shadowFilter, "shadow filter")};
  frame_ = std::make_unique<Frame>(device_, gpuScene_, setup);
  frameKey_ = key;
  return *frame_;
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

void Renderer::renderColor(Job& job) {
  const Settings& s = job.settings;
  Frame& frame = frameFor(job, false);
  const uint32_t n = s.superSampling;
  if (!post_) post_ = std::make_unique<PostPasses>(device_);
  vk::Image sum;
  if (n > 1) {
    sum = vk::Image(device_,
                    {.format = VK_FORMAT_R32G32B32A32_SFLOAT,
                     .width = s.width,
                     .height = s.height,
                     .layers = static_cast<uint32_t>(job.cameras.size()),
                     .usage = VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                     .name = "sum"});
  }
  const ComposeSettings composeSettings{
      .scale = 1.0f / static_cast<float>(n * n),
      .tonemap = indexByName(tonemaps(), s.tonemap, "tonemap"),
      .background = glm::vec4(s.backgroundColor, s.background == Background::Color ? 1.0f : 0.0f)};
  const bool linear = std::find(s.aovs.begin(), s.aovs.end(), output::Aov::Color) != s.aovs.end();

  Progress progress("Rendering", n * n);
  for (uint32_t i = 0; i < n * n; ++i) {
    const bool last = i + 1 == n * n;
    glm::vec2 cell(static_cast<float>(i % n), static_cast<float>(i / n));
    FrameInputs inputs = prepareViews(job, (cell + 0.5f) / static_cast<float>(n) - 0.5f);

    graph::Graph graph;
    graph::ImageId picture = frame.add(graph, inputs).picture;
    if (n > 1) {
      graph::ImageId total = graph.import(sum, i == 0 ? std::nullopt : std::optional(graph::Use::StorageReadWrite));
      post_->accumulate.add(graph, picture, total, i == 0);
      picture = total;
      if (!last) graph.exports(total, graph::Use::StorageReadWrite);
    }
    graph::BufferId display, values;
    if (last && s.display) display = post_->compose.add(graph, picture, composeSettings);
    if (last && linear) values = addReadback(graph, picture);
    if (last) graphviz_ = graph.graphviz();
    graph::Executor& done = run(graph);
    progress.step();
    if (!last) continue;
    for (size_t view = 0; view < job.pictures.size(); ++view) {
      output::FrameOutput& result = job.pictures[view];
      if (s.display) {
        const uint8_t* from = done.buffer(display).as<uint8_t>() + view * job.pixels() * 4;
        result.display.assign(from, from + job.pixels() * 4);
      }
      if (linear) readColor(result, done.buffer(values), view, n > 1, composeSettings.scale);
    }
  }
}

// How many lights each pixel's centre cost: the picture's own frame, counting.
void Renderer::renderLightCounts(Job& job) {
  FrameInputs inputs = prepareViews(job, glm::vec2(0));
  graph::Graph graph;
  graph::BufferId counts = addReadback(graph, frameFor(job, true).add(graph, inputs).lightCounts);
  graph::Executor& done = run(graph);
  for (size_t view = 0; view < job.pictures.size(); ++view)
    readLightCounts(job.pictures[view], done.buffer(counts), view);
}

// Data leaves at pixel centres, in full precision, whatever layout and anti-aliasing the picture has: a geometry pass
// of its own into the layout `exact`.
void Renderer::renderData(Job& job) {
  FrameInputs inputs = prepareViews(job, glm::vec2(0));
  const Layout& exact = findLayout("exact");
  if (!data_) data_ = std::make_unique<DataPasses>(device_, gpuScene_, exact);
  graph::Graph graph;
  Gbuffer gbuffer{.depth = data_->depth.add(graph, inputs)};
  gbuffer.light = createTarget(graph, inputs, kLightFormat, "light");
  data_->geometry.add(graph, inputs, gbuffer);
  DataReadback readback(graph, exact, gbuffer, job.settings.aovs);
  if (graphviz_.empty()) graphviz_ = graph.graphviz();
  graph::Executor& done = run(graph);
  for (size_t view = 0; view < job.pictures.size(); ++view)
    readback.read(done, job.views[view], view, job.settings, scene_.yUp && !job.settings.zUp, job.pictures[view]);
}

output::RawGbuffer Renderer::readTargets(const scene::Camera& camera, const Settings& settings) {
  begin(settings);
  if (findTechnique(settings.lighting).forward)
    badUsage("{} lighting has no G-buffer whose targets could be shown: choose a deferred technique",
             settings.lighting);
  Job job{.cameras = {&camera, 1}, .settings = settings};
  prepareShadows(job);
  const FrameInputs inputs = prepareViews(job, glm::vec2(0));
  graph::Graph graph;
  const LitFrame lit = frameFor(job, false).add(graph, inputs);
  const RawReadback readback(graph, findLayout(settings.layout), findNormalEncoding(settings.normals).index,
                             lit.gbuffer);
  graphviz_ = graph.graphviz();
  return readback.read(run(graph), job.views.front());
}

}  // namespace latelight::render
