#include "kernels/stages/host_factors.hpp"

#include <stdexcept>

namespace mfs {

NumericLayout::NumericLayout(const SymbolicPlan& plan, Offset scalar_bytes, Offset value_bytes) {
  const Offset n = plan.n;
  storage = arena.add(plan.storage_entries * scalar_bytes);
  matrix_values = arena.add(plan.nnz * value_bytes);
  row_scale = arena.add(n * static_cast<Offset>(sizeof(double)));
  column_scale = arena.add(n * static_cast<Offset>(sizeof(double)));
  interchange = arena.add(n * static_cast<Offset>(sizeof(Vertex)));
  local_row = arena.add(n * static_cast<Offset>(sizeof(Vertex)));
  shift = arena.add(n * scalar_bytes);
  work = arena.add(n * scalar_bytes);
  status = arena.add(sizeof(FactorStatus));
}

SubstitutionLayout::SubstitutionLayout(const SymbolicPlan& plan, Offset scalar_bytes, Vertex columns) {
  const Offset block = static_cast<Offset>(plan.n) * columns;
  for (Offset* vector : {&v, &y}) *vector = arena.add(block * scalar_bytes);
  border = arena.add(static_cast<Offset>(plan.border.size()) * columns * scalar_bytes);
}

NumericBytes host_bytes(const SymbolicPlan& plan, Offset scalar_bytes, Offset value_bytes, Vertex columns) {
  const NumericLayout numeric(plan, scalar_bytes, value_bytes);
  NumericBytes bytes;
  bytes.factor = plan.factor_entries * scalar_bytes;
  bytes.contribution = numeric.matrix_values - bytes.factor;
  bytes.other = numeric.arena.total() - numeric.matrix_values;
  bytes.solve = SubstitutionLayout(plan, scalar_bytes, columns).arena.total();
  return bytes;
}

template <class Scalar, class Value>
FrontStore<Scalar, Value> make_front_store(const SymbolicPlan& plan, const Pattern& pattern,
                                           const NumericLayout& layout, const HostArena& arena) {
  if (plan.has_turns()) throw std::logic_error("MFS: the host assembles all blocks of a depth at once");
  FrontStore<Scalar, Value> store;
  store.n = plan.n;
  store.max_block_size = plan.max_block_size;
  for_each_plan_array(store, plan, pattern,
                      [](auto*& pointer, const auto& array) { pointer = array.data(); });
  store.entry_target = plan.entry_target.data();
  store.entry_row = plan.entry_row.data();
  store.matrix_values = arena.at<Value>(layout.matrix_values);
  store.row_scale = arena.at<double>(layout.row_scale);
  store.column_scale = arena.at<double>(layout.column_scale);
  store.storage = arena.at<Scalar>(layout.storage);
  store.interchange = arena.at<Vertex>(layout.interchange);
  store.local_row = arena.at<Vertex>(layout.local_row);
  store.shift = arena.at<Scalar>(layout.shift);
  store.work = arena.at<Scalar>(layout.work);
  store.status = arena.at<FactorStatus>(layout.status);
  return store;
}

namespace {

template <class Value, class Scalar>
std::unique_ptr<Factors<Value>> make(HostSpace space, std::shared_ptr<const SymbolicPlan> plan,
                                     std::shared_ptr<const Pattern> pattern, int threads) {
  if (space == HostSpace::serial)
    return std::make_unique<HostFactors<OneThread, Value, Scalar>>(std::move(plan), std::move(pattern), 1);
  return std::make_unique<HostFactors<HostThreads, Value, Scalar>>(std::move(plan), std::move(pattern),
                                                                   threads);
}

}  // namespace

template <class Value>
std::unique_ptr<Factors<Value>> make_host_factors(HostSpace space, bool single_precision,
                                                  std::shared_ptr<const SymbolicPlan> plan,
                                                  std::shared_ptr<const Pattern> pattern, int threads) {
  if (single_precision)
    return make<Value, Narrow<Value>>(space, std::move(plan), std::move(pattern), threads);
  return make<Value, Value>(space, std::move(plan), std::move(pattern), threads);
}

#define MFS_INSTANTIATE(Value)                                                                              \
  template FrontStore<Value, Value> make_front_store<Value, Value>(const SymbolicPlan&, const Pattern&,     \
                                                                   const NumericLayout&, const HostArena&); \
  template std::unique_ptr<Factors<Value>> make_host_factors<Value>(                                        \
      HostSpace, bool, std::shared_ptr<const SymbolicPlan>, std::shared_ptr<const Pattern>, int);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs
