// The arithmetic of one solid element, total Lagrangian: forces and their derivatives from nodal positions
// and velocities. Voigt order 11, 22, 33, 12, 23, 13, shear strains doubled.
//
//   F = dx/dX,  E = (F^T F - 1) / 2,  S = S(E) + beta C0 : E',   f_i = int F S grad N_i dV.
//
// The viscous part (Kelvin-Voigt; C0 is the material's stiffness at E = 0) depends on the rate of the Green
// strain, so a rigid motion is never damped. For small strains it is stiffness-proportional damping, f = beta
// K q'.
//
// hex8 carries nine enhanced strains alpha (Andelfinger and Ramm, Int. J. Num. Meth. Eng. 36 (1993) 1311; in
// terms of the Green strain, Klinkel and Wagner, ibid. 40 (1997) 4463), which cure bending and volumetric
// locking:
//
//   E = E(u) + M alpha,   int M^T S dV = 0,   M = (j0 / j) J0^-T (modes linear in xi) J0^-1.
//
// The modes integrate to zero, so a state of constant strain needs none of them and passes the patch test.
// The nine equations belong to the element alone and are solved in each evaluation, linear ones for St.
// Venant-Kirchhoff, by Newton's method from scratch for neo-Hookean: no state is kept between evaluations,
// and the derivatives are exact. The viscous stress has enhanced rates of its own. As with all such elements,
// strains of some ten per cent in compression may excite hourglass patterns (Wriggers and Reese 1996).
//
// A state without meaning (an element turned inside out, or no solution of the nine equations) gives NaN, not
// an exception: the loops over elements are parallel, and the solver above reports numbers that are not
// finite.
#pragma once

#include "dae/fem/material.hpp"
#include "dae/fem/mesh.hpp"

namespace mfs::dae {

struct SolidConstants {
  MaterialLaw law;
  double lambda, mu;  ///< Lame's constants
  double beta;        ///< viscosity: factor of C0, s
};

constexpr int kMostPoints = 27;  ///< integration points of an element

/// nodes: reference positions; q, v: positions and velocities, each (nodes x 3). Adds to force (nodes x 3).
void add_internal_force(ElementKind kind, const SolidConstants& constants, const double* nodes,
                        const double* q, const double* v, double* force);

/// Adds the derivatives of the internal force by q and by v, unless the pointer is null; each (3 nodes) x (3
/// nodes), by rows.
void add_internal_tangent(ElementKind kind, const SolidConstants& constants, const double* nodes,
                          const double* q, const double* v, double* force_q, double* force_v);

/// Of the strains, J; the viscous part of the stress has none.
double stored_energy(ElementKind kind, const SolidConstants& constants, const double* nodes, const double* q);

/// Cauchy stress F S F^T / J without its viscous part: kMostPoints x 6 at most, (points x 6) written.
void point_stress(ElementKind kind, const SolidConstants& constants, const double* nodes, const double* q,
                  double* stress);

}  // namespace mfs::dae
