#include "report/study_page.h"

#include <fmt/format.h>

#include "report/chart.h"
#include "report/command.h"
#include "report/html.h"
#include "report/planes.h"
#include "report/spheres.h"
#include "study/normal_error.h"

namespace latelight::report {

namespace {

std::string plotsOf(const study::Result& result) {
  std::string html;
  for (const study::Plot& plot : result.plots) html += toHtml(plot);
  return html;
}

std::string picturesOf(const study::Result& result) {
  std::string html;
  for (size_t i = 0; i < result.pictures.size(); ++i) {
    const study::NamedPicture& each = result.pictures[i];
    if (each.name.starts_with("normals-map")) continue;  // the spheres show these maps
    html += figure(fmt::format("image-{}", i), each.picture, each.name + "; the tables have its numbers",
                   escaped(each.name));
  }
  return html;
}

std::string tablesOf(const study::Result& result) {
  std::string html;
  for (const study::Table& table : result.tables)
    html += table.shown ? toHtml(table, table.name)
                        : fmt::format("<details><summary>{}, {} rows</summary>\n{}</details>\n", escaped(table.name),
                                      table.rows.size(), toHtml(table, table.name));
  return html;
}

const study::Table* tableNamed(const study::Result& result, std::string_view name) {
  for (const study::Table& table : result.tables)
    if (table.name == name) return &table;
  return nullptr;
}

}  // namespace

std::string studyPage(const study::Study& study, const study::Options& options, const study::Result& result,
                      std::span<const std::string> command) {
  Page page{.title = fmt::format("Latelight: study of {}", study.name)};
  page.introduction = fmt::format("<p>{}, on {}. This page was created by:</p>\n{}", escaped(study.description),
                                  escaped(result.device), commandHtml(command));
  Planes planes;
  if (const study::Table* errors = tableNamed(result, "normals")) {
    std::span<const uint32_t> bits = options.bits;
    if (bits.empty()) bits = study::kUsualNormalBits;
    page.data["spheres"] = describeSpheres(bits, *errors, planes);
    page.sections.push_back({"spheres", "Spheres", spheresHtml(bits)});
  }
  if (const std::string plots = plotsOf(result); !plots.empty()) page.sections.push_back({"plots", "Plots", plots});
  if (!result.pictures.empty()) page.sections.push_back({"pictures", "Pictures", picturesOf(result)});
  page.sections.push_back({"tables", "Tables", tablesOf(result)});
  page.values = planes.toHtml();
  return toHtml(page);
}

}  // namespace latelight::report
