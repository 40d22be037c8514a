#include "kernels/stages/segment_moves.hpp"

#include <csignal>
#include <system_error>

#include <mfs/error.hpp>

namespace mfs {

namespace {

/// Extent of the file by segment.
std::vector<std::size_t> extents_of(const SegmentPlan& plan) {
  std::vector<std::size_t> extents;
  std::size_t next = 0;
  for (const Segment& segment : plan.segments) extents.push_back(segment.stays() ? next : next++);
  return extents;
}

}  // namespace

std::vector<Offset> file_extents(const SegmentPlan& plan, Offset entry_bytes) {
  std::vector<Offset> bytes;
  for (const Segment& segment : plan.segments) {
    if (!segment.stays()) bytes.push_back(segment.entries * entry_bytes);
  }
  return bytes;
}

SegmentMoves moves_of_factorization(const SegmentPlan& plan, Offset entry_bytes) {
  const std::vector<std::size_t> extents = extents_of(plan);
  SegmentMoves made;
  made.out = true;
  std::vector<std::size_t> moves_before{0};  // by segment
  for (std::size_t t = 0; t < plan.segments.size(); ++t) {
    const Segment& segment = plan.segments[t];
    if (!segment.stays()) made.moves.push_back({extents[t], segment.place * entry_bytes, t + 1});
    moves_before.push_back(made.moves.size());
  }
  for (const Segment& segment : plan.segments)
    made.before_list.push_back(moves_before[static_cast<std::size_t>(segment.leaves_first)]);
  return made;
}

SegmentMoves moves_of_solve(const SegmentPlan& plan, Offset entry_bytes) {
  const std::vector<std::size_t> extents = extents_of(plan);
  const auto count = static_cast<Vertex>(plan.segments.size());
  SegmentMoves made;
  const auto add_list = [&](Vertex t, bool comes, Vertex lists_before) {
    const auto i = static_cast<std::size_t>(t);
    if (comes)
      made.moves.push_back(
          {extents[i], plan.segments[i].solve_place * entry_bytes, static_cast<std::size_t>(lists_before)});
    made.before_list.push_back(made.moves.size());
  };
  for (Vertex t = 0; t < count; ++t) {
    const Segment& segment = plan.segments[t];
    add_list(t, segment.comes(), segment.forward_after + 1);
  }
  for (Vertex t = count - 1; t >= 0; --t) {
    const Segment& segment = plan.segments[t];
    add_list(t, segment.comes() && segment.backward_after >= 0, 2 * count - segment.backward_after);
  }
  return made;
}

MovingPass::MovingPass(FactorFile& file, const SegmentMoves& moves, char* storage)
    : file_(file), moves_(moves), storage_(storage) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  int refused = 0;
  try {
    thread_ = std::thread([this] { run(); });
  } catch (const std::system_error& error) {
    refused = error.code().value();
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  if (refused != 0) throw BackendError("threads", refused, std::generic_category().message(refused));
}

MovingPass::~MovingPass() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    given_up_ = true;
  }
  end();
}

bool MovingPass::may_begin(std::size_t list) {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [&] { return given_up_ || moved_ >= moves_.before_list[list]; });
  return !given_up_;
}

void MovingPass::done(std::size_t list) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    lists_ = list + 1;
  }
  changed_.notify_all();
}

void MovingPass::finish() {
  end();
  if (error_) std::rethrow_exception(error_);
}

void MovingPass::end() {
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

bool MovingPass::wait_for_lists(std::size_t count) {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [&] { return given_up_ || lists_ >= count; });
  return !given_up_;
}

void MovingPass::run() {
  try {
    for (const SegmentMove& move : moves_.moves) {
      if (!wait_for_lists(move.after)) return;
      char* const data = storage_ + move.place;
      if (moves_.out) {
        file_.write(move.extent, data);
      } else {
        file_.read(move.extent, data);
      }
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        ++moved_;
      }
      changed_.notify_all();
    }
  } catch (...) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      error_ = std::current_exception();
      given_up_ = true;
    }
    changed_.notify_all();
  }
}

}  // namespace mfs
