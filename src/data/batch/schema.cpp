#include "data/batch/schema.h"

#include <algorithm>
#include <string_view>

#include "base/error.h"
#include "base/text.h"
#include "data/json_text.h"
#include "render/options/options.h"

namespace latelight::data {

using Json = nlohmann::ordered_json;

namespace {

constexpr std::string_view kSchemaText =
#include "job_schema.inc"
    ;
constexpr std::string_view kCamerasText =
#include "cameras_schema.inc"
    ;
constexpr std::string_view kVariationsText =
#include "variations_schema.inc"
    ;

// A null value never becomes an array or an object implicitly, by push_back() or operator[]: if memory runs out, that
// leaves nlohmann::json a value without contents, and its destructor crashes.
Json schemaOf(const render::Option& option) {
  using render::OptionKind;
  Json schema{{"description", option.help}};
  switch (option.kind) {
    case OptionKind::Flag:
      schema["type"] = "boolean";
      break;
    case OptionKind::Integer:
    case OptionKind::Number:
      schema["type"] = option.kind == OptionKind::Integer ? "integer" : "number";
      if (std::isfinite(option.range.least))
        schema[option.range.open ? "exclusiveMinimum" : "minimum"] = option.range.least;
      if (std::isfinite(option.range.most)) schema["maximum"] = option.range.most;
      break;
    case OptionKind::Choice:
      schema["enum"] = Json::array();
      for (const render::NamedOption& name : option.names) schema["enum"].push_back(name.name);
      break;
    default:
      schema["type"] = Json::array({"string", "number"});  // a text may be a number: "--shadow-lights 4"
      schema["minLength"] = 1;
  }
  return schema;
}

// Rewrites the references within a schema that is embedded at `place` of another schema.
void moveReferences(Json& schema, const std::string& place) {
  for (auto& [key, value] : schema.items())
    if (key == "$ref")
      value = place + value.get<std::string>().substr(1);
    else if (value.is_structured())
      moveReferences(value, place);
}

// Embeds the separate schema for the value of a key as a definition.
void addSchemaOf(Json& job, const std::string& key, std::string_view text) {
  const std::string place = "#/$defs/" + key;
  Json& schema = job["$defs"][key] = Json::parse(text);
  schema.erase("$schema");
  moveReferences(schema, place);
  job["properties"][key]["$ref"] = place;
}

// --- validation -----------------------------------------------------------------------------------------------------

bool isOfType(const Json& value, std::string_view type) {
  if (type == "integer") return value.is_number_integer();
  if (type == "number") return value.is_number();
  if (type == "string") return value.is_string();
  if (type == "boolean") return value.is_boolean();
  return type == "array" ? value.is_array() : value.is_object();
}

std::string_view inWords(std::string_view type) {
  if (type == "integer") return "a whole number";
  if (type == "number") return "a number";
  if (type == "string") return "a text";
  if (type == "boolean") return "true or false";
  return type == "array" ? "a list" : "an object of keys and values";
}

// Describes the values that the schema accepts. `types` are the schema's types as a list.
std::string expected(const Json& schema, const Json& types) {
  if (schema.contains("enum")) return joinedByOr(schema["enum"].get<std::vector<std::string>>());
  std::vector<std::string> words;
  for (const Json& type : types) words.emplace_back(inWords(type.get<std::string>()));
  std::string text = joinedByOr(words);
  const auto bound = [&](const char* key, const char* before) {
    if (schema.contains(key)) text += fmt::format("{}{:g}", before, schema[key].get<double>());
  };
  bound("minimum", " from ");
  bound("exclusiveMinimum", " above ");
  bound("maximum", " to ");
  return text;
}

bool isInRange(const Json& schema, double value) {
  return value >= schema.value("minimum", value) && value <= schema.value("maximum", value) &&
         (!schema.contains("exclusiveMinimum") || value > schema["exclusiveMinimum"].get<double>());
}

bool isTaken(const Json& schema, const Json& types, const Json& value) {
  if (schema.contains("enum")) return std::ranges::find(schema["enum"], value) != schema["enum"].end();
  if (std::ranges::none_of(types, [&](const Json& type) { return isOfType(value, type.get<std::string>()); }))
    return false;
  return !value.is_number() || isInRange(schema, value.get<double>());
}

void checkValue(const JobDocument& job, const std::string& path, const Json& schema, const Json& value);

void checkKeys(const JobDocument& job, const std::string& path, const Json& schema, const Json& value) {
  for (const auto& [key, inner] : value.items()) {
    const std::string below = path.empty() ? key : path + "." + key;
    if (!schema["properties"].contains(key))
      badUsage("{}: unknown key; see latelight batch --schema", job.place(below));
    checkValue(job, below, schema["properties"][key], inner);
  }
  for (const Json& key : schema.value("required", Json::array()))
    if (!value.contains(key.get<std::string>()))
      badUsage("{}: the key \"{}\" is missing: {}", job.place(path), key.get<std::string>(),
               schema["properties"][key.get<std::string>()]["description"].get<std::string>());
}

void checkValue(const JobDocument& job, const std::string& path, const Json& schema, const Json& value) {
  const Json type = schema.value("type", Json("string"));
  const Json types = type.is_array() ? type : Json::array({type});
  if (!isTaken(schema, types, value))
    badUsage("{} takes {}, not {}", job.place(path), expected(schema, types), dumped(value));
  if (value.is_string() && value.get_ref<const std::string&>().size() < schema.value("minLength", size_t{0}))
    badUsage("{} is empty", job.place(path));
  if (value.is_array() && value.size() < schema.value("minItems", size_t{0}))
    badUsage("{} is an empty list", job.place(path));
  if (value.is_array() && schema.contains("items"))
    for (size_t i = 0; i < value.size(); ++i)
      checkValue(job, fmt::format("{}[{}]", path, i), schema["items"], value[i]);
  if (value.is_object() && schema.contains("properties")) checkKeys(job, path, schema, value);
}

// Rejects texts with a NUL character. The system ends the names of files there, so that names that differ only after it
// would be the same file. Cameras and variations are excluded, because they also contain names of elements of scenes.
void rejectNul(const JobDocument& job, const std::string& path, const Json& value) {
  if (value.is_string() && value.get_ref<const std::string&>().find('\0') != std::string::npos)
    badUsage("{} has a NUL character, which names of files cannot have, in {}: remove it", job.place(path),
             dumped(value));
  if (value.is_array())
    for (size_t i = 0; i < value.size(); ++i) rejectNul(job, fmt::format("{}[{}]", path, i), value[i]);
  if (!value.is_object()) return;
  for (const auto& [key, inner] : value.items())
    if (!path.empty() || (key != "cameras" && key != "variations"))
      rejectNul(job, path.empty() ? key : path + "." + key, inner);
}

}  // namespace

const Json& jobSchema() {
  static const Json made = [] {
    Json schema = Json::parse(kSchemaText);
    for (const render::Option& option : render::options())
      schema["properties"]["options"]["properties"][std::string(render::keyOf(option))] = schemaOf(option);
    schema["$defs"] = Json::object();
    addSchemaOf(schema, "cameras", kCamerasText);
    addSchemaOf(schema, "variations", kVariationsText);
    return schema;
  }();
  return made;
}

void checkJob(const JobDocument& job) {
  if (!job.json.is_object()) badUsage("{}: a job is an object of keys and values", job.place(""));
  checkKeys(job, "", jobSchema(), job.json);
  rejectNul(job, "", job.json);
}

}  // namespace latelight::data
