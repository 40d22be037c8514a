// What a device needs besides the symbolic plan: which kernel takes which front, and the lists of tiles by
// which one launch serves all fronts of a depth. Made once from the plan, on the host, for the limits of a
// device; it names no vendor.
//
//   small fronts   (at most small_rows rows)  one fused kernel: assemble, factor, update, in shared memory
//   larger fronts  assembled in place; then, block column by block column of `tile` pivots,
//
//          k  k2     p         b          block     LU of the diagonal tile (k, k), pivots searched in it
//        +--+--+----------+--------+      strips    L below it times U^-1, L^-1 times U right of it
//      k |  |##|  strips U         |      products  the two from what is left of P, L and U
//     k2 |  +--+----------+--------+      and at the end, as stage "variable update",
//        |  |s |   products        |      C -= L U
//      p |  |t +----------+--------+
//        |  |r |          |   C    |
//
// In a front with many pivots, a slab of them (DeviceLimits::slab) is factored first, without what is right
// of them, which is then solved for and updated at once; and of a slab, in the same way, a panel: products of
// such depth run faster by half. The largest go to the vendor's BLAS. What the next slab needs comes first;
// the rest is updated beside the next slab's tiles, whose chain of short launches cannot fill the device
// (look-ahead). Where a depth has no front with so many, what its next diagonal tiles need comes first in the
// same way.
//
// Where roots have many pivots, the vendor's LAPACK can factor them without pivoting; tiles are the way for
// those that turn out to need it.
//
// Where factors do not fit the device, the launches of a depth are divided among its segments
// (plan/segments.hpp), after the work has been cut for the depth as a whole: a front has the same tiles.
#pragma once

#include <limits>
#include <vector>

#include "plan/segments.hpp"
#include "plan/symbolic_plan.hpp"

namespace mfs {

/// C (m x n) -= A (m x k) B (k x n): places in the region of the plan.
struct ProductTask {
  Offset a, b, c;
  Vertex m, n, k;
  Vertex lda, ldb, ldc;
  Vertex first_tile;  // in its launch
  Vertex padding;     // of the m rows: those that only align the next column
  Vertex front;
};

/// The diagonal tile of a front at its pivot k, and the strips beside it: of the block column, where `left`,
/// and of columns [begin, end) of the block row, counted from the tile's right edge; those of U lie where it
/// would begin at `upper`.
struct StepTask {
  Vertex front, k;
  Vertex left, begin, end;
  Vertex first_strip;  // in its launch
  Offset upper;
  Offset border_at = 0;  // of a tall front, in the launch of its tiles: its place in DevicePlan::tall_border
};

/// Rows [first_row, last_row) of columns [begin, end) of a front, all in one of its blocks, and the original
/// entries that lie there. Entry (i, j) of the front goes to place + i + j * ld, for the block's own ld.
struct AssemblyPart {
  Vertex front, begin, end;
  Vertex first_row, last_row;
  Offset first_entry, last_entry;
  Offset place;
};

/// A block of a front's pivot block, at (begin, column).
struct FrontPart {
  Vertex front, begin, column;
};

/// What a tile of the solve must know of its front, so that it need not look it up: places in the region of
/// the plan, the first pivot by position, the first border row by place, the first of all rows in row_begin.
struct SolveFront {
  Offset lower, upper, border_at, rows_at;
  Vertex pivots_at, pivots, border, ld;
};

/// Steps [first_step, last_step) of the tile of a front that begins at row `begin`, for the solve: a step is
/// kSolveTile entries of the vector times what of the factor multiplies them. A tile has kSolveTile rows;
/// forward, in a border where more tiles than the device can hold would have one step each, up to kTallTile.
/// Backward, what a long border needs is cut in parts, so that few large fronts fill the device. All but the
/// last leave their sums in places of their own; the last takes those from its first place on, does the last
/// steps and finishes the tile.
struct SolvePart {
  Vertex front, begin;
  Vertex first_step, last_step;
  bool finishes;
  Offset place;  // of 64 sums: its own, or of the first part
  Vertex parts;  // before the one that finishes
  SolveFront where;
  Vertex rows;  // of the tile
};

struct Range {
  Offset begin = 0, end = 0;
  Offset count() const { return end - begin; }
};

/// Launches of a depth follow each other (sequential); but concurrent ones may run beside those after them,
/// up to the next that joins, as long as no front is strict.
enum class Order { sequential, concurrent, join };

/// One launch for all its tasks, or for Kind::vendor_gemm one call of the vendor's BLAS for its one task.
struct Launch {
  enum class Kind { diagonal, strips, products, wide_products, vendor_gemm };
  Kind kind;
  Range tasks;
  Vertex blocks = 0;
  Order order = Order::sequential;
  Vertex width = 0;  // pivots of the widest tile, for diagonal and strips
  // For diagonal, where it has tall fronts: most rows of those from the diagonal down in the pivot block,
  // most of all of their rows, and most in their borders.
  Vertex tall_pivots = 0, tall_rows = 0, tall_border = 0;
};

struct SmallLaunch {
  Range fronts;
  Vertex rows = 0;  // of the largest
};

/// The entries of fronts with more rows are too many for DevicePlan::entry_place: those are never small.
constexpr Vertex kMostSmallRows = 32768;
/// Small fronts of a depth are launched by size, in steps of kSmallStep rows on CUDA.
constexpr Vertex kSmallStep = 32, kMostSmallLaunches = 5;

struct DepthLaunches {
  std::vector<SmallLaunch> small;
  Range assemble;                            // P, L and U
  std::vector<Range> assemble_contribution;  // C, which is needed for `update` only, turn by turn
  std::vector<Launch> factor;
  Range exchange;  // block rows left of later panels
  std::vector<Launch> update;
  Range inverses;  // of DevicePlan::wide_tiles, where each segment makes its own

  /// Whether one kernel does all.
  bool is_one_small_launch() const { return small.size() == 1 && assemble.count() == 0 && factor.empty(); }
};

/// A launch of the solve in one direction: tiles and parts of tiles, depth after depth, each of which waits
/// for the results that it needs. Tiny fronts, which a warp solves with, are launched beside the tiles; they
/// do not wait, so a depth that has them shares its launch with no other.
struct SolveLaunch {
  Range tiny;
  Range tiles;
  Range border;  // forward: the places of what its fronts leave
};

/// The LU of a root's pivot block as one call of the vendor's LAPACK: its place in the region of the plan.
struct RootTask {
  Offset at;
  Vertex pivots, ld;
};

struct DevicePlan {
  Vertex tile = 0, strip = 0, small_rows = 0, tall = 0;
  Vertex tall_tasks = 0;   // most of a launch with tall fronts
  Offset tall_border = 0;  // entries: most of a launch, of panels in the borders of its tall fronts
  Vertex panel_entries = 0;
  std::vector<Vertex> small_fronts, tiny_fronts;
  RawVector<AssemblyPart> assemble;
  // Where the plan's original entries go: from the first entry of the first column of their part, or from the
  // first entry of [P; L] of a small front, as if U followed at once.
  RawVector<Vertex> entry_place;
  std::vector<FrontPart> exchange;
  std::vector<FrontPart> wide_tiles;  // of kSolveTile pivots: those that have more than one inverted block
  std::vector<SolvePart> solve;
  Offset solve_places = 0;  // of partial sums
  std::vector<SolveLaunch> forward, backward;
  std::vector<StepTask> steps;
  std::vector<ProductTask> products;
  std::vector<DepthLaunches> depths;  // or segments, as `forward`; `backward` has them from the last one on
  SegmentPlan segments;               // empty where the factors fit as they are
  // The matrix, and where its entries go, are read in the memory of the host: once in a factorization.
  bool matrix_on_host = false;
  // Where there are segments, num_fronts: of SegmentPlan. The executor adds where the memory of the host
  // begins, also to SolvePart::where, for those that a solve reads there.
  std::vector<Offset> solve_lower, solve_upper;
  std::vector<Offset> block_read;  // num_fronts, where contribution blocks leave: for the executor to fill
  std::vector<char> divided;       // num_fronts, where there are divided fronts
  // In place of DepthLaunches::factor of the last depth, if there are any: then the vendor's LAPACK can have
  // all roots that are not small.
  std::vector<RootTask> roots;
  std::vector<FrontPart> unpivoted;  // their tiles: first those on the diagonal, then those below it
  Range on_diagonal, below_diagonal;
  // Row i of front f takes row child_row[child_row_begin[c] + i] of the contribution block of its c-th entry
  // in the plan's children, -1 for none.
  std::vector<Offset> child_row_begin;  // children + 1
  RawVector<Vertex> child_row;
  // Row i of front f takes what its children left at [source_begin[row_begin[f] + i], source_begin[... + 1]).
  // A border row leaves its value at destination[its place in the plan's border]. There are as many places as
  // two neighbouring launches of the forward pass need.
  std::vector<Offset> row_begin;   // num_fronts
  RawVector<Vertex> source_begin;  // rows of all fronts, and the end of each depth's last one
  RawVector<Vertex> destination;
  Offset border_places = 0;
};

/// As DeviceLimits::least_root.
constexpr Vertex kNoRoots = std::numeric_limits<Vertex>::max();

/// Later turns begin once P, L and U of the depth are assembled. More turns make no region smaller (tried:
/// 8).
constexpr AssemblyTurns kAssemblyTurns{4, 160};

/// Entries that a block assembles, if that is more than kAssembleColumns columns.
constexpr Vertex kAssembleEntries = 4096, kAssembleColumns = 4;
/// Most columns of a panel of a tall front whose pivots are searched in all rows.
constexpr Vertex kMostPanelColumns = 16;
/// Rows of a tile of the solve.
constexpr Vertex kSolveTile = 64, kTallTile = 256;
/// The triangles of blocks of so many pivots are left inverted by what factors a diagonal tile.
constexpr Vertex kInverted = 32;

/// Fronts with at most kTinyPivots pivots and so many entries in L are solved with by one warp, in depths
/// that have many of them: a warp takes longer than a block, which matters where the device is not full.
constexpr Vertex kTinyPivots = 32, kTinyEntries = 16384;

/// What a device and its kernels can do, and from which sizes on the work is cut in which way: read from the
/// device (kernels/cuda) or given by a test. The sizes were measured on H100 and H200, which have 132
/// multiprocessors.
struct DeviceLimits {
  // The kernels for one kind of numbers and the shared memory of the device: pivots of a diagonal tile, rows
  // of the largest front that a block factors in shared memory as a whole, whether there are kernels for wide
  // tiles of products, and rows of the strips beside a diagonal tile.
  Vertex tile = 128, small_rows = 160;
  bool wide_products = true;
  Vertex strip = 128;

  Vertex multiprocessors = 132;

  // Fronts of `panelled` pivots and `panelled_rows` rows are factored by panels of `panel`, a multiple of
  // `tile`, in slabs of `slab`, a multiple of that. In smaller ones the launches that this takes cost more
  // than deeper products save.
  Vertex panelled = 1024, panelled_rows = 4096, panel = 512, slab = 2048;
  // Where a depth has none of those, products of more tiles than the device runs at once are made beside the
  // next diagonal tile.
  Offset ahead_tiles = 4 * static_cast<Offset>(multiprocessors);
  // So many tiles use the device better when they are wide.
  Offset enough_tiles = 2 * static_cast<Offset>(multiprocessors);

  // Fronts of at most this part of their depth's operations are small, too, whatever their rows.
  double small_part = 0;
  // Fronts of more pivots are tall: one block of threads would be long alone with those where they are
  // searched in all rows.
  Vertex tall = 128;
  Vertex panel_entries = 0;  // of a panel of those in shared memory
  // Whether the pivots of a tile are searched in all rows of the front's pivot block, in their place.
  bool whole_columns = false;
  // Small fronts of a depth are launched by size, in steps of so many rows.
  Vertex small_step = kSmallStep;
  // Rows and columns of a tile of a product that is not wide. The vendor's BLAS has products of so many
  // entries and so deep, one call each.
  Vertex product_rows = 64, product_columns = 64;
  Offset vendor_entries = Offset(1) << 20;
  Vertex vendor_depth = 256;

  // So many tiny fronts of a depth are solved with by warps.
  Vertex many_tiny = 1024;
  // Parts of a tile of the solve take so many steps, and so many tiles may come before parts of theirs, which
  // they wait for: the device must run one block more than that at once.
  Vertex solve_steps = 16, waiting_tiles = multiprocessors - 1;
  // Tiles of one column that run at once: where the border of a depth has more, some are tall.
  Vertex crowd = 3 * multiprocessors;

  // The vendor's LAPACK can have the roots that are not small if all of them have so many pivots. Those of
  // more fill the device by the look-ahead of tiles.
  Vertex least_root = kNoRoots, most_root = 8192;
};

DevicePlan make_device_plan(const SymbolicPlan& plan, const DeviceLimits& limits);
/// By segments: `placed` is the plan with their places (placed_by).
DevicePlan make_device_plan(const SymbolicPlan& placed, const DeviceLimits& limits, SegmentPlan segments);

}  // namespace mfs
