// Rows of names and numbers: to read, and as CSV and JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <variant>
#include <vector>

namespace latelight::study {

using Cell = std::variant<std::string, double>;

struct Table {
  std::string name;                  // of its file, and in JSON
  std::vector<std::string> columns;  // with their unit: "mean deg"
  std::vector<std::vector<Cell>> rows;
  bool shown = true;  // on standard output; long ones go to files only
};

std::string shortText(const Cell& cell);  // counts in full, measured numbers with three significant digits
std::string toText(const Table& table);   // columns aligned, of short texts
std::string toCsv(const Table& table);    // RFC 4180; numbers in full, "inf" where infinite
nlohmann::ordered_json toJson(const Table& table);

}  // namespace latelight::study
