#include "perf/batch_case.hpp"

#include <algorithm>
#include <random>

#include "perf/measure.hpp"

namespace mfs::perf {

BatchCase make_batch_case(const std::string& name, std::int64_t count) {
  BatchCase batch;
  batch.a = make_system(name, 1).a;
  batch.count = count;
  std::mt19937_64 engine(11);
  std::uniform_real_distribution<double> distribution(-1, 1);
  batch.values.reserve(batch.a.values.size() * static_cast<std::size_t>(count));
  for (std::int64_t k = 0; k < count; ++k) {
    for (const double value : batch.a.values)
      batch.values.push_back(value * (1 + 0.1 * distribution(engine)));
    for (std::int64_t i = 0; i < batch.a.n; ++i) batch.b.push_back(distribution(engine));
  }
  return batch;
}

double worst_error(const BatchCase& batch, const double* x) {
  const std::int64_t n = batch.a.n, entries = batch.a.offsets.back();
  double worst = 0;
  for (std::int64_t k = 0; k < batch.count; ++k) {
    const Errors errors =
        column_errors(batch.a, batch.values.data() + k * entries, batch.b.data() + k * n, x + k * n);
    worst = std::max(worst, errors.backward);
  }
  return worst;
}

}  // namespace mfs::perf
