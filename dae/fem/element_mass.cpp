#include "dae/fem/element_mass.hpp"

#include <numeric>

namespace mfs::dae {

std::vector<double> consistent_mass(ElementKind kind, const double* nodes) {
  const auto n = static_cast<std::size_t>(nodes_per_element(kind));
  const QuadratureRule& rule = mass_rule(kind);
  std::vector<double> mass(n * n), shape(n);
  for (std::size_t p = 0; p < rule.points.size(); ++p) {
    const double weight = rule.weights[p] * determinant(jacobian(kind, rule.points[p], nodes));
    shape_values(kind, rule.points[p], shape.data());
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) mass[i * n + j] += weight * shape[i] * shape[j];
  }
  return mass;
}

std::vector<double> lumped_mass(ElementKind kind, const double* nodes) {
  const auto n = static_cast<std::size_t>(nodes_per_element(kind));
  const std::vector<double> mass = consistent_mass(kind, nodes);
  std::vector<double> lumped(n);
  for (std::size_t i = 0; i < n; ++i) lumped[i] = mass[i * n + i];
  const double scale =
      std::accumulate(mass.begin(), mass.end(), 0.0) / std::accumulate(lumped.begin(), lumped.end(), 0.0);
  for (double& entry : lumped) entry *= scale;
  return lumped;
}

}  // namespace mfs::dae
