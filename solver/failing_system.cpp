#include "solver/failing_system.hpp"

#include <complex>

#include <mfs/matrix_market.hpp>

namespace mfs {

template <class Scalar>
std::string write_system(const System<Scalar>& system, const std::string& prefix) {
  std::string matrix = prefix + "_A.mtx";
  const std::string vectors = prefix + "_b.mtx";
  const std::string comment = std::string(" of a system ") + (system.transposed ? "A^T x = b" : "A x = b") +
                              " that MFS did not solve";
  write_matrix_market(matrix, system.a, "A" + comment);
  if (!system.b) return matrix;
  write_matrix_market(vectors, system.b, system.a.rows, system.nrhs, system.ldb, "b" + comment);
  return matrix + " and " + vectors;
}

template std::string write_system<float>(const System<float>&, const std::string&);
template std::string write_system<double>(const System<double>&, const std::string&);
template std::string write_system<std::complex<float>>(const System<std::complex<float>>&,
                                                       const std::string&);
template std::string write_system<std::complex<double>>(const System<std::complex<double>>&,
                                                        const std::string&);

}  // namespace mfs
