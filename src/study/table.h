// Tables of names and numbers, as readable text, CSV and JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <variant>
#include <vector>

namespace latelight::study {

using Cell = std::variant<std::string, double>;

struct Table {
  std::string name;                  // name of its file, and its key in JSON
  std::vector<std::string> columns;  // with units: "mean deg"
  std::vector<std::vector<Cell>> rows;
  bool shown = true;  // printed on standard output; long tables only go to files
};

std::string shortText(const Cell& cell);            // counts in full, measured numbers with three significant digits
std::string toText(const Table& table);             // aligned columns of short texts
std::string toCsv(const Table& table);              // RFC 4180; numbers in full, "inf" where infinite
nlohmann::ordered_json toJson(const Table& table);  // an empty text, which stands for a missing value, is null

}  // namespace latelight::study
