// Every normal encoding checked through the stored bits.
#include "normals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "shared/normal_bounds.h"
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
  return levels == 0.0f ? x : std::floor(clamp(x, 0.0f, 1.0f) * levels + 0.5f) / levels;
}

// Quantizes to channels of `bits` bits; 0: floats.
vec3 roundTrip(uint encoding, vec3 n, uint bits) {
  const float levels = static_cast<float>((1u << bits) - 1u);
  const vec3 all(levels, levels, levels);
  const vec3 e = encodeNormal(encoding, n, all);
  return decodeNormal(encoding, vec3(stored(e.x, levels), stored(e.y, levels), stored(e.z, levels)), all);
}

bool canHold(uint encoding, vec3 n) {
  return !normalHemisphereOnly(encoding) || n.z >= 0.0f;
}

// The angle between unit vectors in degrees, precise near 0, unlike acos.
double degreesBetween(vec3 a, vec3 b) {
  const double x = double(a.y) * b.z - double(a.z) * b.y, y = double(a.z) * b.x - double(a.x) * b.z,
               z = double(a.x) * b.y - double(a.y) * b.x;
  const double cosine = double(a.x) * b.x + double(a.y) * b.y + double(a.z) * b.z;
  return std::atan2(std::sqrt(x * x + y * y + z * z), cosine) * 180.0 / M_PI;
}

// The six axes, the eight corners and twelve edges of the octahedron, its seams (z = 0, x = 0, y = 0), both poles, and
// small steps to all sides.
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
  const auto take = [&](vec3 n) {
    if (canHold(encoding, n)) worst = std::max(worst, degreesBetween(roundTrip(encoding, n, bits), n));
  };
  for (const vec3 n : hardDirections()) take(n);
  Random random(bits);
  for (int i = 0; i < 300000; ++i) take(random.direction());
  return worst;
}

TEST(Normals, ErrorStaysWithinItsBound) {
  for (const Encoding& encoding : encodings()) {
    for (const uint bits : {8u, 10u, 12u, 16u}) {
      const NormalBound bound = normalBound(encoding.name, double((1u << bits) - 1u));
      const double limit = bound.radians * 180.0 / M_PI, worst = worstDegrees(encoding.id, bits);
      EXPECT_LE(worst, 1.001 * limit + 1e-5) << encoding.name << " with " << bits << " bits a channel";
      // Maxima that occur only in small regions are not reached for every number of bits with this number of
      // directions.
      if (bits == 8) {
        EXPECT_GE(worst, bound.tightest * limit) << "the stated bound of " << encoding.name << " is slack";
      }
      RecordProperty(encoding.name + std::to_string(bits), std::to_string(worst));
    }
  }
}

// Rounding each coordinate separately is never better, and often worse.
TEST(Normals, PreciseOctahedralIsTheBestOfItsNeighbours) {
  Random random(6);
  size_t better = 0;
  for (int i = 0; i < 100000; ++i) {
    const vec3 n = random.direction();
    const double rounded = degreesBetween(roundTrip(kNormal_octahedral, n, 8), n),
                 precise = degreesBetween(roundTrip(kNormal_octahedral_precise, n, 8), n);
    EXPECT_LE(precise, rounded + 1e-5);
    better += precise < rounded;
  }
  EXPECT_GT(better, 10000u);
}

// Channels with a code for 0 return axes unchanged, whatever their number of bits.
TEST(Normals, AxesAreExactWhereZeroHasACode) {
  for (const uint bits : {8u, 10u, 12u, 16u})
    for (const float sign : {1.0f, -1.0f}) {
      for (int axis = 0; axis < 3; ++axis) {
        vec3 n(0.0f, 0.0f, 0.0f);
        n[axis] = sign;
        EXPECT_EQ(roundTrip(kNormal_octahedral, n, bits), n) << bits << " bits, axis " << axis;
        EXPECT_EQ(roundTrip(kNormal_octahedral_precise, n, bits), n) << bits << " bits, axis " << axis;
      }
      // The spheremap's equator is a circle of radius sqrt 1/2, which no code hits, so only its poles are exact.
      const vec3 pole(0.0f, 0.0f, sign);
      EXPECT_EQ(roundTrip(kNormal_spheremap_signed, pole, bits), pole) << bits << " bits";
    }
}

TEST(Normals, XyZMirrorsWhatPointsAway) {
  const vec3 n = normalize(vec3(0.3f, -0.4f, -0.6f)), back = roundTrip(kNormal_xy_z, n, 16);
  EXPECT_NEAR(back.x, n.x, 1e-4f);
  EXPECT_NEAR(back.y, n.y, 1e-4f);
  EXPECT_NEAR(back.z, -n.z, 1e-4f);
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

// Float channels: the remaining error is that of 32-bit floats, which have about 2^23 steps between 1/2 and 1, and of
// the functions on them.
TEST(Normals, LoseNothingBeforeTheyAreStored) {
  Random random(8);
  for (const Encoding& encoding : encodings()) {
    const double limit = normalBound(encoding.name, 0x1p23).radians * 180.0 / M_PI;
    std::vector<vec3> directions = hardDirections();
    for (int i = 0; i < 100000; ++i) directions.push_back(random.direction());
    for (const vec3 n : directions)
      if (canHold(encoding.id, n)) {
        EXPECT_LE(degreesBetween(roundTrip(encoding.id, n, 0), n), limit + 3e-5) << encoding.name;
      }
  }
}

// The generated switch assigns each number its own encoding.
TEST(Normals, GeneratedSwitchAgreesWithTheFiles) {
  const vec3 n = normalize(vec3(0.3f, -0.5f, -0.7f)), levels(255.0f, 255.0f, 255.0f);
#define CHECK(name, id)                                                   \
  EXPECT_EQ(kNormal_##name, uint(id));                                    \
  EXPECT_EQ(normalChannels(id), kNormalChannels_##name);                  \
  EXPECT_EQ(encodeNormal(id, n, levels), encodeNormal_##name(n, levels)); \
  EXPECT_EQ(normalHemisphereOnly(id), kNormalHemisphere_##name != 0u);    \
  EXPECT_EQ(decodeNormal(id, encodeNormal_##name(n, levels), levels),     \
            decodeNormal_##name(encodeNormal_##name(n, levels), levels));
  LATELIGHT_NORMALS(CHECK)
#undef CHECK
  EXPECT_EQ(normalChannels(static_cast<uint>(encodings().size())), 0u);
}

// Without parentheses, the lower half would fold elsewhere: 1 - |y| * sign instead of (1 - |y|) * sign.
TEST(Octahedral, LowerHalfFoldsOverTheDiagonals) {
  const vec2 o = octahedralFromDirection(normalize(vec3(-1.0f, 2.0f, -3.0f)));  // (-1, 2, -3) / 6 before folding
  EXPECT_NEAR(o.x, -2.0f / 3.0f, 1e-6f);                                        // (1 - 2/6) * -1
  EXPECT_NEAR(o.y, 5.0f / 6.0f, 1e-6f);                                         // (1 - 1/6) * 1
}

// The published formulas in their domains. CryEngine 3's and Lambert's are the same map.
TEST(Spheremap, MatchesPublishedFormulas) {
  Random random(9);
  for (int i = 0; i < 10000; ++i) {
    const vec3 n = random.direction();
    const double x = n.x, y = n.y, z = n.z, across = std::sqrt(x * x + y * y);
    if (across < 1e-2) continue;
    const double r = std::sqrt(-z * 0.5 + 0.5), laea = std::sqrt(8.0 * z + 8.0);
    const vec3 none(0.0f, 0.0f, 0.0f);
    const vec3 spheremap = encodeNormal_spheremap(n, none), lambert = encodeNormal_lambert(n, none);
    EXPECT_NEAR(spheremap.x, x / across * r * 0.5 + 0.5, 1e-5);
    EXPECT_NEAR(spheremap.y, y / across * r * 0.5 + 0.5, 1e-5);
    EXPECT_NEAR(lambert.x, x / laea + 0.5, 1e-5);
    EXPECT_NEAR(lambert.y, y / laea + 0.5, 1e-5);
  }
}

}  // namespace
}  // namespace latelight::shared
