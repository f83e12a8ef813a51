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

// Some views of a call of render(): its settings and what it builds.
struct Renderer::Job {
  const Views& cameras;
  const Settings& settings;
  std::vector<output::FrameOutput> pictures;
  std::vector<shared::View> views;
  vk::Buffer viewBuffer, constants;
  bool continues = false;  // the history of temporal anti-aliasing is that of these views, a frame before

  size_t pixels() const { return size_t{settings.width} * settings.height; }
};

namespace {

// More views are rendered in turn, so that many cameras take no more memory than a few: targets of a GiB, data
// outputs and the sum of super-sampled frames included.
size_t viewsAtOnce(const Settings& settings) {
  constexpr uint64_t kBudget = uint64_t{1} << 30;
  constexpr uint64_t kLayers = 256;  // the least maxImageArrayLayers of Vulkan
  const auto bytesOf = [](std::string_view layout) { return uint64_t{findLayout(layout).bytesPerPixel(0).total()}; };
  const uint64_t bytes = bytesOf("exact") + bytesOf(settings.layout) + (settings.temporal ? 96 : 32);
  return std::clamp<uint64_t>(kBudget / (bytes * settings.width * settings.height), 1, kLayers);
}

bool contains(const std::vector<output::Aov>& aovs, output::Aov aov) {
  return std::find(aovs.begin(), aovs.end(), aov) != aovs.end();
}

}  // namespace

// The pipelines of renderData().
struct Renderer::DataPasses {
  DepthPass depth;
  GeometryPass geometry;
  std::unique_ptr<MotionPass> motion;  // once it is asked for
  DataPasses(vk::Device& device, const GpuScene& scene, const Layout& layout)
      : depth(device, scene), geometry(device, scene, FrameSetup{.layout = &layout}) {}
};

// The pipelines that finish a picture, whatever frame it comes from.
struct Renderer::PostPasses {
  AccumulatePass accumulate;
  ComposePass compose;
  struct Temporal {
    TemporalPass blend;
    MotionPass motion;
  };
  std::unique_ptr<Temporal> temporal;  // once it is asked for
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

void Renderer::begin(const Settings& settings, const Moment& moment) {
  checkSettings(settings);
  if (settings.background == Background::Environment && !hasEnvironment_)
    badUsage(
        "the environment can't be the background where there is none: choose one (a .hdr or .exr file, or studio)");
  gpuScene_.setPoses(moment.poses);
  gpuScene_.setExposure(std::exp2(settings.exposure));
  times_.clear();
  graphviz_.clear();
}

std::vector<output::FrameOutput> Renderer::render(std::span<const scene::Camera> cameras, const Settings& settings,
                                                  const Moment& moment) {
  begin(settings, moment);
  const Views views(cameras, moment);
  std::vector<output::FrameOutput> pictures;
  const size_t atOnce = viewsAtOnce(settings);
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
  job.pictures.resize(views.now.size());
  for (output::FrameOutput& picture : job.pictures) {
    picture.width = settings.width;
    picture.height = settings.height;
    for (output::Aov aov : settings.aovs) picture.aovs.push_back({aov, settings.width, settings.height, {}, {}});
  }
  auto asked = [&](auto&& wanted) { return std::any_of(settings.aovs.begin(), settings.aovs.end(), wanted); };
  bool linear = asked([](output::Aov aov) { return aov == output::Aov::Color; });
  if (settings.display || linear) renderColor(job);
  if (asked(isLightCount)) renderLightCounts(job);
  if (asked([](output::Aov aov) { return aov != output::Aov::Color && !isLightCount(aov); })) renderData(job);
  return std::move(job.pictures);
}

// Views and constants of one frame, in device memory.
FrameInputs Renderer::prepareViews(Job& job, glm::vec2 jitter) {
  const Settings& s = job.settings;
  job.views.clear();
  for (const scene::Camera& camera : job.cameras.now) job.views.push_back(makeView(camera, s.width, s.height, jitter));
  std::vector<shared::View> all = job.views;
  for (const scene::Camera& camera : job.cameras.previous) all.push_back(makeView(camera, s.width, s.height));
  for (const scene::Camera& camera : job.cameras.next) all.push_back(makeView(camera, s.width, s.height));
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
          .lights = gpuScene_.lights()};
}

Frame& Renderer::frameFor(const Settings& s, bool countLights) {
  std::string key = countLights ? "counting/" : "";
  for (const std::string& choice :
       {s.layout, s.normals, s.normalSpace, s.position, s.lighting, s.shading, s.volumesOrder})
    key += choice + "/";
  if (frame_ && key == frameKey_) return *frame_;
  FrameSetup setup{.layout = &findLayout(s.layout),
                   .normalEncoding = findNormalEncoding(s.normals).index,
                   .lighting = &findTechnique(s.lighting),
                   .shading = indexByName(shadings(), s.shading, "shading model"),
                   .normalSpace = indexByName(normalSpaces(), s.normalSpace, "space of normals"),
                   .positionMethod = indexByName(positionMethods(), s.position, "position method"),
                   .volumesOrder = indexByName(volumesOrders(), s.volumesOrder, "order of light volumes"),
                   .countLights = countLights};
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
  if (!post_->temporal)
    post_->temporal.reset(
        new PostPasses::Temporal{TemporalPass(device_), MotionPass(device_, gpuScene_, MotionUse::Reproject)});
  const PostPasses::Temporal& temporal = *post_->temporal;
  const TemporalPass::Sources sources{picture, lit.gbuffer.depth,
                                      temporal.motion.add(graph, inputs, lit.gbuffer.depth)};
  return begins ? temporal.blend.begin(graph, inputs, sources, history_)
                : temporal.blend.resume(graph, inputs, sources, history_);
}

void Renderer::renderColor(Job& job) {
  const Settings& s = job.settings;
  Frame& frame = frameFor(s, false);
  const std::vector<glm::vec2> jitters = jittersOf(job);
  const size_t n = jitters.size();
  if (!post_) post_ = std::make_unique<PostPasses>(device_);
  vk::Image sum;
  if (n > 1) {
    sum = vk::Image(device_,
                    {.format = VK_FORMAT_R32G32B32A32_SFLOAT,
                     .width = s.width,
                     .height = s.height,
                     .layers = static_cast<uint32_t>(job.cameras.now.size()),
                     .usage = VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                     .name = "sum"});
  }
  const ComposeSettings composeSettings{
      .scale = s.temporal ? 1.0f : 1.0f / static_cast<float>(n),
      .tonemap = indexByName(tonemaps(), s.tonemap, "tonemap"),
      .background = glm::vec4(s.backgroundColor, s.background == Background::Color ? 1.0f : 0.0f)};
  const bool linear = contains(s.aovs, output::Aov::Color);

  Progress progress("Rendering", n);
  for (size_t i = 0; i < n; ++i) {
    const bool last = i + 1 == n;
    FrameInputs inputs = prepareViews(job, jitters[i]);

    graph::Graph graph;
    const LitFrame lit = frame.add(graph, inputs);
    graph::ImageId picture = lit.picture;
    if (n > 1) {
      graph::ImageId total = graph.import(sum, i == 0 ? std::nullopt : std::optional(graph::Use::StorageReadWrite));
      post_->accumulate.add(graph, picture, total, i == 0);
      picture = total;
      if (!last) graph.exports(total, graph::Use::StorageReadWrite);
    }
    if (last && s.temporal) picture = addTemporal(graph, inputs, lit, picture, n > 1);
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
      if (linear) readColor(result, done.buffer(values), view, n > 1 || s.temporal, composeSettings.scale);
    }
  }
}

// How many lights each pixel's centre cost: the picture's own frame, counting.
void Renderer::renderLightCounts(Job& job) {
  FrameInputs inputs = prepareViews(job, glm::vec2(0));
  graph::Graph graph;
  graph::BufferId counts = addReadback(graph, frameFor(job.settings, true).add(graph, inputs).lightCounts);
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
  graph::ImageId motion;
  if (contains(job.settings.aovs, output::Aov::Motion)) {
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
  const Views views({&camera, 1}, moment);
  Job job{.cameras = views, .settings = settings};
  const FrameInputs inputs = prepareViews(job, glm::vec2(0));
  graph::Graph graph;
  const LitFrame lit = frameFor(settings, false).add(graph, inputs);
  const RawReadback readback(graph, findLayout(settings.layout), findNormalEncoding(settings.normals).index,
                             lit.gbuffer);
  graphviz_ = graph.graphviz();
  return readback.read(run(graph), job.views.front());
}

}  // namespace latelight::render
