#include "study/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace latelight::study {

std::string shortText(const Cell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) return *text;
  const double number = std::get<double>(cell);
  // Counts are printed in full, and measured numbers with three digits.
  return number == std::floor(number) && std::abs(number) < 1e9 ? fmt::format("{:.0f}", number)
                                                                : fmt::format("{:#.3g}", number);
}

namespace {

std::string csvText(const Cell& cell) {
  if (const auto* number = std::get_if<double>(&cell)) return fmt::format("{}", *number);
  std::string text = std::get<std::string>(cell);
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  for (size_t at = 0; (at = text.find('"', at)) != std::string::npos; at += 2) text.insert(at, 1, '"');
  return '"' + text + '"';
}

nlohmann::ordered_json toJson(const Cell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) {
    if (text->empty()) return nullptr;
    return *text;
  }
  const double number = std::get<double>(cell);
  if (std::isfinite(number)) return number;
  return csvText(cell);  // JSON has no infinity
}

}  // namespace

std::string toText(const Table& table) {
  std::vector<size_t> widths;
  for (const std::string& column : table.columns) widths.push_back(column.size());
  std::vector<bool> names(table.columns.size());  // text columns are left-aligned; an empty cell is not text
  std::vector<std::vector<std::string>> lines{table.columns};
  for (const std::vector<Cell>& row : table.rows) {
    std::vector<std::string>& line = lines.emplace_back();
    for (size_t i = 0; i < row.size(); ++i) {
      line.push_back(shortText(row[i]));
      widths[i] = std::max(widths[i], line[i].size());
      names[i] = names[i] || (std::holds_alternative<std::string>(row[i]) && !line[i].empty());
    }
  }
  std::string text;
  for (const std::vector<std::string>& line : lines) {
    for (size_t i = 0; i < line.size(); ++i) {
      text += names[i] ? fmt::format("{:<{}}", line[i], widths[i]) : fmt::format("{:>{}}", line[i], widths[i]);
      text += i + 1 < line.size() ? "  " : "\n";
    }
  }
  return text;
}

std::string toCsv(const Table& table) {
  std::string text;
  const auto add = [&](const auto& cells) {
    for (size_t i = 0; i < cells.size(); ++i) text.append(i ? "," : "").append(csvText(cells[i]));
    text += "\r\n";
  };
  add(table.columns);
  for (const std::vector<Cell>& row : table.rows) add(row);
  return text;
}

nlohmann::ordered_json toJson(const Table& table) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const std::vector<Cell>& row : table.rows) {
    nlohmann::ordered_json object = nlohmann::ordered_json::object();
    for (size_t i = 0; i < row.size(); ++i) object[table.columns[i]] = toJson(row[i]);
    rows.push_back(object);
  }
  return rows;
}

}  // namespace latelight::study
