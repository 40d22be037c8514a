// The parts of the adapter that know ranks and ids but neither Tpetra nor MFS' solver: errors on all ranks,
// gathering, positions of ids. On one rank they are plain calls; CTest also runs them on two.
#include "amesos2_mfs/src/id_positions.hpp"
#include "amesos2_mfs/src/on_all_ranks.hpp"
#include "amesos2_mfs/src/rank_gather.hpp"

#include <gtest/gtest.h>

#include <new>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include <Tpetra_Core.hpp>

#include <mfs/error.hpp>

namespace {

using mfs::amesos2::IdPositions;
using mfs::amesos2::on_all_ranks;
using mfs::amesos2::RankGather;

/// `error` is thrown on the last rank only; `check` sees what arrives on every rank.
template <class Thrown, class Arriving = Thrown, class Check>
void relay(const Thrown& error, const Check& check) {
  const auto comm = Tpetra::getDefaultComm();
  try {
    on_all_ranks(*comm, [&] {
      if (comm->getRank() == comm->getSize() - 1) throw error;
    });
    FAIL() << "nothing was thrown on rank " << comm->getRank();
  } catch (const Arriving& e) {
    check(e);
  }
}

TEST(Amesos2OnAllRanks, EachClassKeepsItsFieldsAndText) {
  const mfs::InvalidInput invalid("values", "not finite", 3, 5);
  relay(invalid, [&](const mfs::InvalidInput& e) {
    EXPECT_STREQ(e.what(), invalid.what());
    EXPECT_EQ(e.argument(), "values");
    EXPECT_EQ(e.row(), 3);
    EXPECT_EQ(e.column(), 5);
  });
  const mfs::SingularMatrix singular(mfs::SingularMatrix::Kind::numerical, 7, 9, 2, "no pivot");
  relay(singular, [&](const mfs::SingularMatrix& e) {
    EXPECT_STREQ(e.what(), singular.what());
    EXPECT_EQ(e.kind(), mfs::SingularMatrix::Kind::numerical);
    EXPECT_EQ(e.row(), 7);
    EXPECT_EQ(e.column(), 9);
    EXPECT_EQ(e.dependent_rows(), 2);
  });
  const mfs::PatternChanged changed("one entry more", 11);
  relay(changed, [&](const mfs::PatternChanged& e) {
    EXPECT_STREQ(e.what(), changed.what());
    EXPECT_EQ(e.row(), 11);
  });
  const mfs::AccuracyNotReached accuracy(1e-5, 1e-12);
  relay(accuracy, [&](const mfs::AccuracyNotReached& e) {
    EXPECT_STREQ(e.what(), accuracy.what());
    EXPECT_EQ(e.reached(), 1e-5);
    EXPECT_EQ(e.asked(), 1e-12);
  });
  const mfs::OutOfMemory memory(mfs::MemorySpace::device, std::size_t{1} << 40, 123);
  relay(memory, [&](const mfs::OutOfMemory& e) {
    EXPECT_STREQ(e.what(), memory.what());
    EXPECT_EQ(e.space(), mfs::MemorySpace::device);
    EXPECT_EQ(e.needed(), std::size_t{1} << 40);
    EXPECT_EQ(e.available(), 123u);
  });
  const mfs::BackendError backend("cublas", 13, "execution failed");
  relay(backend, [&](const mfs::BackendError& e) {
    EXPECT_STREQ(e.what(), backend.what());
    EXPECT_EQ(e.library(), "cublas");
    EXPECT_EQ(e.code(), 13);
  });
  relay(mfs::StateError("too early"), [](const mfs::StateError& e) { EXPECT_STREQ(e.what(), "too early"); });
  relay(std::invalid_argument("shape"), [](const std::exception& e) { EXPECT_STREQ(e.what(), "shape"); });
  relay(std::runtime_error("other"), [](const std::exception& e) { EXPECT_STREQ(e.what(), "other"); });
}

TEST(Amesos2OnAllRanks, ForeignExceptionsBecomeOnesThatCanTravel) {
  if (Tpetra::getDefaultComm()->getSize() == 1) {
    relay<std::bad_alloc>({}, [](const std::bad_alloc&) {});
    relay(42, [](int) {});
    return;
  }
  relay<std::bad_alloc, mfs::OutOfMemory>(
      {}, [](const mfs::OutOfMemory& e) { EXPECT_EQ(e.space(), mfs::MemorySpace::host); });
  relay<int, std::runtime_error>(42, [](const std::runtime_error&) {});
}

TEST(Amesos2OnAllRanks, TheLowestRankIsHeard) {
  const auto comm = Tpetra::getDefaultComm();
  try {
    on_all_ranks(*comm, [&] { throw std::runtime_error("rank " + std::to_string(comm->getRank())); });
    FAIL();
  } catch (const std::runtime_error& e) {
    EXPECT_STREQ(e.what(), "rank 0");
  }
}

TEST(Amesos2OnAllRanks, NoErrorNoEffect) {
  int calls = 0;
  on_all_ranks(*Tpetra::getDefaultComm(), [&] { ++calls; });
  EXPECT_EQ(calls, 1);
}

TEST(Amesos2RankGather, ThereAndBack) {
  const auto comm = Tpetra::getDefaultComm();
  const int rank = comm->getRank(), ranks = comm->getSize();
  // Rank r has 3 r entries: rank 0 has none.
  std::vector<double> mine(static_cast<std::size_t>(3 * rank));
  std::iota(mine.begin(), mine.end(), 100.0 * rank);
  const RankGather gather(comm, static_cast<std::int64_t>(mine.size()));
  ASSERT_EQ(gather.total(), 3 * ranks * (ranks - 1) / 2);
  std::vector<double> all(rank == 0 ? gather.total() : 0);
  gather.to_root(mine.data(), all.data());
  if (rank == 0) {
    std::size_t k = 0;
    for (int r = 0; r < ranks; ++r)
      for (int j = 0; j < 3 * r; ++j) EXPECT_EQ(all[k++], 100.0 * r + j);
  }
  for (double& value : all) value += 0.5;
  gather.from_root(all.data(), mine.data());
  for (std::size_t j = 0; j < mine.size(); ++j)
    EXPECT_EQ(mine[j], 100.0 * rank + static_cast<double>(j) + 0.5);
}

TEST(Amesos2IdPositions, CountingUp) {
  const IdPositions positions({7, 8, 9});
  EXPECT_FALSE(positions.identity());
  EXPECT_EQ(positions.find(6), -1);
  EXPECT_EQ(positions.find(7), 0);
  EXPECT_EQ(positions.find(9), 2);
  EXPECT_EQ(positions.find(10), -1);
  EXPECT_TRUE(IdPositions({0, 1, 2}).identity());
  EXPECT_EQ(IdPositions().find(0), -1);
}

TEST(Amesos2IdPositions, AnyOrder) {
  const IdPositions positions({40, -3, 1LL << 40});
  EXPECT_FALSE(positions.identity());
  EXPECT_EQ(positions.find(40), 0);
  EXPECT_EQ(positions.find(-3), 1);
  EXPECT_EQ(positions.find(1LL << 40), 2);
  EXPECT_EQ(positions.find(0), -1);
  EXPECT_EQ(positions.find(41), -1);
  std::int64_t id = 0;
  EXPECT_FALSE(positions.has_duplicate(id));
  EXPECT_FALSE(IdPositions({1, 0}).identity());
}

TEST(Amesos2IdPositions, Duplicate) {
  std::int64_t id = 0;
  EXPECT_TRUE(IdPositions({0, 1, 5, 2, 5}).has_duplicate(id));
  EXPECT_EQ(id, 5);
}

}  // namespace
