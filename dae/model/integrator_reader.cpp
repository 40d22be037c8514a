// The object "integrator" of a model file. Ranges are checked by the integrator itself.
#include "dae/model/model_parts.hpp"

namespace mfs::dae {

IntegratorOptions read_integrator(JsonObject& object, double length_unit) {
  IntegratorOptions options;
  if (object.has("method"))
    options.method = object.choice<Method>(
        "method", {{"bdf", Method::bdf}, {"generalized_alpha", Method::generalized_alpha}});
  if (object.has("unknowns"))
    options.unknowns =
        object.choice<Unknowns>("unknowns", {{"full", Unknowns::full}, {"reduced", Unknowns::reduced}});
  const auto number = [&](const char* key, double& value) { value = object.not_negative(key, value); };
  number("rtol", options.rtol);
  // The integrator's are in its own unit of length.
  const auto length = [&](const char* key, double& value) {
    if (object.has(key)) value = object.not_negative(key, value) / length_unit;
  };
  length("atol_position", options.atol_position);
  length("atol_velocity", options.atol_velocity);
  length("constraint_position", options.constraint_position);
  length("constraint_velocity", options.constraint_velocity);
  length("constraint_acceleration", options.constraint_acceleration);
  number("initial_step", options.initial_step);
  number("max_step", options.max_step);
  number("min_step", options.min_step);
  number("fixed_step", options.fixed_step);
  number("rho_inf", options.rho_inf);
  const auto integer = [&](const char* key, int least, int& value) {
    if (object.has(key)) value = object.integer(key, least);
  };
  integer("max_order", 1, options.max_order);
  integer("newton_iterations", 1, options.newton_iterations);
  integer("krylov_steps", 0, options.krylov_steps);
  options.keep_factors = object.flag("keep_factors", options.keep_factors);
  object.finish();
  return options;
}

}  // namespace mfs::dae
