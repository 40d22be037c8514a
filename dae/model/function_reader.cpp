// Parameters, functions and expressions of a model file.
#include <algorithm>

#include <mfs/error.hpp>

#include "dae/model/model_parts.hpp"

namespace mfs::dae {
namespace {

using Argument = StateFunction::Argument;

Function read_constant(JsonObject& object) {
  return constant_function(object.number("value"));
}

Function read_linear(JsonObject& object) {
  return linear_function(object.number("value", 0.0), object.number("slope"));
}

Function read_harmonic(JsonObject& object) {
  return harmonic_function(object.number("offset", 0.0), object.number("amplitude"),
                           object.positive("frequency"), object.number("phase", 0.0));
}

Function read_smooth_step(JsonObject& object) {
  return smooth_step(object.number("begin"), object.number("end"), object.number("before", 0.0),
                     object.number("after"));
}

Function read_spline(JsonObject& object) {
  const std::vector<double> x = object.numbers("x"), y = object.numbers("y");
  if (x.size() != y.size() || x.size() < 2) object.refuse("y", "must have as many numbers as x, two or more");
  for (std::size_t i = 1; i < x.size(); ++i)
    if (!(x[i - 1] < x[i])) object.refuse("x", "must ascend");
  return spline_function(x, y);
}

// What a name in an expression of the state stands for.
Argument meaning_of(const std::string& name, const JsonObject& object, const std::string& key,
                    ModelParts& parts) {
  if (name == "t") return {Argument::Kind::time};
  const auto parameter = parts.parameters.find(name);
  if (parameter != parts.parameters.end()) return {Argument::Kind::number, parameter->second};
  const std::size_t dot = name.rfind('.');
  if (dot == std::string::npos)
    object.refuse(key, "there is no parameter '" + name + "'; quantities are JOINT.angle, POINT.x, ...");
  const std::string owner = name.substr(0, dot + 1), member = name.substr(dot + 1);
  const std::map<std::string, std::string> rates{
      {"angle_rate", "angle"}, {"travel_rate", "travel"}, {"vx", "x"}, {"vy", "y"}, {"vz", "z"}};
  const auto rate = rates.find(member);
  if (rate == rates.end())
    return {Argument::Kind::coordinate, 0.0, measured(name, object.place_of(key), parts)};
  return {Argument::Kind::rate, 0.0, measured(owner + rate->second, object.place_of(key), parts)};
}

/// What is no text.
JsonObject function_object(JsonObject& object, const std::string& key) {
  if (object.has_number(key))
    object.refuse(key, "must be a function or an expression, as \"3\", not a number");
  return object.object(key);
}

Expression parsed(const std::string& text, const JsonObject& object, const std::string& key) {
  try {
    return Expression(text, object.place_of(key));
  } catch (const InvalidInput& e) {
    object.refuse(key, e.what());
  }
}

// An expression of `variable` and of parameters.
Function function_of(const Expression& expression, const std::string& variable, const JsonObject& object,
                     const std::string& key, const ModelParts& parts) {
  int place = -1;
  std::vector<double> values;
  for (const std::string& name : expression.variables()) {
    const auto parameter = parts.parameters.find(name);
    if (name == variable)
      place = static_cast<int>(values.size());
    else if (parameter == parts.parameters.end())
      object.refuse(key, "there is no parameter '" + name + "'; the variable is " + variable);
    values.push_back(name == variable ? 0.0 : parameter->second);
  }
  return expression_function(expression, place, values);
}

}  // namespace

Function read_function(JsonObject object) {
  using Reader = Function (*)(JsonObject&);
  const Reader reader = object.choice<Reader>("type", {{"constant", read_constant},
                                                       {"linear", read_linear},
                                                       {"harmonic", read_harmonic},
                                                       {"smooth_step", read_smooth_step},
                                                       {"spline", read_spline}});
  Function function = reader(object);
  object.finish();
  return function;
}

void read_parameters(JsonObject& object, Parameters& parameters) {
  for (const std::string& name : object.keys()) {
    const std::string first(1, name.empty() ? '0' : name[0]);
    if (name == "t" || name == "x" || name == "pi" || name.find('.') != std::string::npos ||
        first.find_first_of("0123456789") == 0)
      object.refuse(name, "t, x, pi and names with dots or that begin with a digit have other meanings");
    // What the library takes for one name is one.
    if (parsed(name, object, name).variables() != std::vector<std::string>{name})
      object.refuse(name, "a parameter's name is made of letters, digits and _");
    parameters[name] = object.number(name);
  }
}

Function read_function(JsonObject& object, const std::string& key, const char* variable,
                       const ModelParts& parts) {
  if (!object.has_text(key)) return read_function(function_object(object, key));
  return function_of(parsed(object.text(key), object, key), variable, object, key, parts);
}

StateFunction read_state_function(JsonObject& object, const std::string& key, ModelParts& parts) {
  if (!object.has_text(key)) return read_function(function_object(object, key));
  const Expression expression = parsed(object.text(key), object, key);
  std::vector<Argument> arguments;
  for (const std::string& name : expression.variables())
    arguments.push_back(meaning_of(name, object, key, parts));
  const bool of_time = std::all_of(arguments.begin(), arguments.end(), [](const Argument& argument) {
    return argument.kind == Argument::Kind::time || argument.kind == Argument::Kind::number;
  });
  if (of_time) return function_of(expression, "t", object, key, parts);
  return {expression, arguments};
}

std::array<StateFunction, 3> read_functions(JsonObject& object, ModelParts& parts) {
  std::array<StateFunction, 3> functions;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string key(1, "xyz"[axis]);
    if (object.has(key)) functions[axis] = read_state_function(object, key, parts);
  }
  return functions;
}

}  // namespace mfs::dae
