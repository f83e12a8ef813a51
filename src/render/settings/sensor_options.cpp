#include "render/settings/sensor_options.h"

#include "base/error.h"
#include "base/text.h"
#include "render/settings/settings.h"

namespace latelight::render {

template <>
Vignetting readText<Vignetting>(const char* option, std::string_view text) {
  if (text == "none") return {};
  if (text == "cos4") return {.cos4 = true};
  const std::vector<double> a = parseNumbers<double>(text);
  bool isValid = !a.empty() && a.size() <= 3;
  for (const double coefficient : a) isValid = isValid && coefficient >= -10 && coefficient <= 10;
  if (!isValid)
    badUsage("{} takes none, cos4, or one to three coefficients a1,a2,a3 from -10 to 10, not \"{}\"", option, text);
  Vignetting vignetting;
  for (size_t i = 0; i < a.size(); ++i) vignetting.coefficients[static_cast<int>(i)] = a[i];
  return vignetting;
}

template <>
WhiteBalance readText<WhiteBalance>(const char* option, std::string_view text) {
  const std::vector<double> factors = parseNumbers<double>(text);
  bool isValid = factors.size() == 3;
  for (const double factor : factors) isValid = isValid && factor >= 0 && factor <= 1000;
  if (!isValid) badUsage("{} takes three factors r,g,b from 0 to 1000, not \"{}\"", option, text);
  return {{factors[0], factors[1], factors[2]}};
}

template <>
Response readText<Response>(const char* option, std::string_view text) {
  constexpr size_t kMaxValues = 65536;
  if (text == "display") return {};
  if (text.starts_with("gamma:")) {
    const std::optional<double> gamma = parseNumber<double>(text.substr(6));
    if (!gamma || !(*gamma >= 0.01) || *gamma > 100)
      badUsage("{}: a gamma is a number from 0.01 to 100, as in gamma:2.2, not \"{}\"", option, text);
    return {.gamma = *gamma};
  }
  Response response{.values = parseNumbers<double>(text)};
  bool isValid = response.values.size() >= 2 && response.values.size() <= kMaxValues;
  for (const double value : response.values) isValid = isValid && value >= 0 && value <= 1;
  if (!isValid)
    badUsage("{} takes display, gamma:G, or 2 to {} comma-separated values from 0 to 1, not \"{}\"", option, kMaxValues,
             text);
  return response;
}

}  // namespace latelight::render
