// Compares each shared function on the device with the same header on the host.
#include <gtest/gtest.h>

#include <cstring>

#include "gpu_math/run_shader.h"
#include "shared/function_cases.h"
#include "shared/random.h"
#include "test_device.h"
#include "vk/resources.h"

namespace latelight::shared {
namespace {

constexpr uint kCount = 4096;  // sets of arguments
constexpr uint kGroup = 64;    // the shader's workgroup

struct Case {
  const char* name;
  float relative, absolute;
};
constexpr Case kCases[] = {
#define ENTRY(name, relative, absolute, result) {#name, relative, absolute},
    FUNCTION_CASES(ENTRY)
#undef ENTRY
};

// Returns a direction, one in eight along an axis or a diagonal, where encodings have their seams.
vec3 someDirection(Random& random) {
  if (random.uniform() >= 0.125f) return random.direction();
  const auto step = [&] { return std::floor(random.uniform(-1.0f, 2.0f)); };
  const vec3 d(step(), step(), step());
  return d == vec3(0.0f, 0.0f, 0.0f) ? vec3(0.0f, 0.0f, 1.0f) : normalize(d);
}

Arguments someArguments(Random& random) {
  const auto share = [&] {  // [0, 1], sometimes exactly 0 or 1
    const float x = random.uniform(-0.02f, 1.02f);
    return clamp(x, 0.0f, 1.0f);
  };
  const auto wide = [&] { return random.logUniform(1e-3f, 1e3f); };
  Arguments a;
  a.n = someDirection(random);
  a.l = someDirection(random);
  a.v = someDirection(random);
  a.c = vec3(share(), share(), share());
  a.d = vec3(share(), share(), share());
  a.u = vec4(share(), share(), share(), share());
  a.w = vec4(wide(), wide(), wide(), wide());
  a.k = static_cast<uint>(random.bits());
  return a;
}

class Results {
 public:
  // The device is destroyed here: at the end of the process, drivers and layers may have ended before it.
  Results() {
    vk::Device device({.selector = test::testDevice(), .validation = true});
    Random random(1);
    for (uint i = 0; i < kCount; ++i) arguments_.push_back(someArguments(random));
    run(device);
    messages_ = device.validationMessages();
  }
  const Arguments& arguments(uint i) const { return arguments_[i]; }
  vec4 of(uint function, uint i) const { return results_[function * kCount + i]; }
  const std::vector<std::string>& messages() const { return messages_; }

 private:
  void run(vk::Device& device);

  std::vector<Arguments> arguments_;
  std::vector<vec4> results_;
  std::vector<std::string> messages_;
};

void Results::run(vk::Device& device) {
  const VkDeviceSize bytes = std::size(kCases) * kCount * sizeof(vec4);
  vk::Buffer arguments(device,
                       {.size = kCount * sizeof(Arguments), .kind = vk::MemoryKind::Upload, .name = "arguments"});
  vk::Buffer results(device, {.size = bytes, .kind = vk::MemoryKind::Readback, .name = "results"});
  std::memcpy(arguments.mapped(), arguments_.data(), kCount * sizeof(Arguments));

  struct {
    VkDeviceAddress arguments, results;
    uint count;
  } const push{arguments.address(), results.address(), kCount};
  test::runShader(device, "gpu_math_functions", push, kCount, static_cast<uint32_t>(std::size(kCases)), kGroup);
  results_.assign(results.as<vec4>(), results.as<vec4>() + bytes / sizeof(vec4));
}

const Results& results() {
  static const Results once;
  return once;
}

class Functions : public testing::TestWithParam<uint> {};

// Returns the difference of the two as a multiple of the case's tolerance; infinite if only one of them is a number.
float share(const Case& bounds, float device, float host) {
  if (std::isnan(host) || std::isnan(device)) return std::isnan(host) && std::isnan(device) ? 0.0f : INFINITY;
  if (device == host) return 0.0f;
  return std::abs(device - host) / (bounds.relative * std::abs(host) + bounds.absolute);
}

// Arguments that differ from these by about their rounding error.
Arguments besides(Arguments a, Random& random) {
  const auto some = [&] { return random.uniform(-4e-7f, 4e-7f); };
  for (vec3* direction : {&a.n, &a.l, &a.v}) *direction += vec3(some(), some(), some());
  for (vec3* shares : {&a.c, &a.d}) *shares = clamp(*shares + vec3(some(), some(), some()), 0.0f, 1.0f);
  a.u = clamp(a.u + vec4(some(), some(), some(), some()), 0.0f, 1.0f);
  a.w *= vec4(1.0f) + vec4(some(), some(), some(), some());
  return a;
}

// Vulkan lets devices fuse products into sums, which the host does not do. At discontinuities of a function (a light at
// the horizon, a frame of parallel directions), devices may return what the host returns nearby; if that is not a
// number, any result is accepted.
bool isGivenBeside(const Case& bounds, uint function, const Arguments& arguments, vec4 device) {
  Random random(5);
  vec4 least = evaluateFunction(function, arguments), most = least;
  for (int i = 0; i < 256; ++i) {
    const vec4 host = evaluateFunction(function, besides(arguments, random));
    least = min(least, host), most = max(most, host);
    if (any(isnan(host)) || any(isnan(least))) return true;
  }
  const vec4 slack = bounds.relative * max(abs(least), abs(most)) + bounds.absolute;
  return all(lessThanEqual(least - slack, device)) && all(lessThanEqual(device, most + slack));
}

TEST_P(Functions, DeviceAgreesWithHost) {
  const Case& bounds = kCases[GetParam()];
  float worst = 0.0f;
  uint where = 0;
  for (uint i = 0; i < kCount; ++i) {
    const Arguments& arguments = results().arguments(i);
    const vec4 device = results().of(GetParam(), i), host = evaluateFunction(GetParam(), arguments);
    float here = 0.0f;
    for (int c = 0; c < 4; ++c) here = std::max(here, share(bounds, device[c], host[c]));
    if (here > 1.0f && isGivenBeside(bounds, GetParam(), arguments, device)) continue;
    if (here > worst) where = i;
    worst = std::max(worst, here);
  }
  const vec4 device = results().of(GetParam(), where), host = evaluateFunction(GetParam(), results().arguments(where));
  EXPECT_LE(worst, 1.0f) << "device (" << device.x << ", " << device.y << ", " << device.z << ", " << device.w
                         << "), host (" << host.x << ", " << host.y << ", " << host.z << ", " << host.w
                         << ") for arguments " << where;
  RecordProperty("shareOfBound", std::to_string(worst));
}

// A function that is 0 for all arguments would agree with any other.
TEST_P(Functions, ResultsVary) {
  if (std::string(kCases[GetParam()].name) == "withoutReflection") return;
  bool varies = false;
  for (uint i = 1; i < kCount; ++i) varies |= results().of(GetParam(), i) != results().of(GetParam(), 0);
  EXPECT_TRUE(varies);
}

INSTANTIATE_TEST_SUITE_P(Shared, Functions, testing::Range(0u, static_cast<uint>(std::size(kCases))),
                         [](const auto& info) { return std::string(kCases[info.param].name); });

TEST(FunctionsOnDevice, ValidationIsSilent) {
  for (const std::string& message : results().messages()) ADD_FAILURE() << message;
}

}  // namespace
}  // namespace latelight::shared
