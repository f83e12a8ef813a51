// The sensors of latelight.lidar.
#include "lidar.h"

#include "options.h"
#include "values.h"

namespace latelight::python {

namespace {

template <size_t N>
std::vector<std::array<double, N>> doubleRowsOf(nb::handle value, std::string_view name) {
  const std::vector<double> values = doublesOf(value, name, {-1, N});
  std::vector<std::array<double, N>> rows(values.size() / N);
  if (!rows.empty()) std::memcpy(rows.data(), values.data(), sizeof(double) * values.size());
  return rows;
}

template <typename T>
std::vector<T> integersOf(nb::handle value, std::string_view name, const char* dtype) {
  const nb::object array = integerArrayOf(value, name, dtype);
  const auto view = viewOf<T>(array);
  return {view.data(), view.data() + view.size()};
}

std::vector<float> floatColumn(const nb::dict& fields, const char* name) {
  return floatsOf(fields[name], name, {-1}).values;
}

template <size_t N>
nb::object doubleRows(const std::vector<std::array<double, N>>& rows) {
  std::vector<double> values(N * rows.size());
  if (!rows.empty()) std::memcpy(values.data(), rows.data(), sizeof(double) * values.size());
  return owned(std::move(values), {rows.size(), N});
}

// The arguments of latelight.lidar.Pattern.
nb::dict fieldsOf(LidarPattern&& p) {
  nb::dict fields;
  const std::vector<size_t> shape{p.times.size()};
  fields["name"] = p.name;
  fields["directions"] = doubleRows(p.directions);
  fields["times"] = owned(std::move(p.times), shape);
  fields["rings"] = owned(std::move(p.rings), shape);
  fields["period"] = p.period;
  fields["min_range"] = p.minRange;
  fields["max_range"] = p.maxRange;
  fields["rated_range"] = p.ratedRange;
  fields["range_noise"] = p.rangeNoise;
  fields["range_resolution"] = p.rangeResolution;
  fields["divergence"] = tupleOf(p.divergence);
  fields["echo_separation"] = p.echoSeparation;
  return fields;
}

nb::dict patternNamed(nb::handle sensor, nb::handle rate, nb::handle columns, nb::handle start) {
  return inPython([&] {
    return fieldsOf(lidarPattern(textOf(sensor, "sensor"), numberOf(rate, "rate"),
                                 static_cast<uint32_t>(integerOf(columns, "columns", 0, INT32_MAX)),
                                 numberOf(start, "start")));
  });
}

nb::dict spinningPattern(nb::handle name, nb::handle elevations, nb::handle azimuths, nb::handle firing,
                         nb::handle cycle, nb::handle columns, nb::handle rate) {
  return inPython([&] {
    return fieldsOf(lidarPattern({.name = textOf(name, "name"),
                                  .elevations = doublesOf(elevations, "elevations", {-1}),
                                  .azimuths = doublesOf(azimuths, "azimuths", {-1}),
                                  .firing = doublesOf(firing, "firing", {-1}),
                                  .cycle = numberOf(cycle, "cycle"),
                                  .columns = static_cast<uint32_t>(integerOf(columns, "columns", 0, INT32_MAX)),
                                  .rate = numberOf(rate, "rate")}));
  });
}

// Writes the fields of a latelight.lidar.Scan, whose positions are x, y and z.
void writeFields(nb::handle path, const nb::dict& fields) {
  LidarPoints points{.time = doublesOf(fields["time"], "time", {-1}),
                     .range = floatColumn(fields, "range"),
                     .intensity = floatColumn(fields, "intensity"),
                     .ring = integersOf<uint16_t>(fields["ring"], "ring", "uint16"),
                     .echo = integersOf<uint8_t>(fields["echo"], "echo", "uint8"),
                     .firing = integersOf<uint32_t>(fields["firing"], "firing", "uint32"),
                     .id = integersOf<uint32_t>(fields["id"], "id", "uint32"),
                     .part = integersOf<uint32_t>(fields["part"], "part", "uint32"),
                     .material = integersOf<uint32_t>(fields["material"], "material", "uint32")};
  const std::vector<float> x = floatColumn(fields, "x"), y = floatColumn(fields, "y"), z = floatColumn(fields, "z");
  for (size_t i = 0; i < x.size(); ++i) points.position.push_back({x[i], y.at(i), z.at(i)});
  points.worldPosition.resize(points.position.size());
  inPython([&] { writePoints(pathOf(path, "path"), points); });
}

}  // namespace

LidarPattern patternOf(nb::handle from) {
  LidarPattern pattern{.name = textOf(from.attr("name"), "name"),
                       .directions = doubleRowsOf<3>(from.attr("directions"), "directions"),
                       .times = doublesOf(from.attr("times"), "times", {-1}),
                       .rings = integersOf<uint16_t>(from.attr("rings"), "rings", "uint16")};
  // Limits may be infinite, which numberOf() rejects.
  const auto number = [&](const char* name) { return nb::cast<double>(nb::float_(from.attr(name))); };
  pattern.period = number("period");
  pattern.minRange = number("min_range");
  pattern.maxRange = number("max_range");
  pattern.ratedRange = number("rated_range");
  pattern.rangeNoise = number("range_noise");
  pattern.rangeResolution = number("range_resolution");
  pattern.divergence = numbersOf<double, 2>(from.attr("divergence"), "divergence");
  pattern.echoSeparation = number("echo_separation");
  return pattern;
}

nb::dict pointsOf(LidarPoints&& points) {
  const std::vector<size_t> shape{points.time.size()};
  nb::dict fields;
  fields["position"] = ownedRows(points.position);
  fields["world_position"] = doubleRows(points.worldPosition);
  fields["time"] = owned(std::move(points.time), shape);
  fields["range"] = owned(std::move(points.range), shape);
  fields["intensity"] = owned(std::move(points.intensity), shape);
  fields["ring"] = owned(std::move(points.ring), shape);
  fields["echo"] = owned(std::move(points.echo), shape);
  fields["firing"] = owned(std::move(points.firing), shape);
  fields["id"] = owned(std::move(points.id), shape);
  fields["part"] = owned(std::move(points.part), shape);
  fields["material"] = owned(std::move(points.material), shape);
  return fields;
}

void bindLidar(nb::module_& module) {
  module.def("lidar_pattern", &patternNamed, argument("sensor"), argument("rate") = 0.0, argument("columns") = 0,
             argument("start") = 0.0,
             nb::sig("def lidar_pattern(sensor: str, rate: float = 0.0, columns: int = 0, start: float = 0.0) -> "
                     "dict[str, typing.Any]"),
             "The arguments of latelight.lidar.Pattern for a sensor by its name.");
  module.def("spinning_pattern", &spinningPattern, argument("name"), argument("elevations"), argument("azimuths"),
             argument("firing"), argument("cycle"), argument("columns"), argument("rate"),
             nb::sig("def spinning_pattern(name: str, elevations: numpy.typing.ArrayLike, azimuths: "
                     "numpy.typing.ArrayLike, firing: numpy.typing.ArrayLike, cycle: float, columns: int, rate: float) "
                     "-> dict[str, typing.Any]"),
             "The arguments of latelight.lidar.Pattern for a spinning sensor.");
  module.def(
      "number_of", [](nb::handle value, const char* name) { return numberOf(value, name); }, argument("value"),
      nb::arg("name"), nb::sig("def number_of(value: typing.Any, name: str) -> float"),
      "A number as a float; other values raise ArgumentTypeError, whose message contains the name.");
  module.def(
      "whole_number_of",
      [](nb::handle value, const char* name, int64_t least, int64_t most) {
        return integerOf(value, name, least, most);
      },
      argument("value"), nb::arg("name"), nb::arg("least"), nb::arg("most"),
      nb::sig("def whole_number_of(value: typing.Any, name: str, least: int, most: int) -> int"),
      "A whole number in this range; other values raise UsageError, whose message contains the name.");
  module.def(
      "numbers_of", [](nb::handle value, const char* name) { return numberArrayOf(value, name); }, argument("value"),
      nb::arg("name"), nb::sig("def numbers_of(value: typing.Any, name: str) -> numpy.typing.NDArray[typing.Any]"),
      "An array of numbers as float64; other values raise ArgumentTypeError, whose message contains the name.");
  module.def(
      "rings_of", [](nb::handle value) { return integerArrayOf(value, "rings", "uint16"); }, argument("value"),
      nb::sig("def rings_of(value: typing.Any) -> numpy.typing.NDArray[typing.Any]"),
      "The rings of a latelight.lidar.Pattern; other values raise UsageError.");
  module.def("write_points", &writeFields, argument("path"), nb::arg("fields"),
             nb::sig("def write_points(path: str | os.PathLike[str], fields: dict[str, typing.Any]) -> None"),
             "Writes the fields of a latelight.lidar.Scan.");
}

}  // namespace latelight::python
