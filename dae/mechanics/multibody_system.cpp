#include "dae/mechanics/multibody_system.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include <mfs/error.hpp>
#include <mfs/version.hpp>

#include "dae/mechanics/divided_residual.hpp"
#include "dae/mechanics/number_text.hpp"
#include "dae/mechanics/state_changes.hpp"

namespace mfs::dae {
namespace {

using Kind = LocalStructure::Kind;

/// What a device has adds nothing to the blocks.
constexpr LocalStructure kNothing{Kind::zero, Kind::zero, Kind::zero, false, false, 0};

/// Elements without a colour that are computed together.
constexpr std::size_t kMostWaiting = 512;
/// Derivatives of F, of all these elements, that are worth waking threads: those of 80 joints of two bodies,
/// of 5 elements of 20 nodes.
constexpr std::size_t kEntriesWorthThreads = 16384;
/// Elements of groups that are evaluated as a whole, whose derivatives are worth waking threads.
constexpr int kElementsWorthThreads = 512;
/// Elements that are longer have not been pressed so far that a message tells of it.
constexpr double kPressed = 0.7;

BlockSet blocks_of(const ElementGroup& group, const LocalStructure& structure) {
  BlockSet blocks;
  for (const Block b : kForceBlocks)
    if (kind_of(structure, b) != Kind::zero) blocks.insert(b);
  if (group.local_constraints() > 0)
    for (const Block b : kConstraintBlocks) blocks.insert(b);
  return blocks;
}

/// The blocks of F that are the same for every state in this group.
BlockSet constant_blocks_of(const LocalStructure& structure) {
  BlockSet blocks;
  if (structure.constant_force_a) blocks.insert(Block::force_a);
  if (structure.constant_force_v) blocks.insert(Block::force_v);
  return blocks;
}

}  // namespace

Multibody::Multibody(Groups groups, std::vector<BodyCoordinates> bodies, double length_unit,
                     double largest_body, int coordinates, int threads, Backend backend)
    : groups_(std::move(groups)),
      bodies_(std::move(bodies)),
      length_unit_(length_unit),
      largest_body_(largest_body),
      n_(coordinates),
      threads_(threads) {
  const bool device = backend_info(backend).memory == MemorySpace::device;
  const std::set<int> on_device = device ? make_device_forces() : std::set<int>{};
  std::set<int> elsewhere = on_device;
  for (int g = 0; g < static_cast<int>(groups_.size()); ++g) {
    structure_.push_back(on_device.count(g) > 0 ? kNothing : groups_[g]->structure());
    blocks_.push_back(blocks_of(*groups_[g], structure_.back()));
    if (const auto* const whole = dynamic_cast<const WholeGroup*>(groups_[g].get())) {
      whole_.push_back({g, whole});
      elsewhere.insert(g);
    }
  }
  number_constraints();
  force_blocks_ = find_force_blocks(groups_, structure_, n_, threads_, pattern_);
  find_constraint_blocks();
  colouring_ = colour_elements(groups_, n_, elsewhere);
  residuals_.emplace(groups_, colouring_, whole_, constraint_start_, n_, threads_);
  find_constant_shares();
  make_workspaces();
}

/// A block that is constant as a whole is evaluated by whoever asks for it, once.
void Multibody::find_constant_shares() {
  constant_blocks_.resize(groups_.size());
  for (const Block block : kForceBlocks) {
    if (pattern_.constant[static_cast<std::size_t>(block)]) continue;
    for (std::size_t g = 0; g < groups_.size(); ++g)
      if (blocks_[g].has(block) && constant_blocks_of(structure_[g]).has(block)) {
        blocks_[g].erase({block});
        constant_blocks_[g].insert(block);
      }
  }
}

void Multibody::make_workspaces() {
  const auto fill = [&](std::vector<Workspace>& workspaces, std::size_t count, const std::set<int>& groups) {
    std::size_t nq = 0, nc = 0;
    for (const int g : groups) {
      nq = std::max(nq, static_cast<std::size_t>(groups_[g]->local_coordinates()));
      nc = std::max(nc, static_cast<std::size_t>(groups_[g]->local_constraints()));
    }
    workspaces.assign(count, Workspace(nq, nc));
    for (Workspace& work : workspaces) work.runs.reserve(nq + 1);  // a copy has no room of its own
  };
  std::set<int> all, uncoloured, wholes;
  for (std::size_t g = 0; g < groups_.size(); ++g) all.insert(static_cast<int>(g));
  const std::size_t first = colouring_.colour_start.back(), end = colouring_.order.size();
  std::size_t entries = 0;
  for (std::size_t k = first; k < end; ++k) {
    const int g = colouring_.order[k].group;
    const auto nq = static_cast<std::size_t>(groups_[g]->local_coordinates());
    uncoloured.insert(g);
    entries += nq * nq;
  }
  uncoloured_are_worth_threads_ = entries > kEntriesWorthThreads;
  fill(workspaces_, static_cast<std::size_t>(threads_), all);
  fill(waiting_, std::min(kMostWaiting, end - first), uncoloured);
  for (const NumberedWhole& whole : whole_) wholes.insert(whole.number);
  fill(whole_workspaces_, whole_.size(), wholes);
}

/// The numbers of the groups whose F a device evaluates.
std::set<int> Multibody::make_device_forces() {
  std::set<int> groups;
  for (std::size_t g = 0; g < groups_.size(); ++g)
    if (auto force = groups_[g]->device_force(n_, threads_)) {
      device_forces_.push_back(std::move(force));
      groups.insert(static_cast<int>(g));
    }
  return groups;
}

void Multibody::number_constraints() {
  std::int64_t m = 0;
  for (const auto& group : groups_) {
    constraint_start_.push_back(static_cast<int>(m));
    m += std::int64_t{group->size()} * group->local_constraints();
    if (m > std::numeric_limits<int>::max())
      throw InvalidInput(group->name(group->size() - 1), std::to_string(m) + " constraints are too many");
  }
  m_ = static_cast<int>(m);
  constraint_start_.push_back(m_);
}

/// The four have one pattern: each row holds the coordinates of its element.
void Multibody::find_constraint_blocks() {
  Pattern pattern{m_, n_, {0}, {}};
  column_rank_.resize(groups_.size());
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const ElementGroup& group = *groups_[g];
    const int nq = group.local_coordinates(), nc = group.local_constraints();
    if (nc == 0) continue;
    for (int e = 0; e < group.size(); ++e) {
      const int* coordinates = group.coordinates(e);
      std::vector<int> sorted(coordinates, coordinates + nq);
      std::sort(sorted.begin(), sorted.end());
      for (int k = 0; k < nq; ++k)
        column_rank_[g].push_back(static_cast<int>(
            std::lower_bound(sorted.begin(), sorted.end(), coordinates[k]) - sorted.begin()));
      for (int row = 0; row < nc; ++row) {
        pattern.column.insert(pattern.column.end(), sorted.begin(), sorted.end());
        pattern.row_start.push_back(static_cast<int>(pattern.column.size()));
      }
    }
  }
  for (const Block block : kConstraintBlocks) {
    pattern_.block[static_cast<std::size_t>(block)] = pattern;
    pattern_.constant[static_cast<std::size_t>(block)] = m_ == 0;
  }
}

/// Calls compute(element, workspace) by all threads, then add(element, workspace) by one, for the elements
/// without a colour.
template <class Compute, class Add>
void Multibody::for_each_uncoloured(const std::vector<char>& group_takes_part, const Compute& compute,
                                    const Add& add) const {
  FirstFailure failure;
  const auto& order = colouring_.order;
  const auto visit = [&](std::size_t k, const auto& work) {
    const ElementId id = order[k];
    if (group_takes_part[id.group] != 0) failure.watch(k, [&] { work(id); });
  };
  for (std::size_t first = colouring_.colour_start.back(); first < order.size(); first += waiting_.size()) {
    const std::size_t end = std::min(order.size(), first + waiting_.size());
#pragma omp parallel for num_threads(threads_) schedule(static) if (uncoloured_are_worth_threads_)
    for (std::size_t k = first; k < end; ++k)
      visit(k, [&](ElementId id) { compute(id, waiting_[k - first]); });
    for (std::size_t k = first; k < end; ++k) visit(k, [&](ElementId id) { add(id, waiting_[k - first]); });
  }
  failure.rethrow();
}

namespace {

void clear(std::vector<double>& values, int threads) {
  const auto count = static_cast<std::int64_t>(values.size());
#pragma omp parallel for num_threads(threads)
  for (std::int64_t k = 0; k < count; ++k) values[k] = 0.0;
}

/// What blocks begin with; empty: zero.
struct Beginning {
  const std::vector<double>* share;
  std::vector<double>* values;
};
void begin(const std::vector<Beginning>& blocks, int threads) {
#pragma omp parallel num_threads(threads)
  for (const Beginning& block : blocks) {
    const std::vector<double>& share = *block.share;
    double* const values = block.values->data();
    const auto count = static_cast<std::int64_t>(block.values->size());
    const bool zero = share.empty();
#pragma omp for schedule(static) nowait
    for (std::int64_t k = 0; k < count; ++k) values[k] = zero ? 0.0 : share[k];
  }
}

}  // namespace

void Multibody::evaluate(const StateView& state, Residual& residual) const {
  for (const auto& force : device_forces_) force->begin(state);
  clear(residual.force, threads_);
  residuals_->add(state, {residual.force.data(), residual.position.data(), residual.velocity.data(),
                          residual.acceleration.data()});
  for (const auto& force : device_forces_) force->add_to(residual.force);
}

std::vector<int> Multibody::host_coordinates() const {
  std::vector<char> is_seen(static_cast<std::size_t>(n_), 0);
  const auto see = [&](ElementId id) {
    const int* coordinates = groups_[id.group]->coordinates(id.element);
    for (int k = 0; k < groups_[id.group]->local_coordinates(); ++k) is_seen[coordinates[k]] = 1;
  };
  for (const ElementId id : colouring_.order) see(id);
  for (const auto& [number, group] : whole_)
    for (int e = 0; e < group->size(); ++e) see({number, e});
  std::vector<int> seen;
  for (int i = 0; i < n_; ++i)
    if (is_seen[i] != 0) seen.push_back(i);
  return seen;
}

ElementResiduals Multibody::host_residuals(const std::vector<int>& coordinates) const {
  std::vector<int> place(static_cast<std::size_t>(n_), -1);
  for (std::size_t k = 0; k < coordinates.size(); ++k) place[coordinates[k]] = static_cast<int>(k);
  return {groups_,  colouring_, whole_, constraint_start_, static_cast<int>(coordinates.size()),
          threads_, place};
}

std::unique_ptr<RemoteResidual> Multibody::remote_residual(const Executor& executor) const {
  if (device_forces_.empty()) return nullptr;
  return std::make_unique<DividedResidual>(*this, executor);
}

void Multibody::evaluate(const StateView& state, Tangent& tangent, BlockSet blocks) const {
  std::vector<Beginning> asked;
  for (const Block block : kForceBlocks)
    if (blocks.has(block)) asked.push_back({&constant_share(block, state), &tangent[block]});
  if (!asked.empty()) begin(asked, threads_);
  std::vector<BlockSet> of_groups = blocks_;
  for (BlockSet& of_group : of_groups) of_group = of_group & blocks;
  add_elements(state, of_groups, tangent);
}

/// Of the groups that have these rows: a rigid interface, whose thousands of rows mostly are not asked for,
/// takes more time than all joints.
void Multibody::evaluate_gradient(const StateView& state, const std::vector<int>& rows,
                                  Tangent& tangent) const {
  std::vector<BlockSet> of_groups(groups_.size());
  for (const int row : rows) of_groups[group_of(row)].insert(Block::position_q);
  add_elements(state, of_groups, tangent);
}

/// Empty: zero.
const std::vector<double>& Multibody::constant_share(Block block, const StateView& state) const {
  std::vector<double>& share = constant_shares_[static_cast<std::size_t>(block)];
  std::vector<BlockSet> of_groups = constant_blocks_;
  for (BlockSet& of_group : of_groups) of_group = of_group & BlockSet{block};
  const bool any = std::any_of(of_groups.begin(), of_groups.end(), [&](BlockSet b) { return b.has(block); });
  if (any && share.empty()) {
    Tangent tangent;
    tangent[block].resize(pattern_[block].entries());
    add_elements(state, of_groups, tangent);
    share = std::move(tangent[block]);
  }
  return share;
}

/// `blocks`: of each group.
void Multibody::add_elements(const StateView& state, const std::vector<BlockSet>& blocks,
                             Tangent& tangent) const {
  std::vector<char> has_some;
  for (const BlockSet of_group : blocks) has_some.push_back(of_group.empty() ? 0 : 1);
  const auto compute = [&](ElementId id, Workspace& work) {
    compute_tangent(id, state, tangent, blocks[id.group], work);
  };
  const auto add = [&](ElementId id, Workspace& work) {
    add_force_blocks(id, blocks[id.group], tangent, work);
  };
  for_each_coloured(colouring_, has_some, threads_, workspaces_, [&](ElementId id, Workspace& work) {
    compute(id, work);
    add(id, work);
  });
  for_each_uncoloured(has_some, compute, add);
  add_whole_groups(state, blocks, tangent);
}

// Each group by one thread. It has its rows to itself; shares of F are added in order.
void Multibody::add_whole_groups(const StateView& state, const std::vector<BlockSet>& blocks,
                                 Tangent& tangent) const {
  int elements = 0;
  for (const NumberedWhole& whole : whole_)
    if (!blocks[whole.number].empty()) elements += whole.group->size();
  FirstFailure failure;
#pragma omp parallel for num_threads(threads_) schedule(dynamic, 1) if (elements > kElementsWorthThreads)
  for (std::size_t k = 0; k < whole_.size(); ++k)
    failure.watch(k, [&] {
      compute_tangent(whole_[k], state, blocks[whole_[k].number], tangent, whole_workspaces_[k]);
    });
  failure.rethrow();
  for (std::size_t k = 0; k < whole_.size(); ++k)
    add_force_blocks({whole_[k].number, 0}, blocks[whole_[k].number], tangent, whole_workspaces_[k]);
}

/// As that of an element below.
void Multibody::compute_tangent(const NumberedWhole& whole, const StateView& state, BlockSet asked,
                                Tangent& tangent, Workspace& work) const {
  if (asked.empty()) return;
  const auto nq = static_cast<std::size_t>(whole.group->local_coordinates());
  const int row = constraint_start_[whole.number];
  const auto force = [&](Block b) { return asked.has(b) ? work.array(b, nq * nq, asked) : nullptr; };
  const auto rows = [&](Block b) {
    return asked.has(b) ? tangent[b].data() + pattern_[b].row_start[row] : nullptr;
  };
  whole.group->tangent_of_all(state, row,
                              {force(Block::force_q), force(Block::force_v), force(Block::force_a),
                               rows(Block::position_q), rows(Block::velocity_q), rows(Block::acceleration_q),
                               rows(Block::acceleration_v), column_rank_[whole.number].data()});
}

/// The blocks of F to `work`, those of constraints, whose rows are the element's own, to where they belong.
void Multibody::compute_tangent(ElementId id, const StateView& state, Tangent& tangent, BlockSet blocks,
                                Workspace& work) const {
  const ElementGroup& group = *groups_[id.group];
  const LocalStructure& structure = structure_[id.group];
  const auto nq = static_cast<std::size_t>(group.local_coordinates());
  const auto nc = static_cast<std::size_t>(group.local_constraints());
  const LocalState local_state = work.gather(state, group.coordinates(id.element), group.local_coordinates(),
                                             first_constraint(id.group, id.element));
  const auto force = [&](Block b) {
    return kind_of(structure, b) == Kind::zero ? nullptr : work.array(b, nq * nq, blocks);
  };
  const auto constraint = [&](Block b) { return nc == 0 ? nullptr : work.array(b, nc * nq, blocks); };
  LocalTangent local{force(Block::force_q),
                     force(Block::force_v),
                     force(Block::force_a),
                     constraint(Block::position_q),
                     constraint(Block::velocity_q),
                     constraint(Block::acceleration_q),
                     constraint(Block::acceleration_v),
                     blocks};
  group.tangent(id.element, local_state, local);
  if (nc == 0) return;
  const double* const constraint_blocks[] = {local.position_q, local.velocity_q, local.acceleration_q,
                                             local.acceleration_v};
  for (std::size_t i = 0; i < kConstraintBlocks.size(); ++i)
    if (blocks.has(kConstraintBlocks[i]))
      set_constraint_block(kConstraintBlocks[i], id, constraint_blocks[i], tangent);
}

void Multibody::add_force_blocks(ElementId id, BlockSet blocks, Tangent& tangent, Workspace& work) const {
  for (std::size_t i = 0; i < kForceBlocks.size(); ++i) {
    const Block block = kForceBlocks[i];
    if (blocks.has(block))
      force_blocks_[i].add(id.group, id.element, *groups_[id.group],
                           work.block[static_cast<std::size_t>(block)].data(), pattern_[block],
                           tangent[block], work.runs);
  }
}

void Multibody::set_constraint_block(Block block, ElementId id, const double* local, Tangent& tangent) const {
  const int nq = groups_[id.group]->local_coordinates(), nc = groups_[id.group]->local_constraints();
  const int* rank = column_rank_[id.group].data() + static_cast<std::ptrdiff_t>(id.element) * nq;
  const Pattern& pattern = pattern_[block];
  const int row = first_constraint(id.group, id.element);
  for (int i = 0; i < nc; ++i) {
    double* values = tangent[block].data() + pattern.row_start[row + i];
    for (int k = 0; k < nq; ++k) values[rank[k]] = local[i * nq + k];
  }
}

std::vector<double> Multibody::marks(const TimeSpan& span) const {
  std::vector<double> marks;
  for (const auto& group : groups_) group->add_marks(span, marks);
  std::sort(marks.begin(), marks.end());
  return marks;
}

std::unique_ptr<ChangeWatch> Multibody::change_watch() const {
  WatchedFunctions functions;
  for (const auto& group : groups_) group->add_watched(functions);
  auto changes = std::make_unique<StateChanges>(functions);
  if (changes->empty()) return nullptr;
  return changes;
}

/// Meshes: bodies of which three coordinates each are a point. Three points or less have no shape to turn.
std::vector<PointRange> Multibody::turning_bodies() const {
  std::vector<PointRange> ranges;
  for (const BodyCoordinates& body : bodies_)
    if (body.components.size() == 3 && body.range.count > 9)
      ranges.push_back({body.range.first, body.range.count / 3});
  return ranges;
}

const BodyCoordinates& Multibody::body_of(int coordinate) const {
  const auto after =
      std::upper_bound(bodies_.begin(), bodies_.end(), coordinate,
                       [](int i, const BodyCoordinates& body) { return i < body.range.first; });
  return *(after - 1);
}

double extent(const std::vector<double>& points) {
  double longest = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double least = HUGE_VAL, most = -HUGE_VAL;
    for (std::size_t i = axis; i < points.size(); i += 3) {
      least = std::min(least, points[i]);
      most = std::max(most, points[i]);
    }
    longest = std::max(longest, most - least);
  }
  return longest;
}

double Multibody::coordinate_scale(int coordinate) const {
  return is_length(coordinate) ? length_unit_ : 1.0;
}

bool Multibody::is_length(int coordinate) const {
  const BodyCoordinates& body = body_of(coordinate);
  return body.is_length(coordinate - body.range.first);
}

std::vector<double> Multibody::ranges(const double* q) const {
  std::vector<double> points;  // frames and nodes
  for (const BodyCoordinates& body : bodies_)
    for (int i = 0; body.lengths == 3 && i < body.range.count; ++i)
      if (body.is_length(i)) points.push_back(q[body.range.first + i]);
  const double lengths = std::max(length_unit_, extent(points));
  std::vector<double> ranges(static_cast<std::size_t>(n_), 1.0);
  for (const BodyCoordinates& body : bodies_)
    for (int i = 0; i < body.range.count; ++i)
      if (body.is_length(i)) ranges[body.range.first + i] = lengths;
  return ranges;
}

std::string Multibody::most_pressed(const double* q) const {
  double least = kPressed;
  std::string text;
  std::vector<double> local;
  for (const auto& group : groups_) {
    local.resize(static_cast<std::size_t>(group->local_coordinates()));
    for (int e = 0; e < group->size(); ++e) {
      for (std::size_t i = 0; i < local.size(); ++i) local[i] = q[group->coordinates(e)[i]];
      const double stretch = group->least_stretch(e, local.data());
      if (!(stretch < least)) continue;
      least = stretch;
      text =
          group->name(e) + " is pressed to " + number_text(least) + " of its length" + group->pressed_note();
    }
  }
  return text;
}

std::string Multibody::coordinate_name(int coordinate) const {
  const BodyCoordinates& body = body_of(coordinate);
  const int local = coordinate - body.range.first;
  const int components = static_cast<int>(body.components.size());
  if (components == 0) return body.name + "[" + std::to_string(local) + "]";
  const std::string& component = body.components[local % components];
  if (components == body.range.count) return body.name + "." + component;
  return body.name + "[" + std::to_string(local / components) + "]." + component;
}

std::size_t Multibody::group_of(int constraint) const {
  const auto after = std::upper_bound(constraint_start_.begin(), constraint_start_.end(), constraint);
  return static_cast<std::size_t>(after - constraint_start_.begin() - 1);
}

/// The group, element and local row that a constraint is of.
Multibody::ConstraintPlace Multibody::place_of(int constraint) const {
  const std::size_t g = group_of(constraint);
  const int nc = groups_[g]->local_constraints(), local = constraint - constraint_start_[g];
  return {*groups_[g], local / nc, local % nc};
}

std::string Multibody::constraint_owner(int row) const {
  const ConstraintPlace place = place_of(row);
  return place.group.name(place.element);
}

std::string Multibody::constraint_name(int row) const {
  const ConstraintPlace place = place_of(row);
  const std::string direction = place.group.direction(place.row);
  return place.group.name(place.element) + ", equation " + std::to_string(place.row + 1) + " of " +
         std::to_string(place.group.local_constraints()) + (direction.empty() ? "" : " (" + direction + ")");
}

}  // namespace mfs::dae
