// Finished pictures compared with the integral of light: the claims of docs/accuracy.md, with fewer samples.
#include <gtest/gtest.h>

#include <cstdlib>
#include <set>

#include "long_tests.h"
#include "study/study.h"

namespace latelight::study {
namespace {

// In levels of 255. The bounds for environments are the goal: a mean of 3 for dielectrics and 4 for metals, at any
// roughness. For the sun in the dark, the most difficult case, they are the measured values plus a tenth. Punctual
// lights are shaded by the BRDF itself.
double boundOf(const std::string& light, const std::string& material) {
  if (light.ends_with(" light")) return 0.05;
  if (material == "dielectric") return 3;
  return light == "sun in the dark" ? 5 : 4;
}

TEST(AccuracyStudy, PicturesAreNearTheIntegral) {
  const char* name = std::getenv("LATELIGHT_TEST_DEVICE");
  const Result result = studyAccuracy({.device = name && *name ? name : "cpu",
                                       .validation = true,
                                       .samples = latelight::test::rounds(600'000u, 150'000u)});
  const Table& table = result.tables.front();
  ASSERT_EQ(table.name, "accuracy");
  std::set<std::string> lights;
  for (const std::vector<Cell>& row : table.rows) {
    const std::string &light = std::get<std::string>(row[0]), &material = std::get<std::string>(row[1]);
    lights.insert(light);
    EXPECT_LE(std::get<double>(row[3]), boundOf(light, material))
        << light << ", " << material << ", roughness " << std::get<std::string>(row[2]);
  }
  EXPECT_EQ(lights.size(), 8u);
  EXPECT_EQ(table.rows.size(), 8u * 3 * 3);
}

}  // namespace
}  // namespace latelight::study
