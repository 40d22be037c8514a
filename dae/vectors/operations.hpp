// What is done with vectors of `count` numbers in an executor's memory, whoever they belong to.
#pragma once

#include <cstddef>
#include <vector>

#include "dae/vectors/executor.hpp"

namespace mfs::dae {

void fill(const Executor& executor, std::size_t count, double value, double* x);
void copy(const Executor& executor, std::size_t count, const double* from, double* to);
void scale(const Executor& executor, std::size_t count, double factor, double* x);
/// x = beta x + alpha[0] terms[0] + ...; what x was does not matter where beta is 0.
void combine(const Executor& executor, std::size_t count, double beta, double* x,
             const std::vector<double>& alpha, const std::vector<const double*>& terms);
/// The Euclidean norm.
double norm(const Executor& executor, std::size_t count, const double* x);

}  // namespace mfs::dae
