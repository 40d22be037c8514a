#include "accuracy/ladder.hpp"

namespace mfs {

Offset ladder_bytes(Vertex n, Offset value_bytes, Vertex columns) {
  const LadderLayout ladder(n, value_bytes, columns);
  return ladder.ends.total() + ladder.work.total();
}

NumericBytes numeric_bytes(const SymbolicPlan& plan, Offset scalar_bytes, Offset value_bytes,
                           Vertex columns) {
  NumericBytes bytes = host_bytes(plan, scalar_bytes, value_bytes, columns);
  bytes.solve += ladder_bytes(plan.n, value_bytes, columns);
  return bytes;
}

template <class Value>
std::unique_ptr<Factorization<Value>> make_factorization(HostSpace space,
                                                         std::unique_ptr<Factors<Value>> factors,
                                                         std::shared_ptr<const SymbolicPlan> plan,
                                                         std::shared_ptr<const Pattern> pattern) {
  if (space == HostSpace::serial)
    return std::make_unique<AccuracyLadder<OneThread, Value>>(std::move(factors), std::move(plan),
                                                              std::move(pattern));
  return std::make_unique<AccuracyLadder<HostThreads, Value>>(std::move(factors), std::move(plan),
                                                              std::move(pattern));
}

#define MFS_INSTANTIATE(Value)                                                         \
  template std::unique_ptr<Factorization<Value>> make_factorization<Value>(            \
      HostSpace, std::unique_ptr<Factors<Value>>, std::shared_ptr<const SymbolicPlan>, \
      std::shared_ptr<const Pattern>);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs
