// Layered materials: limit cases, the specifications' formulas in double precision, and integrals that check energy
// conservation.
#include "shared/layers.h"

#include <gtest/gtest.h>

#include "shared/layers_reference.h"
#include "shared/random.h"

namespace latelight::shared {
namespace {

using reference::Vec;

constexpr uint kShadings[] = {kShadingGgx, kShadingBlinnPhong, kShadingGgxCompensated};
const vec3 kZ(0.0f, 0.0f, 1.0f), kWhite(1.0f, 1.0f, 1.0f), kBlack(0.0f, 0.0f, 0.0f);

vec3 float3(const Vec& v) {
  return vec3(float(v[0]), float(v[1]), float(v[2]));
}
vec3 eyeAt(double cosine, double azimuth = 0.0) {
  const double sine = std::sqrt(1.0 - cosine * cosine);
  return float3({sine * std::cos(azimuth), sine * std::sin(azimuth), cosine});
}

Surface someSurface(Random& random, float roughness) {
  Surface s = emptySurface();
  s.position = random.color();
  s.normal = random.direction();
  s.baseColor = random.color();
  s.metallic = std::round(random.uniform(0.0f, 2.0f)) * 0.5f;
  s.roughness = roughness;
  s.f90 = random.uniform();
  s.f0 = random.color() * s.f90;
  s.ao = random.uniform();
  return s;
}

// Every layer except the film and the volume, each present in half of the results.
SurfaceLayers someLayers(Random& random, const Surface& s) {
  const auto share = [&] { return random.uniform() < 0.5f ? random.uniform() : 0.0f; };
  SurfaceLayers l = emptyLayers();
  l.clearcoat = share();
  l.clearcoatRoughness = random.uniform(0.1f, 1.0f);
  l.clearcoatNormal = normalize(s.normal + random.direction() * 0.3f);
  l.sheenColor = random.color() * share();
  l.sheenRoughness = random.uniform(0.1f, 1.0f);
  l.anisotropy = share();
  l.anisotropyDirection = normalize(cross(s.normal, random.direction()));
  l.ior = random.uniform(1.3f, 2.0f);
  l.transmission = share();
  l.diffuseTransmission = share();
  l.diffuseTransmissionColor = random.color();
  return l;
}

// The values of the split-sum table, by integration.
vec2 tableAt(vec2 place) {
  const double nv = std::clamp(double(place.x), 1e-4, 1.0), alpha = ggxAlpha(place.y);
  const Vec v{std::sqrt(1.0 - nv * nv), 0.0, nv}, n{0.0, 0.0, 1.0};
  const auto sum = [&](double power) {
    return reference::integrateLobe(60, v, alpha, [&](const Vec& l) {
      const double weight = reference::schlickWeight(reference::dot(v, reference::halfway(l, v)));
      return reference::ggx(n, l, v, alpha) * l[2] * std::pow(weight, power);
    });
  };
  const double whole = sum(0.0), grazing = sum(1.0);
  return vec2(float(whole - grazing), float(grazing));
}
LayerTables tablesFor(const Surface& s, const SurfaceLayers& l, vec3 toEye) {
  const LayerTables places = layerTableCoordinates(s, l, toEye);
  return {tableAt(places.base), tableAt(places.coat), tableAt(places.behind)};
}
constexpr vec2 kSomeTable(0.7f, 0.1f);
const LayerTables kSomeTables{kSomeTable, vec2(0.9f, 0.05f), vec2(0.8f, 0.05f)};

vec3 lit(const LayeredBrdf& b, vec3 toLight, uint shading) {
  return shadeLayeredLight(b, LightSample{toLight, kWhite, 1.0f}, shading);
}

// --- limits ----------------------------------------------------------------------------------------------------------

TEST(Layers, OfStrengthZeroArePlainToTheBit) {
  Random random(1);
  for (const uint shading : kShadings) {
    for (int i = 0; i < 5000; ++i) {
      Surface s = someSurface(random, random.uniform());
      SurfaceLayers l = someLayers(random, s);
      l.clearcoat = l.anisotropy = l.transmission = l.diffuseTransmission = 0.0f;
      l.sheenColor = kBlack;
      l.thickness = random.uniform();
      l.dispersion = random.uniform();
      const vec3 eye = random.directionAbout(s.normal), light = random.direction(), radiance = random.color();
      const LayeredBrdf b = layeredBrdf(s, l, eye, shading, kSomeTables);
      s.scattered = surfaceReflectance(s, kSomeTable).scattered;
      EXPECT_EQ(lit(b, light, shading), shadeLight(surfaceBrdf(s, eye, shading), {light, kWhite, 1.0f}, shading));
      const LayerLight found{radiance, random.color(), random.color(), radiance * 0.5f, random.color()};
      EXPECT_EQ(shadeLayeredEnvironment(b, found), shadeEnvironment(s, eye, radiance, radiance * 0.5f, kSomeTable));
      EXPECT_EQ(transmittedRadiance(b, kWhite), kBlack);
      EXPECT_EQ(coatedEmission(b, radiance), radiance);
    }
  }
}

TEST(Layers, StretchedLobeOfOneWidthIsRound) {
  Random random(2);
  for (int i = 0; i < 20000; ++i) {
    const vec3 n = random.direction(), l = random.directionAbout(n), v = random.directionAbout(n);
    const float roughness = random.uniform(), nl = dot(n, l), nv = dot(n, v), alpha = ggxAlpha(roughness);
    if (nl < 1e-3f || nv < 1e-3f) continue;
    const vec3 h = halfVector(l, v);
    const StretchedFrame f = stretchedFrame(n, normalize(cross(n, random.direction())), roughness, 0.0f);
    const float round = ggxLobe(halfAngles(n, l, v), nl, nv, alpha * alpha, smithRoot(nv, alpha * alpha));
    EXPECT_NEAR(stretchedLobe(f, l, v, h, nl, nv) / round, 1.0f, 1e-3f);
  }
}

TEST(Layers, FilmWithoutThicknessOrIndexReflectsLikeTheSurface) {
  for (const float f0 : {0.0f, 0.02f, 0.04f, 0.3f, 0.8f}) {
    const vec3 color(f0, f0 * 0.5f, f0 * f0);
    for (const float cosine : {1.0f, 0.7f, 0.3f, 0.05f})
      EXPECT_EQ(thinFilm(color, 1.5f, 0.0f, cosine), schlick(color, 1.0f, cosine));
    EXPECT_LE(length(thinFilm(color, 1.0f, 400.0f, 1.0f) - color), 1e-6f) << f0;
  }
}

TEST(Layers, VolumeWithoutRefractionIsSeenStraightThrough) {
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const Surface s = someSurface(random, 0.5f);
    SurfaceLayers l = emptyLayers();
    l.transmission = 1.0f;
    const vec3 eye = random.directionAbout(s.normal);
    if (dot(s.normal, eye) < 0.01f) continue;
    const TransmittedRay thin = transmittedRay(layeredBrdf(s, l, eye, kShadingGgx, kSomeTables), 0u);
    EXPECT_EQ(thin.direction, eye * -1.0f);
    EXPECT_EQ(thin.exit, s.position);
    EXPECT_EQ(thin.roughness, s.roughness);
    l.thickness = 2.0f;
    l.ior = 1.0f;
    l.dispersion = 1.0f;
    const TransmittedRay air = transmittedRay(layeredBrdf(s, l, eye, kShadingGgx, kSomeTables), 2u);
    EXPECT_LE(length(air.direction + eye), 3e-6f);
    EXPECT_LE(length(air.exit - (s.position - eye * 2.0f)), 3e-6f);
    EXPECT_EQ(air.roughness, 0.0f);
  }
}

TEST(Layers, AreFiniteAndNotNegativeEverywhere) {
  Random random(4);
  const auto extreme = [&](float most) {
    const float choice = random.uniform();
    return choice < 0.2f ? 0.0f : (choice < 0.4f ? most : (choice < 0.5f ? 1e30f : random.uniform(0.0f, most)));
  };
  for (int i = 0; i < 60000; ++i) {
    const uint shading = kShadings[i % 3];
    Surface s = someSurface(random, i % 5 == 0 ? 0.0f : random.uniform());
    SurfaceLayers l = someLayers(random, s);
    l.clearcoatRoughness = l.sheenRoughness = i % 7 == 0 ? 0.0f : random.uniform();
    l.iridescence = extreme(1.0f), l.iridescenceIor = 1.0f + extreme(2.0f), l.iridescenceThickness = extreme(1000.0f);
    l.ior = 1.0f + random.uniform(0.0f, 2.0f) * float(i % 2), l.thickness = extreme(1.0f);
    l.absorption = absorptionOf(random.color() * float(i % 2), extreme(1.0f)), l.dispersion = extreme(5.0f);
    const vec3 light = random.direction();
    vec3 eye = random.direction();
    if (i % 3 == 0) eye = light * -1.0f;
    if (i % 4 == 1) eye = s.normal * -1.0f;
    if (i % 8 == 2) eye = s.normal;
    const LayerTables places = layerTableCoordinates(s, l, eye);
    for (const vec2 place : {places.base, places.coat, places.behind})
      EXPECT_TRUE(place.x >= 0.0f && place.x <= 1.0f && place.y >= 0.0f && place.y <= 1.0f);
    const LayeredBrdf b = layeredBrdf(s, l, eye, shading, kSomeTables);
    const LayerLight found{kWhite, kWhite, kWhite, kWhite, kWhite};
    const vec3 direction = transmittedRay(b, uint(i) % 3u).direction;
    for (const vec3 value : {lit(b, light, shading), shadeLayeredEnvironment(b, found), transmittedRadiance(b, kWhite)})
      for (int c = 0; c < 3; ++c) EXPECT_TRUE(std::isfinite(value[c]) && value[c] >= 0.0f) << i << ' ' << value[c];
    EXPECT_NEAR(length(direction), 1.0f, 1e-5f);
  }
}

// --- against the specifications --------------------------------------------------------------------------------------

TEST(Layers, FollowTheSpecificationsForLightsOnBothSides) {
  Random random(5);
  int behind = 0;
  for (int i = 0; i < 50000; ++i) {
    const Surface s = someSurface(random, random.uniform(0.1f, 1.0f));
    const SurfaceLayers l = someLayers(random, s);
    const vec3 eye = random.directionAbout(s.normal), light = random.direction();
    const Vec le = reference::unit(reference::vec(light)), ve = reference::unit(reference::vec(eye));
    if (dot(s.normal, eye) < 1e-2f || std::abs(dot(s.normal, light)) < 1e-2f) continue;
    if (dot(l.clearcoatNormal, eye) < 1e-2f || std::abs(dot(l.clearcoatNormal, light)) < 1e-2f) continue;
    const LayeredBrdf b = layeredBrdf(s, l, eye, kShadingGgx, kSomeTables);
    if (b.sheenScale < 1.0f) continue;  // the sheen of the specification creates energy there
    const vec3 actual = lit(b, light, kShadingGgx);
    const Vec expected = reference::layeredRadiance(s, l, le, ve, b.sheenAlbedo);
    behind += dot(s.normal, light) < 0.0f && expected[0] > 0.0;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(actual[c], expected[c], 5e-4 * expected[c] + 1e-6);
  }
  EXPECT_GT(behind, 5000);
}

// Over dielectrics, and over metals, for which the series that shading truncates converges slowly.
TEST(ThinFilm, FollowsTheSpectralIntegral) {
  for (const auto& [f0, mostWorst, mostMean] :
       {std::array{0.04f, 0.03f, 0.005f}, {0.5f, 0.06f, 0.01f}, {0.9f, 0.18f, 0.02f}}) {
    double worst = 0.0, sum = 0.0;
    int count = 0;
    for (const float ior : {1.1f, 1.33f, 1.8f, 2.2f}) {
      for (const float thickness : {5.0f, 60.0f, 150.0f, 300.0f, 550.0f, 1200.0f}) {
        for (const float cosine : {1.0f, 0.8f, 0.4f, 0.15f}) {
          const vec3 film = thinFilm(vec3(f0, f0, f0), ior, thickness, cosine);
          const Vec integral = reference::filmColor(f0, ior, thickness, cosine);
          for (int c = 0; c < 3; ++c, ++count) {
            worst = std::max(worst, std::abs(film[c] - integral[c]));
            sum += std::abs(film[c] - integral[c]);
          }
        }
      }
    }
    EXPECT_LE(worst, mostWorst) << "f0 " << f0;
    EXPECT_LE(sum / count, mostMean) << "f0 " << f0;
    RecordProperty("worst and mean of " + std::to_string(f0),
                   std::to_string(worst) + " " + std::to_string(sum / count));
  }
}

TEST(ThinFilm, AnglesOfFacetsAreThoseOfTheLobe) {
  const Vec n{0.0, 0.0, 1.0};
  double worst = 0.0;
  for (const float roughness : {0.1f, 0.3f, 0.5f, 0.7f, 1.0f}) {
    for (const double cosine : {1.0, 0.8, 0.6, 0.4, 0.2, 0.1}) {
      const double alpha = ggxAlpha(roughness);
      const Vec v{std::sqrt(1.0 - cosine * cosine), 0.0, cosine};
      const auto moment = [&](double power) {
        return reference::integrateLobe(80, v, alpha, [&](const Vec& l) {
          return reference::ggx(n, l, v, alpha) * l[2] * std::pow(reference::dot(v, reference::halfway(l, v)), power);
        });
      };
      const double mean = moment(1.0) / moment(0.0), square = moment(2.0) / moment(0.0);
      const FacetCosines facets = facetCosines(float(cosine), float(alpha));
      worst =
          std::max({worst, std::abs(facets.mean - mean), std::abs(facets.spread - std::sqrt(square - mean * mean))});
    }
  }
  EXPECT_LE(worst, 0.055);
  RecordProperty("worst", std::to_string(worst));
}

TEST(Transmission, AbsorbsByBeersLaw) {
  Random random(6);
  for (int i = 0; i < 1000; ++i) {
    const vec3 color = random.color();
    const float distance = random.logUniform(1e-3f, 1e3f), path = distance * random.uniform(0.0f, 2.0f);
    const vec3 left = beersLaw(absorptionOf(color, distance), path);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(left[c], std::pow(double(color[c]), double(path) / distance), 1e-5);
  }
  EXPECT_EQ(absorptionOf(vec3(0.5f, 0.5f, 0.5f), INFINITY), kBlack);
  EXPECT_EQ(absorptionOf(vec3(0.5f, 0.5f, 0.5f), 0.0f), kBlack);
  EXPECT_EQ(absorptionOf(kWhite, 1.0f), kBlack);
}

TEST(Transmission, RefractsBySnellsLawAndDispersesByTheAbbeNumber) {
  Random random(7);
  for (int i = 0; i < 10000; ++i) {
    const vec3 n = random.direction(), v = random.directionAbout(n);
    const float ior = random.uniform(1.0f, 3.0f), nv = dot(n, v);
    if (nv < 1e-3f) continue;
    const vec3 ray = refractedRay(n, v, nv, ior);
    EXPECT_NEAR(length(cross(n, ray)) * ior, length(cross(n, v)), 2e-6f);
    EXPECT_NEAR(dot(cross(n, v), ray), 0.0f, 1e-6f);
    EXPECT_LE(dot(n, ray), 0.0f);
  }
  // Crown glass: (n_d - 1) / (n_F - n_C) is 59.
  EXPECT_NEAR(0.52 / (dispersedIor(1.52f, 20.0f / 59.0f, 2u) - dispersedIor(1.52f, 20.0f / 59.0f, 0u)), 59.0, 1e-2);
  EXPECT_EQ(dispersedIor(1.52f, 0.3f, 1u), 1.52f);
  EXPECT_EQ(dispersedIor(1.1f, 1000.0f, 0u), 1.0f);
}

// --- integrals -------------------------------------------------------------------------------------------------------

TEST(Charlie, DistributionIntegratesToOneOverTheProjectedHemisphere) {
  for (const float roughness : {0.0f, 0.1f, 0.3f, 0.6f, 1.0f}) {
    const double sum = reference::integrateHemisphere(2000, [&](const Vec& h) {
      return charlieDistribution(float(1.0 - h[2] * h[2]), charlieAlpha(roughness)) * h[2];
    });
    EXPECT_NEAR(sum, 1.0, 1e-4) << "roughness " << roughness;
  }
}

TEST(Charlie, AlbedoIsThatOfTheIntegral) {
  double worst = 0.0;
  for (const float roughness : {0.0f, 0.1f, 0.2f, 0.35f, 0.5f, 0.75f, 1.0f}) {
    for (const double cosine : {1.0, 0.8, 0.6, 0.4, 0.25, 0.12, 0.06, 0.03, 0.01}) {
      const Vec v{std::sqrt(1.0 - cosine * cosine), 0.0, cosine}, n{0.0, 0.0, 1.0};
      // Cells are denser at the horizon, where a smooth lobe lies: z = t^2.
      const double integral = reference::integrateHemisphere(300, [&](const Vec& cell) {
        const double z = cell[2] * cell[2], flat = std::hypot(cell[0], cell[1]), r = std::sqrt(1.0 - z * z);
        const Vec l{cell[0] / flat * r, cell[1] / flat * r, z};
        return reference::charlie(n, l, v, charlieAlpha(roughness)) * z * 2.0 * cell[2];
      });
      worst = std::max(worst, std::abs(charlieAlbedo(float(cosine), roughness) - integral) / std::max(integral, 1.0));
    }
  }
  EXPECT_LE(worst, 0.045);
  RecordProperty("worst", std::to_string(worst));
}

TEST(StretchedLobe, DistributionIntegratesToOneOverTheProjectedHemisphere) {
  for (const auto& [roughness, strength] : {std::array{0.3f, 0.5f}, {0.5f, 1.0f}, {0.8f, 0.3f}, {1.0f, 1.0f}}) {
    const StretchedFrame f = stretchedFrame(kZ, vec3(0.6f, 0.8f, 0.0f), roughness, strength);
    const double sum =
        reference::integrateHemisphere(800, [&](const Vec& h) { return stretchedDistribution(f, float3(h)) * h[2]; });
    EXPECT_NEAR(sum, 1.0, 2e-3) << roughness << ' ' << strength;
  }
}

// Smith's masking: the visible facets have together the projected area of the surface (Heitz 2014, equation 14). The
// masking of one direction is 2 n.v / (n.v + root).
TEST(StretchedLobe, MaskingLeavesTheVisibleArea) {
  const StretchedFrame f = stretchedFrame(kZ, vec3(1.0f, 0.0f, 0.0f), 0.5f, 0.7f);
  for (const double cosine : {1.0, 0.6, 0.2}) {
    for (const double azimuth : {0.0, 0.7, 1.57}) {
      const vec3 v = eyeAt(cosine, azimuth);
      const double masking = 2.0 * v.z / (v.z + stretchedRoot(f, v, v.z));
      const double area = reference::integrateHemisphere(
          800, [&](const Vec& h) { return std::max(dot(v, float3(h)), 0.0f) * stretchedDistribution(f, float3(h)); });
      EXPECT_NEAR(area * masking / v.z, 1.0, 5e-3) << cosine << ' ' << azimuth;
    }
  }
}

// The directions represent everything that the lobe reflects: their shares are those of the integral over lights.
TEST(StretchedLobe, DirectionsHaveTheSharesOfTheIntegral) {
  double worst = 0.0;
  for (const auto& [roughness, strength] : {std::array{0.5f, 0.5f}, {0.4f, 1.0f}, {0.8f, 0.3f}}) {
    const StretchedFrame f = stretchedFrame(kZ, vec3(1.0f, 0.0f, 0.0f), roughness, strength);
    for (const double cosine : {1.0, 0.6, 0.2}) {
      for (const double azimuth : {0.0, 0.7, 1.57}) {
        const vec3 v = eyeAt(cosine, azimuth);
        const auto share = [&](double power) {
          return reference::integrateHemisphere(300, [&](const Vec& d) {
            const vec3 l = float3(d), h = halfVector(l, v);
            return double(stretchedLobe(f, l, v, h, l.z, v.z) * l.z) * std::pow(schlickWeight(dot(v, h)), power);
          });
        };
        const vec2 table = stretchedTable(f, v, v.z);
        const double grazing = share(1.0);
        worst = std::max({worst, std::abs(table.y - grazing), std::abs(table.x - (share(0.0) - grazing))});
      }
    }
  }
  EXPECT_LE(worst, 0.012);
  RecordProperty("worst", std::to_string(worst));
}

// Light from one half of the sky only: the mean over the directions compared with the integral over lights.
TEST(Sheen, DirectionsFindTheMeanOfTheIntegral) {
  double worst = 0.0, sum = 0.0;
  int count = 0;
  for (const float roughness : {0.3f, 0.6f, 1.0f}) {
    for (const double cosine : {0.9, 0.5, 0.2}) {
      for (const Vec& lit : {Vec{1.0, 0.0, 0.0}, Vec{0.0, 1.0, 0.0}, Vec{-0.6, 0.0, 0.8}, Vec{0.6, 0.0, 0.8}}) {
        const vec3 v = eyeAt(cosine), along = alongEye(kZ, v);
        const auto radiance = [&](const vec3& l) { return std::max(dot(float3(lit), l), 0.0f); };
        double weights = 0.0, found = 0.0;
        for (uint i = 0; i < kSheenSamples; ++i) {
          const SheenSample s = sheenSample(kZ, along, v, v.z, roughness, i);
          EXPECT_NEAR(length(s.toLight), 1.0f, 1e-5f);
          weights += s.weight, found += s.weight * radiance(s.toLight);
        }
        const Vec n{0.0, 0.0, 1.0}, eye{std::sqrt(1.0 - cosine * cosine), 0.0, cosine};
        const auto integral = [&](bool seen) {
          return reference::integrateHemisphere(200, [&](const Vec& l) {
            return reference::charlie(n, l, eye, charlieAlpha(roughness)) * l[2] * (seen ? radiance(float3(l)) : 1.0f);
          });
        };
        const double apart = std::abs(found / weights - integral(true) / integral(false));
        worst = std::max(worst, apart), sum += apart, ++count;
      }
    }
  }
  EXPECT_LE(worst, 0.01);
  EXPECT_LE(sum / count, 0.004);
  RecordProperty("worst and mean", std::to_string(worst) + " " + std::to_string(sum / count));
}

TEST(Layers, ThoseThatLookAtBothSidesAlikeAreReciprocal) {
  Random random(8);
  for (int i = 0; i < 20000; ++i) {
    const Surface s = someSurface(random, random.uniform(0.1f, 1.0f));
    SurfaceLayers l = someLayers(random, s);
    l.clearcoat = 0.0f;
    l.sheenColor = kBlack;
    l.iridescence = i % 3 == 0 ? random.uniform() : 0.0f;
    const vec3 a = random.directionAbout(s.normal), c = random.direction();
    const float na = dot(s.normal, a), nc = dot(s.normal, c);
    if (na < 1e-2f || std::abs(nc) < 1e-2f) continue;
    Surface turned = s;
    if (nc < 0.0f) turned.normal = s.normal * -1.0f;
    const vec3 forth = lit(layeredBrdf(s, l, a, kShadingGgx, kSomeTables), c, kShadingGgx) / std::abs(nc);
    const vec3 back = lit(layeredBrdf(turned, l, c, kShadingGgx, kSomeTables), a, kShadingGgx) / na;
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(forth[k], back[k], 2e-3f * std::max(forth[k], 1e-3f));
  }
}

struct Furnace {
  const char* name;
  void (*set)(Surface& s, SurfaceLayers& l);
  // minimum and maximum share of uniform light from all sides that is reflected, with energy compensation
  double least, most;
};
constexpr Furnace kFurnaces[] = {
    {"coat", [](Surface&, SurfaceLayers& l) { l.clearcoat = 1.0f; }, 0.99, 1.01},
    {"rough coat", [](Surface&, SurfaceLayers& l) { l.clearcoat = l.clearcoatRoughness = 1.0f; }, 0.99, 1.005},
    {"sheen", [](Surface&, SurfaceLayers& l) { l.sheenColor = kWhite; }, 0.96, 1.01},
    {"stretched metal", [](Surface& s, SurfaceLayers& l) { s.metallic = 1.0f, l.anisotropy = 0.5f; }, 0.985, 1.012},
    {"fully stretched metal", [](Surface& s, SurfaceLayers& l) { s.metallic = l.anisotropy = 1.0f; }, 0.985, 1.012},
    {"film", [](Surface&, SurfaceLayers& l) { l.iridescence = 1.0f; }, 0.95, 1.01},
    {"thin wall", [](Surface&, SurfaceLayers& l) { l.transmission = 1.0f; }, 0.98, 1.02},
    {"volume", [](Surface&, SurfaceLayers& l) { l.transmission = l.thickness = 1.0f; }, 0.99, 1.01},
    {"leaf", [](Surface&, SurfaceLayers& l) { l.diffuseTransmission = 0.7f; }, 0.99, 1.005},
    {"all but metal",
     [](Surface&, SurfaceLayers& l) {
       l.clearcoat = 0.7f, l.clearcoatRoughness = 0.4f, l.sheenColor = vec3(0.5f, 0.5f, 0.5f);
       l.transmission = 0.5f, l.diffuseTransmission = 0.5f;
     },
     0.98, 1.01},
};

// Both sides of the surface are in a white room; energy is neither created nor lost beyond the approximations' bounds.
TEST(Layers, WhiteOnesReturnAllLight) {
  for (const Furnace& f : kFurnaces) {
    double least = 9.0, most = 0.0;
    for (const auto& [roughness, azimuth] : {std::array{0.4f, 0.5f}, {0.4f, 1.4f}, {0.7f, 0.0f}, {1.0f, 0.8f}}) {
      for (const double cosine : {1.0, 0.7, 0.4, 0.2, 0.1}) {
        Surface s = emptySurface();
        s.baseColor = kWhite, s.roughness = roughness, s.f0 = vec3(0.04f, 0.04f, 0.04f), s.f90 = 1.0f;
        SurfaceLayers l = emptyLayers();
        l.clearcoatRoughness = 0.4f, l.sheenRoughness = roughness;
        f.set(s, l);
        const vec3 eye = eyeAt(cosine, azimuth);
        const LayeredBrdf b = layeredBrdf(s, l, eye, kShadingGgxCompensated, tablesFor(s, l, eye));
        const double share = reference::integrateHemisphere(120, [&](const Vec& d) {
          const vec3 front = float3(d), back = vec3(front.x, front.y, -front.z);
          return double(lit(b, front, kShadingGgxCompensated).y) + double(lit(b, back, kShadingGgxCompensated).y);
        });
        least = std::min(least, share), most = std::max(most, share);
      }
    }
    EXPECT_GE(least, f.least) << f.name;
    EXPECT_LE(most, f.most) << f.name;
    RecordProperty(f.name, std::to_string(least) + " to " + std::to_string(most));
  }
}

// An environment of radiance 1 on all sides, including behind the transmissive surface, is indistinguishable from it.
TEST(Layers, WhiteOnesVanishInAWhiteRoom) {
  for (const Furnace& f : kFurnaces) {
    for (const float roughness : {0.0f, 0.4f, 1.0f}) {
      for (const double cosine : {1.0, 0.5, 0.1}) {
        Surface s = emptySurface();
        s.baseColor = kWhite, s.roughness = roughness, s.f0 = vec3(0.04f, 0.04f, 0.04f), s.f90 = 1.0f;
        SurfaceLayers l = emptyLayers();
        l.sheenRoughness = roughness;
        f.set(s, l);
        l.iridescence = 0.0f;
        const vec3 eye = eyeAt(cosine);
        const LayeredBrdf b = layeredBrdf(s, l, eye, kShadingGgx, tablesFor(s, l, eye));
        const LayerLight white{kWhite, kWhite, kWhite, kWhite, kWhite};
        const vec3 seen = shadeLayeredEnvironment(b, white) + transmittedRadiance(b, kWhite);
        EXPECT_NEAR(seen.x, 1.0f, 2e-6f) << f.name;
      }
    }
  }
}

// The radiance of a stretched lobe under white light from all directions.
vec3 underWhite(LayeredBrdf b) {
  const FilmCurve film = filmCurve(b);
  StretchedSum sum = emptySum();
  for (uint i = 0u; i < kStretchedSamples; ++i) addSample(sum, b, film, baseSample(b, i), kWhite);
  LayerLight white{kWhite, kWhite, kWhite, kWhite, kWhite};
  white.base = meanOfSum(b, sum);
  return shadeLayeredEnvironment(b, white);
}

// With a film some colors are lost, because the largest channel decides how much light reaches the base; none is
// created.
TEST(Layers, FilmsMakeNoLight) {
  Random random(9);
  float mixed = 0.0f;
  for (int i = 0; i < 2000; ++i) {
    Surface s = someSurface(random, random.uniform());
    s.baseColor = kWhite, s.f0 = vec3(0.04f, 0.04f, 0.04f), s.f90 = 1.0f, s.ao = 1.0f;
    SurfaceLayers l = emptyLayers();
    l.iridescence = 1.0f, l.iridescenceIor = random.uniform(1.0f, 2.5f),
    l.iridescenceThickness = random.uniform(0.0f, 1500.0f);
    const vec3 eye = random.directionAbout(s.normal);
    const LayeredBrdf b = layeredBrdf(s, l, eye, kShadingGgx, kSomeTables);
    const vec3 seen = shadeLayeredEnvironment(b, {kWhite, kWhite, kWhite, kWhite, kWhite});
    for (int c = 0; c < 3; ++c) EXPECT_LE(seen[c], 1.00001f);
    l.anisotropy = random.uniform();
    l.anisotropyDirection = normalize(cross(s.normal, random.direction()));
    // The film over a mixture of a metal and a dielectric is evaluated once, so the split between both is approximate.
    mixed = std::max(mixed, maxChannel(underWhite(layeredBrdf(s, l, eye, kShadingGgx, kSomeTables))));
    s.metallic = float(i % 2);
    EXPECT_LE(maxChannel(underWhite(layeredBrdf(s, l, eye, kShadingGgx, kSomeTables))), 1.00001f);
  }
  EXPECT_LE(mixed, 1.02f);
  RecordProperty("stretched lobes of half metals", std::to_string(mixed));
}

// The minimum fraction of white light in a channel that a white dielectric with a film returns under an environment, as
// in docs/accuracy.md.
TEST(Layers, FilmsLoseLight) {
  constexpr float kIors[] = {1.3f, 1.5f, 1.8f, 2.5f}, kRoughness[] = {0.0f, 0.2f, 0.4f, 0.6f, 1.0f};
  constexpr double kLeast[4][5] = {{0.822, 0.852, 0.918, 0.936, 0.955},
                                   {0.948, 0.957, 0.974, 0.981, 0.991},
                                   {0.843, 0.854, 0.882, 0.892, 0.917},
                                   {0.577, 0.589, 0.628, 0.638, 0.683}};
  for (int r = 0; r < 5; ++r) {
    float least[4] = {1, 1, 1, 1};
    for (int step = 1; step <= 10; ++step) {
      Surface s = emptySurface();
      s.baseColor = kWhite, s.roughness = kRoughness[r], s.f0 = vec3(0.04f, 0.04f, 0.04f), s.f90 = 1.0f;
      SurfaceLayers l = emptyLayers();
      l.iridescence = 1.0f;
      const vec3 eye = eyeAt(0.1 * step);
      const LayerTables tables = tablesFor(s, l, eye);
      for (int i = 0; i < 4; ++i)
        for (float thickness = 0.0f; thickness <= 1200.0f; thickness += 10.0f) {
          l.iridescenceIor = kIors[i], l.iridescenceThickness = thickness;
          const LayeredBrdf b = layeredBrdf(s, l, eye, kShadingGgx, tables);
          const vec3 seen = shadeLayeredEnvironment(b, {kWhite, kWhite, kWhite, kWhite, kWhite});
          least[i] = std::min({least[i], seen.x, seen.y, seen.z});
        }
    }
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(least[i], kLeast[i][r], 1e-3) << kIors[i] << ' ' << kRoughness[r];
  }
}

// The fraction of light that a film on a stretched lobe reflects is that of its three angles, also where it decides how
// much light reaches the base: a white base returns all light of the channel that the film reflects most.
TEST(Layers, StretchedFilmsReturnAllLightOfAChannel) {
  for (const float ior : {1.3f, 1.8f})
    for (const double cosine : {1.0, 0.7, 0.4, 0.15})
      for (const float thickness : {250.0f, 400.0f, 700.0f})
        for (const float strength : {0.01f, 0.4f, 1.0f}) {
          Surface s = emptySurface();
          s.baseColor = kWhite, s.roughness = 0.4f, s.f0 = vec3(0.04f, 0.04f, 0.04f), s.f90 = 1.0f;
          SurfaceLayers l = emptyLayers();
          l.iridescence = 1.0f, l.iridescenceIor = ior, l.iridescenceThickness = thickness, l.anisotropy = strength;
          const vec3 eye = eyeAt(cosine, 0.5f);
          const vec3 seen = underWhite(layeredBrdf(s, l, eye, kShadingGgx, kSomeTables));
          EXPECT_NEAR(maxChannel(seen), 1.0f, 1e-5f) << ior << ' ' << cosine << ' ' << thickness << ' ' << strength;
        }
}

}  // namespace
}  // namespace latelight::shared
