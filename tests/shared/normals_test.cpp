// Every normal encoding through the bits that are stored.
#include "normals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "shared/random.h"

namespace latelight::shared {
namespace {

struct Encoding {
  std::string name;
  uint id;
};

std::vector<Encoding> encodings() {
#define ENTRY(name, id) Encoding{#name, id},
  return {LATELIGHT_NORMALS(ENTRY)};
#undef ENTRY
}

float stored(float x, float levels) {
  return std::floor(clamp(x, 0.0f, 1.0f) * levels + 0.5f) / levels;
}

vec3 roundTrip(uint encoding, vec3 n, uint bits) {
  const float levels = static_cast<float>((1u << bits) - 1u);
  const vec3 e = encodeNormal(encoding, n, vec3(levels, levels, levels));
  return decodeNormal(encoding, vec3(stored(e.x, levels), stored(e.y, levels), stored(e.z, levels)));
}

// Degrees between unit vectors, precise near 0 where acos is not.
double degreesBetween(vec3 a, vec3 b) {
  const double x = double(a.y) * b.z - double(a.z) * b.y, y = double(a.z) * b.x - double(a.x) * b.z,
               z = double(a.x) * b.y - double(a.y) * b.x;
  const double cosine = double(a.x) * b.x + double(a.y) * b.y + double(a.z) * b.z;
  return std::atan2(std::sqrt(x * x + y * y + z * z), cosine) * 180.0 / M_PI;
}

// The six axes, the eight corners and twelve edges of the octahedron, its seams (z = 0, x = 0, y = 0) and both poles'
// neighbourhoods, with steps to either side.
std::vector<vec3> hardDirections() {
  std::vector<vec3> list;
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z)
        if (x || y || z) list.push_back(normalize(vec3(x, y, z)));
  for (const float step : {0.0f, 1e-7f, -1e-7f, 1e-3f, -1e-3f}) {
    for (int i = 0; i < 360; ++i) {
      const float c = std::cos(float(i) * kPi / 180.0f), s = std::sin(float(i) * kPi / 180.0f);
      for (const vec3 d : {vec3(c, s, step), vec3(step, c, s), vec3(c, step, s)}) list.push_back(normalize(d));
      for (const float pole : {1.0f, -1.0f}) list.push_back(normalize(vec3(c * step, s * step, pole)));
    }
  }
  return list;
}

double worstDegrees(uint encoding, uint bits) {
  double worst = 0.0;
  for (const vec3 n : hardDirections()) worst = std::max(worst, degreesBetween(roundTrip(encoding, n, bits), n));
  Random random(bits);
  for (int i = 0; i < 300000; ++i) {
    const vec3 n = random.direction();
    worst = std::max(worst, degreesBetween(roundTrip(encoding, n, bits), n));
  }
  return worst;
}

// The largest error of an encoding whose channels have `levels` steps is factor / levels radians, to first order. A new
// encoding has its factor added here; the test fails until it has.
struct Bound {
  const char* encoding;
  double factor;
};
const Bound kBounds[] = {
    // Rounding moves each coordinate by up to 1 / levels. At a face's centre, |o| = 1 / sqrt 3, that is (1, 1, -2) /
    // levels
    // along the face: sqrt 6 sqrt 3.
    {"octahedral", std::sqrt(18.0)},
    // (1, 1, 1) / levels, for normals across it.
    {"xyz", std::sqrt(3.0)},
};

TEST(Normals, ErrorStaysWithinItsBound) {
  for (const Encoding& encoding : encodings()) {
    const Bound* bound = std::find_if(std::begin(kBounds), std::end(kBounds),
                                      [&](const Bound& b) { return encoding.name == b.encoding; });
    ASSERT_NE(bound, std::end(kBounds)) << encoding.name << " has no bound in this test";
    for (const uint bits : {8u, 10u, 12u, 16u}) {
      const double limit = bound->factor / double((1u << bits) - 1u) * 180.0 / M_PI;
      const double worst = worstDegrees(encoding.id, bits);
      EXPECT_LE(worst, 1.001 * limit + 1e-5) << encoding.name << " with " << bits << " bits a channel";
      EXPECT_GE(worst, 0.97 * limit) << "the stated bound of " << encoding.name << " is slack";
      RecordProperty(encoding.name + std::to_string(bits), std::to_string(worst));
    }
  }
}

TEST(Normals, DecodeToUnitLength) {
  Random random(7);
  for (const Encoding& encoding : encodings())
    for (int i = 0; i < 10000; ++i) EXPECT_NEAR(length(roundTrip(encoding.id, random.direction(), 8)), 1.0f, 1e-6f);
}

TEST(Normals, ChannelsStayInRange) {
  for (const Encoding& encoding : encodings()) {
    for (const vec3 n : hardDirections()) {
      const vec3 e = encodeNormal(encoding.id, n, vec3(255.0f, 255.0f, 255.0f));
      for (int c = 0; c < 3; ++c) EXPECT_TRUE(e[c] >= -1e-6f && e[c] <= 1.0f + 1e-6f) << encoding.name;
      if (normalChannels(encoding.id) == 2u) {
        EXPECT_EQ(e.z, 0.0f) << encoding.name;
      }
    }
  }
}

// Float error alone, without quantising: what an encoding itself loses.
TEST(Normals, LoseNothingBeforeTheyAreStored) {
  Random random(8);
  for (const Encoding& encoding : encodings()) {
    for (int i = 0; i < 100000; ++i) {
      const vec3 n = random.direction();
      const vec3 levels(65535.0f, 65535.0f, 65535.0f);
      EXPECT_LE(degreesBetween(decodeNormal(encoding.id, encodeNormal(encoding.id, n, levels)), n), 3e-5)
          << encoding.name;
    }
  }
}

// The generated switch gives each number its own encoding.
TEST(Normals, GeneratedSwitchAgreesWithTheFiles) {
  const vec3 n = normalize(vec3(0.3f, -0.5f, -0.7f)), levels(255.0f, 255.0f, 255.0f);
#define CHECK(name, id)                                                   \
  EXPECT_EQ(kNormal_##name, uint(id));                                    \
  EXPECT_EQ(normalChannels(id), kNormalChannels_##name);                  \
  EXPECT_EQ(encodeNormal(id, n, levels), encodeNormal_##name(n, levels)); \
  EXPECT_EQ(decodeNormal(id, encodeNormal_##name(n, levels)), decodeNormal_##name(encodeNormal_##name(n, levels)));
  LATELIGHT_NORMALS(CHECK)
#undef CHECK
  EXPECT_EQ(normalChannels(static_cast<uint>(encodings().size())), 0u);
}

// Seed 000's OctWrap lacks brackets, and folds the lower half elsewhere: 1 - |y| * sign instead of (1 - |y|) * sign.
TEST(Octahedral, LowerHalfFoldsOverTheDiagonals) {
  const vec2 o = octahedralFromDirection(normalize(vec3(-1.0f, 2.0f, -3.0f)));  // (-1, 2, -3) / 6 before folding
  EXPECT_NEAR(o.x, -2.0f / 3.0f, 1e-6f);                                        // (1 - 2/6) * -1
  EXPECT_NEAR(o.y, 5.0f / 6.0f, 1e-6f);                                         // (1 - 1/6) * 1
}

}  // namespace
}  // namespace latelight::shared
