// Reads a JSON object key by key, so that nothing in a model file is wrong without a word about it: a value
// of the wrong type or out of range, a key that is missing, a key that nobody asked for. Every complaint is
// an InvalidInput whose argument is the place in the file, "joints.crank_pin.axis".
#pragma once

#include <Eigen/Core>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "parts/comma_list.hpp"

namespace mfs::dae {

/// Keeps the order of the file.
using Json = nlohmann::ordered_json;

/// Named numbers of a model, which texts in place of numbers are expressions of.
using Parameters = std::map<std::string, double>;

/// Throws InvalidInput where the file cannot be read, is no JSON (with line and column) or an object has a
/// key twice.
Json read_json(const std::string& path);

class JsonObject {
 public:
  /// Both have to live as long. `parameters`: of expressions in place of numbers, here and in all that it
  /// holds; null: there are none. Throws InvalidInput unless it is an object.
  JsonObject(const Json& json, std::string place, const Parameters* parameters = nullptr);

  const std::string& place() const { return place_; }
  /// Of one of its keys.
  std::string place_of(const std::string& key) const;
  /// The key is known from now on: whoever asks reads it where it is there.
  bool has(const std::string& key) {
    known_.insert(key);
    return json_->contains(key);
  }
  bool has_text(const std::string& key) { return has(key) && json_->at(key).is_string(); }
  bool has_number(const std::string& key) { return has(key) && json_->at(key).is_number(); }
  std::vector<std::string> keys() const;

  // All throw InvalidInput. Without a fallback the key has to be there. Numbers may be expressions.
  double number(const std::string& key);
  double number(const std::string& key, double fallback) { return has(key) ? number(key) : fallback; }
  double positive(const std::string& key);
  double not_negative(const std::string& key, double fallback);
  int integer(const std::string& key, int least, int most = std::numeric_limits<int>::max());
  bool flag(const std::string& key, bool fallback);
  std::string text(const std::string& key);
  Eigen::Vector3d vector(const std::string& key);
  Eigen::Vector3d vector(const std::string& key, const Eigen::Vector3d& fallback) {
    return has(key) ? vector(key) : fallback;
  }
  std::vector<double> numbers(const std::string& key);
  std::vector<std::string> texts(const std::string& key);
  JsonObject object(const std::string& key);
  /// The members of the object `key`, each an object with a name; none where the key is missing.
  std::vector<std::pair<std::string, JsonObject>> members(const std::string& key);

  /// One of these words.
  template <class Value>
  Value choice(const std::string& key, const std::map<std::string, Value>& values) {
    const std::string word = text(key);
    const auto found = values.find(word);
    if (found != values.end()) return found->second;
    refuse(key, "'" + word + "' is none of: " + comma_list(values, key_of));
  }

  [[noreturn]] void refuse(const std::string& key, const std::string& what) const;
  /// To be called in the end: throws InvalidInput where the object has a key that was not asked for, with
  /// those that were.
  void finish() const;

 private:
  const Json& at(const std::string& key);
  double evaluated(const std::string& key, const std::string& expected, const Json& value) const;
  double ordinary(const std::string& key, double number) const;
  std::vector<double> any_numbers(const std::string& key);

  const Json* json_;
  std::string place_;
  const Parameters* parameters_;
  std::set<std::string> known_;
};

}  // namespace mfs::dae
