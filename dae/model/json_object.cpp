#include "dae/model/json_object.hpp"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <mfs/error.hpp>

#include "dae/mechanics/expression.hpp"

namespace mfs::dae {
namespace {

/// Squares of numbers, and their inverses, are numbers.
constexpr double kLargest = 1e100;
// Names become those of files and columns of tables.
constexpr const char* kNameCharacters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";

std::string kind_of(const Json& value) {
  return value.is_number() ? "a number" : std::string("of type ") + value.type_name();
}

}  // namespace

Json read_json(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InvalidInput(path, std::string("cannot be read: ") + std::strerror(errno));
  if (std::filesystem::is_directory(path)) throw InvalidInput(path, "cannot be read: it is a folder");
  std::vector<std::set<std::string>> keys;  // of the objects that are open
  const auto watch = [&](int, Json::parse_event_t event, const Json& parsed) {
    if (event == Json::parse_event_t::object_start) keys.emplace_back();
    if (event == Json::parse_event_t::object_end) keys.pop_back();
    if (event == Json::parse_event_t::key && !keys.back().insert(parsed.get<std::string>()).second)
      throw InvalidInput(path, "the key '" + parsed.get<std::string>() + "' is twice in one object");
    return true;
  };
  try {
    return Json::parse(file, watch);
  } catch (const nlohmann::json::exception& e) {
    const std::string what = e.what();  // "[json.exception.parse_error.101] parse error at line 3, ..."
    throw InvalidInput(path, what.substr(what.find("] ") + 2));
  }
}

JsonObject::JsonObject(const Json& json, std::string place, const Parameters* parameters)
    : json_(&json), place_(std::move(place)), parameters_(parameters) {
  if (!json.is_object()) throw InvalidInput(place_, "must be an object, not " + kind_of(json));
}

std::string JsonObject::place_of(const std::string& key) const {
  return place_.empty() ? key : place_ + "." + key;
}

/// With control characters as JSON writes them: a zero would end a message.
static std::string shown(const std::string& place) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (const char c : place)
    if (const auto code = static_cast<unsigned char>(c); code < 0x20)
      text += std::string("\\u00") + kDigits[code / 16] + kDigits[code % 16];
    else
      text += c;
  return text;
}

void JsonObject::refuse(const std::string& key, const std::string& what) const {
  throw InvalidInput(shown(place_of(key)), what);
}

const Json& JsonObject::at(const std::string& key) {
  known_.insert(key);
  const auto found = json_->find(key);
  if (found == json_->end()) refuse(key, "is missing");
  return *found;
}

double JsonObject::number(const std::string& key) {
  return ordinary(key, evaluated(key, "must be a number, not ", at(key)));
}

double JsonObject::ordinary(const std::string& key, double number) const {
  if (!(std::abs(number) <= kLargest)) refuse(key, "must not be more than 1e100 in size");
  return number;
}

/// A number, or the value of a text that is an expression of parameters.
double JsonObject::evaluated(const std::string& key, const std::string& expected, const Json& value) const {
  if (value.is_number()) return value.get<double>();
  if (!value.is_string()) refuse(key, expected + kind_of(value));
  try {
    const Expression expression(value.get<std::string>());
    std::vector<double> values;
    for (const std::string& name : expression.variables()) {
      if (!parameters_ || parameters_->count(name) == 0)
        refuse(key, expected + kind_of(value) + ": there is no parameter '" + name + "'");
      values.push_back(parameters_->at(name));
    }
    const double number = expression.value(values);
    if (!std::isfinite(number)) refuse(key, "'" + expression.text() + "' is not finite");
    return number;
  } catch (const InvalidInput& e) {
    if (e.argument() == place_of(key)) throw;
    refuse(key, e.what());
  }
}

std::vector<std::string> JsonObject::keys() const {
  std::vector<std::string> keys;
  for (const auto& item : json_->items()) keys.push_back(item.key());
  return keys;
}

double JsonObject::positive(const std::string& key) {
  const double value = number(key);
  if (!(value > 0)) refuse(key, "must be positive, not " + at(key).dump());
  return value;
}

double JsonObject::not_negative(const std::string& key, double fallback) {
  const double value = number(key, fallback);
  if (!(value >= 0)) refuse(key, "must not be negative, as " + at(key).dump());
  return value;
}

int JsonObject::integer(const std::string& key, int least, int most) {
  const Json& value = at(key);
  const double number = value.is_number_integer() ? value.get<double>() : std::nan("");
  if (!(number >= least && number <= most))
    refuse(key, "must be an integer from " + std::to_string(least) +
                    (most < std::numeric_limits<int>::max() ? " to " + std::to_string(most) : " up"));
  return static_cast<int>(number);
}

bool JsonObject::flag(const std::string& key, bool fallback) {
  if (!has(key)) return fallback;
  const Json& value = at(key);
  if (!value.is_boolean()) refuse(key, "must be true or false, not " + kind_of(value));
  return value.get<bool>();
}

std::string JsonObject::text(const std::string& key) {
  const Json& value = at(key);
  if (!value.is_string()) refuse(key, "must be a text, not " + kind_of(value));
  return value.get<std::string>();
}

std::vector<double> JsonObject::numbers(const std::string& key) {
  std::vector<double> numbers = any_numbers(key);
  for (const double each : numbers) ordinary(key, each);
  return numbers;
}

std::vector<double> JsonObject::any_numbers(const std::string& key) {
  const Json& value = at(key);
  if (!value.is_array()) refuse(key, "must be an array of numbers, not " + kind_of(value));
  std::vector<double> numbers;
  for (const Json& entry : value)
    numbers.push_back(evaluated(key, "must be an array of numbers, but has one ", entry));
  return numbers;
}

std::vector<std::string> JsonObject::texts(const std::string& key) {
  if (!has(key)) return {};
  const Json& value = at(key);
  if (!value.is_array()) refuse(key, "must be an array of texts, not " + kind_of(value));
  std::vector<std::string> texts;
  for (const Json& entry : value) {
    if (!entry.is_string()) refuse(key, "must be an array of texts, but has one " + kind_of(entry));
    texts.push_back(entry.get<std::string>());
  }
  return texts;
}

Eigen::Vector3d JsonObject::vector(const std::string& key) {
  const std::vector<double> values = any_numbers(key);  // axes may be of any length
  if (values.size() != 3) refuse(key, "must have three numbers, not " + std::to_string(values.size()));
  return {values[0], values[1], values[2]};
}

JsonObject JsonObject::object(const std::string& key) {
  return {at(key), place_of(key), parameters_};
}

std::vector<std::pair<std::string, JsonObject>> JsonObject::members(const std::string& key) {
  std::vector<std::pair<std::string, JsonObject>> members;
  if (!has(key)) return members;
  const JsonObject parent = object(key);
  for (const auto& item : parent.json_->items()) {
    if (item.key().empty() || item.key().find_first_not_of(kNameCharacters) != std::string::npos)
      parent.refuse(item.key(), "a name is made of letters, digits, _ and -");
    members.emplace_back(item.key(), JsonObject(item.value(), parent.place_of(item.key()), parameters_));
  }
  return members;
}

void JsonObject::finish() const {
  for (const auto& item : json_->items())
    if (known_.count(item.key()) == 0)
      refuse(item.key(), "is not known here; known are: " + comma_list(known_));
}

}  // namespace mfs::dae
