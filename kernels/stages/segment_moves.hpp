// How the factors of segments (plan/segments.hpp) leave the memory of the host for a file and come back,
// beside the work on other segments. A pass, which is a factorization or a solve, is a row of lists, one for
// each segment (in a solve twice: forward, then backward), and a row of moves, which one thread does in their
// order:
//
//   lists   | 0 | 1 | 2 | ...            A move waits until the lists before `after` are done: what it writes
//   moves     0 | 1 | 2 | ...            is there, or what lies where it reads to is not needed any more.
//                                        A list waits until its first moves are done.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <exception>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "kernels/runtime/factor_file.hpp"
#include "plan/segments.hpp"

namespace mfs {

struct SegmentMove {
  std::size_t extent;  // of the file
  Offset place;        // bytes of the region
  std::size_t after;   // lists
};

struct SegmentMoves {
  bool out = false;  // to the file
  std::vector<SegmentMove> moves;
  std::vector<std::size_t> before_list;  // how many moves are done before each list begins
};

/// Of a factorization, and of a solve, which goes forward and backward. Extent k of the file has the factors
/// of the k-th segment that leaves.
SegmentMoves moves_of_factorization(const SegmentPlan& plan, Offset entry_bytes);
SegmentMoves moves_of_solve(const SegmentPlan& plan, Offset entry_bytes);
std::vector<Offset> file_extents(const SegmentPlan& plan, Offset entry_bytes);

/// One pass. Its thread begins with it and ends with it, and takes no signals.
class MovingPass {
 public:
  /// All must outlive this; the region begins at `storage`. Throws BackendError("threads"), std::bad_alloc.
  MovingPass(FactorFile& file, const SegmentMoves& moves, char* storage);
  ~MovingPass();
  MovingPass(const MovingPass&) = delete;
  MovingPass& operator=(const MovingPass&) = delete;

  /// Waits until a list may begin; from any thread. False after a move has failed: nothing more is to be
  /// done.
  bool may_begin(std::size_t list);
  void done(std::size_t list);
  /// Waits for the last move. Throws what a move has thrown.
  void finish();

 private:
  void run();
  bool wait_for_lists(std::size_t count);
  void end();

  FactorFile& file_;
  const SegmentMoves& moves_;
  char* const storage_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t lists_ = 0, moved_ = 0;  // done
  bool given_up_ = false;
  std::exception_ptr error_;
  std::thread thread_;
};

}  // namespace mfs
