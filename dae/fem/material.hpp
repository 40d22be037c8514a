// Hyperelastic, isotropic materials. Each gives the second Piola-Kirchhoff stress S as a function of the
// Green strain E = (F^T F - 1) / 2, so a rotation of the body changes nothing.
//
//   St. Venant-Kirchhoff   S = lambda tr(E) 1 + 2 mu E
//   neo-Hookean            S = mu (1 - C^-1) + lambda ln(J) C^-1,   C = 2 E + 1,  J = sqrt(det C)
//
// (Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, 2008, section 6.4). For small
// strains both are Hooke's law. The first is meant for large rotations with small strains (a metal); under
// strong compression it softens and at last lets the material vanish. The second resists that.
#pragma once

#include <string>

namespace mfs::dae {

enum class MaterialLaw { st_venant_kirchhoff, neo_hookean };

struct Material {
  MaterialLaw law = MaterialLaw::st_venant_kirchhoff;
  double young = 2.1e11;    ///< Young's modulus, Pa; the defaults are steel
  double poisson = 0.3;     ///< Poisson's ratio, in (-1, 0.5)
  double density = 7850.0;  ///< kg/m^3

  double lame_lambda() const { return young * poisson / ((1 + poisson) * (1 - 2 * poisson)); }
  double shear_modulus() const { return young / (2 * (1 + poisson)); }
};

/// Throws InvalidInput that names `body` and the value that is out of range.
void check_material(const Material& material, const std::string& body);

}  // namespace mfs::dae
