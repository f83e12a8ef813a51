#include "render/renderer.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/error.h"
#include "base/log.h"
#include "base/memory.h"
#include "render/gbuffer/raw_read.h"
#include "render/lighting/technique.h"
#include "render/request.h"
#include "render/view.h"

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
  std::optional<FrameShadows> shadows;        // none where no light casts any
  MemoryClaim memory;                         // of the pictures
  size_t strips = 1;                          // that are rendered one after the other
  std::optional<Progress> progress;           // over all of them, and the frames that each takes
  bool continues = false;  // the history of temporal anti-aliasing is that of these views, a frame before

  ViewsInTime views(glm::vec2 jitter) const {
    ViewsInTime all;
    for (const scene::Camera& camera : cameras.now) all.now.push_back(viewOf(camera, jitter));
    for (const scene::Camera& camera : cameras.previous) all.previous.push_back(viewOf(camera));
    for (const scene::Camera& camera : cameras.next) all.next.push_back(viewOf(camera));
    return all;
  }

 private:
  shared::View viewOf(const scene::Camera& camera, glm::vec2 jitter = glm::vec2(0)) const {
    return render::viewOf(makeView(camera, settings.width, settings.height, jitter), strip);
  }
};

namespace {

// More views are rendered in turn, so that many cameras take no more memory than a few: targets of a GiB, data
// outputs, the sum of super-sampled frames, shadow maps and what post-processing needs included.
size_t viewsAtOnce(const Settings& settings, bool shadows) {
  constexpr uint64_t kBudget = uint64_t{1} << 30;
  constexpr uint64_t kLayers = 256;  // the least maxImageArrayLayers of Vulkan
  const auto bytesOf = [](const Layout& layout) { return uint64_t{layout.bytesPerPixel(0).total()}; };
  const uint64_t pixel = bytesOf(findLayout("exact")) + settings.aa.samples * (bytesOf(*settings.layout) + 32) +
                         (settings.aa.temporal ? 112 : 48);
  uint64_t bytes = pixel * settings.width * settings.height;
  if (shadows) bytes += 4 * shadowTexels(settings);
  return std::clamp<uint64_t>(kBudget / bytes, 1, kLayers);
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
  if (settings.background.kind == Background::Environment && !hasEnvironment_)
    badUsage(
        "the environment can't be the background where there is none: choose one (a .hdr or .exr file, or studio)");
  gpuScene_.setAnisotropy(settings.anisotropy.value_or(usualAnisotropy(device_)));
  gpuScene_.update(moment.poses, settings.sun ? std::optional(lightOf(*settings.sun)) : std::nullopt);
  drawOrder_.update(gpuScene_);
  times_.clear();
  shadingCounts_.reset();
  graphviz_.clear();
}

bool Renderer::castsShadows(const Settings& settings) const {
  return settings.shadows != ShadowFormat::None && gpuScene_.lights().count() > 0 && isLit(settings);
}

RenderState Renderer::state() {
  return {device_, gpuScene_, environment_, hasEnvironment_, drawOrder_, overflow_};
}

// For the whole pictures, whatever their jitter: samples and strips of one share their maps' places.
void Renderer::planShadows(Job& job) {
  if (!castsShadows(job.settings)) return;
  std::vector<shared::View> views;
  for (const scene::Camera& camera : job.cameras.now)
    views.push_back(makeView(camera, job.settings.width, job.settings.height));
  job.shadows.emplace(device_, gpuScene_, views, job.settings);
  if (job.shadows->empty()) job.shadows.reset();
}

std::vector<output::FrameOutput> Renderer::render(std::span<const scene::Camera> cameras, const Settings& settings,
                                                  const Moment& moment) {
  begin(settings, moment);
  const Views views(cameras, moment);
  std::vector<output::FrameOutput> pictures;
  const size_t atOnce = viewsAtOnce(settings, castsShadows(settings));
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
  planShadows(job);
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
  planShadows(job);
  renderStrip(job, strip);
  return std::move(job.pictures.front());
}

// The samples of a picture, a frame each, as offsets from the pixel's centre.
std::vector<glm::vec2> Renderer::jittersOf(const Job& job) const {
  const Settings& s = job.settings;
  if (!s.display && !output::contains(s.aovs, output::Aov::Color)) return {glm::vec2(0)};
  if (s.aa.temporal) {
    const std::vector<glm::vec2>& all = temporalJitters();
    if (!job.continues) return all;
    return {all[history_.frames() % all.size()]};
  }
  const uint32_t side = s.aa.superSampling;
  std::vector<glm::vec2> jitters;
  for (uint32_t i = 0; i < side * side; ++i) {
    const glm::vec2 cell(static_cast<float>(i % side), static_cast<float>(i / side));
    jitters.push_back((cell + 0.5f) / static_cast<float>(side) - 0.5f);
  }
  return jitters;
}

// Fills the job's pictures with that strip of them. What overflows is done again from the first frame on: the sum has
// one that lacks something.
void Renderer::renderStrip(Job& job, Strip strip) {
  job.strip = strip;
  job.pictures.assign(job.cameras.now.size(), emptyOutput(job.settings, strip.rows));
  while (!tryStrip(job)) {
  }
}

bool Renderer::tryStrip(Job& job) {
  const Settings& s = job.settings;
  const std::vector<glm::vec2> jitters = jittersOf(job);
  const size_t n = jitters.size();
  if (!job.progress) job.progress.emplace("Rendering", n * job.strips);
  const RenderState state = this->state();
  const ViewsInTime steady = job.views(glm::vec2(0));
  FrameShadows* shadows = job.shadows ? &*job.shadows : nullptr;
  vk::Image sum;
  if (n > 1) sum = makeSum(job);
  for (size_t i = 0; i + 1 < n; ++i) {
    Request request(state, s, steady, job.views(jitters[i]), shadows);
    request.accumulate(sum, i == 0);
    if (overflow_.happened(run(request.graph()))) return false;
    job.progress->step();
  }
  Request request(state, s, steady, job.views(jitters.back()), shadows);
  TemporalHistory* history = s.aa.temporal ? &history_ : nullptr;
  const bool continues = n == 1;
  request.finish(n > 1 ? &sum : nullptr, static_cast<uint32_t>(n), history, continues);
  graphviz_ = request.graph().graphviz();
  const graph::Executor& done = run(request.graph());
  if (overflow_.happened(done)) {
    if (history) history_.undo();
    return false;
  }
  job.progress->step();
  request.read(done, scene_.yUp && s.axes == Axes::File, job.pictures);
  request.countShadings(done, shadingCounts_);
  return true;
}

vk::Image Renderer::makeSum(const Job& job) {
  return {device_,
          {.format = VK_FORMAT_R32G32B32A32_SFLOAT,
           .width = job.settings.width,
           .height = job.strip.rows,
           .layers = static_cast<uint32_t>(job.cameras.now.size()),
           .usage = VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
           .name = "sum"}};
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

output::RawGbuffer Renderer::readTargets(const scene::Camera& camera, const Settings& settings, const Moment& moment) {
  begin(settings, moment);
  if (settings.lighting->forward)
    badUsage("{} lighting has no G-buffer whose targets could be shown: choose a deferred technique",
             settings.lighting->name);
  Settings atCentres = settings;
  atCentres.aa.samples = 1;
  const Views views({&camera, 1}, moment);
  Job job{.cameras = views, .settings = atCentres};
  const Layout& layout = *settings.layout;
  if (layout.sunTarget >= 0) planShadows(job);  // else nothing in the targets is lit
  ViewSet set(state(), job.views(glm::vec2(0)), atCentres, job.shadows ? &*job.shadows : nullptr,
              HardwareOptions{.atCentres = true});
  graph::Graph graph;
  const LitFrame lit = addOpaque(set.frame(graph, frameSetup(atCentres, job.shadows.has_value())));
  const RawReadback readback(graph, layout, settings.normals->index, lit.gbuffer);
  graphviz_ = graph.graphviz();
  return readback.read(run(graph), set.views().front());
}

}  // namespace latelight::render
