// The rays of the public API: through the scene, and through all worlds of a call.
#include "render/submit/cast.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <new>
#include <string_view>
#include <utility>
#include <variant>

#include "api/device_array.h"
#include "api/renderer.h"
#include "api/settings.h"
#include "api/worlds/world_array.h"
#include "base/error.h"
#include "base/log.h"
#include "base/memory.h"

namespace latelight {

Renderer::Impl::RayInput Renderer::Impl::rayInput(const Options& options) const {
  owner.require("the renderer");
  RayInput input{.settings = internalSettings(options), .moment = {}};
  input.moment = internalState(options, input.settings, scene, 0);
  return input;
}

namespace {

// The public vectors have the layout of glm's.
std::span<const glm::dvec3> vectors(std::span<const std::array<double, 3>> arrays) {
  static_assert(sizeof(glm::dvec3) == sizeof(std::array<double, 3>));
  return {reinterpret_cast<const glm::dvec3*>(arrays.data()), arrays.size()};
}

std::span<const glm::vec3> vectors(std::span<const std::array<float, 3>> arrays) {
  static_assert(sizeof(glm::vec3) == sizeof(std::array<float, 3>));
  return {reinterpret_cast<const glm::vec3*>(arrays.data()), arrays.size()};
}

render::CastRays raysOf(std::span<const std::array<double, 3>> origins,
                        std::span<const std::array<double, 3>> directions, double maxDistance) {
  return {vectors(origins), vectors(directions), maxDistance};
}
render::CastRays raysOf(std::span<const std::array<float, 3>> origins, std::span<const std::array<float, 3>> directions,
                        double maxDistance) {
  return {.maxDistance = maxDistance, .floatOrigins = vectors(origins), .floatDirections = vectors(directions)};
}

// The public structs have exactly the arrays of hits.def.
static_assert(sizeof(CastTargets) == sizeof(render::CastTargets) && sizeof(CastHits) == sizeof(render::CastHits));

// Throws Error(Usage) if the arrays of two outputs overlap. `count`: the number of values in each.
void checkDistinct(const CastTargets& targets, uint64_t count) {
  struct Range {
    std::string_view name;
    std::uintptr_t begin, end;
  };
  std::vector<Range> ranges;
  const auto add = [&](const render::HitInfo& info, const auto* array) {
    const auto begin = reinterpret_cast<std::uintptr_t>(array);
    if (array) ranges.push_back({info.name, begin, begin + count * sizeof(*array)});
  };
  render::forEachHitArray(add, targets);
  std::ranges::sort(ranges, {}, &Range::begin);
  for (size_t i = 1; i < ranges.size(); ++i)
    if (ranges[i].begin < ranges[i - 1].end)
      badUsage("the arrays of the outputs {} and {} overlap: use one array per output", ranges[i - 1].name,
               ranges[i].name);
}

render::CastTargets internalTargets(const CastTargets& targets, uint64_t count) {
  checkDistinct(targets, count);
  render::CastTargets internal;
  const auto assign = []<typename From, typename To>(const render::HitInfo&, From* from, To*& to) {
    static_assert(sizeof(From) == sizeof(To));
    to = reinterpret_cast<To*>(from);
  };
  render::forEachHitArray(assign, targets, internal);
  return internal;
}

// Renderer::Impl is private, so its type is deduced.
template <typename Impl>
render::CastTicket submitTo(Impl& impl, const render::CastRays& rays, const CastTargets& t, const Options& options,
                            std::function<void()> beforeStore = {}) {
  const auto input = impl.rayInput(options);
  checkPlayback(input.settings);
  const uint64_t count = std::max(rays.origins.size(), rays.floatOrigins.size());
  return impl.renderer.submitCast(rays, internalTargets(t, count), input.settings, input.moment,
                                  std::move(beforeStore));
}

}  // namespace

CastHits Renderer::cast(std::span<const std::array<double, 3>> origins,
                        std::span<const std::array<double, 3>> directions, const Options& options,
                        double maxDistance) try {
  filled();
  CastHits hits;
  render::HitMemory<CastTargets, CastHits> memory(hits, origins.size());
  submitTo(*impl_, raysOf(origins, directions, maxDistance), memory.targets(), options, [&] { memory.wait(); }).take();
  return hits;
} catch (const std::bad_alloc&) {
  failWithoutMemory("the hits of rays");
}

void Renderer::cast(std::span<const std::array<double, 3>> origins, std::span<const std::array<double, 3>> directions,
                    const CastTargets& targets, const Options& options, double maxDistance) try {
  submitTo(filled(), raysOf(origins, directions, maxDistance), targets, options).take();
} catch (const std::bad_alloc&) {
  failWithoutMemory("the hits of rays");
}

void Renderer::cast(std::span<const std::array<float, 3>> origins, std::span<const std::array<float, 3>> directions,
                    const CastTargets& targets, const Options& options, double maxDistance) try {
  submitTo(filled(), raysOf(origins, directions, maxDistance), targets, options).take();
} catch (const std::bad_alloc&) {
  failWithoutMemory("the hits of rays");
}

struct CastTicket::Impl {
  static constexpr const char* kResults = "hits";
  std::shared_ptr<Renderer::Impl> renderer;  // destroyed after the ticket
  std::variant<render::CastTicket, render::WorldCastTicket> ticket;
  bool onDevice;  // the hits are arrays

  template <typename Cast>
  static CastTicket submitted(const std::shared_ptr<Renderer::Impl>& renderer, Cast&& cast, bool onDevice = false) {
    CastTicket ticket;
    ticket.impl_ = ownedByProcess(new Impl{renderer, std::forward<Cast>(cast), onDevice});
    return ticket;
  }
  // Waits for rays through worlds.
  render::WorldHits worldHits() {
    render::WorldHits hits = std::get<render::WorldCastTicket>(ticket).take();
    warnOfInvalidWorlds(worldsOfStatus(hits.worldStatus), hits.worlds);
    return hits;
  }
};

CastTicket::CastTicket() = default;
CastTicket::~CastTicket() = default;
CastTicket::CastTicket(CastTicket&&) noexcept = default;
CastTicket& CastTicket::operator=(CastTicket&&) noexcept = default;

bool CastTicket::done() const {
  if (!impl_ || !impl_->renderer) return true;
  usable(impl_->renderer);
  return std::visit([](const auto& cast) { return cast.done(); }, impl_->ticket);
}

void CastTicket::take() {
  requireUntaken(impl_);
  if (impl_->onDevice) badUsage("these hits are arrays on the device: take those");
  taken(impl_, [](Impl& ticket) {
    if (auto* const cast = std::get_if<render::CastTicket>(&ticket.ticket))
      cast->take();
    else
      ticket.worldHits();
    return true;
  });
}

std::map<std::string, DeviceArray> CastTicket::takeArrays() try {
  requireUntaken(impl_);
  if (!impl_->onDevice) badUsage("these hits are no arrays on the device: take() stores them in those of the call");
  const std::shared_ptr<vk::Device> device = impl_->renderer->device;
  const render::WorldHits hits = taken(impl_, [](Impl& ticket) { return ticket.worldHits(); });
  std::map<std::string, DeviceArray> arrays;
  for (const render::WorldCast::Target& from : hits.arrays) {
    DeviceArray& array = arrays[std::string(from.array->name)];
    array.element = from.array->integers ? DeviceArray::Element::Uint32 : DeviceArray::Element::Float32;
    array.shape = {1, hits.worlds, hits.rays, from.array->channels};
    array.impl_ = ownedByProcess(new DeviceArray::Impl{.owner = {}, .device = device, .memory = from.memory});
  }
  return arrays;
} catch (const std::bad_alloc&) {
  failWithoutMemory("the hits of rays");
}

CastTicket Renderer::submitCast(std::span<const std::array<double, 3>> origins,
                                std::span<const std::array<double, 3>> directions, const CastTargets& targets,
                                const Options& options, double maxDistance) try {
  return CastTicket::Impl::submitted(impl_,
                                     submitTo(filled(), raysOf(origins, directions, maxDistance), targets, options));
} catch (const std::bad_alloc&) {
  failWithoutMemory("the hits of rays");
}

CastTicket Renderer::submitCast(std::span<const std::array<float, 3>> origins,
                                std::span<const std::array<float, 3>> directions, const CastTargets& targets,
                                const Options& options, double maxDistance) try {
  return CastTicket::Impl::submitted(impl_,
                                     submitTo(filled(), raysOf(origins, directions, maxDistance), targets, options));
} catch (const std::bad_alloc&) {
  failWithoutMemory("the hits of rays");
}

namespace {

void checkRays(const WorldRays& rays, uint32_t worlds, const vk::Device& device) {
  if (rays.count > render::kMaxWorldRays / std::max(worlds, 1u))
    badUsage("{} rays in each of {} worlds are too many for one call: cast at most {} rays", rays.count, worlds,
             render::kMaxWorldRays);
  for (const auto& [array, name] : {std::pair(&rays.origins, "origins"), std::pair(&rays.directions, "directions")}) {
    if (!*array && rays.count > 0) badUsage("WorldRays::{} must be given", name);
    checkWorldArray(*array, ElementKind::Numbers, device, fmt::format("WorldRays::{}", name));
  }
  if (rays.origins.element != rays.directions.element)
    badUsage("WorldRays::origins and directions must have elements of the same type");
}

// Returns the worlds with what rays read of them.
Worlds worldsOfRays(const Worlds& worlds) {
  Worlds seen = worlds;
  seen.cameras = {Camera{}};
  seen.cameraInstances.clear(), seen.cameraToWorld.clear(), seen.intrinsics.clear();
  seen.previousCameraToWorld.clear(), seen.nextCameraToWorld.clear();
  seen.environments.clear(), seen.environmentIndex.clear();
  for (WorldArray* array : {&seen.arrays.cameraToWorld, &seen.arrays.previousCameraToWorld,
                            &seen.arrays.nextCameraToWorld, &seen.arrays.intrinsics, &seen.arrays.environmentIndex})
    *array = {};
  return seen;
}

// Returns the options with which worlds are converted for rays: shaders place them, and there is no picture.
Options optionsOfRays(Options options) {
  options.raster = "compute";
  options.lighting = "clustered";
  options.shadows = options.indirect = options.ground = "none";
  options.ambientOcclusion = "none";
  options.aa = "none";
  options.aovs.clear();
  return options;
}

// The arrays of a call in memory that the device reads.
VkDeviceAddress addressOf(render::Renderer& renderer, const WorldArray& array, uint64_t bytes,
                          std::vector<std::shared_ptr<const void>>& held) {
  if (array.device) {
    const vk::Buffer& buffer = DeviceArrayMemory::bufferOf(*array.device);
    if (!DeviceArrayMemory::contains(*array.device, array.offset, 1, bytes))
      badUsage("the rays of worlds extend beyond their memory");
    held.push_back(DeviceArrayMemory::held(*array.device));
    return buffer.address() + array.offset;
  }
  if (bytes == 0) return 0;
  const std::shared_ptr<const vk::Buffer> memory = renderer.inputMemory(bytes);
  std::memcpy(memory->mapped(), array.host, bytes);
  held.push_back(memory);
  return memory->address();
}

}  // namespace

std::map<std::string, DeviceArray> Renderer::cast(const Worlds& worlds, const WorldRays& rays,
                                                  const std::vector<std::string>& outputs, const Options& options,
                                                  const std::map<std::string, DeviceArray>& targets) try {
  return submitCast(worlds, rays, outputs, options, targets).takeArrays();
} catch (const std::bad_alloc&) {
  failWithoutMemory("the hits of rays");
}

render::WorldCastTicket Renderer::Impl::submitCast(const Worlds& worlds, const WorldRays& rays,
                                                   std::vector<render::WorldCast::Target>&& hits,
                                                   const Options& options) {
  render::WorldCast call{.doubles = rays.origins.element == WorldArray::Element::Float64,
                         .rays = rays.count,
                         .maxDistance = rays.maxDistance,
                         .hits = std::move(hits)};
  const RayInput input = rayInput(options);
  checkPlayback(input.settings);
  const render::Settings placing = settingsFor(*device, optionsOfRays(options), scene);
  render::SceneState moment = input.moment;
  if (worlds.arrays.ready > 0 && inputTimeline) device->waitFirst(inputTimeline->get(), worlds.arrays.ready);
  source.convert(worldsOfRays(worlds), placing, moment, renderer, *device);
  const uint64_t bytes = uint64_t{worlds.count} * rays.count * 3 * (call.doubles ? sizeof(double) : sizeof(float));
  call.origins = addressOf(renderer, rays.origins, bytes, call.memory);
  call.directions = addressOf(renderer, rays.directions, bytes, call.memory);
  return renderer.submitCast(std::move(call), input.settings, moment);
}

CastTicket Renderer::submitCast(const Worlds& worlds, const WorldRays& rays, const std::vector<std::string>& outputs,
                                const Options& options, const std::map<std::string, DeviceArray>& targets) try {
  Impl& impl = filled();
  checkRays(rays, worlds.count, *impl.device);
  DeviceArrayMemory::checkDistinct(targets);
  for (const auto& [name, array] : targets)
    if (std::ranges::find(outputs, name) == outputs.end())
      badUsage("there is an array to store {} in, but this output is not requested", printable(name));
  std::vector<render::WorldCast::Target> hits;
  for (const std::string& name : outputs) {
    const auto found = std::ranges::find(render::hitInfos(), name, &render::HitInfo::name);
    if (found == render::hitInfos().end()) badUsage("rays have no output \"{}\"", printable(name));
    std::shared_ptr<render::ExportedMemory>& memory = hits.emplace_back(render::WorldCast::Target{&*found}).memory;
    const auto target = targets.find(name);
    if (target == targets.end()) continue;
    memory = DeviceArrayMemory::of(target->second, *impl.device, fmt::format("the array to store {} in", name));
    const uint64_t count = uint64_t{worlds.count} * rays.count;
    if (!DeviceArrayMemory::contains(target->second, 0, count, sizeof(float) * found->channels))
      badUsage("the array of {} is too small for the hits of {} rays", name, count);
    if (worlds.arrays.ready == 0 && memory->beforeReuse) memory->beforeReuse();
  }
  return CastTicket::Impl::submitted(impl_, impl.submitCast(worlds, rays, std::move(hits), options), true);
} catch (const std::bad_alloc&) {
  failWithoutMemory("the hits of rays");
}

void Renderer::cast(const Worlds& worlds, const WorldRays& rays, const CastTargets& targets,
                    const Options& options) try {
  submitCast(worlds, rays, targets, options).take();
} catch (const std::bad_alloc&) {
  failWithoutMemory("the hits of rays");
}

CastTicket Renderer::submitCast(const Worlds& worlds, const WorldRays& rays, const CastTargets& targets,
                                const Options& options) try {
  Impl& impl = filled();
  checkRays(rays, worlds.count, *impl.device);
  return CastTicket::Impl::submitted(
      impl_, impl.submitCast(worlds, rays, render::worldTargets(internalTargets(targets, worlds.count * rays.count)),
                             options));
} catch (const std::bad_alloc&) {
  failWithoutMemory("the hits of rays");
}

}  // namespace latelight
