#include "kernels/stages/host_factors.hpp"

#include <limits>
#include <stdexcept>

namespace mfs {

NumericLayout::NumericLayout(const SymbolicPlan& plan, Offset scalar_bytes, Offset value_bytes,
                             const SegmentPlan* segments) {
  const Offset n = plan.n;
  storage = arena.add((segments ? segments->region_entries : plan.storage_entries) * scalar_bytes);
  matrix_values = arena.add(plan.nnz * value_bytes);
  row_scale = arena.add(n * static_cast<Offset>(sizeof(double)));
  column_scale = arena.add(n * static_cast<Offset>(sizeof(double)));
  interchange = arena.add(n * static_cast<Offset>(sizeof(Vertex)));
  local_row = arena.add(n * static_cast<Offset>(sizeof(Vertex)));
  shift = arena.add(n * scalar_bytes);
  work = arena.add(n * scalar_bytes);
  status = arena.add(sizeof(FactorStatus));
  if (segments) diagonal = arena.add(n * scalar_bytes);
  if (!plan.triangle.empty()) couplings = arena.add(plan.triangle.couplings() * scalar_bytes);
}

SubstitutionLayout::SubstitutionLayout(const SymbolicPlan& plan, Offset scalar_bytes, Vertex columns) {
  const Offset width = rows::width_of(columns), block = plan.n * width;
  for (Offset* vector : {&v, &y}) *vector = arena.add(block * scalar_bytes);
  border = arena.add(static_cast<Offset>(plan.border.size()) * width * scalar_bytes);
}

namespace {

/// HostFactors keeps the positions of rows and columns for more than one right-hand side.
Offset position_bytes(const SymbolicPlan& plan, Vertex columns) {
  return columns > 1 ? 2 * plan.n * static_cast<Offset>(sizeof(Vertex)) : 0;
}

}  // namespace

NumericBytes host_bytes(const SymbolicPlan& plan, Offset scalar_bytes, Offset value_bytes, Vertex columns) {
  const NumericLayout numeric(plan, scalar_bytes, value_bytes);
  NumericBytes bytes;
  bytes.factor = plan.factor_entries * scalar_bytes;
  bytes.contribution = numeric.matrix_values - bytes.factor;
  bytes.other = numeric.arena.total() - numeric.matrix_values;
  bytes.solve = SubstitutionLayout(plan, scalar_bytes, columns).arena.total() + position_bytes(plan, columns);
  return bytes;
}

namespace {

/// Fronts of any size stay whole.
constexpr Vertex kUndivided = std::numeric_limits<Vertex>::max();

Movement movement_of(const SymbolicPlan& plan, const SegmentPlan& segments, Offset scalar_bytes) {
  Movement movement;
  movement.segments.assign(static_cast<std::size_t>(plan.num_depths), 0);
  for (const Segment& segment : segments.segments) ++movement.segments[segment.step];
  movement.out = segments.host_entries * scalar_bytes;
  movement.back = segments.entries_back() * scalar_bytes;
  return movement;
}

}  // namespace

OutOfCore plan_out_of_core(const SymbolicPlan& plan, Offset scalar_bytes, Offset value_bytes,
                           const std::function<Offset(Vertex)>& ladder_bytes, const std::string& folder,
                           Offset available) {
  const SegmentPlan nothing;
  const Offset others = NumericLayout(plan, scalar_bytes, value_bytes, &nothing).arena.total();
  const auto spare_for = [&](Vertex columns) {
    const Offset bytes = SubstitutionLayout(plan, scalar_bytes, columns).arena.total();
    return aligned((bytes + scalar_bytes - 1) / scalar_bytes);
  };
  OutOfCore made;
  made.folder = folder;
  for (made.columns = kSolveColumns; made.columns > 0; made.columns /= 4) {
    const Offset ladder = ladder_bytes(made.columns) + position_bytes(plan, made.columns);
    const Offset spare = spare_for(made.columns);
    const Offset region = (available - others - ladder) / scalar_bytes / kAlignment * kAlignment;
    if (region <= spare) continue;
    made.segments = make_segments(plan, region, spare, kUndivided, Outside::file);
    if (!made.segments.empty()) break;
  }
  if (made.segments.empty()) {
    const Offset least = least_region(plan, spare_for(1), kUndivided, Outside::file) * scalar_bytes;
    throw OutOfMemory(MemorySpace::host, static_cast<std::size_t>(least + others + ladder_bytes(1)),
                      static_cast<std::size_t>(available));
  }
  made.bytes.factor = plan.factor_entries * scalar_bytes;
  made.bytes.outside = made.segments.host_entries * scalar_bytes;
  made.bytes.other = others;
  made.bytes.contribution =
      made.segments.region_entries * scalar_bytes - (made.bytes.factor - made.bytes.outside);
  made.bytes.solve = ladder_bytes(made.columns) + position_bytes(plan, made.columns);
  made.movement = movement_of(plan, made.segments, scalar_bytes);
  return made;
}

SegmentedFactors::SegmentedFactors(const OutOfCore& made, Offset entry_bytes)
    : made_(made),
      factorization_(moves_of_factorization(made.segments, entry_bytes)),
      solve_(moves_of_solve(made.segments, entry_bytes)),
      file_(made.folder, file_extents(made.segments, entry_bytes)) {}

void SegmentedFactors::begin_factorization(std::optional<MovingPass>& pass, void* storage) {
  pass.emplace(file_, factorization_, static_cast<char*>(storage));
}

void SegmentedFactors::begin_solve(std::optional<MovingPass>& pass, void* storage) {
  pass.emplace(file_, solve_, static_cast<char*>(storage));
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
  store.planned_lower = plan.lower_begin.data();
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
                                     std::shared_ptr<const Pattern> pattern, int threads,
                                     const OutOfCore* outside, Vertex columns) {
  if (space == HostSpace::serial)
    return std::make_unique<HostFactors<OneThread, Value, Scalar>>(std::move(plan), std::move(pattern), 1,
                                                                   outside, columns);
  return std::make_unique<HostFactors<HostThreads, Value, Scalar>>(std::move(plan), std::move(pattern),
                                                                   threads, outside, columns);
}

}  // namespace

template <class Value>
std::unique_ptr<Factors<Value>> make_host_factors(HostSpace space, bool single_precision,
                                                  std::shared_ptr<const SymbolicPlan> plan,
                                                  std::shared_ptr<const Pattern> pattern, int threads,
                                                  const OutOfCore* outside, Vertex columns) {
  if (single_precision)
    return make<Value, Narrow<Value>>(space, std::move(plan), std::move(pattern), threads, outside, columns);
  return make<Value, Value>(space, std::move(plan), std::move(pattern), threads, outside, columns);
}

#define MFS_INSTANTIATE(Value)                                                                              \
  template FrontStore<Value, Value> make_front_store<Value, Value>(const SymbolicPlan&, const Pattern&,     \
                                                                   const NumericLayout&, const HostArena&); \
  template std::unique_ptr<Factors<Value>> make_host_factors<Value>(                                        \
      HostSpace, bool, std::shared_ptr<const SymbolicPlan>, std::shared_ptr<const Pattern>, int,            \
      const OutOfCore*, Vertex);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs
